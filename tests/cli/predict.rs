//! `septet predict`: from a report with a record to a table and JSON.

use super::Place;

#[test]
fn a_recorded_run_is_predicted() {
    let place = Place::new();
    let run = "simulate sample:uniform:2000 --leaf 100 --json";
    place.good(&format!("{run} one.json --workers 1 --tasks"));
    place.good(&format!("{run} eight.json --workers 8 --transport sim"));
    let table = place.good("predict one.json --workers 1..64 --json p.json");
    assert_eq!(String::from_utf8_lossy(&table.stdout).lines().count(), 1 + 7 + 1);
    let (predicted, real) = (place.json("p.json"), place.json("eight.json"));
    let eight = predicted["predictions"].as_array().unwrap().iter().find(|p| p["workers"] == 8).unwrap();
    for key in ["rounds", "messages", "bytes"] {
        assert_eq!(eight[key], real["machine"][key], "{key}");
    }
    assert_eq!(eight["exact"], true);
    place.good("predict one.json --workers 48 --calibrate --json p.json");
    assert_eq!(place.json("p.json")["predictions"][0]["exact"], false);

    place.fails("predict eight.json", 3, &["no record of the tasks"]);
    place.fails("predict one.json --workers 0", 2, &["expected numbers such as"]);
    place.fails("predict missing.json", 3, &["missing.json"]);
    place.fails("simulate sample:uniform:100 --tasks --json t.json --separator-sets both", 2, &["ghost"]);
}
