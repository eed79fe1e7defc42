//! Cost traces and their prices.

use std::fs;

use serde_json::Value;

use super::{Place, stderr};

#[test]
fn a_cost_trace_has_the_counts_of_the_report() {
    let place = Place::new();
    place.good("simulate sample:uniform:800 --leaf 60 --workers 3 --cost-trace c.jsonl --json r.json");
    let text = fs::read_to_string(place.path("c.jsonl")).unwrap();
    let mut lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let header = lines.next().unwrap();
    assert_eq!((&header["schema"], &header["points"]), (&Value::from("septet-cost/1"), &Value::from(800)));
    assert_eq!(header["rows"], lines.clone().count());
    assert!(lines.all(|row| row.get("work").is_none() && row.get("depth").is_none()));
    let table = String::from_utf8(place.good("fold c.jsonl --report r.json").stdout).unwrap();
    let report = place.json("r.json");
    let depth = report["machine"]["paper"]["depth"].to_string();
    let row = table.lines().find(|line| line.starts_with("paper")).unwrap();
    assert!(row.split_whitespace().any(|cell| cell == depth), "{table}");
}

#[test]
fn other_counts_are_refused() {
    let place = Place::new();
    place.good("simulate sample:uniform:300 --leaf 60 --cost-trace c.jsonl --json r.json");
    let mut report = place.json("r.json");
    report["machine"]["paper"]["work"] = Value::from(1);
    place.file("other.json", report.to_string());
    place.fails("fold c.jsonl --report other.json", 4, &["work of paper", "1 count differs"]);
    let text = fs::read_to_string(place.path("c.jsonl")).unwrap();
    let short: Vec<&str> = text.lines().filter(|line| !line.contains("\"row\":20,")).collect();
    place.file("short.jsonl", short.join("\n"));
    place.fails("fold short.jsonl", 3, &["row 20 is missing"]);
    place.fails("fold r.json", 3, &["r.json", "septet simulate --cost-trace"]);
    place.fails("fold none.jsonl", 3, &["no such file"]);
    place.fails("fold c.jsonl --report c.jsonl", 3, &["septet simulate --json"]);
    place.fails("triangulate sample:uniform:300 --cost-trace c.jsonl", 2, &["--cost-trace"]);
    place.fails("simulate sample:uniform:300 --cost-trace c.jsonl --json c.jsonl", 2, &["same file"]);
    let said = stderr(&place.good("simulate sample:uniform:300 --cost-trace -"));
    assert!(said.contains("certificate passed"), "{said}");
}
