use septet_geometry::cost::Primitive;
use septet_protocol::ids::{Group, Phase};

use super::*;

/// A trace of two parallel chains, each with a step of a later phase.
const TRACE: &str = r#"{"schema":"septet-cost/1","version":"0","points":2,"seed":5,"rows":8}
{"row":0,"phase":"load","primitive":"barrier","items":0,"after":[]}
{"row":1,"phase":"partition","node":1,"rank":1,"primitive":"pack","items":10,"after":[0]}
{"row":2,"phase":"partition","node":2,"rank":1,"primitive":"sort","items":5,"after":[1]}
{"row":3,"phase":"partition","node":3,"rank":2,"primitive":"split","items":4,"after":[1]}
{"row":4,"phase":"hulls","node":2,"rank":1,"primitive":"lanes","items":2,"calls":[{"primitive":"sequential","items":7,"times":1},{"primitive":"step","items":3,"times":2}],"longest":[{"primitive":"sequential","items":7}],"after":[2]}
{"row":5,"phase":"hulls","node":3,"rank":2,"primitive":"merge","items":5,"after":[3]}
{"row":6,"phase":"check","node":3,"rank":2,"primitive":"scan","items":9,"after":[4,5]}
{"row":7,"phase":"done","primitive":"barrier","items":0,"after":[6]}
"#;

fn folded(text: &str) -> Result<Accounts, AccountError> {
    fold(text.as_bytes())
}

#[test]
fn clocks_take_the_longest_paths() {
    let accounts = folded(TRACE).unwrap();
    let phase = |name: &str| {
        let found = accounts.phases.iter().find(|phase| phase.phase == name).unwrap();
        (found.work, found.depth)
    };
    assert_eq!(phase("partition"), (30 + 15 + 16, 3 + 4));
    // A merge takes 5, 3, 2 and 1 operations.
    assert_eq!(phase("hulls"), (7 + 6 + 11, 7));
    assert_eq!(phase("check"), (9, 1));
    let brent =
        [(30, 3), (31, 4), (24, 7)].map(|(work, depth): (u64, u64)| (work - depth).div_ceil(2) + depth);
    assert_eq!(accounts.paper, TotalAccount { work: 85, depth: 3 + 3 + 7, brent: brent.iter().sum() });
    assert_eq!(accounts.repair, TotalAccount { work: 9, depth: 1, brent: 5 });
}

#[test]
fn incomplete_traces_are_refused() {
    let without = |row: usize| {
        let lines = TRACE.lines().enumerate().filter(|(at, _)| *at != row + 1);
        folded(&lines.map(|(_, line)| line.to_owned() + "\n").collect::<String>())
    };
    for row in 0..8 {
        assert!(without(row).is_err(), "{row}");
    }
    let with = |from: &str, to: &str| {
        assert!(TRACE.contains(from), "{from}");
        let error = folded(&TRACE.replace(from, to)).unwrap_err();
        format!("{error}; {}", error.remedy().unwrap())
    };
    let again = "; write the cost trace again";
    let row = |number: u64, text: &str| format!("row {number} {text}{again}");
    assert_eq!(with("\"after\":[2]", "\"after\":[]"), row(4, "has no predecessor in `after`"));
    assert_eq!(with("\"after\":[4,5]", "\"after\":[4]"), row(5, "has no successor"));
    let order = "names row 9 in `after`, which does not come before it";
    assert_eq!(with("\"after\":[2]", "\"after\":[9]"), row(4, order));
    assert_eq!(with("\"rows\":8", "\"rows\":9"), format!("the trace has 8 of 9 rows{again}"));
    let version = "; use the version of septet that wrote the trace";
    assert_eq!(with("\"scan\"", "\"scam\""), format!("row 6: the primitive `scam` has no price{version}"));
    assert_eq!(with("\"check\"", "\"lunch\""), format!("row 6: there is no phase `lunch`{version}"));
    let file = "; give a file that `septet simulate` wrote with `cost_trace`";
    let format = "the format is `septet-cost/9` instead of `septet-cost/1`";
    assert_eq!(with("cost/1", "cost/9"), format!("{format}{file}"));
    assert_eq!(folded("").unwrap_err().to_string(), "the cost trace is empty");
}

#[test]
fn damaged_rows_are_refused() {
    let with = |from: &str, to: &str| {
        assert!(TRACE.contains(from), "{from}");
        folded(&TRACE.replace(from, to)).unwrap_err()
    };
    assert!(matches!(with("\"node\":1,", "\"node\":0,"), AccountError::Node { row: 1 }));
    let most = format!("\"items\":{}", u64::MAX);
    let long = format!("\"primitive\":\"sequential\",{most}");
    // Two rows of one phase, and a total.
    let pair = TRACE.replace("\"primitive\":\"pack\",\"items\":10", &long);
    assert!(matches!(folded(&pair).unwrap_err(), AccountError::Overflow { row: 2 }));
    let pair = pair.replace("\"primitive\":\"sort\",\"items\":5", &long);
    assert!(matches!(folded(&pair).unwrap_err(), AccountError::Overflow { row: 2 }));
    for primitive in ["pack", "merge", "sort"] {
        let other = format!("\"primitive\":\"{primitive}\",{most}");
        let error = with("\"primitive\":\"pack\",\"items\":10", &other);
        assert!(matches!(error, AccountError::Overflow { row: 1 }), "{primitive}: {error}");
    }
    let times = format!("\"times\":{}", u64::MAX);
    assert!(matches!(with("\"times\":2", &times), AccountError::Overflow { row: 4 }));
    let lane = "[{\"primitive\":\"sequential\",\"items\":7}]";
    let other = lane.replace('7', "8");
    assert!(matches!(with(lane, &other), AccountError::Longest { row: 4 }));
}

/// The longest lane may contain a vector step, whose longest lane contains none.
#[test]
fn deep_nesting_is_refused() {
    let lane = "[{\"primitive\":\"sequential\",\"items\":7}]";
    let calls = "[{\"primitive\":\"sequential\",\"items\":7,\"times\":1}]";
    let inside = |longest: &str| {
        format!("[{{\"primitive\":\"lanes\",\"items\":1,\"calls\":{calls},\"longest\":{longest}}}]")
    };
    let depth = |longest: &str| {
        let accounts = folded(&TRACE.replace(lane, longest));
        accounts.map(|accounts| accounts.paper.depth)
    };
    assert_eq!(depth(&inside(lane)).unwrap(), depth(lane).unwrap());
    assert!(matches!(depth(&inside(&inside(lane))).unwrap_err(), AccountError::Nesting { row: 4 }));
}

/// The list of phases of this account against the list of the machine.
#[test]
fn all_phases_are_known() {
    for phase in Phase::ALL {
        let group = match phase.group() {
            Group::Paper => clock::Group::Paper,
            Group::Repair => clock::Group::Repair,
            Group::Selection => clock::Group::Selection,
            Group::Direct | Group::Machine => clock::Group::Neither,
        };
        assert_eq!(clock::Group::of(phase.name()), Some(group), "{phase:?}");
    }
    assert_eq!(clock::Group::of("lunch"), None);
}

#[test]
fn differences_name_the_phase() {
    let text = r#"{"schema":"septet-run/2","seed":5,"points":{"input":3,"used":2},
        "machine":{"workers":2,"paper":{"work":85,"depth":13,"depth_log_scan":9,"brent":51},
        "repair":{"work":9,"depth":1,"brent":5}},"phases":[{"name":"partition","work":61,"depth":7},
        {"name":"hulls","work":24,"depth":8},{"name":"check","work":9,"depth":1},{"name":"load","work":0,"depth":0}]}"#;
    let compared = |text: &str| folded(TRACE).unwrap().compare(&ReportedRun::parse(text.as_bytes())?);
    let differences: Vec<String> = compared(text).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(differences, ["depth of hulls: 7 by the cost trace, 8 by the ledger"]);
    let with = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        let error = compared(&text.replace(from, to)).unwrap_err();
        format!("{error}; {}", error.remedy().unwrap())
    };
    let other = "the report belongs to another run: it has ";
    let once = "; write both files in one run";
    assert_eq!(with("\"seed\":5", "\"seed\":3"), format!("{other}seed 3, and the trace has seed 5{once}"));
    let points = format!("{other}4 points, and the trace has 2 points{once}");
    assert_eq!(with("\"used\":2", "\"used\":4"), points);
    let counts = "\"paper\":{\"work\":85,\"depth\":13,\"depth_log_scan\":9,\"brent\":51}";
    let none = "\"paper\":{\"work\":null,\"depth\":null,\"brent\":null}";
    assert_eq!(with(counts, none), "this run has no counts; run `septet simulate` with `json`");
    assert!(with("run/2", "mesh/2").starts_with("the format is `septet-mesh/2` instead of `septet-run/2`"));
    assert!(with("\"seed\"", "\"seat\"").contains("missing field `seed`"));
}

/// The price list of this account against the list of the meters, which share no code.
#[test]
fn both_price_lists_agree() {
    let sizes = (0..70).chain([127, 128, 129, 1000, 1023, 1024, 1025, 1 << 20, (1 << 20) + 1]);
    for items in sizes {
        for primitive in Primitive::ALL {
            let (own, theirs) = (price::of_call(primitive.name(), items).unwrap(), primitive.price(items));
            assert_eq!((own.work, own.depth), (theirs.work(), theirs.depth()), "{primitive:?} {items}");
        }
    }
}
