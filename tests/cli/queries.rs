//! `locate`, `interpolate`, `voronoi` and `alpha`.

use super::*;

/// Stations in a square with a linear value, and one that coincides with the first.
const STATIONS: &str = "x,y,rain\n0,0,1\n4,0,5\n0,4,9\n4,4,13\n1,2,6\n0,0,7\n";
const QUERIES: &str = "x,y\n1,1\n4,4\n5,5\n2,0\n";

fn text(place: &Place, name: &str) -> String {
    std::fs::read_to_string(place.path(name)).unwrap()
}

#[test]
fn queries_find_their_simplices() {
    let place = Place::new();
    place.file("p.csv", STATIONS).file("q.csv", QUERIES);
    let output = place.good("locate p.csv q.csv -o out.csv");
    assert!(stderr(&output).contains("4 queries, 3 inside of the hull"), "{}", stderr(&output));
    let found = text(&place, "out.csv");
    assert!(found.starts_with("row,simplex\n0,") && found.contains("\n2,\n"), "{found}");
    // The numbers are those of the rows of `triangulate`.
    place.good("triangulate p.csv -o p.1.ele");
    let cells = text(&place, "p.1.ele");
    let row: usize = found.lines().nth(2).unwrap().split(',').nth(1).unwrap().parse().unwrap();
    let cell: Vec<&str> = cells.lines().nth(row + 1).unwrap().split_whitespace().skip(1).collect();
    assert!(cell.contains(&"3"), "{cells}");
    let printed = place.good("locate p.csv q.csv --threads 1 -q");
    assert_eq!(String::from_utf8(printed.stdout).unwrap(), found);
    // Arrays have no other columns.
    place.good("generate uniform -n 60 -d 2 -o a.npy");
    place.good("locate a.npy a.npy -o all.csv");
    assert!(!text(&place, "all.csv").contains(",\n"));
    place.good("voronoi a.npy --box 0,0,1,1 -o cells.csv");
    place.good("interpolate p.csv a.npy --values rain -o rain.csv");
    // Every point is inside, also with ties and in space.
    for sample in ["sample:grid:1000", "sample:sphere:300", "sample:uniform:500,d=2"] {
        let output = place.good(&format!("locate {sample} {sample} -o all.csv"));
        assert!(!text(&place, "all.csv").contains(",\n"), "{sample}: {}", stderr(&output));
    }
}

#[test]
fn values_are_interpolated() {
    let place = Place::new();
    place.file("p.csv", STATIONS).file("q.csv", QUERIES);
    for method in ["", " --method linear", " --method sibson", " --method laplace"] {
        let output = place.good(&format!("interpolate p.csv q.csv --values rain{method}"));
        let found = String::from_utf8(output.stdout).unwrap();
        let fields: Vec<&str> = found.lines().skip(1).map(|line| line.split_once(',').unwrap().1).collect();
        let expected = [Some(4.0), Some(13.0), None, Some(3.0)];
        for (field, expected) in fields.iter().zip(expected) {
            let value: Option<f64> = field.parse().ok();
            assert_eq!(value.is_some(), expected.is_some(), "{found}");
            assert!((value.unwrap_or(0.0) - expected.unwrap_or(0.0)).abs() < 1e-12, "{method} {found}");
        }
        assert!(found.starts_with("row,value\n") && fields.len() == 4);
    }
    place.fails("interpolate p.csv q.csv --values snow", 3, &["p.csv", "snow", "rain"]);
    place.fails("interpolate p.csv q.csv --values rain --method cubic", 2, &["cubic", "sibson"]);
    place.fails("interpolate q.csv p.csv --values rain", 3, &["no column", "other columns"]);
}

#[test]
fn volumes_add_up_to_the_box() {
    let place = Place::new();
    place.file("p.csv", STATIONS);
    for (input, corners, whole) in [
        ("p.csv", "-1,-1,5,5", 36.0),
        ("sample:uniform:500", "0,0,0,1,1,1", 1.0),
        ("sample:uniform:300,d=2", "-0.5,0,1,1", 1.5),
    ] {
        place.good(&format!("voronoi {input} --box {corners} -o cells.csv"));
        let found = text(&place, "cells.csv");
        let volumes =
            found.lines().skip(1).map(|line| line.split_once(',').unwrap().1.parse::<f64>().unwrap());
        let volumes: Vec<f64> = volumes.collect();
        assert!((volumes.iter().sum::<f64>() - whole).abs() < 1e-12, "{input}");
        assert_eq!(volumes.iter().filter(|volume| **volume == 0.0).count(), usize::from(input == "p.csv"));
    }
    place.fails("voronoi p.csv --box 0,0,1,1", 3, &["p.csv", "point 1", "outside of the box"]);
    place.fails("voronoi p.csv --box 0,0,0,1,1,1", 2, &["6 numbers", "need 4"]);
    place.fails("voronoi p.csv --box 4,0,0,4", 2, &["box is empty"]);
    place.fails("voronoi p.csv", 2, &["need a box", "--box"]);
    place.file("line.csv", "x,y\n0,0\n1,1\n2,2\n");
    place.fails("voronoi line.csv --box 0,0,2,2", 3, &["line.csv", "no cells"]);
}

#[test]
fn shapes_are_surfaces() {
    let place = Place::new();
    let output = place.good("alpha sample:sphere:200 --radius 10 -o hull.off");
    assert!(stderr(&output).contains("396 triangles"), "{}", stderr(&output));
    place.good("triangulate sample:sphere:200 -o own.off");
    let counts = |name: &str| text(&place, name).lines().nth(1).unwrap().to_owned();
    assert_eq!(counts("hull.off"), "200 396 0");
    assert!(counts("own.off").starts_with("200 396"));
    place.file("p.csv", STATIONS);
    let output = place.good("alpha p.csv --radius 100 -o flat.off");
    assert!(stderr(&output).contains("area 16"), "{}", stderr(&output));
    place.good("verify flat.off");
    let none = place.good("alpha p.csv --radius 0");
    assert_eq!(String::from_utf8(none.stdout).unwrap(), "OFF\n0 0 0\n");
    place.fails("alpha p.csv --radius -1", 2, &["radius"]);
    place.fails("alpha p.csv --radius 1 -o shape.vtu", 2, &["shape.vtu", ".off"]);
}

#[test]
fn files_of_queries_are_checked() {
    let place = Place::new();
    place.file("p.csv", STATIONS).file("q.csv", QUERIES).file("space.xyz", "0 0 0\n1 1 1\n");
    place.fails("locate p.csv none.csv", 3, &["none.csv: no such file"]);
    place.fails("locate p.csv q.csv -o q.csv", 2, &["q.csv", "overwrite"]);
    place.fails("locate p.csv q.csv -o out.npy", 2, &["out.npy", ".csv"]);
    place.fails("locate - -", 2, &["standard input"]);
    place.fails("locate sample:uniform:100 q.csv", 2, &["q.csv", "--columns"]);
    place.fails("locate p.csv @list.txt", 2, &["queries are one file"]);
}

/// The second column of a table.
fn column(place: &Place, name: &str) -> Vec<f64> {
    text(place, name).lines().skip(1).map(|line| line.split_once(',').unwrap().1.parse().unwrap()).collect()
}

#[test]
fn cells_have_weights_and_periods() {
    let place = Place::new();
    place.file(
        "a.csv",
        "x,y,z,r\n0.1,0.2,0.3,0.1\n0.5,0.5,0.5,0.3\n0.52,0.5,0.5,0.01\n0.9,0.8,0.1,0.2\n0.2,0.9,0.7,0\n",
    );
    let unit = "--box 0,0,0,1,1,1";
    for more in ["--periodic 1,1,1", "--radii r --periodic 1,1,1", &format!("--radii r {unit}")] {
        let output = place.good(&format!("voronoi a.csv {more} -o cells.csv"));
        let volumes = column(&place, "cells.csv");
        assert!((volumes.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{more}: {volumes:?}");
        // The small sphere lies within the large one.
        assert_eq!(volumes[2] == 0.0, more.contains("radii"), "{}", stderr(&output));
    }
    place.good("voronoi a.csv --periodic 1,none,1 --box 0,-1,0,1,2,1 -o cells.csv");
    assert!((column(&place, "cells.csv").iter().sum::<f64>() - 3.0).abs() < 1e-14);
    place.fails("voronoi a.csv --periodic 1,none,1", 2, &["not periodic", "--box"]);
    place.fails(&format!("voronoi a.csv --periodic 1,1,1 {unit}"), 2, &["omit --box"]);
    place.fails("voronoi a.csv --radii mass --periodic 1,1,1", 2, &["mass"]);
    place.fails("locate a.csv a.csv --radii r", 2, &["--radii"]);
    place.good(&format!("voronoi a.csv --radii r {unit} -o cells.vtu"));
    let cells = text(&place, "cells.vtu");
    assert!(cells.contains("NumberOfCells=\"4\"") && cells.contains("42 42 42 42"), "{cells}");
    place.fails(&format!("voronoi a.csv {unit} -o cells.vtk"), 2, &[".csv or .vtu"]);
}
