//! Rivals: other ways to the same triangulation, and their counts.

use serde_json::Value;

use super::{Place, stderr};

/// The sum of a field over rows.
fn sum(rows: &Value, field: &str) -> u64 {
    rows.as_array().unwrap().iter().map(|row| row[field].as_u64().unwrap()).sum()
}

#[test]
fn incremental_insertion_is_counted_beside_septet() {
    let place = Place::new();
    for (input, dimension) in [("sample:uniform:2000", 3), ("sample:grid:900,d=2", 2)] {
        let output = place.good(&format!("rival incremental {input} --against --json r.json"));
        let table = String::from_utf8(output.stdout).unwrap();
        for words in ["incremental", "its repair", "dependence depth", "in-sphere tests", "level"] {
            assert!(table.contains(words), "{table}");
        }
        let report = place.json("r.json");
        assert_eq!(report["schema"], "septet-rival/2");
        assert_eq!((&report["same_cells"], &report["space"]), (&true.into(), &dimension.into()));
        let rival = &report["incremental"];
        for (field, of) in [("work", "work"), ("tests", "tests"), ("cells", "cells")] {
            assert_eq!(rival[field].as_u64().unwrap(), sum(&rival["insertion_rounds"], of), "{field}");
        }
        let count = |field: &str| rival[field].as_u64().unwrap();
        assert!(count("chain") > 10 && count("chain") < count("depth_hashed"));
        assert!(count("depth_hashed") < count("depth") && count("depth") < count("depth_log_scan"));
        assert!(count("cells") > report["simplices"].as_u64().unwrap());
        let septet = &report["septet"];
        place.good(&format!("simulate {input} --json s.json"));
        let run = place.json("s.json");
        for field in ["work", "depth", "depth_log_scan", "brent"] {
            assert_eq!(septet["paper"][field], run["machine"]["paper"][field]);
            assert_eq!(septet["repair"][field], run["machine"]["repair"][field]);
        }
        assert_eq!(report["simplices"], run["simplices"]);
        assert_eq!(septet["levels"], run["tree"]["levels"]);
    }
}

#[test]
fn every_rival_has_the_same_cells_and_counts() {
    let place = Place::new();
    for (line, name) in [("incremental", "incremental"), ("splay --k 12", "splay"), ("direct", "direct")] {
        place.good(&format!("rival {line} -n 900 --kind clusters --workers 5 --json r.json"));
        let report = place.json("r.json");
        assert_eq!((&report["same_cells"], &report["workers"]), (&true.into(), &5.into()), "{line}");
        for count in ["work", "depth", "brent", "rounds", "messages", "bytes"] {
            assert!(report[name][count].as_u64().unwrap() > 0, "{count} of {line}");
        }
    }
    place.fails("rival splay -n 900 --kind clusters --k 0", 2, &["--k"]);
    place.fails("rival direct -n 900 --kind clusters --k 12", 2, &["--k"]);
}

#[test]
fn the_rival_is_a_function_of_points_and_seed() {
    let place = Place::new();
    let json = |line: &str| -> Value { serde_json::from_slice(&place.good(line).stdout).unwrap() };
    let first = json("rival incremental sample:clusters:800 --json -");
    assert_eq!(first["septet"], Value::Null);
    assert_eq!(first, json("rival incremental sample:clusters:800 --json -"));
    let other = json("rival incremental sample:clusters:800 --seed 2 --json -");
    assert_ne!(first["incremental"], other["incremental"]);
    assert_eq!(first["simplices"], other["simplices"]);
}

#[test]
fn the_rival_takes_points_as_a_run_does() {
    let place = Place::new();
    place.file("p.xyz", "0 0\n1 0\n0 1\n1 0\nnan 1\n1 1\n");
    place.fails("rival incremental p.xyz", 3, &["p.xyz", "line 5"]);
    let talk = stderr(&place.good("rival incremental p.xyz --skip-invalid --json r.json"));
    assert!(talk.contains("4 points, 2 triangles"), "{talk}");
    assert_eq!(place.json("r.json")["same_cells"], true);
    place.file("flat.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n");
    place.good("rival incremental flat.xyz --against --json r.json");
    assert_eq!(
        (&place.json("r.json")["simplices"], &place.json("r.json")["dimension"]),
        (&0.into(), &2.into())
    );
    let json = |line: &str| -> Value { serde_json::from_slice(&place.good(line).stdout).unwrap() };
    let named = json("rival incremental -n 500 --kind clusters -d 2 --seed 7 --json -");
    assert_eq!(named["input"], "sample:clusters:500,d=2,seed=7");
    assert_eq!(named, json("rival incremental sample:clusters:500,d=2,seed=7 --seed 7 --json -"));
    place.fails("rival incremental -n 500", 2, &["--kind"]);
    place.fails("rival incremental --kind clusters", 2, &["--number"]);
    place.fails("rival incremental p.xyz -n 500 --kind clusters", 2, &["INPUT"]);
    place.fails("rival incremental -n 500 --kind cube", 2, &["cube", "clusters"]);
    place.fails("rival incremental p.xyz --json p.xyz", 2, &["overwrite"]);
    place.fails("rival voronoi p.xyz", 2, &["voronoi"]);
    place.fails("rival", 2, &["incremental"]);
}

#[test]
fn planes_and_naive_correction_give_the_same_bytes() {
    let place = Place::new();
    place.good("triangulate sample:clusters:3000 -o a.vtu");
    let reference = std::fs::read(place.path("a.vtu")).unwrap();
    for line in [
        "triangulate sample:clusters:3000 --partition kd --workers 7 --leaf 200",
        "simulate sample:clusters:3000 --partition kd --workers leaves --leaf 300",
        "simulate sample:clusters:3000 --neighbours naive --workers 5 --leaf 200 --transport sim",
        "simulate sample:clusters:3000 --neighbours naive --partition kd --supergraph knn --leaf 300",
        "simulate sample:clusters:3000 --neighbours fmt --workers 5 --leaf 200",
        "simulate sample:clusters:3000 --neighbours pairs --workers 3 --leaf 200",
    ] {
        let talk = stderr(&place.good(&format!("{line} -o b.vtu --json r.json")));
        assert!(std::fs::read(place.path("b.vtu")).unwrap() == reference, "{line}");
        let report = place.json("r.json");
        let kd = line.contains("kd");
        assert_eq!(report["parameters"]["partition"], if kd { "kd" } else { "sphere" }, "{line}");
        let correction = ["naive", "fmt", "pairs"].into_iter().find(|word| line.contains(word));
        assert_eq!(report["parameters"]["neighbours"], correction.unwrap_or("descent"), "{line}");
        let bottom_up = matches!(correction, Some("naive" | "fmt"));
        assert_eq!((talk.contains("k-d planes"), talk.contains("bottom-up")), (kd, bottom_up), "{talk}");
        let by_pairs = correction == Some("pairs");
        assert_eq!((talk.contains("pairs"), report["tree"]["pairs"] != 0), (by_pairs, by_pairs), "{talk}");
        assert_eq!(report["tree"]["punts"], 0, "{line}");
        assert!(!kd || report["tree"]["spheres"] == 0 && report["tree"]["planes"] != 0, "{line}");
    }
    place.fails("triangulate sample:uniform:500 --neighbours naive", 2, &["--neighbours"]);
    place.fails("triangulate sample:uniform:500 --neighbours fmt", 2, &["--neighbours"]);
    place.fails("scale -n 500 --timed --neighbours naive -o s.jsonl", 2, &["--timed"]);
    place.fails("triangulate sample:uniform:500 --partition bsp", 2, &["sphere", "kd"]);
}
