//! Dimensions 4 to 6: what is read, written and refused.

#[cfg(feature = "dimensions")]
use std::fs;

#[cfg(feature = "dimensions")]
use serde_json::Value;

use super::Place;
#[cfg(feature = "dimensions")]
use super::stderr;

fn array(columns: usize, numbers: &[f64]) -> Vec<u8> {
    let rows = numbers.len() / columns;
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}\n");
    let length = (header.len() as u16).to_le_bytes();
    let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    [b"\x93NUMPY\x01\x00".as_slice(), &length, header.as_bytes(), &data].concat()
}

/// A place with a set of dimension 4 as `p.npy` and `p.txt`.
fn place_with_points() -> Place {
    let place = Place::new();
    place.good("generate uniform -n 40 -d 4 -o p.npy");
    place.good("generate uniform -n 40 -d 4 -o p.txt");
    place
}

#[test]
fn formats_and_options_of_space_are_refused() {
    let place = place_with_points();
    for output in
        ["m.vtu", "m.vtk", "m.msh", "m.mesh", "m.1.ele", "m.off", "m.stl", "m.obj", "m.ply", "m.pvtu"]
    {
        place.fails(&format!("triangulate p.npy -o {output}"), 2, &[output, "dimensions 2 and 3", ".npy"]);
    }
    place.fails("triangulate p.npy -o m.svg", 2, &["m.svg"]);
    place.fails("generate uniform -n 9 -d 5 -o p.vtu", 2, &["p.vtu", "dimensions 2 and 3"]);
    place.fails("generate shells -n 48 -d 4", 2, &["shells", "dimension 4", "uniform"]);
    place.fails("triangulate p.npy --stats", 2, &["--stats", "dimension 4"]);
    place.fails("triangulate p.npy --periodic 1,1,1,1", 2, &["periodic", "dimension 4"]);
    if cfg!(feature = "dimensions") {
        place.fails("simulate p.npy --partition hilbert", 2, &["Hilbert", "dimension"]);
    }
    place.file("w.npy", array(1, &[1.0; 40]));
    place.fails("triangulate p.npy --weights w.npy", 3, &["dimension 4 have no weights"]);
    place.fails("triangulate sample:uniform:9,d=7", 2, &["2 to 6"]);
    place.fails("triangulate p.npy -d 7", 2, &["2 to 6"]);
}

#[test]
fn no_column_is_dropped_silently() {
    let place = place_with_points();
    place.file("one.npy", array(4, &[0.5, 1.0, 2.0, 1.0, 3.0, 4.0, 5.0, 1.0]));
    place.fails("triangulate one.npy", 3, &["(2, 4)", "homogeneous coordinates?", "--dimension 4"]);
    place.file("many.npy", array(7, &[1.0; 70]));
    place.fails("triangulate many.npy", 3, &["(10, 7)", "supported: 2 to 6"]);
    place.fails("triangulate p.npy -d 3", 3, &["(40, 4)"]);
    place.fails("triangulate p.txt", 2, &["4 columns of numbers", "--columns"]);
    place.fails("triangulate p.txt -d 5", 3, &["4 coordinates instead of 5"]);
}

#[cfg(not(feature = "dimensions"))]
#[test]
fn a_build_without_the_feature_names_it() {
    let place = place_with_points();
    for command in
        ["triangulate p.npy", "simulate p.npy", "triangulate p.txt -d 4", "simulate sample:uniform:50,d=6"]
    {
        place.fails(command, 2, &["feature `dimensions`"]);
    }
}

#[cfg(feature = "dimensions")]
#[test]
fn both_commands_give_the_same_cells() {
    let place = place_with_points();
    place.good("simulate p.npy -o a.npy --json a.json");
    let cells = fs::read(place.path("a.npy")).unwrap();
    for command in [
        "triangulate p.npy",
        "triangulate p.txt -d 4",
        "simulate p.txt --columns 1,2,3,4 --workers 3",
        "simulate p.npy --workers 8 --transport sim",
        "triangulate p.npy --transport processes --processes 2",
        "simulate p.npy --transport processes --processes 3",
    ] {
        place.good(&format!("{command} -o b.npy"));
        assert!(fs::read(place.path("b.npy")).unwrap() == cells, "{command}");
    }
    let report: Value = serde_json::from_str(&fs::read_to_string(place.path("a.json")).unwrap()).unwrap();
    assert_eq!((&report["space"], &report["dimension"]), (&4.into(), &4.into()));
    assert!(report["machine"]["paper"]["work"].as_u64() > Some(0));
    place.good("report a.json -o a.html");
}

#[cfg(feature = "dimensions")]
#[test]
fn samples_and_flat_sets_have_reports() {
    let place = Place::new();
    for (dimension, n) in [(4, 60), (5, 30), (6, 16)] {
        let output = place.good(&format!("simulate sample:uniform:{n},d={dimension}"));
        let said = stderr(&output);
        assert!(
            said.contains(&format!("{dimension}-simplices")) && said.contains("certificate passed"),
            "{said}"
        );
    }
    let flat: Vec<f64> =
        (0..60).flat_map(|i| [f64::from(i), f64::from(i * i % 17), 3.0, f64::from(i % 5)]).collect();
    place.file("flat.npy", array(4, &flat));
    for command in ["triangulate", "simulate"] {
        place.good(&format!("{command} flat.npy -o none.npy"));
        assert!(String::from_utf8_lossy(&fs::read(place.path("none.npy")).unwrap()).contains("(0, 5)"));
    }
}
