use septet_geometry::cost::Primitive;

use super::*;

/// A trace of two parallel chains, each with a step of a later phase.
const TRACE: &str = r#"{"schema":"septet-cost/1","version":"0","points":2,"rows":8}
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
    let brent = [(30, 3), (31, 4), (24, 7)].map(|(work, depth): (u64, u64)| (work - depth) / 2 + depth);
    assert_eq!(accounts.paper, TotalAccount { work: 85, depth: 3 + 3 + 7, brent: brent.iter().sum() });
    assert_eq!(accounts.repair, TotalAccount { work: 9, depth: 1, brent: 5 });
}

#[test]
fn incomplete_traces_are_refused() {
    let without = |row: usize| {
        let lines = TRACE.lines().enumerate().filter(|(at, _)| *at != row + 1);
        folded(&lines.map(|(_, line)| format!("{line}\n")).collect::<String>())
    };
    for row in 0..8 {
        assert!(without(row).is_err(), "{row}");
    }
    let with = |from: &str, to: &str| {
        assert!(TRACE.contains(from), "{from}");
        folded(&TRACE.replace(from, to)).unwrap_err().to_string()
    };
    assert_eq!(with("\"after\":[2]", "\"after\":[]"), "row 4 is after no other row");
    assert_eq!(with("\"after\":[4,5]", "\"after\":[4]"), "no row is after row 5");
    assert_eq!(with("\"after\":[2]", "\"after\":[9]"), "row 4 is after row 9, which does not come before it");
    assert_eq!(with("\"scan\"", "\"scam\""), "row 6: the primitive `scam` has no price");
    assert_eq!(with("cost/1", "cost/9"), "the format is `septet-cost/9` instead of `septet-cost/1`");
    let longest = "row 4: the longest lane has calls that the vector step does not have";
    assert_eq!(
        with("[{\"primitive\":\"sequential\",\"items\":7}]", "[{\"primitive\":\"sequential\",\"items\":8}]"),
        longest
    );
    assert_eq!(folded("").unwrap_err().to_string(), "the cost trace is empty");
}

#[test]
fn differences_name_the_phase() {
    let text = r#"{"schema":"septet-run/1","machine":{"workers":2,"paper":{"work":85,"depth":13,"depth_log_scan":9,"brent":48},
        "repair":{"work":9,"depth":1,"brent":5}},"phases":[{"name":"partition","work":61,"depth":7},
        {"name":"hulls","work":24,"depth":8},{"name":"check","work":9,"depth":1},{"name":"load","work":0,"depth":0}]}"#;
    let reported: ReportedCounts = serde_json::from_str(text).unwrap();
    let accounts = folded(TRACE).unwrap();
    let differences: Vec<String> = accounts.differences(&reported).iter().map(ToString::to_string).collect();
    assert_eq!(differences, ["depth of hulls: 7 by the cost trace, 8 by the ledger"]);
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
