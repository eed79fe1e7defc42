//! `--weights` and `--radii`: points with weights, and `--hidden`: the rows of hidden ones.

use super::*;

/// A grid of 81 points with weights. Rows 40 and 44 are hidden, and row 81 is a duplicate of row 0.
fn table() -> String {
    let weight = |i: u64| match i {
        40 | 44 => "-1000".to_owned(),
        _ => format!("{}", (i * 7 % 5) as f64 / 16.0),
    };
    let row = |i: u64| format!("{},{},{},{}\n", i % 9 * 4, i / 9 * 4, i * i, weight(i));
    (0..81).chain([0]).fold("x,y,mass,w\n".to_owned(), |text, i| text + &row(i))
}

/// The last column of the table, one number a row.
fn last_column(table: &str) -> String {
    let number = |line: &str| line.rsplit(',').next().unwrap().to_owned() + "\n";
    table.lines().skip(1).map(number).collect()
}

/// A `.npy` array of one dimension.
fn vector(text: &str) -> Vec<u8> {
    let numbers: Vec<f64> = text.lines().map(|line| line.parse().unwrap()).collect();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", numbers.len());
    header.push_str(&" ".repeat(117 - header.len()));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

fn read(place: &Place, name: &str) -> Vec<u8> {
    fs::read(place.path(name)).unwrap()
}

#[test]
fn hidden_points_are_counted_and_listed() {
    let place = Place::new();
    place.file("p.csv", table());
    let line = "triangulate p.csv --weights w -o p.npy -o p.vtu --json p.json --hidden p.rows";
    let talk = stderr(&place.good(line));
    assert!(talk.contains("1 duplicate of earlier points, 2 points hidden by weights"), "{talk}");
    assert!(talk.contains("wrote") && talk.contains("p.rows"), "{talk}");
    assert!(!talk.contains("  next"), "{talk}");
    assert_eq!(fs::read_to_string(place.path("p.rows")).unwrap(), "40\n44\n");
    let report = place.json("p.json");
    let points = serde_json::json!({ "input": 82, "used": 79, "duplicate": 1, "refused": 0, "hidden": 2 });
    assert_eq!(report["points"], points);
    assert_eq!(report["parameters"]["weights"], "w");
    assert!(report["parameters"].get("radii").is_none(), "{}", report["parameters"]);
    place.good("report p.json -o p.html");
    place.good("triangulate p.csv --weights 4 --hidden h.npy");
    let rows = read(&place, "h.npy");
    assert!(
        rows.starts_with(b"\x93NUMPY\x01\x00v\x00{'descr': '<u8', 'fortran_order': False, 'shape': (2,), }")
    );
    assert_eq!(rows[rows.len() - 16..], [40_u64.to_le_bytes(), 44_u64.to_le_bytes()].concat());
    let output = place.good("triangulate p.csv --weights w --hidden -");
    assert_eq!(output.stdout, b"40\n44\n");
}

#[test]
fn columns_and_files_have_the_same_cells() {
    let place = Place::new();
    let (table, weights) = (table(), last_column(&table()));
    place.file("p.csv", &table).file("w.txt", &weights).file("w.npy", vector(&weights));
    place.good("triangulate p.csv --weights w -o p.npy --hidden p.rows");
    let expected = [read(&place, "p.npy"), read(&place, "p.rows")];
    place.good("triangulate p.csv -o plain.npy");
    assert_ne!(read(&place, "plain.npy"), expected[0]);
    for given in ["4", "W", "w.txt", "w.npy", "w.txt --workers 3", "w.npy --threads 1"] {
        place.good(&format!("triangulate p.csv --weights {given} -o q.npy --hidden q.rows"));
        assert_eq!([read(&place, "q.npy"), read(&place, "q.rows")], expected, "{given}");
    }
    place.file("zero.txt", "0\n".repeat(82)).file("same.txt", "2.5\n".repeat(82));
    for given in ["zero.txt", "same.txt"] {
        place.good(&format!("triangulate p.csv --weights {given} -o q.npy --json q.json"));
        assert_eq!(read(&place, "q.npy"), read(&place, "plain.npy"), "{given}");
        assert_eq!(place.json("q.json")["points"]["hidden"], 0);
    }
}

#[test]
fn radii_are_squared() {
    let place = Place::new();
    place.file("p.csv", "x,y,r,w\n0,0,0,0\n4,0,1,1\n0,4,2,4\n4,4,3,9\n2,1,0.5,0.25\n1,3,0,0\n");
    place.good("triangulate p.csv --weights w -o w.npy --hidden w.rows");
    place.good("triangulate p.csv --radii r -o r.npy --hidden r.rows --json r.json");
    assert_eq!(read(&place, "w.npy"), read(&place, "r.npy"));
    assert_eq!(read(&place, "w.rows"), read(&place, "r.rows"));
    let parameters = &place.json("r.json")["parameters"];
    assert_eq!((&parameters["radii"], parameters.get("weights")), (&"r".into(), None));
}

#[test]
fn the_heaviest_point_of_a_position_stays() {
    let place = Place::new();
    place.file("p.csv", "x,y,w\n0,0,0\n4,0,0\n0,4,0\n1,1,1\n1,1,2\n1,1,2\n1,1,-7\n");
    place.good("triangulate p.csv --weights w -o p.npy --hidden p.rows --duplicates p.same --json p.json");
    assert_eq!(fs::read_to_string(place.path("p.rows")).unwrap(), "3\n6\n");
    assert_eq!(fs::read_to_string(place.path("p.same")).unwrap(), "row,first\n5,4\n");
    let points = place.json("p.json")["points"].clone();
    let expected = serde_json::json!({ "input": 7, "used": 4, "duplicate": 1, "refused": 0, "hidden": 2 });
    assert_eq!(points, expected);
}

#[test]
fn dropped_rows_stay_aligned() {
    let place = Place::new();
    let lines: Vec<String> = table().lines().map(str::to_owned).collect();
    // The first row of points is dropped for its coordinate, and the tenth for its weight.
    let mut damaged = lines.clone();
    damaged[1] = "nan,0,0,0".to_owned();
    damaged[10] = damaged[10].rsplit_once(',').unwrap().0.to_owned() + ",inf";
    let text = damaged.join("\n") + "\n";
    place.file("p.csv", &text).file("w.txt", last_column(&text));
    place.fails("triangulate p.csv --weights w.txt -o a.npy", 3, &["p.csv", "line 2", "--skip-invalid"]);
    place.good("triangulate p.csv --weights w --skip-invalid -o p.npy --hidden p.rows --json p.json");
    assert_eq!(fs::read_to_string(place.path("p.rows")).unwrap(), "40\n44\n");
    assert_eq!(place.json("p.json")["points"]["refused"], 2);
    place.good("triangulate p.csv --weights w.txt --skip-invalid -o q.npy --hidden q.rows");
    assert_eq!(
        [read(&place, "p.npy"), read(&place, "p.rows")],
        ["q.npy", "q.rows"].map(|name| read(&place, name))
    );
    if cfg!(unix) {
        for (given, processes) in [("w", 3), ("w.txt", 2), ("w.txt", 5)] {
            let line = format!("triangulate p.csv --weights {given} --skip-invalid -o r.npy --hidden r.rows");
            place.good(&format!("{line} --workers 8 --transport processes --processes {processes}"));
            let found = ["r.npy", "r.rows"].map(|name| read(&place, name));
            assert_eq!(found, [read(&place, "p.npy"), read(&place, "p.rows")], "{given}, {processes}");
        }
    }
}

#[cfg(unix)]
#[test]
fn processes_have_the_weights_of_their_rows() {
    let place = Place::new();
    let weights = last_column(&table());
    place.file("p.csv", table()).file("w.txt", &weights).file("w.npy", vector(&weights));
    place.good("triangulate p.csv --weights w --workers 8 -o p.npy -o p.vtu --hidden p.rows --json p.json");
    let names = ["npy", "vtu", "rows"];
    let expected = names.map(|ending| read(&place, &format!("p.{ending}")));
    for (given, processes) in [("w", 2), ("4", 5), ("w.txt", 3), ("w.npy", 8)] {
        let line =
            format!("triangulate p.csv --weights {given} -o q.npy -o q.vtu --hidden q.rows --json q.json");
        place.good(&format!("{line} --workers 8 --transport processes --processes {processes}"));
        assert_eq!(
            names.map(|ending| read(&place, &format!("q.{ending}"))),
            expected,
            "{given}, {processes}"
        );
        assert_eq!(place.json("q.json")["points"], place.json("p.json")["points"]);
    }
    place.file("few.txt", "1\n2\n");
    let line = "triangulate p.csv --transport processes --workers 2 -o a.npy --weights";
    place.fails(&format!("{line} few.txt"), 3, &["few.txt: 2 weights for 82 rows of points"]);
    place.fails(&format!("{line} none.npy"), 3, &["none.npy", "no such file"]);
}

#[cfg(target_os = "linux")]
#[test]
fn no_output_is_left_if_the_rows_cannot_be_written() {
    let place = Place::new();
    place.file("p.csv", table());
    for processes in ["", " --workers 4 --transport processes --processes 2"] {
        let line = format!("triangulate p.csv --weights w -o a.npy -o a.vtu --hidden /dev/full{processes}");
        place.fails(&line, 1, &["/dev/full"]);
    }
}

#[test]
fn plain_reports_do_not_mention_weights() {
    let place = Place::new();
    place.file("p.csv", table());
    let talk = stderr(&place.good("triangulate p.csv --json p.json"));
    assert!(talk.contains("next") && !talk.contains("hidden"), "{talk}");
    let report = place.json("p.json");
    assert!(report["points"].get("hidden").is_none());
    assert!(report["parameters"].get("weights").is_none() && report["parameters"].get("radii").is_none());
}

#[test]
fn calls_that_cannot_be_meant_are_exit_2() {
    let place = Place::new();
    place
        .file("p.csv", table())
        .file("w.txt", "1\n")
        .file("p.ply", PLY)
        .file("3.txt", "0 0 1\n1 0 1\n0 1 1\n");
    for (line, words) in [
        ("p.csv --weights w --radii w", &["--weights", "--radii"][..]),
        ("p.csv --hidden h.txt", &["--hidden has no effect without --weights or --radii"]),
        ("p.csv --weights w --terrain", &["--weights contradicts --terrain"]),
        ("sample:uniform:10 --radii w.txt", &["--radii applies to files, not to a generated sample"]),
        ("p.csv --weights v", &["p.csv, line 1: there is no column v (columns: x, y, mass, w)", "--columns"]),
        ("p.csv --weights x", &["column x is a coordinate, and cannot be the weights"]),
        ("3.txt --columns 1,2,3 --weights 3", &["column 3 is a coordinate"]),
        ("p.ply --weights w", &["p.ply: a .ply file has no column of weights", ".csv .npy .npz"]),
        ("p.csv --weights w.txt -o w.txt", &["unknown output format"]),
        ("p.csv --weights w.txt --json w.txt", &["would overwrite the input file w.txt"]),
        ("p.csv --weights w --hidden p.csv", &["would overwrite the input file p.csv"]),
        ("p.csv --weights w --hidden h.vtu", &["h.vtu: unknown output format", ".npy"]),
        ("p.csv --weights w --hidden h.txt --json h.txt", &["would write the same file"]),
    ] {
        let line = format!("triangulate {line}");
        let before = place.names();
        let output = place.run(&line);
        assert_eq!(code(&output), 2, "{line}: {}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "{line}: {}", stderr(&output));
        }
        assert_eq!(place.names(), before, "{line}");
    }
    place.fails("simulate p.csv --weights w --hidden p.csv", 2, &["would overwrite the input file p.csv"]);
}

#[test]
fn both_commands_have_the_same_cells_and_hidden_points() {
    let place = Place::new();
    place.file("p.csv", table()).file("w.npy", vector(&last_column(&table())));
    place.good("triangulate p.csv --weights w -o p.npy --hidden p.rows --json p.json");
    let expected = [read(&place, "p.npy"), read(&place, "p.rows")];
    for given in [
        "--weights w",
        "--weights w.npy --workers 5",
        "--weights 4 --supergraph knn --k 9",
        "--weights w --repair splay --leaf 8",
    ] {
        let line = format!("simulate p.csv {given} -o q.npy --hidden q.rows --json q.json");
        let talk = stderr(&place.good(&line));
        assert!(talk.contains("2 points hidden by weights"), "{talk}");
        assert_eq!([read(&place, "q.npy"), read(&place, "q.rows")], expected, "{given}");
        assert_eq!(place.json("q.json")["points"], place.json("p.json")["points"], "{given}");
    }
    if cfg!(unix) {
        let line = "simulate p.csv --weights w.npy --workers 4 --transport processes --processes 2";
        place.good(&format!("{line} -o q.npy --hidden q.rows"));
        assert_eq!([read(&place, "q.npy"), read(&place, "q.rows")], expected);
    }
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
                   property double w\nend_header\n0 0 0 1\n1 0 0 1\n0 1 0 1\n";

#[test]
fn bad_weights_are_exit_3() {
    let place = Place::new();
    place
        .file("p.csv", "x,y,w\n0,0,1\n1,0,nan\n0,1,-2\n")
        .file("w.txt", "1\n\nx\n3\n")
        .file("few.txt", "1\n2\n");
    for (line, words) in [
        (
            "p.csv --weights w",
            &["p.csv, line 3: weight of point 1 (from 0) is NaN, not a finite number", "--skip-invalid"][..],
        ),
        ("p.csv --radii w --skip-invalid -d 3", &["does not name the columns x, y and z"]),
        ("p.csv --radii 3 --columns 2,1", &["radius of point 1 (from 0) is NaN"]),
        ("p.csv --weights w.txt", &["w.txt, line 3, column 1: found \"x\", expected"]),
        ("p.csv --radii few.txt", &["few.txt: 2 radii for 3 rows of points"]),
        ("p.csv --weights none.csv", &["none.csv: no such file"]),
        ("p.csv --weights w.vtu", &["w.vtu: no such file"]),
    ] {
        let output = place.run(&format!("triangulate {line} -o a.npy"));
        let expected = if line.contains("-d 3") { 2 } else { 3 };
        assert_eq!(code(&output), expected, "{line}: {}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "{line}: {}", stderr(&output));
        }
        assert!(!place.path("a.npy").exists(), "{line}");
    }
    place.fails("triangulate p.csv --weights few.txt --hidden no/h.txt", 1, &["no/h.txt"]);
}

#[test]
fn cells_and_hidden_points_are_verified() {
    let place = Place::new();
    let (table, weights) = (table(), last_column(&table()));
    place.file("p.csv", &table).file("w.npy", vector(&weights));
    place.good("triangulate p.csv --weights w -o p.npy -o p.vtu");
    place.good("triangulate p.csv -o plain.npy");
    let talk = stderr(&place.good("verify p.csv p.npy --weights w --perturbed --json v.json"));
    assert!(talk.contains("p.npy is a regular triangulation of p.csv"), "{talk}");
    assert!(talk.contains(", 2 points hidden"), "{talk}");
    let report = place.json("v.json");
    assert_eq!((&report["hidden"], &report["weights"]), (&2.into(), &"w".into()));
    assert_eq!(report["levels"][6]["name"], "hidden sites");
    place.good("verify p.csv p.npy --weights w.npy");
    place.good("verify p.vtu --weights w.npy --perturbed");
    place.fails("verify p.csv p.npy", 4, &["p.npy is not a Delaunay triangulation"]);
    place.fails(
        "verify p.csv plain.npy --weights w",
        4,
        &["plain.npy is not a regular triangulation", "empty spheres"],
    );
    // In the set without the point 30, the triangulation is regular, but the point is not hidden.
    let without: String = table.lines().map(|line| line.to_owned() + "\n").collect();
    let light = without.replacen("12,12,900,0\n", "12,12,900,-99\n", 1);
    assert_ne!(light, without);
    place.file("light.csv", light);
    place.good("triangulate light.csv --weights w -o light.npy");
    place.fails("verify p.csv light.npy --weights w", 4, &["point 30 is not a vertex"]);
    place.good("triangulate p.csv --radii mass -o r.npy");
    place.good("verify p.csv r.npy --radii mass");
    place.fails("verify p.csv r.npy --weights mass", 4, &["not a regular triangulation"]);
    for (line, words) in [
        ("sample:uniform:100 p.npy --weights w", "--weights applies to files"),
        ("p.csv p.npy --weights w --radii w", "--radii"),
        ("p.csv p.npy --weights w.npy --json w.npy", "would overwrite the input file w.npy"),
        ("p.csv p.npy --weights w --terrain", "--weights contradicts --terrain"),
        ("p.vtu --weights w", "a .vtu file has no column of weights"),
    ] {
        place.fails(&format!("verify {line}"), 2, &[words]);
    }
}

/// Images that are far shorter than all images without weights, and centres that need more digits than messages have.
#[test]
fn very_heavy_points_have_exact_stars() {
    let place = Place::new();
    for exponent in [200, 270, 342, 352, 360] {
        let heavy = 2f64.powi(exponent);
        let row = |i: u64| {
            let at = |factor: u64| ((i * factor) % 1009) as f64 / 1024.0;
            format!("{},{},{},{}\n", at(611), at(357), at(811), if i == 40 { heavy } else { 0.0 })
        };
        place.file("p.csv", (0..80).map(row).fold("x,y,z,w\n".to_owned(), |text, row| text + &row));
        place.good("triangulate p.csv --weights w -o a.npy --json a.json");
        for workers in [1, 3] {
            let line = format!("simulate p.csv --weights w -o b.npy --json b.json --workers {workers}");
            place.good(&line);
            assert!(read(&place, "a.npy") == read(&place, "b.npy"), "2^{exponent}, {workers} workers");
            let (report, points) = (place.json("b.json"), place.json("b.json")["points"].clone());
            assert_eq!(points, place.json("a.json")["points"]);
            let count = |name: &str| report["how_proved"][name].as_u64().unwrap();
            let stars: u64 = ["direct", "hypothesis", "local_radius", "exchange"].map(count).iter().sum();
            assert_eq!(stars, points["used"].as_u64().unwrap() + points["hidden"].as_u64().unwrap());
        }
    }
}

/// The supergraph is one of positions, so its numbers do not depend on weights.
#[test]
fn the_graph_of_hidden_points_counts_them() {
    let place = Place::new();
    let row = |i: u64| {
        let at = |factor: u64| ((i * factor) % 2003) as f64 / 2048.0;
        format!("{},{},{},{}\n", at(611), at(357), (i % 7) as f64 / 20.0, 0)
    };
    place.file("p.csv", (0..400).map(row).fold("x,y,w,v\n".to_owned(), |text, row| text + &row));
    let graphs = ["w", "v"].map(|weights| {
        place.good(&format!("simulate p.csv --columns x,y --weights {weights} --alpha 3 --json r.json"));
        place.json("r.json")["graph"].clone()
    });
    assert_eq!(graphs[0], graphs[1]);
}
