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
    assert_eq!((&report["schema"], &report["passed"]), (&"septet-claims/2".into(), &true.into()));
    assert_eq!((&report["extent"], &report["seed"]), (&"quick".into(), &3.into()));
    let claims = report["claims"].as_array().unwrap();
    assert_eq!(claims.len(), 2);
    assert_eq!(
        (&report["tests_passed"], &report["tests"]),
        (&1.into(), &1.into()),
        "illustrations do not count"
    );
    assert_eq!((&claims[0]["role"], &claims[1]["role"]), (&"test".into(), &"illustration".into()));
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
fn both_accounts_agree() {
    let good = Place::new().run("reproduce accounts");
    assert_eq!(code(&good), 0, "{}{}", stdout(&good), stderr(&good));
}

#[test]
fn a_failed_claim_has_its_exit_code() {
    let place = Place::new();
    let bad =
        place.run("reproduce separator-attempts separator-split --fault small-sphere --json claims.json");
    assert_eq!(code(&bad), 4, "{}", stderr(&bad));
    let table = stdout(&bad);
    assert!(!table.contains("separator-attempts"), "only failed claims are shown: {table}");
    assert!(table.lines().any(|line| line.starts_with("FAIL  separator-split")), "{table}");
    let row = table.lines().find(|line| line.contains("splits;")).expect("a row");
    let figure = row.split_whitespace().find_map(|word| word.parse::<f64>().ok());
    assert!(figure.is_some_and(|ratio| (0.9..1.0).contains(&ratio)), "figure and set: {row}");
    assert!(table.contains("as printed: does not hold"), "{table}");
    assert!(stderr(&bad).contains("claims that failed: separator-split"));
    let report: Value = serde_json::from_slice(&fs::read(place.path("claims.json")).unwrap()).unwrap();
    assert_eq!((&report["passed"], &report["fault"]), (&false.into(), &"small-sphere".into()));
    assert_eq!(report["claims"].as_array().unwrap().len(), 2, "the report has all claims");
}

#[test]
fn a_fault_may_escape_the_claims_or_end_their_runs() {
    let place = Place::new();
    let escaped = place.run("reproduce separator-attempts --fault free:partition");
    assert_eq!(code(&escaped), 0, "{}", stderr(&escaped));
    assert!(!stdout(&escaped).contains("separator-attempts"), "{}", stdout(&escaped));
    assert!(stderr(&escaped).contains("fault free:partition: 1 of 1 tests pass"), "{}", stderr(&escaped));
    let dead = place.run("reproduce separator-attempts --fault die:1:partition");
    assert_eq!(code(&dead), 4, "{}", stderr(&dead));
    let row =
        stdout(&dead).lines().find(|line| line.starts_with("FAIL  separator-attempts")).map(str::to_string);
    assert!(row.as_ref().is_some_and(|row| row.contains("worker 1 failed")), "{row:?}");
}

#[test]
fn faults_are_listed_and_misspelt_faults_are_refused() {
    let place = Place::new();
    let list = stdout(&place.good("reproduce --fault list"));
    for name in ["slow:PHASE:LAW[:FACTOR]", "work:PHASE:FACTOR", "free:PHASE", "flood", "median-planes"] {
        assert!(list.lines().any(|line| line == name), "{list}");
    }
    assert_eq!(list.lines().filter(|line| line.starts_with("  ")).count() * 2, list.lines().count());
    place.fails("reproduce --fault half-gosts", 2, &["the nearest is half-ghosts", "there is no fault"]);
    place.fails("reproduce --fault free:hull", 2, &["the nearest is hulls", "`free` has no phase `hull`"]);
    place.fails("reproduce --fault work:hulls:0", 2, &["the factor of fault `work` is `0`"]);
    place.fails("reproduce --fault slow:hulls", 2, &["`slow:PHASE:LAW[:FACTOR]`"]);
}

/// A call that was interrupted continues with the claims that its journal does not contain, and refuses other options.
#[test]
fn a_journal_continues_a_call() {
    let place = Place::new();
    let whole =
        place.run("reproduce separator-attempts separator-split --journal whole.jsonl --json whole.json");
    assert_eq!(code(&whole), 0, "{}", stderr(&whole));
    let lines = fs::read_to_string(place.path("whole.jsonl")).unwrap();
    let first = lines.split_inclusive('\n').next().unwrap();
    assert_eq!(lines.lines().count(), 2);
    // The first claim is complete, and with another value. The line of the second one is cut off.
    let known = first.replacen("\"value\":0.0", "\"value\":-1.0", 1);
    fs::write(place.path("cut.jsonl"), format!("{known}{}", &lines[first.len()..first.len() + 30])).unwrap();
    let again =
        place.run("reproduce separator-attempts separator-split --journal cut.jsonl --json again.json");
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    let (whole, again) = (place.json("whole.json"), place.json("again.json"));
    assert_eq!(whole["claims"][1], again["claims"][1]);
    assert_ne!(whole["claims"][0], again["claims"][0], "the figures of the journal");
    assert_eq!(
        fs::read_to_string(place.path("cut.jsonl")).unwrap(),
        format!("{known}{}", &lines[first.len()..])
    );
    let other = place.run("reproduce separator-attempts --seed 2 --journal whole.jsonl");
    assert_eq!(code(&other), 2, "{}", stderr(&other));
    assert!(stderr(&other).contains("--seed 1") && stderr(&other).contains("--seed 2"), "{}", stderr(&other));
}
