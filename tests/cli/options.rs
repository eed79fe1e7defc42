//! The options of a run: what commands offer and refuse, and what reports say of them.

use super::*;

/// Returns the `parameters` of the report of a command.
fn parameters(place: &Place, line: &str) -> Value {
    place.good(&format!("{line} --json r.json"));
    place.json("r.json")["parameters"].clone()
}

/// Two triangulations of other columns of one table are other runs.
#[test]
fn parameters_tell_runs_over_other_points_apart() {
    let place = Place::new();
    let row = |i: u64| format!("{},{},{},{}\n", i * 37 % 101, i * 59 % 103, i * 71 % 107, i * 83 % 109);
    let table: String = std::iter::once("a,b,c,d\n".to_owned()).chain((0..60).map(row)).collect();
    std::fs::write(place.path("t.csv"), table).unwrap();
    let of = |columns: &str| parameters(&place, &format!("triangulate t.csv --columns {columns}"));
    let (first, second) = (of("a,b,c"), of("b,c,d"));
    assert_ne!(first, second);
    assert_eq!(first["columns"], serde_json::json!(["a", "b", "c"]));
    let other =
        parameters(&place, "triangulate t.csv --columns a,b,c --registers baseline --keep-columns -o m.vtu");
    assert_eq!((&other["registers"], &other["keep_columns"]), (&"baseline".into(), &true.into()));
}

/// Parameters are those that were requested, on every transport and in meshes.
#[test]
fn parameters_are_as_requested() {
    let place = Place::new();
    let lines = ["--transport channel", "--transport sim", "--transport processes --processes 2"];
    let all = lines.map(|transport| {
        let line = format!("simulate sample:uniform:300,d=2 --leaf 50 {transport}");
        let mut parameters = parameters(&place, &line);
        for key in ["transport", "delivery_seed", "processes"] {
            parameters.as_object_mut().unwrap().remove(key).unwrap();
        }
        parameters
    });
    assert_eq!(all[0]["workers"], "auto");
    assert_eq!(all[0], all[1]);
    assert_eq!(all[0], all[2]);
    let settled = &place.json("r.json")["settled"];
    assert_eq!((&settled["workers"], &settled["leaf"]), (&2.into(), &50.into()));
    std::fs::write(place.path("square.poly"), SQUARE).unwrap();
    for workers in ["auto", "leaves", "4"] {
        let line = format!("mesh square.poly --size 0.5 --leaf auto --workers {workers}");
        assert_eq!(parameters(&place, &line)["workers"], workers);
    }
}

/// A square as a piecewise linear complex.
const SQUARE: &str = "4 2 0 0\n0 0 0\n1 1 0\n2 1 1\n3 0 1\n4 0\n0 0 1\n1 1 2\n2 2 3\n3 3 0\n0\n";

/// Cells ask by default. The cells are the same without probes, and only runs that count offer the choice.
#[test]
fn repair_is_an_option() {
    let place = Place::new();
    let counts = |line: &str| {
        place.good(&format!("simulate sample:body:600 {line} --json r.json"));
        let report = place.json("r.json");
        (report["repair"].clone(), report["simplices"].clone())
    };
    let (probed, splayed) = (counts(""), counts("--repair splay"));
    assert_eq!(counts("--repair probe"), probed);
    assert_eq!(probed.1, splayed.1);
    assert!(probed.0["probes"].as_u64() > Some(0) && splayed.0["probes"] == 0);
    place.fails("simulate sample:body:600 --repair walk", 2, &["repair", "probe", "splay"]);
    place.fails("triangulate sample:body:600 --repair splay", 2, &["repair"]);
}

/// No command offers a value that it refuses.
#[test]
fn only_runs_offer_processes() {
    let place = Place::new();
    for (command, offers) in
        [("triangulate", true), ("simulate", true), ("scale", false), ("predict", false), ("mesh", false)]
    {
        let help = String::from_utf8(place.good(&format!("help {command}")).stdout).unwrap();
        let words = "processes:";
        assert_eq!(help.contains(words), offers, "{command}");
    }
    place.fails("scale -n 100 --transport processes -o r.jsonl", 2, &["processes", "channel"]);
    place.fails("predict sample:grid:27 --transport processes", 2, &["processes", "sim"]);
}
