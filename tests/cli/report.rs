//! The JSON report: every documented key, and sums that must agree.

use std::collections::BTreeSet;

use serde_json::Value;

use super::Place;

/// The documented keys, level by level.
const KEYS: [(&str, &str); 13] = [
    (
        "",
        "schema version parameters seed supergraph points space dimension simplices hull_facets certificate \
         repair fallback how_proved machine plan phases critical_path rounds tree nodes graph control_bytes seconds \
         rss_before_bytes peak_rss_bytes",
    ),
    (
        "/parameters",
        "command input outputs workers threads supergraph alpha k separator_sets leaf leaf_auto transport \
         delivery_seed lipschitz skip_invalid max_memory with_owner exchange_cap",
    ),
    ("/supergraph", "kind alpha k why"),
    ("/points", "input used duplicate refused"),
    ("/repair", "rounds stars"),
    ("/how_proved", "hypothesis local_radius exchange"),
    ("/machine", "workers rounds messages bytes paper repair"),
    ("/machine/paper", "work depth depth_log_scan brent"),
    ("/phases/0", "name paper rounds work depth critical_depth messages bytes seconds"),
    ("/rounds/0", "round phase active merged points messages bytes largest retries separators"),
    (
        "/tree",
        "levels leaves nodes spheres planes largest_split_ratio mean_split_ratio largest_attempts mean_attempts \
         largest_separator_ratio mean_separator_ratio by_level",
    ),
    (
        "/tree/by_level/0",
        "level nodes leaves points largest largest_split_ratio largest_attempts separator_points \
         partition_depth neighbours_depth merge_depth",
    ),
    ("/seconds", "read triangulate write total"),
];

fn assert_keys(report: &Value, pointer: &str, keys: &str) {
    let object = report.pointer(pointer).and_then(Value::as_object).unwrap_or_else(|| panic!("no {pointer}"));
    let found: BTreeSet<&str> = object.keys().map(String::as_str).collect();
    let expected: BTreeSet<&str> = keys.split_whitespace().collect();
    assert_eq!(found, expected, "{pointer}");
}

#[test]
fn the_report_is_whole_and_adds_up() {
    let place = Place::new();
    let output = place.good("simulate sample:uniform:6000 --workers leaves --leaf 700 --json -");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (pointer, keys) in KEYS {
        assert_keys(&report, pointer, keys);
    }
    assert_keys(&report, "/critical_path/0", "subproblem phase depth");
    assert_keys(&report, "/graph", "edges edge_hash max_degree mean_degree replication");
    assert_keys(
        &report,
        "/nodes/0",
        "id level population inside attempts kind crossing_inside crossing_outside members edges",
    );
    let sum = |array: &str, key: &str| -> u64 {
        report[array].as_array().unwrap().iter().map(|s| s[key].as_u64().unwrap()).sum()
    };
    let machine = &report["machine"];
    assert_eq!(report["schema"], "septet-run/1");
    assert_eq!(machine["paper"]["depth"], sum("critical_path", "depth"));
    assert_eq!(machine["paper"]["depth"], sum("phases", "critical_depth"));
    assert_eq!(machine["bytes"], sum("phases", "bytes"));
    assert_eq!(machine["bytes"], sum("rounds", "bytes"));
    assert_eq!(machine["messages"], sum("rounds", "messages"));
    assert_eq!(machine["workers"], report["tree"]["leaves"]);
    assert_eq!(report["tree"]["nodes"], report["nodes"].as_array().unwrap().len());
    let part = |key: &str| report["how_proved"][key].as_u64().unwrap();
    assert_eq!(part("hypothesis") + part("local_radius") + part("exchange"), 6000);
    assert_eq!(report["certificate"], "passed");
}

#[test]
fn triangulate_has_the_same_keys_and_echoes_its_options() {
    let place = Place::new();
    let line = "triangulate sample:graded:2000,d=2,lipschitz=0.2 --workers 5 --threads 1 --seed 9 --transport sim \
                --delivery-seed 4 --separator-sets both --json -";
    let report: Value = serde_json::from_slice(&place.good(line).stdout).unwrap();
    for (pointer, keys) in KEYS {
        assert_keys(&report, pointer, keys);
    }
    let parameters = &report["parameters"];
    let expected = [
        ("command", "triangulate".into()),
        ("workers", "5".into()),
        ("threads", 1.into()),
        ("separator_sets", "both".into()),
        ("transport", "sim".into()),
        ("delivery_seed", 4.into()),
        ("alpha", "auto".into()),
    ];
    for (key, value) in expected {
        let expected: Value = value;
        assert_eq!(parameters[key], expected, "{key}");
    }
    assert_eq!(report["seed"], 9);
    assert_eq!(report["machine"]["paper"]["work"], Value::Null);
    // The formula of an f-spaced set, with the constant that its size function really has.
    let lipschitz = parameters["lipschitz"].as_f64().unwrap();
    let alpha = report["supergraph"]["alpha"].as_f64().unwrap();
    assert!(lipschitz > 0.0 && lipschitz <= 0.2, "{lipschitz}");
    assert!((alpha - 1.25 * 2.0 * (1.0 + lipschitz) / (1.0 - lipschitz)).abs() < 1e-12, "{alpha}");
}
