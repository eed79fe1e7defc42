//! Lists of point files: patterns and files of names in place of one file.

use std::fs;

use super::{Place, code, stderr};

/// Formats of the whole file and its parts.
const FORMATS: [&str; 3] = ["npy", "xyz", "csv"];

/// Writes a set of points as one file, `whole.csv`, and as parts in the three formats. The names of the parts ascend.
fn parts(place: &Place, dimension: usize) {
    place.good(&format!("generate uniform -n 300 -d {dimension} -o whole.csv"));
    let text = fs::read_to_string(place.path("whole.csv")).unwrap();
    let rows: Vec<&str> = text.lines().collect();
    let bounds = [0, 7, 7, 120, 301, rows.len()].map(|at: usize| at.min(rows.len()));
    for (part, ends) in bounds.windows(2).enumerate() {
        let rows = &rows[ends[0]..ends[1]];
        for format in FORMATS {
            place.file(&format!("part-{part}.{format}"), encoded(rows, dimension, format));
        }
    }
    place
        .file("whole.xyz", encoded(&rows, dimension, "xyz"))
        .file("whole.npy", encoded(&rows, dimension, "npy"));
}

/// Rows of a `.csv` file without a header row, in another format.
fn encoded(rows: &[&str], dimension: usize, format: &str) -> Vec<u8> {
    if format == "npy" {
        let numbers = rows.iter().flat_map(|row| row.split(',')).map(|n| n.parse::<f64>().unwrap());
        return npy("<f8", [rows.len(), dimension], &numbers.flat_map(f64::to_le_bytes).collect::<Vec<u8>>());
    }
    let row = |row: &&str| if format == "csv" { format!("{row}\n") } else { row.replace(',', " ") + "\n" };
    rows.iter().map(row).collect::<String>().into_bytes()
}

fn npy(kind: &str, shape: [usize; 2], data: &[u8]) -> Vec<u8> {
    let [rows, columns] = shape;
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}), }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00".as_slice(), &length, header.as_bytes(), data].concat()
}

/// Asserts that an input gives the outputs of `whole.xyz`.
fn assert_whole(place: &Place, input: &str) {
    let outputs = ["vtu", "npy", "1.ele", "1.node"];
    let run = |input: &str, stem: &str| {
        place.good(&format!("triangulate {input} -o {stem}.vtu -o {stem}.npy -o {stem}.1.ele"));
        outputs.map(|output| fs::read(place.path(&format!("{stem}.{output}"))).unwrap())
    };
    let (whole, list) = (run("whole.xyz", "w"), run(input, "l"));
    for ((whole, list), output) in whole.iter().zip(&list).zip(outputs) {
        assert!(whole == list, "{input}: {output} differs");
    }
}

#[test]
fn a_list_has_the_outputs_of_the_whole_file() {
    for dimension in [2, 3] {
        let place = Place::new();
        parts(&place, dimension);
        for format in FORMATS {
            assert_whole(&place, &format!("whole.{format}"));
            assert_whole(&place, &format!("part-*.{format}"));
        }
        place
            .file("mixed.txt", "# parts\npart-0.npy\n\npart-1.csv\npart-2.xyz\n  part-3.npy\r\npart-4.csv\n");
        assert_whole(&place, "@mixed.txt");
        fs::create_dir(place.path("names")).unwrap();
        let lines = |folder: &str| [0, 1, 2, 3, 4].map(|part| format!("{folder}/part-{part}.xyz")).join("\n");
        place.file("names/list", lines(".."));
        assert_whole(&place, "@names/list");
        let output = place.feed("triangulate @- -o stream.npy", lines(".").as_bytes());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert_eq!(fs::read(place.path("stream.npy")).unwrap(), fs::read(place.path("w.npy")).unwrap());
    }
}

#[test]
fn every_command_that_reads_points_reads_lists() {
    let place = Place::new();
    parts(&place, 3);
    let talk = stderr(&place.good("simulate part-*.npy --json list.json -o list.npy"));
    assert!(talk.contains("read 300 points from 5 files"), "{talk}");
    assert!(
        talk.contains("`septet verify POINTS CELLS`") || talk.contains("septet report list.json"),
        "{talk}"
    );
    place.good("simulate whole.npy --json whole.json -o whole.cells.npy");
    let [list, whole] = ["list.json", "whole.json"].map(|name| place.json(name));
    assert_eq!(list["parameters"]["input"], "part-*.npy");
    assert_eq!(list["points"], whole["points"]);
    assert_eq!(list["machine"], whole["machine"]);
    assert_eq!(fs::read(place.path("list.npy")).unwrap(), fs::read(place.path("whole.cells.npy")).unwrap());
    place.good("verify whole.npy list.npy --perturbed");
    place.file("list.txt", "part-0.npy\npart-3.xyz\n");
    for command in
        ["predict @list.txt --workers 2 --json a.json", "rival incremental @list.txt --json a.json"]
    {
        place.good(command);
        assert_eq!(place.json("a.json")["points"], 187, "{command}");
        assert_eq!(place.json("a.json")["input"], "@list.txt", "{command}");
    }
}

#[test]
fn files_of_a_pattern_are_in_byte_order() {
    let place = Place::new();
    place.file("part-1.xyz", "0 0\n1 0\n").file("part-10.xyz", "0 1\n").file("part-2.xyz", "5 5\n");
    place.file("whole.xyz", "0 0\n1 0\n0 1\n5 5\n");
    assert_whole(&place, "part-*.xyz");
    assert_whole(&place, "part-[0-9]*.xyz");
    place.good("triangulate part-?.xyz");
    // A file with exactly this name takes precedence.
    place.file("part-[12].xyz", "0 0\n1 0\n0 1\n5 5\n");
    let talk = stderr(&place.good("triangulate part-[12].xyz"));
    assert!(!talk.contains("files") && talk.contains("4 points"), "{talk}");
}

#[test]
fn empty_files_are_legal() {
    let place = Place::new();
    place
        .file("a.xyz", "")
        .file("b.csv", "x,y,z\n")
        .file("c.xyz", "# nothing\n")
        .file("d.npy", npy("<f4", [0, 2], b""));
    place.file("e.csv", "z,y,x\n0,0,0\n0,0,1\n0,1,0\n1,0,0\n").file("f.npy", npy("<f8", [0, 3], b""));
    place.file("list.txt", "a.xyz\nb.csv\nc.xyz\nd.npy\ne.csv\nf.npy\n");
    place.file("whole.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    assert_whole(&place, "@list.txt");
    place.file("none.txt", "a.xyz\nb.csv\nd.npy\n");
    let talk = stderr(&place.good("triangulate @none.txt"));
    assert!(talk.contains("read 0 points from 3 files"), "{talk}");
}

#[test]
fn bad_points_are_named_by_file_and_rows() {
    let place = Place::new();
    place
        .file("p-0.xyz", "0 0 0\n1 0 0\n")
        .file("p-1.csv", "x,y,z\n0,1,0\n0,0,1\n1,1,nan\n")
        .file("p-2.xyz", "2 2 2\n");
    let rows = ["p-1.csv, line 4", "row 4 of the list, row 2 of its file", "point 2", "--skip-invalid"];
    place.fails("triangulate p-*", 3, &rows);
    place.fails("rival incremental p-*", 3, &rows);
    let talk = stderr(&place.good("triangulate p-* --skip-invalid -o cells.npy"));
    assert!(talk.contains("1 invalid point skipped"), "{talk}");
    // Cells count all rows, including the dropped one.
    let cells = fs::read(place.path("cells.npy")).unwrap();
    let ids: Vec<i64> =
        cells[cells.len() % 8..].chunks_exact(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect();
    assert!(ids.contains(&5) && !ids.contains(&4), "{ids:?}");
    let bad: Vec<u8> =
        [0.0, 0.0, 0.5, 0.25, 0.5, f64::INFINITY].iter().flat_map(|v: &f64| v.to_le_bytes()).collect();
    place.file("q.npy", npy("<f8", [2, 3], &bad)).file("q.txt", "p-0.xyz\nq.npy\n");
    place.fails("simulate @q.txt", 3, &["q.npy, byte", "row 3 of the list, row 1 of its file", "inf"]);
    place.file("word.xyz", "0 0 0\n0 x 0\n").file("w.txt", "p-0.xyz\nword.xyz\n");
    place.fails(
        "triangulate @w.txt",
        3,
        &["word.xyz, line 2", "row 3 of the list, row 1 of its file", "\"x\""],
    );
    place.file("wide.xyz", "1 1 1\n1e300 0 0\n").file("r.txt", "p-0.xyz\nwide.xyz\ntiny.xyz\n");
    place.file("tiny.xyz", "0 1e-300 0\n0 0 1\n");
    let words = &["point 4 needs", "point 4 is row 0 of tiny.xyz", "point 3 is row 1 of wide.xyz"];
    place.fails("triangulate @r.txt", 3, words);
}

#[test]
fn files_that_do_not_agree_are_refused() {
    let place = Place::new();
    place.file("a.xyz", "0 0 0\n1 0 0\n").file("b.xyz", "0 1\n").file("ab.txt", "a.xyz\nb.xyz\n");
    place.fails("triangulate @ab.txt", 3, &["b.xyz: points of dimension 2", "a.xyz", "--dimension 2"]);
    place.good("triangulate @ab.txt -d 2");
    place.fails("triangulate @ab.txt -d 3", 3, &["b.xyz, line 1", "row 2 of the list"]);
    place.file("c.npy", npy("<f8", [1, 3], &[0; 24])).file("d.npy", npy("<f4", [1, 3], &[0; 12]));
    place
        .file("e.npy", npy("<i4", [1, 3], &[0; 12]))
        .file("cad.txt", "c.npy\na.xyz\nd.npy\n")
        .file("de.txt", "d.npy\ne.npy\n");
    place.fails("triangulate @cad.txt", 3, &["d.npy: coordinates of type float32", "c.npy", "float64"]);
    place.fails("predict @de.txt", 3, &["e.npy: coordinates of type integer", "d.npy", "float32"]);
}

#[test]
fn options_of_reading_apply_to_every_file() {
    let place = Place::new();
    place
        .file("a.csv", "id,u,v\n7,0,0\n8,1,0\n")
        .file("b.csv", "v,id,u\n1,9,0\n")
        .file("whole.xyz", "0 0\n1 0\n0 1\n");
    place.file("none.csv", "u,v,id\n").file("kept.csv", "id,u,v\n7,0,0\n8,1,0\n9,0,1\n");
    place.file("list.txt", "a.csv\nb.csv\n").file("all.txt", "a.csv\nnone.csv\nb.csv\n");
    place.fails("triangulate @list.txt", 2, &["a.csv, line 1", "--columns"]);
    place.good("triangulate @list.txt --columns u,v -o list.npy");
    place.good("triangulate whole.xyz -o whole.npy");
    assert_eq!(fs::read(place.path("list.npy")).unwrap(), fs::read(place.path("whole.npy")).unwrap());
    for list in ["@list.txt", "kept.csv"] {
        place.good(&format!("triangulate {list} --columns u,v --keep-columns -o {}.vtu", &list[1..4]));
    }
    assert_eq!(fs::read(place.path("lis.vtu")).unwrap(), fs::read(place.path("ept.vtu")).unwrap());
    place.file("other.csv", "u,v,mass\n0,1,3\n").file("other.txt", "a.csv\nother.csv\n");
    place.good("triangulate @other.txt --columns u,v");
    let words = &["other.csv: the kept columns are mass", "a.csv has id", "--keep-columns"];
    place.fails("triangulate @other.txt --columns u,v --keep-columns -o o.vtu", 3, words);
    place.file("p.foo", "0 0\n1 0\n").file("q.foo", "0 1\n");
    place.fails("triangulate *.foo", 2, &["p.foo", "--input-format"]);
    place.good("triangulate *.foo --input-format xyz -o foo.npy");
    assert_eq!(fs::read(place.path("foo.npy")).unwrap(), fs::read(place.path("whole.npy")).unwrap());
}

#[test]
fn faulty_lists_and_patterns_are_refused() {
    let place = Place::new();
    place.file("a.xyz", "0 0\n1 0\n0 1\n");
    place.fails("triangulate b-*.xyz", 3, &["b-*.xyz: no file matches this pattern", "help:"]);
    place.fails("triangulate absent/*.xyz", 3, &["absent/*.xyz", "the folder absent cannot be read"]);
    place.fails("triangulate a**.xyz", 2, &["a**.xyz: invalid pattern"]);
    place.fails("triangulate @absent.txt", 3, &["absent.txt: no such file"]);
    for (list, words) in [
        ("a.xyz\n\ngone.xyz\n", ["l.txt, line 3: gone.xyz: no such file", "relative to the folder"]),
        ("a.xyz\nl.txt\n", ["l.txt, line 2: l.txt: is this list itself", "remove"]),
        ("@l.txt\n", ["l.txt, line 1: @l.txt: is this list itself", "remove"]),
        ("@a.xyz\n", ["l.txt, line 1: @a.xyz: a list cannot contain a list", "./@NAME"]),
        ("a.xyz\n-\n", ["l.txt, line 2: -: a list cannot contain standard input", "save"]),
        ("# a.xyz\n", ["l.txt: the list names no file", "one path per line"]),
    ] {
        place.file("l.txt", list);
        place.fails("triangulate @l.txt -o l.vtu", 3, &words);
    }
    place.fails("mesh a*.poly -o m.vtu", 2, &["a*.poly", "a domain or a file of sizes is one file"]);
    place.fails("mesh @l.txt -o m.vtu", 2, &["@l.txt", "a domain or a file of sizes is one file"]);
    for line in ["verify a*.xyz c.npy", "verify @l.txt c.npy", "verify a.xyz c*.npy", "verify a.xyz @l.txt"] {
        place.fails(line, 2, &["a triangulation has one file of points and one file of cells"]);
    }
}

#[test]
fn files_of_a_list_are_not_overwritten() {
    let place = Place::new();
    place.file("a.npy", npy("<f8", [1, 2], &[0; 16])).file("b.npy", npy("<f8", [1, 2], &[0; 16]));
    place.file("list.txt", "a.npy\nb.npy\n");
    place.fails("triangulate *.npy -o b.npy", 2, &["b.npy would overwrite the input file b.npy"]);
    place.fails("triangulate @list.txt -o b.npy", 2, &["b.npy would overwrite the input file b.npy"]);
    place.fails(
        "triangulate @list.txt --json list.txt",
        2,
        &["list.txt would overwrite the input file list.txt"],
    );
}

#[test]
fn names_that_a_shell_has_expanded_are_refused_with_advice() {
    let place = Place::new();
    place.file("a.xyz", "0 0\n1 0\n0 1\n").file("b.xyz", "1 1\n");
    place.fails(
        "triangulate a.xyz b.xyz",
        2,
        &["unexpected argument 'b.xyz'", "quote a pattern", "@list.txt"],
    );
    let talk = stderr(&place.run("mesh a.xyz b.xyz"));
    assert!(!talk.contains("quote a pattern"), "{talk}");
}
