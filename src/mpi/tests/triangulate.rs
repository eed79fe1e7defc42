//! `septet-mpi` writes the bytes of `septet`, and all processes end together.

#[path = "common/mpirun.rs"]
mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{PROGRAM, mpirun, run};
use tempfile::TempDir;

/// The time in which all processes must be gone.
const END: Duration = Duration::from_secs(5);

/// The program `septet` of the same build.
fn septet() -> PathBuf {
    let program = Path::new(PROGRAM).with_file_name("septet");
    assert!(program.exists(), "{} is missing: run cargo build with the same profile", program.display());
    program
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// Runs `septet` in a folder.
fn one(folder: &TempDir, line: &str) -> Output {
    let output = run(Command::new(septet()).args(words(line)).current_dir(folder.path()));
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Runs `septet-mpi` in a folder.
fn many(folder: &TempDir, processes: u32, line: &str) -> Output {
    run(mpirun(processes, &words(line)).current_dir(folder.path()))
}

/// The files of the outputs `NAME.npy`, `NAME.vtu` and `NAME.pvtu`, by name.
fn outputs(folder: &TempDir) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for name in ["x.npy", "x.vtu", "x.pvtu"] {
        found.push((name.to_owned(), fs::read(folder.path().join(name)).unwrap()));
    }
    for entry in fs::read_dir(folder.path().join("x.pieces")).unwrap() {
        let entry = entry.unwrap();
        found.push((entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()));
    }
    found.sort();
    found
}

const OUTPUTS: &str = "-q -o x.npy -o x.vtu -o x.pvtu";

fn same(command: &str, folder: &TempDir) {
    one(folder, &format!("{command} --workers 8 {OUTPUTS}"));
    let expected = outputs(folder);
    for processes in [1, 2, 5, 8] {
        let output = many(folder, processes, &format!("{command} --workers 8 {OUTPUTS}"));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command}, {processes} processes: {errors}");
        for (found, expected) in outputs(folder).iter().zip(&expected) {
            assert!(found == expected, "{command}, {processes} processes: other bytes in {}", found.0);
        }
    }
}

#[test]
fn processes_write_the_bytes_of_one_process() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |n: usize, row: &dyn Fn(usize) -> String| (0..n).map(row).collect::<String>();
    one(&folder, "generate uniform -n 100000 -q -o uniform.npy");
    one(&folder, "generate grid -n 8000 -q -o grid.npy");
    for part in 0..3 {
        one(&folder, &format!("generate clusters -n 3000 --seed {part} -q -o part-{part}.npy"));
    }
    let put = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    put("repeated.xyz", rows(3000, &|i| format!("{} {} {}\n", i * 37 % 61, i * 23 % 59, i * 11 % 3)));
    put("plane.xyz", rows(500, &|i| format!("{} {} 1\n", i % 20, i / 20)));
    put("line.xyz", rows(20, &|i| format!("{i} {i} {i}\n")));
    put("seven.xyz", rows(7, &|i| format!("{} {} {}\n", i % 2, i / 2, i * i)));
    for input in
        ["uniform.npy", "grid.npy", "part-*.npy", "repeated.xyz", "plane.xyz", "line.xyz", "seven.xyz"]
    {
        same(&format!("triangulate {input}"), &folder);
    }
}

/// Messages that are cut into small parts arrive as whole messages.
#[test]
fn parts_do_not_change_the_bytes() {
    let folder = tempfile::tempdir().unwrap();
    one(&folder, "generate uniform -n 20000 -q -o uniform.npy");
    one(&folder, &format!("triangulate uniform.npy --workers 8 {OUTPUTS}"));
    let expected = outputs(&folder);
    for processes in [5, 8] {
        let line = format!("triangulate uniform.npy --workers 8 {OUTPUTS} --part-bytes 4096");
        let output = many(&folder, processes, &line);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(outputs(&folder) == expected, "{processes} processes");
    }
}

/// Rows have the numbers that they have without MPI.
#[test]
fn rows_are_numbered_from_any_number() {
    let folder = tempfile::tempdir().unwrap();
    one(&folder, "generate grid -n 1000 -q -o grid.npy");
    let line = format!("triangulate grid.npy --workers 8 {OUTPUTS} --first-row 8589934592");
    one(&folder, &format!("{line} --transport processes --processes 3"));
    let expected = outputs(&folder);
    for processes in [1, 5] {
        let output = many(&folder, processes, &line);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(outputs(&folder) == expected, "{processes} processes");
    }
}

#[test]
fn processes_simulate_as_one_process_does() {
    let folder = tempfile::tempdir().unwrap();
    one(&folder, "generate clusters -d 2 -n 2000 -q -o clusters.npy");
    same("simulate sample:uniform:2000", &folder);
    same("simulate clusters.npy --supergraph knn", &folder);
    let line = "simulate sample:graded:1000 --workers 5 -q --json";
    one(&folder, &format!("{line} one.json --view 0"));
    assert!(many(&folder, 3, &format!("{line} many.json")).status.success());
    // Reports have a line for each field, and these have no measurement.
    let counts = |name: &str| -> Vec<String> {
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        let fields = ["supergraph", "repair", "how_proved", "machine", "graph", "tree"];
        let is_count = |line: &&str| fields.iter().any(|f| line.starts_with(&format!("  \"{f}\": ")));
        text.lines().filter(is_count).map(str::to_owned).collect()
    };
    assert_eq!(counts("many.json"), counts("one.json"));
    assert_eq!(counts("many.json").len(), 6);
    assert!(many(&folder, 3, &format!("{line} none.json --nodes none")).status.success());
    assert_eq!(counts("none.json"), counts("one.json"));
}

#[test]
fn a_start_without_mpirun_is_one_process() {
    let folder = tempfile::tempdir().unwrap();
    one(&folder, "triangulate sample:uniform:2000 --workers 1 -q -o a.npy");
    let line = "triangulate sample:uniform:2000 -q -o b.npy";
    let output =
        run(Command::new(PROGRAM).args(words(line)).current_dir(folder.path()).envs(common::SETTINGS));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("a.npy") == read("b.npy"));
}

/// The run fails with this code, and one message with this word.
fn fails(folder: &TempDir, line: &str, code: i32, word: &str) {
    let output = many(folder, 3, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{line}: {errors}");
    assert_eq!(errors.matches("error:").count(), 1, "{line}: {errors}");
    assert!(errors.contains(word), "{line}: {errors}");
}

#[test]
fn all_processes_fail_with_one_message() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bad.xyz"), "0 0 0\n1 0 0\n0 1 0\n0 0 nan\n1 1 1\n").unwrap();
    fails(&folder, "triangulate bad.xyz -o m.vtu", 3, "bad.xyz");
    fails(&folder, "triangulate none.npy -o m.vtu", 3, "none.npy");
    fails(&folder, "triangulate bad.xyz -o m.msh", 3, "bad.xyz");
    fails(&folder, "triangulate bad.xyz -o m.vtu --no-such-option", 2, "--no-such-option");
    fails(&folder, "mesh bad.xyz -o m.vtu", 2, "simulate");
    fails(&folder, "simulate bad.xyz -o m.vtu --workers leaves", 2, "in one process");
    fails(&folder, "triangulate sample:uniform:500 -o m.npy --fault die:2:partition", 6, "worker 2");
    fails(&folder, "triangulate sample:uniform:500 -o m.npy --fault spoil:1", 4, "certificate");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["bad.xyz"]);
}

/// Runs two programs as the processes of one run. It fails with this code and this word.
fn differ(folder: &TempDir, [program, arguments]: [&str; 2], code: i32, word: &str) {
    let mut command = mpirun(1, &words("triangulate sample:uniform:500 -o m.npy"));
    command.args([":", "-n", "1", program]).args(words(arguments)).current_dir(folder.path());
    let output = run(&mut command);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{errors}");
    assert!(errors.contains(word), "{errors}");
}

#[test]
fn processes_that_differ_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    differ(&folder, [PROGRAM, "triangulate sample:uniform:600 -o m.npy"], 2, "other arguments");
    let other = folder.path().join("septet-mpi");
    // The loader ignores bytes after the program.
    fs::write(&other, [fs::read(PROGRAM).unwrap(), vec![0]].concat()).unwrap();
    fs::set_permissions(&other, fs::metadata(PROGRAM).unwrap().permissions()).unwrap();
    differ(&folder, ["./septet-mpi", "triangulate sample:uniform:500 -o m.npy"], 6, "another build");
    assert!(!folder.path().join("m.npy").exists());
}

/// The processes of a run in this folder: `septet-mpi`, without `mpirun`.
fn running(folder: &Path) -> Vec<u32> {
    let mut found = Vec::new();
    for entry in fs::read_dir("/proc").unwrap().flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse() else { continue };
        let is_here = fs::read_link(entry.path().join("cwd")).is_ok_and(|cwd| cwd == folder);
        let is_program = fs::read_link(entry.path().join("exe")).is_ok_and(|exe| exe == Path::new(PROGRAM));
        if is_here && is_program {
            found.push(pid);
        }
    }
    found
}

/// Returns the status of `mpirun`, whose processes have ended. Open MPI's launcher can hang after a process was killed. After
/// 10 seconds, this function kills the launcher and returns `None`.
fn end_of(launcher: &mut Child) -> Option<ExitStatus> {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(10) {
        if let Some(status) = launcher.try_wait().unwrap() {
            return Some(status);
        }
        thread::sleep(Duration::from_millis(10));
    }
    launcher.kill().unwrap();
    launcher.wait().unwrap();
    None
}

/// Kills a process after different times. All processes end within 5 seconds, and no output is left under its name.
#[test]
fn all_processes_end_with_one_of_them() {
    let folder = tempfile::tempdir().unwrap();
    one(&folder, "generate uniform -n 200000 -q -o points.npy");
    for try_number in 0..10_u64 {
        let line = "triangulate points.npy --workers 6 -q -o m.npy -o m.pvtu";
        let mut command = mpirun(3, &words(line));
        command.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let start = Instant::now();
        let victims = loop {
            let found = running(folder.path());
            if found.len() == 3 {
                break found;
            }
            assert!(start.elapsed() < Duration::from_secs(30), "the processes do not start");
            thread::sleep(Duration::from_millis(5));
        };
        thread::sleep(Duration::from_millis(100 * try_number));
        let signal = ["-KILL", "-TERM"][try_number as usize % 2];
        let victim = victims[try_number as usize % 3].to_string();
        let _ = Command::new("kill").args([signal, &victim]).status().unwrap();
        let killed = Instant::now();
        while !running(folder.path()).is_empty() {
            assert!(killed.elapsed() < END, "{signal} {try_number}: a process still runs");
            thread::sleep(Duration::from_millis(10));
        }
        if !end_of(&mut child).is_some_and(|status| status.success()) {
            for output in ["m.npy", "m.pvtu", "m.pieces"] {
                assert!(!folder.path().join(output).exists(), "{signal} {try_number}: {output}");
            }
        }
        for entry in fs::read_dir(folder.path()).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                fs::remove_dir_all(path).unwrap();
            } else if !path.ends_with("points.npy") {
                fs::remove_file(path).unwrap();
            }
        }
    }
}
