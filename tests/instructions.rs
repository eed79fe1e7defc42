//! Instructions retired for each unit of charged work, by valgrind: a charge that leaves out its loop is found.

use std::process::{Command, Output};

/// `bench/work-instructions` on a small set.
fn counted(fault: &[&str]) -> Output {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/bench/work-instructions");
    let septet = env!("CARGO_BIN_EXE_septet");
    let run =
        Command::new("python3").args([script, "--sizes", "4000", "--binary", septet]).args(fault).output();
    run.expect("python3 must be installed: tests/run does that")
}

#[test]
#[ignore = "needs valgrind and python3"]
fn work_is_charged_where_it_is_done() {
    let run = counted(&[]);
    let text = String::from_utf8_lossy(&run.stdout);
    assert!(
        run.status.success() && text.ends_with("passed\n"),
        "{text}{}",
        String::from_utf8_lossy(&run.stderr)
    );
}

#[test]
#[ignore = "needs valgrind and python3"]
fn a_charge_without_its_loop_is_found() {
    let run = counted(&["--fault", "free-loop"]);
    let text = String::from_utf8_lossy(&run.stdout);
    assert_eq!(run.status.code(), Some(1), "{text}{}", String::from_utf8_lossy(&run.stderr));
    assert!(text.contains("between radii and ") && text.ends_with("FAILED\n"), "{text}");
}
