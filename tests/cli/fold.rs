//! Cost traces and their prices.

use std::fs;

use serde_json::Value;

use super::{Place, code, stderr};

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
    let differs = place.run("fold c.jsonl --report other.json");
    assert_eq!(code(&differs), 4, "{}", stderr(&differs));
    for words in ["work of paper", "1 count differs"] {
        assert!(stderr(&differs).contains(words), "{}", stderr(&differs));
    }
    let text = fs::read_to_string(place.path("c.jsonl")).unwrap();
    let short: Vec<&str> = text.lines().filter(|line| !line.contains("\"row\":20,")).collect();
    place.file("short.jsonl", short.join("\n"));
    place.fails("fold short.jsonl", 3, &["short.jsonl: row 20 is missing", "write the cost trace again"]);
    place.file("phase.jsonl", text.replacen("\"hulls\"", "\"lunch\"", 1));
    place.fails("fold phase.jsonl", 3, &["there is no phase `lunch`"]);
    place.file("node.jsonl", text.replacen("\"node\":1,", "\"node\":0,", 1));
    place.fails("fold node.jsonl", 3, &["there is no node 0"]);
    place.fails("fold r.json", 3, &["r.json", "septet simulate", "--cost-trace"]);
    place.fails("fold none.jsonl", 3, &["no such file"]);
    place.fails("triangulate sample:uniform:300 --cost-trace c.jsonl", 2, &["--cost-trace"]);
    place.fails("simulate sample:uniform:300 --cost-trace c.jsonl --json c.jsonl", 2, &["same file"]);
    let said = stderr(&place.good("simulate sample:uniform:300 --cost-trace -"));
    assert!(said.contains("certificate passed"), "{said}");
}

#[test]
fn reports_of_other_runs_are_refused() {
    let place = Place::new();
    place.good("simulate sample:uniform:300 --leaf 60 --seed 2 --cost-trace c.jsonl");
    place.good("simulate sample:uniform:300 --leaf 60 --seed 3 --json seed.json");
    place.fails(
        "fold c.jsonl --report seed.json",
        3,
        &["another run: it has seed 3, and the trace has seed 2"],
    );
    place.good("simulate sample:uniform:200 --leaf 60 --seed 2 --json few.json");
    place.fails("fold c.jsonl --report few.json", 3, &["another run: it has 200 points", "has 300 points"]);
    place.good("triangulate sample:uniform:300 --seed 2 --json direct.json");
    let words = &["direct.json: this run has no counts", "run `septet simulate` with --json"];
    place.fails("fold c.jsonl --report direct.json", 3, words);
    place.fails("fold c.jsonl --report c.jsonl", 3, &["`septet simulate` wrote with --json"]);
    place.file("verify.json", "{\"schema\":\"septet-verify/1\"}");
    place.fails("fold c.jsonl --report verify.json", 3, &["`septet-verify/1` instead of `septet-run/2`"]);
    place.fails("fold - --report -", 2, &["standard input"]);
}

/// Compressed traces and reports, and a trace from standard input, have the counts of plain files.
#[test]
fn compressed_files_and_standard_input_are_read() {
    let place = Place::new();
    let line = "simulate sample:uniform:300 --leaf 60";
    place.good(&format!("{line} --cost-trace c.jsonl --json r.json"));
    place.good(&format!("{line} --cost-trace c.jsonl.gz --json r.json.gz"));
    for file in ["c.jsonl.gz", "r.json.gz"] {
        assert!(fs::read(place.path(file)).unwrap().starts_with(&[0x1f, 0x8b]), "{file}");
    }
    let table = place.good("fold c.jsonl --report r.json").stdout;
    assert_eq!(place.good("fold c.jsonl.gz --report r.json.gz").stdout, table);
    for file in ["c.jsonl", "c.jsonl.gz"] {
        let output = place.feed("fold - --report r.json", &fs::read(place.path(file)).unwrap());
        assert_eq!((code(&output), output.stdout), (0, table.clone()), "{file}");
    }
    place.good("report r.json.gz -o page.html");
    let packed = fs::read(place.path("c.jsonl.gz")).unwrap();
    place.file("cut.jsonl.gz", &packed[..packed.len() / 2]);
    place.fails("fold cut.jsonl.gz", 3, &["cut.jsonl.gz: line", "cannot be read"]);
}
