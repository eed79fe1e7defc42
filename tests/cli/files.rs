//! Files as users name them: columns, formats, endings, compression, standard output.

use std::fs;

use super::{Place, code, stderr};

const CATALOGUE: &str = "id,ra,dec,z\n7,0,0,0\n8,4,0,0\n9,0,4,0\n10,0,0,4\n11,1,1,1\n";

#[test]
fn a_header_row_is_obeyed_or_refused() {
    let place = Place::new();
    place.file("named.csv", "id,z,y,x\n9,0,0,0\n8,0,0,1\n7,0,1,0\n6,1,0,0\n");
    let output = place.good("triangulate named.csv -o named.npy");
    assert!(stderr(&output).contains("coordinates are x, y, z; column id is ignored"), "{}", stderr(&output));
    place.file("plain.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    place.good("verify plain.xyz named.npy --perturbed");
    place.file("cat.csv", CATALOGUE);
    let words = &["cat.csv, line 1", "id, ra, dec, z", "with --columns"];
    place.fails("triangulate cat.csv -o cat.vtu", 2, words);
    place.fails("simulate cat.csv", 2, words);
    place.fails("rival incremental cat.csv", 2, words);
    place.fails("verify cat.csv named.npy", 2, words);
    for columns in ["ra,dec,z", "2,3,4", "RA,Dec,4"] {
        place.good(&format!("triangulate cat.csv --columns {columns} -o cells.npy"));
        place.good(&format!("verify cat.csv cells.npy --columns {columns} --perturbed"));
    }
    place.fails("triangulate cat.csv --columns ra,nothing", 2, &["no column nothing"]);
    place.fails("triangulate sample:uniform:9 --columns x,y", 2, &["--columns", "sample"]);
    place.fails("triangulate plain.npy --columns 1,2", 3, &["no such file"]);
}

#[test]
fn a_run_says_what_it_read() {
    let place = Place::new();
    let rows = "7,47.5,9.25,1\n8,47,9.5,2\n# c\n9,47.25,9.75,3\n9,47.25,9.75,3\n";
    place.file("a.csv", format!("id,lat,lon,t\n{rows}"));
    for processes in ["", " --transport processes --processes 2"] {
        let output = place.good(&format!("triangulate a.csv --json a.json{processes}"));
        let line = "read        a.csv: 4 rows, columns lon lat (2 ignored), 1 header line, 1 comment line; \
                    x 9.25 to 9.75, y 47.0 to 47.5";
        assert!(stderr(&output).contains(line), "{}", stderr(&output));
        let report: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(place.path("a.json")).unwrap()).unwrap();
        let wanted = serde_json::json!({
            "rows": 4, "columns": ["lon", "lat"], "ignored": ["id", "t"],
            "header_lines": 1, "count_lines": 0, "comment_lines": 1, "blank_lines": 0,
            "terrain": false, "height_difference": null, "extent": [[9.25, 9.75], [47.0, 47.5]], "duplicates": 1,
        });
        assert_eq!(report["input"], wanted);
    }
    place.good("triangulate sample:uniform:30 --json s.json");
    assert!(!fs::read_to_string(place.path("s.json")).unwrap().contains("\"input\": {"));
    place.file("ids.txt", "1 0.5 2\n2 3 4\n3 5 7\n");
    place.fails("triangulate ids.txt", 2, &["counts the rows from 1", "--columns 2,3"]);
    place.good("triangulate ids.txt --columns 2,3");
    place.file("grid.asc", "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 4\n");
    place.fails("triangulate grid.asc", 3, &["a grid of heights", "--terrain"]);
}

#[test]
fn a_file_of_words_alone_is_refused() {
    let place = Place::new();
    place.file("w.xyz", "hello world\n");
    place.fails("triangulate w.xyz -o w.npy", 3, &["w.xyz, line 1", "hello world", "rows of numbers"]);
    place.file("labels.csv", "A,1,2,3\nB,4,5,6\n");
    place.fails("triangulate labels.csv", 3, &["labels.csv", "--columns 2,3,4"]);
    place.file("quoted.csv", "\"1\",\"2\"\n\"3\",\"4\"\n\"5\",\"0\"\n");
    place.good("triangulate quoted.csv -o q.npy");
}

#[test]
fn other_columns_become_data_of_the_points() {
    let place = Place::new();
    place.file("cat.csv", CATALOGUE);
    place.good("triangulate cat.csv --columns ra,dec,z --keep-columns -o cat.vtu -o cat.vtk -o plain.npy");
    for file in ["cat.vtu", "cat.vtk"] {
        let bytes = fs::read(place.path(file)).unwrap();
        let ids = [7.0f64, 8.0, 9.0, 10.0, 11.0];
        let little: Vec<u8> = ids.iter().flat_map(|id| id.to_le_bytes()).collect();
        let big: Vec<u8> = ids.iter().flat_map(|id| id.to_be_bytes()).collect();
        let wanted = if file == "cat.vtu" { little } else { big };
        assert!(bytes.windows(wanted.len()).any(|w| w == wanted), "{file}");
        place.good(&format!("verify {file} {file}"));
    }
    let words = &["--keep-columns", "-o OUT.vtu"];
    place.fails("triangulate cat.csv --columns ra,dec,z --keep-columns -o cat.msh", 2, words);
}

#[test]
fn formats_are_recognised_and_stated() {
    let place = Place::new();
    let square = "0 0\n1 0\n0 1\n1 1\n0.4 0.3\n";
    for name in ["p.dat", "p.pts", "p.asc", "points"] {
        place.file(name, square);
        place.good(&format!("triangulate {name} -o a.vtk"));
        place.good(&format!("verify {name} a.vtk --perturbed"));
    }
    place.file("p.foo", square);
    place.fails("triangulate p.foo", 2, &["unknown format", ".vtk", "--input-format"]);
    place.good("triangulate p.foo --input-format xyz -o b.npy");
    place.good("verify p.foo b.npy --input-format txt");
    place.fails("triangulate p.foo --input-format zzz", 2, &["--input-format", "vtu"]);
    place.fails("triangulate p.foo --input-format vut", 2, &["the nearest is vtu"]);
    place.file("set.dat", "4 2 0 0\n1 0 0\n2 1 0\n3 0 1\n4 1 1.5\n");
    let talk = stderr(&place.good("triangulate set.dat -o set.1.ele"));
    assert!(talk.contains("4 points") && talk.contains("septet verify set.1.node set.1.ele"), "{talk}");
    place.good("verify set.1.node set.1.ele");
    place.file("four.csv", "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n");
    place.fails("triangulate four.csv", 2, &["4 columns of numbers", "with --columns"]);
    place.good("triangulate four.csv --columns 2,3,4");
    let talk = stderr(&place.good("triangulate four.csv -d 3"));
    assert!(talk.contains("columns after the first 3 are ignored"), "{talk}");
    place.file("header.xyz", "name x y z\n");
    place.fails("triangulate header.xyz", 3, &["header.xyz, line 1", "a header and no rows"]);
    place.good("generate uniform -n 50 -o p.vtk");
    place.good("triangulate p.vtk -o c.vtu.gz -o c.1.ele.gz -o c.npy");
    for cells in ["c.vtu.gz", "c.1.ele.gz", "c.npy"] {
        place.good(&format!("verify p.vtk {cells} --perturbed"));
    }
    assert!(place.path("c.1.node.gz").exists());
    place.good("generate uniform -n 50 -o p.out --format csv");
    assert!(fs::read_to_string(place.path("p.out")).unwrap().lines().all(|l| l.split(',').count() == 3));
}

#[test]
fn errors_list_formats_and_name_the_nearest() {
    let place = Place::new();
    place.file("p.xyz", "0 0\n1 0\n0 1\n");
    for (output, word) in [
        ("a.cgns", "write .vtu for ParaView"),
        ("a.vut", "the nearest is .vtu"),
        ("a", ".msh22"),
        ("-", "--format"),
    ] {
        place.fails(&format!("triangulate p.xyz -o {output}"), 2, &["unknown output format", ".vtk", word]);
    }
    place.fails("triangulate p.xyz -o - --format ele", 2, &["several files"]);
    place.fails("triangulate p.xyz -o - --format vtu --json -", 2, &["standard output"]);
    place.fails("triangulate .", 3, &["is a directory", "name a file in it"]);
    place.fails("triangulate uniform:100", 3, &["no such file", "sample:uniform:100"]);
    place.file("scan.pcd", "# .PCD v0.7");
    place.fails("triangulate scan.pcd", 2, &["convert the point cloud to .ply"]);
}

#[test]
fn standard_output_receives_the_bytes_of_a_file() {
    let place = Place::new();
    place.good("triangulate sample:uniform:200 -o a.vtu");
    let output = place.run("triangulate sample:uniform:200 -o - --format vtu");
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(output.stdout.starts_with(b"<?xml") && output.stdout == fs::read(place.path("a.vtu")).unwrap());
    let domain = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/domains/good/map.poly");
    let output = place.run(&format!("mesh {domain} --size 1 -o - --format vtk"));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(output.stdout.starts_with(b"# vtk DataFile"));
}

#[test]
fn a_size_field_of_the_wrong_width_is_a_fault_of_the_file() {
    let place = Place::new();
    let domain = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/domains/good/cube.poly");
    place.file("plane.txt", "0 0 1\n").file("wide.txt", "0 0 0 0 0 1\n");
    place.fails(&format!("mesh {domain} -o m.vtu --size-field plane.txt"), 3, &["the size field has 2"]);
    place.fails(&format!("mesh {domain} -o m.vtu --size-field wide.txt"), 3, &["wide.txt", "three or four"]);
}

/// A value for missing data is named, with its row.
#[test]
fn far_points_are_named() {
    let place = Place::new();
    let rows = (0..200).map(|i| format!("{},{}\n", i * 37 % 101, i * 61 % 97));
    let table: String = std::iter::once("x,y\n".to_owned()).chain(rows).collect();
    place.file("scan.csv", &table);
    let output = place.good("triangulate scan.csv");
    assert!(!stderr(&output).contains("as far as"), "{}", stderr(&output));
    place.file("scan.csv", table + "1e20,3\n");
    let note = "times as far as the median point; it is point 200 (from 0)";
    for processes in ["", " --transport processes --processes 3"] {
        let output = place.good(&format!("triangulate scan.csv{processes}"));
        assert!(stderr(&output).contains(note), "{}", stderr(&output));
    }
}

/// Duplicates have rows, which are counted in the input.
#[test]
fn rows_of_duplicates_are_written() {
    let place = Place::new();
    place.file("d.csv", "x,y\n0,0\n1,0\n0,1\nnan,1\n1,0\n0,0\n0,0\n");
    place.good("triangulate d.csv --skip-invalid --duplicates d.rows --workers 3");
    assert_eq!(fs::read_to_string(place.path("d.rows")).unwrap(), "row,first\n4,1\n5,0\n6,0\n");
    place.file("e.csv", "x,y\n0,0\n1,0\n0,1\n1,0\n0,0\n");
    for processes in ["", " --transport processes --processes 2"] {
        place.good(&format!("triangulate e.csv --duplicates e.rows{processes}"));
        assert_eq!(fs::read_to_string(place.path("e.rows")).unwrap(), "row,first\n3,1\n4,0\n");
    }
    place.fails("triangulate e.csv --duplicates e.csv", 2, &["e.csv"]);
}
