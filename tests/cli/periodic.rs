//! `--periodic`: points in boxes that repeat, their offsets, and outputs without a place for images.

use super::*;

/// 40 points in the box from (0, 0) to (10, 20); row 40 repeats row 0 on the upper face.
fn table() -> String {
    let row = |i: u64| format!("{},{}\n", (i * 7 % 40) as f64 / 4.0, i as f64 / 2.0);
    (0..40).map(row).chain(["10,0\n".to_owned()]).fold("x,y\n".to_owned(), |text, row| text + &row)
}

/// The numbers of a `.npy` array of bytes, after its header.
fn bytes_after_header(place: &Place, name: &str) -> (String, Vec<i8>) {
    let bytes = fs::read(place.path(name)).unwrap();
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let head = String::from_utf8_lossy(&bytes[10..end]).into_owned();
    (head, bytes[end..].iter().map(|&byte| byte as i8).collect())
}

#[test]
fn a_torus_has_twice_as_many_triangles_as_points() {
    let place = Place::new();
    place.file("p.csv", table());
    let line = "triangulate p.csv --periodic 10,20 -o c.npy -o c.vtu --offsets o.npy --json r.json";
    let talk = stderr(&place.good(line));
    for words in
        ["80 triangles", "periodic    10 x 20, a simplicial complex", "1 duplicate of earlier points"]
    {
        assert!(talk.contains(words), "{talk}");
    }
    assert!(!talk.contains("  next"), "{talk}");
    let report = place.json("r.json");
    assert_eq!(report["points"]["used"], 40);
    assert_eq!(report["periodic"]["box"], serde_json::json!([10.0, 20.0]));
    assert_eq!(report["periodic"]["origin"], serde_json::json!([0.0, 0.0]));
    assert_eq!(report["periodic"]["sheets"], serde_json::json!([1, 1]));
    assert_eq!(report["parameters"]["periodic"], serde_json::json!(["10", "20"]));
    let (head, offsets) = bytes_after_header(&place, "o.npy");
    assert!(head.contains("'descr': '|i1'") && head.contains("(80, 3, 2)"), "{head}");
    assert!(offsets.iter().all(|steps| steps.abs() <= 1) && offsets.contains(&1), "{offsets:?}");
    assert!(offsets.chunks(6).all(|cell| cell[..2] == [0, 0]));
    let vtu = String::from_utf8_lossy(&fs::read(place.path("c.vtu")).unwrap()).into_owned();
    for array in ["\"site\"", "\"image_x\"", "\"image_y\""] {
        assert!(vtu.contains(array), "{array}");
    }
    place.good("report r.json -o r.html");
    // Neither workers nor the origin of the box matter.
    place.good(
        "triangulate p.csv --periodic 10,20 --origin -3.5,1 --wrap --workers 7 -o d.npy --offsets e.npy",
    );
    let same = |a: &str, b: &str| fs::read(place.path(a)).unwrap() == fs::read(place.path(b)).unwrap();
    assert!(same("c.npy", "d.npy"));
}

#[test]
fn weights_and_boxes_combine() {
    let place = Place::new();
    let row = |i: u64| format!("{},{},{}\n", i * 7 % 40, i, if i == 9 { -400 } else { 0 });
    place.file("p.csv", (0..40).map(row).fold("x,y,w\n".to_owned(), |text, row| text + &row));
    let talk = stderr(&place.good("triangulate p.csv --weights w --periodic 40,40 --hidden h.rows -o c.npy"));
    assert!(talk.contains("78 triangles") && talk.contains("1 point hidden by weights"), "{talk}");
    assert_eq!(fs::read_to_string(place.path("h.rows")).unwrap(), "9\n");
    let talk = stderr(&place.good("triangulate p.csv --columns x,y --periodic 40,none -o c.npy"));
    assert!(talk.contains("periodic    40 x none"), "{talk}");
}

#[test]
fn few_points_are_no_simplicial_complex() {
    let place = Place::new();
    place.file("p.xyz", "0.25 0.5 0.75\n");
    let talk = stderr(&place.good("triangulate p.xyz --periodic 1,1,1 --json r.json -o c.npy"));
    assert!(talk.contains("6 tetrahedra") && talk.contains("3 x 3 x 3 boxes are one"), "{talk}");
    assert_eq!(place.json("r.json")["periodic"]["simplicial"], false);
}

#[test]
fn boxes_that_cannot_be_used_are_refused() {
    let place = Place::new();
    place.file("p.csv", table());
    for (line, code, words) in [
        ("--periodic 10", 2, ["numbers of the periodic box: 1", "2 coordinates"]),
        ("--periodic 10,0", 2, ["length", "positive"]),
        ("--periodic 10,x", 2, ["x", "numbers"]),
        ("--periodic none,none", 2, ["no axis", "periodic"]),
        ("--origin 1,1", 2, ["--origin", "--periodic"]),
        ("--wrap", 2, ["--wrap", "--periodic"]),
        ("--offsets o.npy", 2, ["--offsets", "--periodic"]),
        ("--periodic 10,5", 3, ["p.csv", "point 11"]),
        ("--periodic 10,20 --stats", 2, ["--stats", "--periodic"]),
        ("--periodic 10,20 -o c.off", 2, ["c.off", ".npy"]),
        ("--periodic 10,20 --offsets o.csv", 2, ["o.csv", ".npy"]),
        ("--periodic 10,20 --with-owner -o c.vtu", 2, ["owner", "--periodic"]),
    ] {
        place.fails(&format!("triangulate p.csv {line}"), code, &words);
    }
    place.fails("simulate p.csv --periodic 10,20 --cost-trace t.jsonl", 2, &["cost trace", "periodic"]);
}

/// Rows outside of the box, each with a weight and a column.
fn scattered() -> String {
    let row = |i: u64| {
        let at = |factor: u64, places: u64| (i * factor % 97) as f64 / 9.7 * places as f64 - 5.0;
        format!("{},{},{},{},{i}\n", at(31, 1), at(57, 3), at(11, 2), i % 5)
    };
    (0..90).map(row).fold("x,y,z,w,i\n".to_owned(), |text, row| text + &row)
}

#[cfg(unix)]
#[test]
fn processes_write_what_one_process_writes() {
    let place = Place::new();
    place.file("p.csv", scattered().replace("\n-0.", "\nnan,0,0,0,0\n-0."));
    let names = ["npy", "vtu", "vtk", "offsets", "rows"];
    let line = |to: &str, more: &str| {
        format!(
            "triangulate p.csv --weights w --periodic 3,3.3,0.7 --wrap --skip-invalid --keep-columns --workers 5 \
             -o {to}.npy -o {to}.vtu -o {to}.vtk --offsets {to}.offsets.npy --hidden {to}.rows --json {to}.json {more}"
        )
    };
    place.good(&line("p", ""));
    let read = |to: &str| {
        names.map(|name| {
            let name = if name == "offsets" { format!("{to}.offsets.npy") } else { format!("{to}.{name}") };
            fs::read(place.path(&name)).unwrap()
        })
    };
    let (expected, report) = (read("p"), place.json("p.json"));
    for processes in [2, 3, 5] {
        place.good(&line("q", &format!("--transport processes --processes {processes}")));
        let found = read("q");
        for (at, name) in names.iter().enumerate() {
            assert!(found[at] == expected[at], "{name}, {processes} processes");
        }
        processes::same_counts(&place.json("q.json"), &report, &format!("{processes} processes"));
    }
    // More processes than workers.
    let talk =
        "triangulate p.csv --weights w --periodic 3,3.3,0.7 --wrap --skip-invalid --workers 2 -o q.npy";
    place.good(&format!("{talk} --transport processes --processes 4"));
    assert!(fs::read(place.path("q.npy")).unwrap() == expected[0]);
    let talk = "triangulate p.csv --skip-invalid --columns x,y,z --periodic 3,4,5 --transport processes --processes 3";
    place.fails(talk, 3, &["p.csv", "--wrap"]);
}

/// The stars of the paper's recursion are those of the direct path.
#[test]
fn simulate_finds_the_same_cells() {
    let place = Place::new();
    place.file("p.csv", scattered());
    for given in ["--columns x,y,z", "--weights w"] {
        let line = format!("p.csv {given} --periodic 3,3.3,0.7 --wrap -o");
        place.good(&format!("triangulate {line} a.npy --offsets a.offsets.npy --json a.json"));
        for workers in [1, 3, 8] {
            let to = "b.npy --offsets b.offsets.npy --json b.json";
            place.good(&format!("simulate {line} {to} --workers {workers}"));
            for name in ["npy", "offsets.npy"] {
                let read = |of: &str| fs::read(place.path(&format!("{of}.{name}"))).unwrap();
                assert!(read("a") == read("b"), "{given}, {workers} workers: {name}");
            }
            let (found, expected) = (place.json("b.json"), place.json("a.json"));
            for key in ["points", "periodic", "cells"] {
                assert_eq!(found[key], expected[key], "{given}, {workers} workers: {key}");
            }
            assert!(found["machine"]["total"]["work"].as_u64() > Some(0), "{given}, {workers} workers");
            assert!(found["graph"]["mean_degree"].as_f64() < Some(200.0), "{}", found["graph"]);
        }
    }
    place.good("report b.json -o r.html");
}

/// A `.npy` array of equal rows: its header without the number of rows, and the rows.
struct Rows {
    head: String,
    rows: Vec<Vec<u8>>,
}

impl Rows {
    fn read(place: &Place, name: &str, row: usize) -> Self {
        let bytes = fs::read(place.path(name)).unwrap();
        let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let head = String::from_utf8_lossy(&bytes[10..end]).trim_end().to_owned();
        Rows { head, rows: bytes[end..].chunks_exact(row).map(<[u8]>::to_vec).collect() }
    }

    /// Writes other rows with the same type.
    fn write(&self, place: &Place, name: &str, rows: &[Vec<u8>]) {
        let head = self.head.replace(&format!("({}, ", self.rows.len()), &format!("({}, ", rows.len()));
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((head.len() as u16 + 1).to_le_bytes());
        bytes.extend(head.bytes().chain([b'\n']).chain(rows.concat()));
        place.file(name, bytes);
    }
}

/// Triangulates points, verifies the cells, and returns the verification and its dimension.
fn verified(place: &Place, points: &str, options: &str, d: usize) -> (String, Rows, Rows) {
    place.good(&format!("triangulate {points} {options} -o c.npy --offsets o.npy"));
    let line = format!("{points} c.npy {options} --offsets o.npy");
    place.good(&format!("verify {line} --perturbed"));
    let cells = Rows::read(place, "c.npy", 8 * (d + 1));
    let offsets = Rows::read(place, "o.npy", d * (d + 1));
    assert_eq!(cells.rows.len(), offsets.rows.len());
    (format!("verify {points} d.npy {options} --offsets e.npy"), cells, offsets)
}

#[test]
fn cells_of_boxes_are_verified_and_altered_ones_refused() {
    let place = Place::new();
    place.file("p.csv", table());
    let row = |i: u64| {
        let at = |factor: u64| (i * factor % 11) as f64 / 3.0 - 1.0;
        format!("{} {} {}\n", at(5), at(3), at(7))
    };
    place.file("s.xyz", (0..8).map(row).collect::<String>());
    place.file("one.xyz", "0.25 0.5 0.75\n");
    place.file("w.txt", "0\n9\n0\n-1\n0\n-40\n0\n1\n");
    for (points, options, d) in [
        ("p.csv", "--periodic 10,20", 2),
        ("p.csv", "--periodic 10,none", 2),
        ("p.csv", "--periodic 3.1,7.3 --wrap --origin -0.7,0.1", 2),
        ("s.xyz", "--periodic 1.1,1.3,0.7 --wrap", 3),
        ("s.xyz", "--periodic 4,none,4 --origin -1,0,-1 --weights w.txt", 3),
        ("one.xyz", "--periodic 1,1,1", 3),
    ] {
        let (line, cells, offsets) = verified(&place, points, options, d);
        let refused = |cells_of: &[Vec<u8>], offsets_of: &[Vec<u8>]| {
            cells.write(&place, "d.npy", cells_of);
            offsets.write(&place, "e.npy", offsets_of);
            place.fails(&line, 4, &["d.npy is not a periodic", "triangulation"]);
        };
        let last = cells.rows.len() - 1;
        for number in [0, last / 2, last] {
            let at = (number * 5) % (d * (d + 1));
            let mut wrong = offsets.rows.clone();
            wrong[number][at] = wrong[number][at].wrapping_add(1);
            refused(&cells.rows, &wrong);
        }
        refused(&cells.rows[1..], &offsets.rows[1..]);
        let twice = |rows: &[Vec<u8>]| [rows, &rows[last / 2..=last / 2]].concat();
        refused(&twice(&cells.rows), &twice(&offsets.rows));
        let replaced = |rows: &[Vec<u8>]| [&rows[1..], &rows[last..]].concat();
        refused(&replaced(&cells.rows), &replaced(&offsets.rows));
        // The cells of a box without the last ones are those of a sheet that is cut.
        let crosses = |offsets: &&Vec<u8>| offsets.iter().all(|steps| *steps == 0);
        let inner: Vec<usize> = (0..=last).filter(|&i| crosses(&&offsets.rows[i])).collect();
        let only = |rows: &[Vec<u8>]| inner.iter().map(|&i| rows[i].clone()).collect::<Vec<_>>();
        refused(&only(&cells.rows), &only(&offsets.rows));
        cells.write(&place, "d.npy", &cells.rows);
        offsets.write(&place, "e.npy", &offsets.rows[1..]);
        place.fails(&line, 3, &["e.npy", "cells"]);
    }
}

#[test]
fn weights_decide_which_cells_of_a_box_pass() {
    let place = Place::new();
    let row = |i: u64| format!("{},{},{},{}\n", i * 7 % 40, i, if i == 9 { -400 } else { 0 }, i % 3);
    place.file("p.csv", (0..40).map(row).fold("x,y,w,v\n".to_owned(), |text, row| text + &row));
    for column in ["w", "v"] {
        let line = format!("triangulate p.csv --weights {column} --periodic 40,40 --offsets {column}.o.npy");
        place.good(&format!("{line} -o {column}.npy"));
    }
    let box_of = "--columns x,y --periodic 40,40 --offsets";
    place.good(&format!("triangulate p.csv {box_of} n.o.npy -o n.npy"));
    let report = |column: &str| format!("verify p.csv {column}.npy --weights {column}");
    place.good(&format!("{} --periodic 40,40 --offsets w.o.npy --json r.json", report("w")));
    let json = place.json("r.json");
    assert_eq!((&json["hidden"], &json["passed"]), (&serde_json::json!(1), &serde_json::json!(true)));
    let expected = serde_json::json!({"box": [40.0, 40.0], "offsets_file": "w.o.npy"});
    assert_eq!(json["periodic"], expected);
    // A hidden point is shown, and a point that should be shown is not.
    place.fails("verify p.csv n.npy --weights w --periodic 40,40 --offsets n.o.npy", 4, &["regular"]);
    place.fails(&format!("verify p.csv w.npy {box_of} w.o.npy"), 4, &["Delaunay"]);
}

#[test]
fn boxes_that_do_not_fit_the_cells_are_refused() {
    let place = Place::new();
    place.file("p.csv", table());
    place.good("triangulate p.csv --periodic 10,20 -o c.npy -o c.vtu --offsets o.npy");
    for (line, code, words) in [
        ("p.csv c.npy --periodic 10 --offsets o.npy", 2, ["numbers of the periodic box: 1", "2 coordinates"]),
        ("p.csv c.npy --periodic 10,0 --offsets o.npy", 2, ["length", "positive"]),
        ("p.csv c.npy --periodic none,none --offsets o.npy", 2, ["no axis", "periodic"]),
        ("p.csv c.npy --periodic 10,20", 2, ["--periodic", "--offsets"]),
        ("p.csv c.npy --offsets o.npy", 2, ["--offsets", "--periodic"]),
        ("p.csv c.npy --origin 1,1", 2, ["--origin", "--periodic"]),
        ("p.csv c.npy --wrap", 2, ["--wrap", "--periodic"]),
        ("c.vtu --periodic 10,20 --offsets o.npy", 2, ["--periodic", "two files"]),
        ("p.csv c.npy --periodic 10,5 --offsets o.npy", 3, ["p.csv", "point 11"]),
        ("p.csv c.npy --periodic 10,20 --offsets c.npy", 3, ["c.npy", "shape"]),
        ("p.csv c.npy --periodic 10,20 --offsets p.csv", 3, ["p.csv", ".npy"]),
        ("p.csv c.npy --periodic 10,20 --offsets none.npy", 3, ["none.npy", "none.npy"]),
        (
            "p.csv c.npy --periodic 10,20 --wrap --origin 5,5 --offsets o.npy --json o.npy",
            2,
            ["o.npy", "o.npy"],
        ),
    ] {
        place.fails(&format!("verify {line}"), code, &words);
    }
    place.good("verify p.csv c.npy --periodic 10,20 --wrap --origin 5,5 --offsets o.npy");
}

/// A box far from 0, its upper face as a rounded sum, and the offsets of few points.
#[test]
fn boxes_far_away_verify() {
    let place = Place::new();
    let row = |i: u32| format!("{},{}\n", 68e6 + f64::from(i * 7 % 20) / 32.0, 68e6 + f64::from(i) / 32.0);
    place.file("p.csv", (0..20).map(row).fold("x,y\n".to_owned(), |text, row| text + &row));
    let given = "--periodic 1,1 --origin 68000000,68000000";
    place.good(&format!("triangulate p.csv {given} -o c.npy --offsets o.npy"));
    place.good(&format!("verify p.csv c.npy {given} --offsets o.npy"));
    place.file("q.csv", "x,y\n0.1,0\n2.1,0.5\n1,1\n");
    place.good("triangulate q.csv --periodic 2,2 --origin 0.1,0 -o c.npy");
    place.file("one.xyz", "0.25 0.5 0.75\n");
    place.good("triangulate one.xyz --periodic 1,1,1 -o c.npy --offsets o.npy");
    let (_, offsets) = bytes_after_header(&place, "o.npy");
    assert!(offsets.chunks(12).all(|cell| cell[..3] == [0; 3]), "{offsets:?}");
}

#[cfg(unix)]
#[test]
fn a_failed_certificate_ends_all_processes_alike() {
    let place = Place::new();
    place.file("p.csv", table());
    for processes in [3, 5] {
        let line = "simulate p.csv --periodic 10,20 --workers 3 --fault spoil:1 -o c.npy";
        let line = format!("{line} --transport processes --processes {processes}");
        place.fails(&line, 4, &["the certificate failed"]);
    }
}

#[cfg(unix)]
#[test]
fn a_row_outside_has_its_number_in_the_file() {
    let place = Place::new();
    let row = |i: u32| match i {
        3 | 5 => "nan,0\n".to_owned(),
        30 => "1.5,0.5\n".to_owned(),
        _ => format!("{},{}\n", f64::from(i * 7 % 40) / 40.0, f64::from(i) / 40.0),
    };
    place.file("p.csv", (0..40).map(row).fold("x,y\n".to_owned(), |text, row| text + &row));
    for processes in ["", " --transport processes --processes 3"] {
        place.fails(
            &format!("triangulate p.csv --skip-invalid --periodic 1,1{processes}"),
            3,
            &["p.csv", "point 30"],
        );
    }
}
