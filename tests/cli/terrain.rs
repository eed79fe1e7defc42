//! `--terrain`: points with heights, triangulated in the plane.

use super::*;

/// Returns a table of 90 points with heights. Some points have the x and y of an earlier one.
fn table() -> String {
    let row = |i: u64| {
        let [x, y] = [i % 80 * 37 % 101, i % 80 * 23 % 97];
        format!("{},{},{}.5,{}\n", x, y, 100 + i, i * i)
    };
    (0..90).fold("x,y,elevation,mass\n".to_owned(), |text, i| text + &row(i))
}

/// Returns the table without heights.
fn plane() -> String {
    table().lines().map(|line| line.split(',').take(2).collect::<Vec<_>>().join(",") + "\n").collect()
}

#[test]
fn the_cells_are_those_of_the_plane() {
    let place = Place::new();
    place.file("p.csv", table()).file("q.csv", plane());
    let output = place.good("triangulate p.csv --terrain -o p.npy -o p.ele -o tin.obj --json p.json");
    let talk = stderr(&output);
    for words in [
        "p.csv: terrain of 90 rows, columns x y elevation",
        "z 100.5 to 189.5",
        "10 points have the x and y of an earlier point, whose z is kept; their z differ by at most 80.0",
    ] {
        assert!(talk.contains(words), "{words}: {talk}");
    }
    place.good("triangulate q.csv -o q.npy -o q.ele");
    for format in ["npy", "ele", "neigh", "edge"] {
        let [p, q] = ["p", "q"].map(|name| fs::read(place.path(&format!("{name}.{format}"))).unwrap());
        assert_eq!(p, q, "{format}");
    }
    assert!(fs::read_to_string(place.path("p.node")).unwrap().starts_with("90 2 1 0\n0 0 0 100.5\n"));
    assert!(fs::read_to_string(place.path("tin.obj")).unwrap().contains("\nv 37 23 101.5\n"));
    let report = place.json("p.json");
    assert_eq!((&report["input"]["terrain"], &report["space"]), (&true.into(), &2.into()));
    assert_eq!(report["input"]["height_difference"], 80.0);
    assert_eq!(report["input"]["extent"][2], serde_json::json!([100.5, 189.5]));
    assert_eq!(report["parameters"]["terrain"], true);
    place.good("report p.json -o p.html");
}

#[test]
fn every_output_can_be_verified() {
    let place = Place::new();
    place.file("p.csv", table());
    let outputs = ["vtu", "vtk", "msh", "msh22", "mesh", "off", "obj", "ply", "stl", "npy"];
    let all = outputs.iter().map(|ending| format!(" -o m.{ending}")).collect::<Vec<_>>().concat();
    place.good(&format!("triangulate p.csv --terrain -o m.pvtu -o m.ele{all}"));
    for ending in ["vtu", "vtk", "msh", "msh22", "mesh", "off", "obj", "ply"] {
        place.good(&format!("verify m.{ending} m.{ending} --terrain --perturbed"));
        place.fails(&format!("verify m.{ending} m.{ending}"), 3, &["three coordinates", "--terrain"]);
    }
    for ending in ["vtu", "vtk", "msh", "msh22", "mesh", "off", "obj", "ply", "pvtu"] {
        place.good(&format!("verify m.{ending} --terrain --perturbed"));
        place.fails(&format!("verify m.{ending}"), 3, &["three coordinates", "--terrain"]);
    }
    for points in ["m.vtu", "m.ply", "m.obj", "p.csv"] {
        for cells in ["m.npy", "m.pvtu", "m.ele"] {
            place.good(&format!("verify {points} {cells} --terrain --perturbed"));
        }
    }
    // Pieces have the heights of their points.
    place.file("higher.csv", table().replace("\n37,23,101.5,", "\n37,23,102.5,")).file("flat.csv", plane());
    place.fails("verify higher.csv m.pvtu --terrain", 3, &["m.pieces/", "other coordinates", "higher.csv"]);
    place.fails("verify flat.csv m.pvtu", 3, &["m.pieces/", "other coordinates", "flat.csv"]);
    place.good("verify m.node m.ele --perturbed");
    place.good("verify m.node m.ele --terrain --perturbed");
    // A terrain has other cells after its points have moved in the plane.
    let moved = fs::read_to_string(place.path("p.csv")).unwrap().replace("\n37,23,", "\n500,500,");
    place.file("moved.csv", moved);
    let failed = place.run("verify moved.csv m.npy --terrain");
    assert_eq!(code(&failed), 4, "{}", stderr(&failed));
    let next = stderr(&place.good("triangulate p.csv --terrain -o m.vtu"));
    assert!(next.contains("septet verify m.vtu --terrain"), "{next}");
}

#[test]
fn a_grid_is_a_terrain() {
    let place = Place::new();
    let grid = "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -9999\n\
                1 2 3\n4 5 6 -9999 8 9\n10 11 12\n";
    place.file("g.asc", grid).file("g.txt", grid);
    place.fails("triangulate g.asc", 3, &["g.asc", "a grid of heights", "--terrain"]);
    for name in ["g.asc", "g.txt"] {
        let output = place.good(&format!("triangulate {name} --terrain -o g.npy -o g.off"));
        let talk = stderr(&output);
        for words in [
            "read as a grid of 4 x 3 heights; 1 cell without data is left out",
            "terrain of 11 rows; x 105.0 to 135.0, y 205.0 to 225.0, z 1.0 to 12.0",
        ] {
            assert!(talk.contains(words), "{words}: {talk}");
        }
        place.good(&format!("verify {name} g.npy --terrain --perturbed"));
    }
    let off = fs::read_to_string(place.path("g.off")).unwrap();
    assert!(off.starts_with("OFF\n11 ") && off.contains("\n105 225 1\n"), "{off}");
    place.file("bad.asc", grid.replace(" 11 ", " nan "));
    place.fails("triangulate bad.asc --terrain", 3, &["bad.asc, line 9", "--skip-invalid"]);
    place.good("triangulate bad.asc --terrain --skip-invalid");
}

#[test]
fn terrain_that_is_none_is_refused() {
    let place = Place::new();
    place.file("q.csv", plane()).file("q.xyz", "0 0\n1 0\n0 1\n").file("p.xyz", "0 0 1\n1 0 1\n0 1 1\n");
    place.fails("triangulate q.csv --terrain", 2, &["q.csv, line 1", "no z", "--columns"]);
    place.fails("triangulate q.xyz --terrain", 3, &["q.xyz, line 1", "no z", "--terrain"]);
    place.fails("verify q.xyz m.vtu --terrain", 3, &["no z"]);
    place.fails("triangulate p.xyz --terrain -d 3", 2, &["--terrain", "-d 3"]);
    place.good("triangulate p.xyz --terrain -d 2");
    place.fails("triangulate sample:uniform:9,d=2 --terrain", 2, &["--terrain", "sample"]);
    place.fails("simulate p.xyz --terrain", 2, &["--terrain"]);
    place.fails("triangulate q.xyz --terrain --transport processes --processes 2", 3, &["no z"]);
}

#[cfg(unix)]
#[test]
fn several_processes_write_the_same_bytes() {
    let place = Place::new();
    let rows: String = table().lines().skip(1).map(|line| line.replace(',', " ") + "\n").collect();
    let xyz: String = rows.lines().map(|l| l.rsplit_once(' ').unwrap().0.to_owned() + "\n").collect();
    place.file("all.xyz", &xyz).file("all.csv", table().replace("\n74,", "\nnan,"));
    let lines: Vec<&str> = xyz.split_inclusive('\n').collect();
    place.file("p-1.xyz", lines[..31].concat()).file("p-2.xyz", lines[31..].concat());
    place.file("g.asc", "ncols 9\nnrows 5\ncellsize 3\n".to_owned() + &"1 7 3 -9999 5 2 8 8 1\n".repeat(5));
    let outputs = ["vtu", "pvtu", "vtk", "msh", "mesh", "off", "obj", "ply", "stl", "npy", "ele"];
    for input in
        ["all.xyz", "p-*.xyz", "all.csv --skip-invalid --keep-columns", "g.asc", "all.csv --skip-invalid"]
    {
        let run = |name: &str, more: &str| {
            let all =
                outputs.iter().map(|ending| format!(" -o {name}.{ending}")).collect::<Vec<_>>().concat();
            let output = place.good(&format!("triangulate {input} --terrain --workers 5{all} {more}"));
            let read = |path: PathBuf| fs::read(path).unwrap();
            let mut bytes: Vec<Vec<u8>> = outputs
                .iter()
                .filter(|e| **e != "pvtu")
                .map(|e| read(place.path(&format!("{name}.{e}"))))
                .collect();
            bytes.extend((0..5).map(|piece| read(place.path(&format!("{name}.pieces/000{piece}.vtu")))));
            bytes.push(read(place.path(&format!("{name}.node"))));
            let talk = stderr(&output);
            let notes: Vec<String> = talk
                .lines()
                .filter(|line| line.contains("z differ") || line.contains("grid") || line.contains("read  "))
                .map(str::to_owned)
                .collect();
            (bytes, notes)
        };
        let (one, notes) = run("one", "");
        assert!(input == "g.asc" || notes.iter().any(|note| note.contains("their z differ")), "{notes:?}");
        let (many, same) = run("many", "--transport processes --processes 3");
        assert!(one == many, "{input}");
        assert_eq!(notes, same, "{input}");
    }
}

#[test]
fn break_lines_are_edges_of_the_cells() {
    let place = Place::new();
    place.file("p.csv", table());
    place.file("a.wkt", "LINESTRING Z (5 5 1, 90 60 2, 40 90 3)\n");
    let line = r#"{"type": "LineString", "coordinates": [[5, 5, 1], [90, 60, 2], [40, 90, 3]]}"#;
    place.file("a.geojson", line);
    place.file("a.poly", "3 2 0 0\n1 5 5\n2 90 60\n3 40 90\n2 0\n1 1 2\n2 2 3\n");
    for lines in ["a.wkt", "a.geojson", "a.poly"] {
        let output = place.good(&format!("triangulate p.csv --terrain --breaklines {lines} -o m.off"));
        let talk = stderr(&output);
        assert!(talk.contains("edges of break lines are kept") && !talk.contains("septet verify"), "{talk}");
        let text = fs::read_to_string(place.path("m.off")).unwrap();
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(1)
            .map(|row| row.split_whitespace().map(|word| word.parse().unwrap()).collect())
            .collect();
        let [points, cells] = [rows[0][0] as usize, rows[0][1] as usize];
        let at = |v: f64| &rows[1 + v as usize];
        // The length of the edges of cells that lie on the lines.
        let cross =
            |p: &[f64], q: &[f64], r: &[f64]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let covered = |from: [f64; 2], to: [f64; 2]| {
            let mut seen = BTreeSet::new();
            for cell in &rows[1 + points..][..cells] {
                for (a, b) in [(cell[1], cell[2]), (cell[2], cell[3]), (cell[3], cell[1])] {
                    let on = |v: f64| cross(&from, &to, at(v)) == 0.0;
                    if on(a) && on(b) {
                        seen.insert([a.min(b) as u64, a.max(b) as u64]);
                    }
                }
            }
            let length = |&[a, b]: &[u64; 2]| {
                let (a, b) = (at(a as f64), at(b as f64));
                (a[0] - b[0]).hypot(a[1] - b[1])
            };
            seen.iter().map(length).sum::<f64>()
        };
        for (from, to) in [([5.0_f64, 5.0_f64], [90.0, 60.0]), ([90.0, 60.0], [40.0, 90.0])] {
            let whole = (from[0] - to[0]).hypot(from[1] - to[1]);
            assert!(covered(from, to) >= whole - 1e-9, "{lines}: {from:?} {to:?}");
        }
    }
    place.file("b.wkt", "LINESTRING (5 5, 90 60)\nLINESTRING (5 60, 90 5)\n");
    place.fails(
        "triangulate p.csv --terrain --breaklines b.wkt -o m.off",
        3,
        &["b.wkt", "crosses", "common point"],
    );
    place.file("c.wkt", "LINESTRING (5 5, 900 60)\n");
    place.fails("triangulate p.csv --terrain --breaklines c.wkt -o m.off", 3, &["900 60", "no height"]);
}
