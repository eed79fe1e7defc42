//! `septet reproduce` as scripts see it.

use std::fs;

use serde_json::Value;

use super::{Place, code, stderr};

fn stdout(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn claims_are_listed_and_run_by_name() {
    let place = Place::new();
    let list = place.run("reproduce --list");
    assert_eq!(code(&list), 0);
    let names: Vec<String> =
        stdout(&list).lines().filter(|line| !line.starts_with(' ')).map(str::to_string).collect();
    assert!(names.len() >= 30 && names.iter().any(|name| name == "merged-per-round"), "{names:?}");
    assert_eq!(stdout(&list).lines().count(), 3 * names.len(), "two lines each");

    let unknown = place.run("reproduce levels no-such-claim");
    assert_eq!(code(&unknown), 2);
    assert!(stderr(&unknown).contains("`no-such-claim`") && stderr(&unknown).contains("--list"));
    assert_eq!(code(&place.run("reproduce --quick --full")), 2);
    assert_eq!(code(&place.run("reproduce ply --json nowhere/claims.json")), 1, "found before the work");
}

#[test]
fn results_are_json_and_tables() {
    let place = Place::new();
    let good = place.run("reproduce separator-split merged-per-round --seed 3 --json -");
    assert_eq!(code(&good), 0, "{}", stderr(&good));
    let report: Value = serde_json::from_slice(&good.stdout).unwrap();
    assert_eq!((&report["schema"], &report["passed"]), (&"septet-claims/1".into(), &true.into()));
    assert_eq!((&report["extent"], &report["seed"]), (&"quick".into(), &3.into()));
    let claims = report["claims"].as_array().unwrap();
    assert_eq!(claims.len(), 2);
    let split = &claims[0];
    assert_eq!((&split["name"], &split["reading"]["kind"]), (&"separator-split".into(), &"as-read".into()));
    assert_eq!(split["holds_as_printed"], false);
    let figures = split["figures"].as_array().unwrap();
    let of = |printed: bool| figures.iter().filter(move |f| f["as_printed"] == printed);
    assert!(of(false).all(|f| f["value"].as_f64().unwrap() <= f["bound"].as_f64().unwrap()));
    assert!(of(true).any(|f| f["value"].as_f64().unwrap() > f["bound"].as_f64().unwrap()));
    assert!(figures.iter().all(|f| f["seed"] == 3), "the seed asked for");
}

#[test]
fn a_failed_claim_has_its_exit_code() {
    let place = Place::new();
    let bad =
        place.run("reproduce separator-attempts separator-split --fault small-sphere --json claims.json");
    assert_eq!(code(&bad), 4, "{}", stderr(&bad));
    let table = stdout(&bad);
    assert!(table.lines().any(|line| line.starts_with("PASS  separator-attempts")), "{table}");
    let row = table.lines().find(|line| line.starts_with("FAIL  separator-split")).expect("a row");
    let figure: f64 = row.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((0.9..1.0).contains(&figure) && row.contains("splits;"), "figure and set: {row}");
    assert!(table.contains("as printed: does not hold"), "{table}");
    assert!(stderr(&bad).contains("claims that failed: separator-split"));
    let report: Value = serde_json::from_slice(&fs::read(place.path("claims.json")).unwrap()).unwrap();
    assert_eq!(report["passed"], false);
}
