//! The JSON report: every documented key, and sums that must agree.

use std::collections::BTreeSet;

use serde_json::Value;

use super::Place;

/// The documented keys, level by level.
const KEYS: [(&str, &str); 19] = [
    (
        "",
        "schema version parameters settled seed supergraph points space dimension simplices hull_facets certificate \
         repair fallback how_proved machine plan phases critical_path rounds traffic timeline tree nodes graph view coordinator control_bytes seconds \
         rss_before_bytes peak_rss_bytes",
    ),
    (
        "/parameters",
        "command input outputs skip_invalid dimension columns input_format raw keep_columns terrain periodic origin wrap with_owner view nodes workers seed \
         threads registers supergraph alpha k separator_sets partition neighbours repair constants samples tries transport \
         delivery_seed processes max_memory leaf leaf_auto lipschitz exchange_cap",
    ),
    ("/settled", "workers threads leaf samples tries"),
    ("/supergraph", "kind alpha k why"),
    ("/points", "input used duplicate refused"),
    ("/repair", "rounds stars probes probe_visits"),
    ("/how_proved", "direct hypothesis local_radius exchange"),
    ("/machine", "workers rounds messages bytes total paper repair selection"),
    ("/machine/total", "work exact_tests depth depth_log_scan brent brent_at rounds messages bytes"),
    ("/machine/paper", "work exact_tests depth depth_log_scan brent brent_at rounds messages bytes"),
    (
        "/phases/0",
        "name paper repair group rounds work exact_tests depth depth_log_scan critical_depth messages bytes seconds",
    ),
    (
        "/rounds/0",
        "round phase active merged points largest_load messages bytes largest probe_visits probes retries separators",
    ),
    ("/traffic", "bins grouped rows"),
    ("/traffic/rows/0", "phase from to messages bytes"),
    ("/timeline", "bins grouped rows"),
    ("/timeline/rows/0", "round phase worker messages bytes points"),
    (
        "/tree",
        "samples tries levels leaves nodes spheres planes curves largest_split_ratio mean_split_ratio attempts largest_attempts mean_attempts \
         largest_separator_ratio mean_separator_ratio punts pairs by_level",
    ),
    (
        "/tree/by_level/0",
        "level nodes leaves points largest largest_split_ratio attempts largest_attempts separator_points \
         partition_depth neighbours_depth merge_depth depths",
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
        "id level population inside attempts kind crossing_inside crossing_outside members edges max_degree visits",
    );
    assert_keys(
        &report,
        "/view",
        "of points low high leaves positions owner leaf crossing flags ghost ghost_leaf ghosts_omitted separators \
         separators_omitted",
    );
    assert_keys(&report, "/view/separators/0", "node level kind vector number interior low high");
    let sum = |array: &str, key: &str| -> u64 {
        report
            .pointer(&format!("/{array}"))
            .unwrap()
            .as_array()
            .unwrap()
            .iter()
            .map(|s| s[key].as_u64().unwrap())
            .sum()
    };
    let machine = &report["machine"];
    assert_eq!(report["schema"], "septet-run/2");
    assert_eq!(machine["paper"]["depth"], sum("critical_path", "depth"));
    assert_eq!(machine["paper"]["depth"], sum("phases", "critical_depth"));
    let totals = ["paper", "repair", "selection"].map(|group| machine[group]["work"].as_u64().unwrap());
    assert_eq!(totals.iter().sum::<u64>(), sum("phases", "work"), "every operation is in one total");
    assert!(totals[2] > 0, "the choice of the supergraph counts its work");
    assert_eq!(machine["bytes"], sum("phases", "bytes"));
    assert_eq!(machine["bytes"], sum("rounds", "bytes"));
    assert_eq!(machine["messages"], sum("rounds", "messages"));
    for rows in ["traffic/rows", "timeline/rows"] {
        assert_eq!(machine["bytes"], sum(rows, "bytes"), "{rows}");
        assert_eq!(machine["messages"], sum(rows, "messages"), "{rows}");
    }
    assert_eq!(sum("rounds", "points"), sum("timeline/rows", "points"));
    assert!(report["traffic"]["rows"].as_array().unwrap().iter().all(|r| r["from"] != r["to"]));
    assert_eq!(machine["workers"], report["tree"]["leaves"]);
    assert_eq!(report["tree"]["nodes"], report["nodes"].as_array().unwrap().len());
    let part = |key: &str| report["how_proved"][key].as_u64().unwrap();
    assert_eq!(part("hypothesis") + part("local_radius") + part("exchange"), 6000);
    assert_eq!(part("direct"), 0);
    assert_eq!(report["certificate"], "passed");
}

#[test]
fn triangulate_has_the_same_keys_and_echoes_its_options() {
    let place = Place::new();
    let line = "triangulate sample:graded:2000,d=2,lipschitz=0.2 --workers 5 --threads 1 --seed 9 --transport sim \
                --delivery-seed 4 --partition kd --json -";
    let report: Value = serde_json::from_slice(&place.good(line).stdout).unwrap();
    for (pointer, keys) in KEYS {
        assert_keys(&report, pointer, keys);
    }
    let proved = &report["how_proved"];
    assert_eq!((&proved["direct"], &proved["hypothesis"]), (&report["points"]["used"], &0.into()));
    let parameters = &report["parameters"];
    let expected = [
        ("command", "triangulate".into()),
        ("workers", "5".into()),
        ("threads", 1.into()),
        ("separator_sets", "ghost".into()),
        ("partition", "kd".into()),
        ("neighbours", "descent".into()),
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
    assert_eq!(report["supergraph"]["kind"], "none", "pieces need none");
    // The formula of an f-spaced set, with the constant that its size function really has.
    place.good("simulate sample:graded:800,d=2,lipschitz=0.2 --json counted.json");
    let counted = place.json("counted.json");
    let lipschitz = counted["parameters"]["lipschitz"].as_f64().unwrap();
    let alpha = counted["supergraph"]["alpha"].as_f64().unwrap();
    assert!(lipschitz > 0.0 && lipschitz <= 0.2, "{lipschitz}");
    assert!((alpha - 1.25 * 2.0 * (1.0 + lipschitz) / (1.0 - lipschitz)).abs() < 1e-12, "{alpha}");
}

/// The picture without what depends on the workers.
fn picture(p: &str, more: &str) -> Value {
    let line = format!("simulate sample:well-spaced:30000,seed=4 --workers {p} {more} --json -");
    let output = Place::new().good(&line);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut view = report["view"].clone();
    let text = view.to_string();
    assert!(text.len() <= 4 << 20, "{} bytes", text.len());
    assert!(
        view["owner"]
            .as_array()
            .unwrap()
            .iter()
            .all(|o| (1..=p.parse().unwrap()).contains(&o.as_u64().unwrap()))
    );
    view["owner"] = Value::Null;
    view
}

#[test]
fn the_picture_does_not_depend_on_the_workers() {
    let one = picture("1", "");
    assert_eq!(one, picture("7", "--transport sim --delivery-seed 3"));
    let points = one["points"].as_u64().unwrap();
    assert!((18_000..=20_000).contains(&points), "{points}");
    assert_eq!(one["positions"].as_array().unwrap().len() as u64, 3 * points);
    assert!(one["of"].as_u64().unwrap() > 20_000);
    // Every ghost lies in another leaf than its owning leaf; every separator's members are on its path.
    let list = |key: &str| one[key].as_array().unwrap().clone();
    let (leaf, ghost, holder) = (list("leaf"), list("ghost"), list("ghost_leaf"));
    assert!(!ghost.is_empty() && ghost.len() == holder.len());
    for (g, h) in ghost.iter().zip(&holder) {
        assert_ne!(&leaf[g.as_u64().unwrap() as usize], h);
    }
    let level = |leaf: &Value| list("leaves")[leaf.as_u64().unwrap() as usize].as_u64().unwrap().ilog2();
    let crossing = list("crossing");
    assert!(crossing.iter().any(|c| c.as_u64().unwrap() & 1 == 1));
    for (c, l) in crossing.iter().zip(&leaf).take(2000) {
        assert!(c.as_u64().unwrap() >> level(l) == 0);
    }
}

#[test]
fn pictures_are_asked_for() {
    let place = Place::new();
    let view = |line: &str| -> Value {
        serde_json::from_slice::<Value>(&place.good(line).stdout).unwrap()["view"].clone()
    };
    assert_eq!(view("triangulate sample:uniform:500 --json -"), Value::Null);
    assert_eq!(view("simulate sample:uniform:500 --view 0 --json -"), Value::Null);
    assert_eq!(view("triangulate sample:uniform:500,d=2 --view 20000 --json -")["points"], 500);
}

#[test]
fn the_page_shows_the_group_of_each_phase() {
    let place = Place::new();
    place.good("simulate sample:uniform:4000 --workers 8 --json r.json");
    place.good("report r.json -o page.html --svg figures");
    let figures = std::fs::read_dir(place.path("figures")).unwrap().map(|entry| entry.unwrap().path());
    let mut figures = figures.filter(|path| path.to_string_lossy().ends_with("phases-work.svg"));
    let work = figures.next().unwrap();
    let svg = std::fs::read_to_string(work).unwrap();
    let class = |phase: &str| {
        let before = svg.split_once(&format!(">{phase}<")).unwrap().0;
        before.rsplit_once("<rect class=\"").unwrap().1.split_once('"').unwrap().0.to_owned()
    };
    assert_eq!(class("partition"), "bar c0");
    assert_eq!(class("check"), "hatched");
    assert_eq!(class("choice"), "bar c1");
    for name in ["the paper", "agreement and repair", "choice of the supergraph"] {
        assert!(svg.contains(&format!(">{name}<")), "the legend lacks {name}");
    }
}
