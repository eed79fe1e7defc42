//! Traces and tables as files.

use std::fs;
use std::process::{Command, Stdio};

use serde_json::Value;

use super::{Place, code, stderr};

fn rows(trace: &Value) -> &Vec<Value> {
    trace["traceEvents"].as_array().unwrap()
}

#[test]
fn traces_are_written_beside_other_outputs() {
    let place = Place::new();
    place.good("simulate sample:uniform:2000 --workers 3 --trace t.json --json r.json");
    let (trace, report) = (place.json("t.json"), place.json("r.json"));
    let count = |kind: &str| rows(&trace).iter().filter(|r| r["ph"] == kind).count();
    assert_eq!(count("B"), count("E"));
    assert_eq!(count("s") as u64, report["machine"]["messages"].as_u64().unwrap());
    let phases = rows(&trace).iter().filter(|r| r["ph"] == "B" && r["cat"] == "phase");
    let names: Vec<&str> = phases.map(|r| r["name"].as_str().unwrap()).collect();
    let expected = report["phases"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap());
    // The steps of repair contain the probes of cells.
    let expected: Vec<&str> =
        ["run"].into_iter().chain(expected.filter(|name| *name != "probe-cells")).collect();
    assert_eq!(names, expected);
    place.good("triangulate sample:uniform:2000 --trace u.json --trace-level phase");
    assert!(rows(&place.json("u.json")).iter().all(|r| r["ph"] == "M" || r["pid"] == 1));
    // Points in a plane: the ranks only prepare the rows.
    place.file("flat.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n").good("triangulate flat.xyz --trace v.json");
    let trace = place.json("v.json");
    let phases = rows(&trace).iter().filter(|r| r["ph"] == "B" && r["cat"] == "phase");
    assert!(phases.map(|r| r["name"].as_str().unwrap()).eq(["run", "load", "collect"]));
}

#[test]
fn impossible_instruments_are_refused() {
    let place = Place::new();
    place.fails("simulate sample:uniform:200 --trace -", 2, &["--trace"]);
    place.fails("simulate sample:uniform:200 --trace-level phase", 2, &["--trace"]);
    place.fails("simulate sample:uniform:200 --trace t.json --json t.json", 2, &["same file"]);
    place.fails("simulate sample:uniform:200 --trace none/t.json", 1, &["does not exist"]);
    place.fails("simulate sample:uniform:200 --profile=p.txt", 2, &[".md"]);
    place.fails("simulate sample:uniform:200 --profile=p.csv --json p.rounds.csv", 2, &["same file"]);
    place.file("a.json", "0 0\n1 0\n0 1\n");
    place.fails("triangulate a.json --trace a.json", 2, &["overwrite the input"]);
}

/// Devices stay, and take several outputs; a pipe takes one, and so does the name of an open file.
#[cfg(target_os = "linux")]
#[test]
fn devices_and_pipes_are_written_to() {
    use std::os::unix::fs::FileTypeExt;
    let place = Place::new();
    place.good("simulate sample:uniform:200 --trace /dev/null --json /dev/null");
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    let pipe = place.path("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    place.fails("simulate sample:uniform:200 --trace pipe --json pipe", 2, &["same file"]);
    let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
    place.good("simulate sample:uniform:200 --json pipe");
    let report: Value = serde_json::from_slice(&reader.join().unwrap()).unwrap();
    assert_eq!(report["schema"], "septet-run/2");
    let log = fs::File::create(place.path("log")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_septet"));
    command.args(["simulate", "sample:uniform:200", "--json", "/dev/stdout"]).stdout(log);
    let output = command.stderr(Stdio::piped()).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(place.json("log")["schema"], "septet-run/2");
}

#[test]
fn tables_as_files_say_what_is_modelled_and_what_is_measured() {
    let place = Place::new();
    place.good("simulate sample:uniform:2000 --profile=p.csv --json r.json");
    let report = place.json("r.json");
    let read = |name: &str| fs::read_to_string(place.path(name)).unwrap();
    for (table, key) in [("phases", "phases"), ("rounds", "rounds")] {
        let text = read(&format!("p.{table}.csv"));
        let columns = text.lines().next().unwrap().split(',').count();
        assert_eq!(text.lines().count(), report[key].as_array().unwrap().len() + 1);
        assert!(text.lines().all(|l| l.split(',').count() == columns), "{text}");
    }
    let phases = read("p.phases.csv");
    let head: Vec<&str> = phases.lines().next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|h| *h == name).unwrap();
    let (depth, seconds) = (at("modelled_depth"), at("measured_seconds"));
    for (line, phase) in phases.lines().skip(1).zip(report["phases"].as_array().unwrap()) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells[0], phase["name"]);
        assert_eq!(cells[depth].parse::<u64>().ok(), phase["depth"].as_u64());
        assert!((cells[seconds].parse::<f64>().unwrap() - phase["seconds"].as_f64().unwrap()).abs() < 1e-4);
    }
    let levels = report["tree"]["by_level"].as_array().unwrap().len();
    assert_eq!(read("p.levels.csv").lines().count(), levels + 1);
    // What `triangulate` does not count is empty, not zero.
    place.good("triangulate sample:uniform:2000 --profile=q.csv");
    assert!(read("q.phases.csv").lines().skip(1).all(|l| l.split(',').nth(depth) == Some("")));
    place.good("triangulate sample:uniform:2000 --profile=q.md");
    let text = read("q.md");
    for words in [
        "# triangulate of 2000 points",
        "## Phases",
        "## Rounds",
        "| modelled depth |",
        "| measured seconds |",
    ] {
        assert!(text.contains(words), "{text}");
    }
}

#[cfg(unix)]
#[test]
fn the_trace_of_an_interrupted_run_is_whole() {
    let place = Place::new();
    let mut command = place.command("simulate sample:uniform:3e5 --workers 64 -o a.ele --trace t.json");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    // The trace grows under a temporary name once the run goes on.
    let growing = || {
        let entries = fs::read_dir(place.0.path()).unwrap().flatten();
        entries.filter_map(|e| e.metadata().ok()).any(|m| m.len() > 0)
    };
    while !growing() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    assert!(stderr(&output).contains("wrote t.json"));
    assert_eq!(place.names().into_iter().collect::<Vec<_>>(), ["t.json"]);
    let trace = place.json("t.json");
    let count = |kind: &str| rows(&trace).iter().filter(|r| r["ph"] == kind).count();
    assert!(count("B") > 0);
    assert_eq!(count("B"), count("E"));
}
