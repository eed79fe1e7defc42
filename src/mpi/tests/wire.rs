//! The wire between processes that `mpirun` starts.
//!
//! `MPIRUN` names another `mpirun`, for example that of another MPI library.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

#[path = "common/mpirun.rs"]
mod common;

use common::{PROGRAM, SETTINGS, run};

fn mpirun(processes: u32, test: &str) -> Command {
    common::mpirun(processes, &[test])
}

/// The time in which all processes must be gone after one of them was killed.
const END: Duration = Duration::from_secs(5);

fn passes(command: &mut Command) {
    let output = run(command);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}\n{errors}", output.status);
    assert_eq!(String::from_utf8_lossy(&output.stdout), "passed\n", "{command:?}\n{errors}");
}

#[test]
fn parcels_arrive() {
    for processes in [1, 2, 5] {
        passes(&mut mpirun(processes, "--self-test"));
    }
}

#[test]
fn a_process_without_mpirun_works() {
    passes(Command::new(PROGRAM).arg("--self-test").envs(SETTINGS));
}

/// Runs a test in which one process fails alone, and the others wait for it.
fn fails(test: &str, code: i32, message: &str) {
    let start = Instant::now();
    let output = run(&mut mpirun(3, test));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{errors}");
    assert_eq!(errors.matches(message).count(), 1, "{errors}");
    assert!(!String::from_utf8_lossy(&output.stdout).contains("passed"));
    assert!(start.elapsed() < Duration::from_secs(30), "the end took {:?}", start.elapsed());
}

#[test]
fn a_panic_ends_all_processes() {
    fails("--self-test=panic", 101, "this panic is planted");
}

#[test]
fn a_failure_of_one_process_ends_all() {
    fails("--self-test=fail", 7, "this failure is planted");
}

#[test]
fn processes_with_the_same_error_end_in_order() {
    let output = run(&mut mpirun(3, "--self-test=unknown"));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(!errors.to_lowercase().contains("mpi_abort"), "{errors}");
}

#[test]
fn a_killed_process_ends_all() {
    let mut child =
        mpirun(3, "--self-test=hang").stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    let is_id = |line: String| line.strip_prefix("id ").map(str::to_string);
    let ids: Vec<String> = lines.filter_map(is_id).take(3).collect();
    assert_eq!(ids.len(), 3, "the processes did not start");
    let runs = |id: &String| Path::new("/proc").join(id).exists();
    thread::sleep(Duration::from_millis(300));
    assert!(ids.iter().all(runs), "the processes end early");
    let start = Instant::now();
    assert!(Command::new("kill").args(["-9", &ids[1]]).status().unwrap().success());
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        assert!(start.elapsed() < END, "mpirun still runs");
        thread::sleep(Duration::from_millis(20));
    };
    assert!(!status.success(), "{status}");
    while ids.iter().any(runs) {
        assert!(start.elapsed() < END, "a process still runs");
        thread::sleep(Duration::from_millis(20));
    }
}
