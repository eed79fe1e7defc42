//! `septet predict`: from points to a table and JSON.

use super::Place;

#[test]
fn predictions_have_the_counts_of_runs() {
    let place = Place::new();
    let set = "sample:uniform:2000 --leaf 100";
    place.good(&format!("simulate {set} --json eight.json --workers 8 --transport sim"));
    let table = place.good(&format!("predict {set} --workers 1..16 --json p.json"));
    assert_eq!(String::from_utf8_lossy(&table.stdout).lines().count(), 1 + 5 + 1);
    let (predicted, real) = (place.json("p.json"), place.json("eight.json"));
    let of = |workers: u64| {
        let all = predicted["predictions"].as_array().unwrap();
        all.iter().find(|p| p["workers"] == workers).unwrap()
    };
    for key in ["rounds", "messages", "bytes"] {
        assert_eq!(of(8)[key], real["machine"][key], "{key}");
    }
    for (predicted, real) in
        of(8)["phases"].as_array().unwrap().iter().zip(real["phases"].as_array().unwrap())
    {
        assert_eq!((&predicted["name"], &predicted["bytes"]), (&real["name"], &real["bytes"]));
    }
    let work: u64 =
        real["phases"].as_array().unwrap().iter().map(|phase| phase["work"].as_u64().unwrap_or(0)).sum();
    let busiest = |workers| of(workers)["busiest_work"].as_u64().unwrap();
    assert!(busiest(16) < busiest(4) && busiest(4) < busiest(1) && busiest(1) <= work);
    assert!(busiest(8) >= work / 9);

    // Brent's bound for one processor is `work + depth`, over all phases.
    assert!(of(1)["brent"].as_u64().unwrap() > work, "{} {work}", of(1)["brent"]);

    place
        .good(&format!("predict {set},d=2 --workers 3 --calibrate --json p.json").replace(" --leaf 100", ""));
    assert!(place.json("p.json")["hardware"]["phase_rates"]["hulls"].as_f64().unwrap() > 0.0);
    place.fails(&format!("predict {set} --workers 0"), 2, &["expected numbers such as"]);
    place.fails(&format!("predict {set} --workers 2000000"), 2, &["1048576"]);
    place.fails("predict missing.xyz", 3, &["missing.xyz"]);
    place.fails("predict sample:grid:27 --skip-invalid", 2, &["--skip-invalid", "sample"]);
}
