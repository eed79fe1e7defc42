//! `--transport processes`: formats that one process writes, kept columns and dropped rows.
#![cfg(unix)]

use super::processes::outputs;
use super::*;

/// Removes the outputs of a run.
fn clear(place: &Place, name: &str) {
    for path in fs::read_dir(place.0.path()).unwrap().map(|entry| entry.unwrap().path()) {
        match path.file_stem() {
            Some(stem) if stem == name && path.is_dir() => fs::remove_dir_all(path).unwrap(),
            Some(stem) if stem == name => fs::remove_file(path).unwrap(),
            _ => {}
        }
    }
}

/// Runs a command in one process and in several. Their outputs have the same bytes.
fn same_outputs(line: &str, place: &Place, files: &[&str]) {
    let all = |name: &str| files.iter().map(|file| format!("-o {name}.{file}")).collect::<Vec<_>>().join(" ");
    clear(place, "one");
    place.good(&format!("{line} -q --workers 5 {}", all("one")));
    let expected = outputs(place, "one");
    assert!(expected.len() >= files.len(), "{line}");
    for processes in [2, 5] {
        clear(place, "many");
        let several = format!("--workers 5 --transport processes --processes {processes} {}", all("many"));
        place.good(&format!("{line} -q {several}"));
        assert!(outputs(place, "many") == expected, "{line}: {processes} processes");
    }
}

/// Every format that one process writes.
#[test]
fn all_formats_have_the_bytes_of_one_process() {
    let place = Place::new();
    for kind in ["uniform:400", "uniform:300,d=2", "line:20"] {
        for command in ["triangulate", "simulate"] {
            let line = format!("{command} sample:{kind}");
            same_outputs(&line, &place, &["vtk", "msh", "msh22", "mesh", "off", "stl", "npy", "vtu", "pvtu"]);
            same_outputs(&line, &place, &["ele"]);
            same_outputs(&format!("{line} --with-owner"), &place, &["vtu", "pvtu", "vtk", "npy", "vtu.gz"]);
        }
    }
}

/// Kept columns and dropped rows, in one file and in a list.
#[test]
fn columns_and_dropped_rows_have_the_bytes_of_one_process() {
    let place = Place::new();
    let row = |i: u64| {
        let x = if i % 17 == 5 { "nan".to_owned() } else { format!("{}", i * 37 % 101) };
        format!("{x},{},{},{}\n", i * 23 % 97, i * 11 % 89, i * i)
    };
    let file = |name: &str, rows: std::ops::Range<u64>| {
        place.file(name, rows.fold("x,y,z,mass\n".to_owned(), |text, i| text + &row(i)));
    };
    file("all.csv", 0..120);
    file("p-1.csv", 0..70);
    file("p-2.csv", 70..120);
    for input in ["all.csv", "p-*.csv"] {
        let line = format!("triangulate {input} --skip-invalid");
        same_outputs(&line, &place, &["npy", "vtu", "pvtu", "vtk", "msh"]);
        let line = format!("{line} --keep-columns");
        same_outputs(&line, &place, &["vtu", "pvtu", "vtk", "npy"]);
    }
    let many = "--transport processes --workers 2";
    place.fails(&format!("triangulate all.csv --keep-columns -o m.npy {many}"), 2, &["--keep-columns"]);
}
