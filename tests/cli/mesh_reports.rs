//! Reports, pictures, tables and traces of `septet mesh`.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use super::mesh::root;
use super::{Place, stderr};

fn sum(rows: &Value, key: &str) -> u64 {
    rows.as_array().unwrap().iter().map(|r| r[key].as_u64().unwrap_or(0)).sum()
}

#[test]
fn pictures_and_instruments_that_cannot_be_are_refused() {
    let place = Place::new();
    place.file("cube.poly", fs::read(root("domains/good/cube.poly")).unwrap());
    for (options, words) in [
        ("--json r.json --view 200001", &["--view", "at most 200000"][..]),
        ("--json r.json --view=-1", &["--view"]),
        ("-o m.vtu --view 5", &["--json"]),
        ("--check --profile", &["--check", "--profile"]),
        ("--check --trace t.json", &["--check", "--trace"]),
        ("--check --size 0.5", &["--check", "--size"]),
        ("--check --boundary exact", &["--check", "--boundary"]),
        ("--check --improve", &["--check", "--improve"]),
        ("--check --workers 2", &["--check", "--workers"]),
        ("--trace -", &["--trace"]),
        ("-o m.vtu --trace-level phase", &["--trace"]),
        ("--profile=p.txt", &[".md"]),
        ("--profile=p.csv --json p.stages.csv", &["same file"]),
        ("--trace t.json --json t.json", &["same file"]),
        ("--trace cube.poly", &["overwrite the input"]),
    ] {
        place.fails(&format!("mesh cube.poly {options}"), 2, words);
    }
    place.fails("mesh cube.poly --trace none/t.json", 1, &["does not exist"]);
}

#[test]
fn pictures_of_meshes_are_whole_or_not_there() {
    let place = Place::new();
    place.file("cube.poly", fs::read(root("domains/good/cube.poly")).unwrap());
    let view = |options: &str| {
        let output = place.good(&format!("mesh cube.poly --size 1 --json r.json {options}"));
        (place.json("r.json"), stderr(&output))
    };
    let (report, talk) = view("");
    assert!(!talk.contains("picture"), "{talk}");
    let cells = report["mesh"]["cells"].as_u64().unwrap();
    assert_eq!(report["view"]["cells"].as_u64(), Some(cells));
    let (limited, talk) = view(&format!("--view {}", cells - 1));
    assert_eq!(limited["view"], Value::Null);
    let note = format!("no picture: the mesh has {cells} cells, --view allows {}", cells - 1);
    assert!(talk.contains(&note), "{talk}");
    assert_eq!(view(&format!("--view {cells}")).0["view"], report["view"]);
    let (none, talk) = view("--view 0");
    assert!(none["view"] == Value::Null && !talk.contains("picture"), "{talk}");
}

/// Numbers of a list in a picture.
fn list(view: &Value, key: &str) -> Vec<f64> {
    view[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn pictures_of_meshes_say_what_the_mesh_is() {
    let place = Place::new();
    let domain = root("domains/good/two-regions.poly");
    let report = |workers: u32| {
        let line = format!(
            "mesh {} --size 0.36 --conforming --no-improve --workers {workers} --json r.json",
            domain.display()
        );
        place.good(&line);
        place.json("r.json")
    };
    let (one, five) = (report(1), report(5));
    let without_owner = |report: &Value| {
        let mut view = report["view"].clone();
        view["owner"] = Value::Null;
        view
    };
    assert_eq!(without_owner(&one), without_owner(&five));
    let view = &five["view"];
    // The owner of a cell is the worker of its lexicographically smallest point.
    let (positions, corners, owner) = (list(view, "positions"), list(view, "corners"), list(view, "owner"));
    let mut owners: std::collections::BTreeMap<usize, f64> = std::collections::BTreeMap::new();
    for (cell, &worker) in corners.chunks_exact(4).zip(&owner) {
        let at = |&v: &f64| &positions[3 * v as usize..][..3];
        let first = cell.iter().min_by(|a, b| at(a).partial_cmp(at(b)).unwrap()).unwrap();
        assert_eq!(*owners.entry(*first as usize).or_insert(worker), worker, "point {first}");
    }
    let workers: BTreeSet<u64> = owner.iter().map(|&p| p as u64).collect();
    assert!(workers.len() > 1 && workers.iter().all(|p| (1..=5).contains(p)), "{workers:?}");
    assert!(list(&one["view"], "owner").iter().all(|&p| p == 1.0));
    // What it says of cells is what the histograms count.
    let quality = &five["quality"];
    let extreme = |key: &str, first: f64, f: fn(f64, f64) -> f64| list(view, key).into_iter().fold(first, f);
    let close = |a: f64, b: &Value| assert!((a - b.as_f64().unwrap()).abs() <= 1e-5 * a.abs(), "{a} {b}");
    close(extreme("radius_edge", 0.0, f64::max), &quality["radius_edge"]["most"]);
    close(extreme("radius_edge", 9.0, f64::min), &quality["radius_edge"]["least"]);
    close(extreme("least_angle", 180.0, f64::min), &quality["least_angles"]["least"]);
    close(extreme("least_angle", 0.0, f64::max), &quality["least_angles"]["most"]);
    assert!(list(view, "size").iter().all(|&f| f > 0.0 && f <= 0.36));
    assert_eq!(list(view, "regions").len(), 2);
    // The regions meet in one plane: no cell lies on both sides of it.
    let region = list(view, "region");
    let half = |r: f64| region.iter().filter(|&&x| x == r).count();
    assert!(half(0.0) > 100 && half(1.0) > 100 && half(0.0) + half(1.0) == owner.len());
}

#[test]
fn tables_of_meshing_are_those_of_the_report() {
    let place = Place::new();
    place.file("cube.poly", fs::read(root("domains/good/cube.poly")).unwrap());
    place.good("mesh cube.poly --size 0.7 --conforming --workers 3 --improve --profile=p.csv --json r.json");
    let report = place.json("r.json");
    let table = |name: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(place.path(&format!("p.{name}.csv"))).unwrap();
        text.lines().map(|l| l.split(',').map(str::to_owned).collect()).collect()
    };
    for (name, labels) in [("stages", 1), ("phases", 2), ("runs", 3)] {
        let rows = table(name);
        assert_eq!(rows.len(), report[name].as_array().unwrap().len() + 1, "{name}");
        let head = &rows[0];
        for (row, json) in rows[1..].iter().zip(report[name].as_array().unwrap()) {
            for (cell, column) in row.iter().zip(head).skip(labels) {
                let Some(key) = column.strip_prefix("modelled_") else { continue };
                assert_eq!(cell.parse::<u64>().ok(), json[key].as_u64(), "{name}, {column}");
            }
        }
    }
    let names: Vec<String> = table("stages").into_iter().skip(1).map(|mut r| r.swap_remove(0)).collect();
    assert_eq!(names, ["sizes", "segments", "facets", "volume", "improve"]);
    for key in ["rounds", "messages", "bytes", "work", "depth"] {
        assert_eq!(sum(&report["phases"], key), sum(&report["stages"], key), "{key}");
        assert_eq!(sum(&report["runs"], key), sum(&report["stages"], key), "{key}");
    }
    // Each stage has a row for each phase of Section 5.
    for phase in ["octree", "sizes", "candidates", "conflicts", "completion"] {
        let rows = report["phases"].as_array().unwrap().iter().filter(|row| row["phase"] == phase);
        assert_eq!(rows.count(), 4, "{phase}");
    }
    // Every run counts its operations.
    let counted = |task: &str| {
        let runs = report["runs"].as_array().unwrap().iter().filter(move |r| r["task"] == task);
        runs.map(|r| r["work"].is_u64() && r["depth"].is_u64()).collect::<Vec<bool>>()
    };
    assert!(counted("independent set").into_iter().all(|c| c) && !counted("independent set").is_empty());
    assert!(counted("triangulation").into_iter().all(|c| c) && !counted("triangulation").is_empty());
    assert!(counted("evaluation").into_iter().all(|c| c) && !counted("evaluation").is_empty());
    place.good("mesh cube.poly --size 2 --profile=p.md");
    let text = fs::read_to_string(place.path("p.md")).unwrap();
    for words in ["# mesh of cube.poly", "## Stages", "## Phases", "## Runs", "| modelled candidates |"] {
        assert!(text.contains(words), "{text}");
    }
    let talk = stderr(&place.good("mesh cube.poly --size 2 --profile"));
    assert!(talk.contains("Stages: modelled | measured") && talk.contains("\nrefinement "), "{talk}");
}

#[test]
fn traces_of_meshing_name_its_stages() {
    let place = Place::new();
    place.file("cube.poly", fs::read(root("domains/good/cube.poly")).unwrap());
    place.good("mesh cube.poly --size 0.7 --conforming --workers 3 --trace t.json --json r.json");
    let (trace, report) = (place.json("t.json"), place.json("r.json"));
    let rows = trace["traceEvents"].as_array().unwrap();
    let count = |kind: &str| rows.iter().filter(|r| r["ph"] == kind).count() as u64;
    assert_eq!(count("B"), count("E"));
    // Every message is billed and arrives.
    let runs = report["runs"].as_array().unwrap().len() as u64;
    assert_eq!(count("s"), sum(&report["stages"], "messages"));
    assert_eq!(count("s"), count("f"));
    // On the track of phases: stages hold runs, runs hold phases.
    let track = rows.iter().filter(|r| r["pid"] == 1 && r["tid"] == 2 && (r["ph"] == "B" || r["ph"] == "E"));
    let (mut open, mut stages, mut held) = (Vec::new(), Vec::new(), 0);
    for row in track {
        if row["ph"] == "E" {
            open.pop();
            continue;
        }
        let name = row["name"].as_str().unwrap();
        match open.len() {
            0 => stages.push(name),
            1 => {
                assert_eq!(name, "run");
                held += 1;
            }
            _ => assert_eq!(open[1], "run"),
        }
        open.push(name);
    }
    assert!(open.is_empty());
    assert_eq!(stages, ["sizes", "segments", "facets", "volume", "improve", "conformity", "quality"]);
    assert_eq!(held, runs);
    place.good("mesh cube.poly --size 2 --trace u.json --trace-level phase");
    let rows = place.json("u.json");
    assert!(rows["traceEvents"].as_array().unwrap().iter().all(|r| r["ph"] == "M" || r["tid"] == 2));
}
