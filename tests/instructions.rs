//! Instructions retired for each unit of charged work, by valgrind: a charge that leaves out its loop is found.
//!
//! Without valgrind and Python nothing runs, unless `SEPTET_REQUIRE_FOREIGN=1` asks for it.

use std::process::{Command, Output};

/// `bench/work-instructions` on a small set, or nothing if its programs are missing.
fn counted(fault: &[&str]) -> Option<Output> {
    let there = |program: &str| Command::new(program).arg("--version").output().is_ok();
    if !(there("valgrind") && there("python3")) {
        let required = std::env::var_os("SEPTET_REQUIRE_FOREIGN").is_some_and(|value| value == "1");
        assert!(!required, "SEPTET_REQUIRE_FOREIGN=1, and valgrind or python3 is missing");
        return None;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/bench/work-instructions");
    let septet = env!("CARGO_BIN_EXE_septet");
    let run =
        Command::new("python3").args([script, "--sizes", "4000", "--binary", septet]).args(fault).output();
    Some(run.expect("python3 runs"))
}

#[test]
fn work_is_charged_where_it_is_done() {
    let Some(run) = counted(&[]) else { return };
    let text = String::from_utf8_lossy(&run.stdout);
    assert!(
        run.status.success() && text.ends_with("passed\n"),
        "{text}{}",
        String::from_utf8_lossy(&run.stderr)
    );
}

#[test]
fn a_charge_without_its_loop_is_found() {
    let Some(run) = counted(&["--fault", "free-loop"]) else { return };
    let text = String::from_utf8_lossy(&run.stdout);
    assert_eq!(run.status.code(), Some(1), "{text}{}", String::from_utf8_lossy(&run.stderr));
    assert!(text.contains("between radii and ") && text.ends_with("FAILED\n"), "{text}");
}
