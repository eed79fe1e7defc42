//! `--transport processes`: the outputs, the report, and the end of all processes.
#![cfg(unix)]

use std::collections::BTreeMap;

use super::*;

/// The files that a run writes as `name.*`, by the rest of their names.
pub(super) fn outputs(place: &Place, name: &str) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let files = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
    };
    for path in files(place.0.path()).into_iter().filter(|path| path.file_stem().unwrap() == name) {
        let pieces = if path.is_dir() { files(&path) } else { vec![path.clone()] };
        for piece in pieces {
            let label = piece.strip_prefix(&path).unwrap().join(path.extension().unwrap());
            let bytes = fs::read(&piece).unwrap();
            // A `.pvtu` file contains the name of its folder.
            let is_list = path.extension().unwrap() == "pvtu";
            let bytes = if is_list {
                String::from_utf8(bytes).unwrap().replace(&format!("{name}.pieces"), "x.pieces").into_bytes()
            } else {
                bytes
            };
            found.push((label.to_str().unwrap().to_owned(), bytes));
        }
    }
    found.sort();
    found
}

/// The fields of a report that state measurements, the outputs and the transport. All others do not depend on the processes.
const OF_THE_PROCESSES: [&str; 7] =
    ["parameters", "settled", "phases", "seconds", "rss_before_bytes", "peak_rss_bytes", "processes"];

/// The reports of one process and of several have the same counts.
pub(super) fn same_counts(found: &Value, one: &Value, label: &str) {
    let fields = |report: &Value| -> BTreeMap<String, Value> {
        let fields = report.as_object().unwrap().clone().into_iter();
        fields.filter(|(field, _)| !OF_THE_PROCESSES.contains(&field.as_str())).collect()
    };
    let (found_fields, one_fields) = (fields(found), fields(one));
    assert_eq!(found_fields.len(), one_fields.len(), "{label}");
    for (field, value) in one_fields {
        assert_eq!(found_fields.get(&field), Some(&value), "{label}: {field}");
    }
    let of_phases = |report: &Value| -> Vec<Value> {
        let mut phases = report["phases"].as_array().unwrap().clone();
        for phase in &mut phases {
            phase.as_object_mut().unwrap().remove("seconds");
        }
        phases
    };
    assert_eq!(of_phases(found), of_phases(one), "{label}: phases");
    assert_eq!(found["parameters"]["transport"], "processes", "{label}");
}

/// Removes the list of nodes of a report.
fn without_nodes(mut report: Value) -> Value {
    assert!(report.as_object_mut().unwrap().remove("nodes").is_some());
    report
}

/// Runs of 1, 2, 5 and 8 processes write the bytes of one process, and count as it does.
pub(super) fn same_run(place: &Place, command: &str, workers: u32) {
    place.good(&format!(
        "{command} -q --workers {workers} -o one.npy -o one.vtu -o one.pvtu --json r.json --view 0"
    ));
    let (expected, one) = (outputs(place, "one"), place.json("r.json"));
    assert_eq!(expected.len(), 3 + workers as usize, "{command}");
    for processes in [1, 2, 5, 8] {
        let label = format!("{command}, {processes} processes");
        place.good(&format!(
            "{command} -q --workers {workers} -o m.npy -o m.vtu -o m.pvtu --json r.json --transport processes \
             --processes {processes}"
        ));
        let found = outputs(place, "m");
        let names = |files: &[(String, Vec<u8>)]| files.iter().map(|file| file.0.clone()).collect::<Vec<_>>();
        assert_eq!(names(&found), names(&expected), "{label}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(found == expected, "{label}: other bytes in {}", found.0);
        }
        let report = place.json("r.json");
        same_counts(&report, &one, &label);
        let rows = report["processes"].as_array().unwrap();
        assert_eq!(rows.len(), processes, "{label}");
        let sum = |field: &str| rows.iter().map(|row| row[field].as_u64().unwrap()).sum::<u64>();
        assert_eq!(sum("workers"), u64::from(workers), "{label}");
        assert_eq!(sum("bytes_in"), sum("bytes_out"), "{label}");
        assert_eq!(sum("bytes_in") > 0, processes > 1, "{label}");
        // Points that do not span the space are not divided among the workers.
        let is_flat = one["dimension"].as_i64() < one["space"].as_i64();
        let used = if is_flat { 0 } else { one["points"]["used"].as_u64().unwrap() };
        assert_eq!(sum("points"), used, "{label}");
    }
    if command.starts_with("simulate") {
        same_sums(place, &format!("{command} -q --workers {workers} --json r.json"), &one);
    }
}

/// Without the list of nodes, the reports of 1, 2 and 4 processes have the other counts of the report of one process.
fn same_sums(place: &Place, line: &str, one: &Value) {
    let expected = without_nodes(one.clone());
    for processes in [1, 2, 4] {
        place.good(&format!("{line} --nodes none --transport processes --processes {processes}"));
        same_counts(&place.json("r.json"), &expected, &format!("{line}, {processes} processes, no nodes"));
    }
}

/// Writes inputs in which points repeat, are flat, or are fewer than the processes.
fn put_inputs(place: &Place) {
    let rows = |n: usize, row: &dyn Fn(usize) -> String| (0..n).map(row).collect::<String>();
    place.good("generate grid -n 1000 -q -o grid.npy");
    place.file("repeated.xyz", rows(300, &|i| format!("{} {} {}\n", i * 37 % 61, i * 23 % 59, i * 11 % 3)));
    place.file("flat.csv", rows(50, &|i| format!("{},{},0\n", i % 7, i / 7)));
    place.file("line.xyz", rows(20, &|i| format!("{i} {i} {i}\n")));
    place.file("seven.xyz", rows(7, &|i| format!("{} {} {}\n", i % 2, i / 2, i * i)));
    place.good("generate clusters -d 2 -n 900 -q -o clusters.xyz");
    let clusters = fs::read_to_string(place.path("clusters.xyz")).unwrap();
    let again: String = clusters.split_inclusive('\n').step_by(7).collect();
    place.file("repeated-clusters.xyz", clusters + &again);
}

#[test]
fn processes_triangulate_as_one_process_does() {
    let place = Place::new();
    put_inputs(&place);
    same_run(&place, "triangulate sample:uniform:3000", 8);
    same_run(&place, "triangulate sample:clusters:2000,d=2", 5);
    same_run(&place, "triangulate sample:graded:1000,d=2,lipschitz=0.3", 5);
    same_run(&place, "triangulate grid.npy", 3);
    for input in ["repeated.xyz", "flat.csv", "line.xyz", "seven.xyz"] {
        same_run(&place, &format!("triangulate {input}"), 8);
    }
    let rows = |n: usize, row: &dyn Fn(usize) -> String| (0..n).map(row).collect::<String>();
    place.file("part-1.xyz", rows(100, &|i| format!("{} {} {}\n", i * 7 % 13, i * 5 % 11, i % 9)));
    place.file("part-2.xyz", rows(31, &|i| format!("{} {} {}\n", i * 7 % 17, i * 5 % 19, i % 4)));
    same_run(&place, "triangulate part-*.xyz", 3);
}

#[test]
fn processes_simulate_as_one_process_does() {
    let place = Place::new();
    put_inputs(&place);
    same_run(&place, "simulate sample:uniform:2000", 8);
    same_run(&place, "simulate repeated-clusters.xyz", 5);
    same_run(&place, "simulate sample:graded:1000,d=2,lipschitz=0.3", 7);
    same_run(&place, "simulate grid.npy", 3);
    for input in ["repeated.xyz", "flat.csv", "line.xyz", "seven.xyz --k 3 --supergraph knn"] {
        same_run(&place, &format!("simulate {input}"), 8);
    }
    same_run(&place, "simulate seven.xyz", 11);
    same_run(&place, "simulate sample:uniform:600 --supergraph knn --k 12 --neighbours naive", 5);
    same_run(&place, "simulate sample:clusters:600,d=2 --supergraph overlap --separator-sets both", 6);
    same_run(&place, "simulate sample:uniform:600 --supergraph overlap --alpha 2 --k 3", 5);
    same_run(&place, "simulate sample:uniform:500 --partition hilbert --seed 9", 1);
    same_run(&place, "simulate sample:uniform:500 --partition kd --separator-sets smaller --seed 9", 1);
}

/// The list of nodes is left out on request, in one process and in several. All others are sums of the same nodes.
#[test]
fn nodes_are_left_out_on_request() {
    let place = Place::new();
    let line = "simulate sample:uniform:3000 -q --workers 6 --view 0 --json";
    place.good(&format!("{line} all.json --nodes all"));
    place.good(&format!("{line} default.json"));
    place.good(&format!("{line} none.json --nodes none"));
    let [all, default, none] = ["all.json", "default.json", "none.json"].map(|name| place.json(name));
    assert_eq!(all["nodes"], default["nodes"]);
    assert_eq!(all["nodes"].as_array().map(Vec::len), all["tree"]["nodes"].as_u64().map(|n| n as usize));
    assert_eq!(none.get("nodes"), None);
    assert_eq!(none["tree"], all["tree"]);
    place.good("report none.json -q -o page.html");
    // Process 0 receives fewer bytes without the nodes. The other processes receive the same.
    let bytes = |nodes: &str| -> Vec<u64> {
        place.good(&format!(
            "simulate sample:uniform:3000 -q --workers 6 --json r.json --nodes {nodes} --transport processes \
             --processes 3"
        ));
        let report = place.json("r.json");
        report["processes"].as_array().unwrap().iter().map(|p| p["bytes_in"].as_u64().unwrap()).collect()
    };
    let (all, none) = (bytes("all"), bytes("none"));
    assert!(none[0] + 3000 < all[0], "{none:?} and {all:?}");
    assert!(none[1].abs_diff(all[1]) < 500, "{none:?} and {all:?}");
}

#[test]
fn faults_act_on_processes_as_in_one_process() {
    let place = Place::new();
    for fault in [
        "half-ghosts",
        "halve-alpha",
        "one-clock",
        "free-loop",
        "slow:partition:log2:0.5",
        "work:hulls:3",
        "free:hulls",
        "refuse:1",
        "refuse:2",
        "refuse:4-7",
        "refuse-draws:3",
    ] {
        let command = format!("simulate sample:uniform:800 -q --workers 5 --fault {fault} --json r.json");
        place.good(&format!("{command} --view 0"));
        let one = place.json("r.json");
        place.good(&format!("{command} --transport processes --processes 3"));
        same_counts(&place.json("r.json"), &one, fault);
        same_sums(&place, &command, &one);
    }
    for fault in ["flip:move:1", "flip:fingerprint:1", "flip:totals:1", "die:2:hulls"] {
        let command = format!("simulate sample:uniform:800 -q --workers 5 --fault {fault} -o m.npy");
        let one = place.run(&command);
        let many = place.run(&format!("{command} --transport processes --processes 3"));
        assert!([4, 6].contains(&code(&one)), "{fault}: {}", stderr(&one));
        assert_eq!(code(&many), code(&one), "{fault}: {}", stderr(&many));
    }
}

/// All processes know that the certificate failed. The first one writes the report, and no process writes cells.
#[test]
fn processes_report_a_failed_certificate() {
    let place = Place::new();
    for command in ["triangulate", "simulate"] {
        let line =
            format!("{command} sample:uniform:2000 --workers 3 --fault spoil:1 --json r.json -o m.vtu");
        assert_eq!(code(&place.run(&format!("{line} --view 0"))), 4);
        let one = place.json("r.json");
        fs::remove_file(place.path("r.json")).unwrap();
        // The last process has no worker.
        let output = place.run(&format!("{line} --transport processes --processes 4"));
        let talk = stderr(&output);
        assert_eq!((code(&output), talk.matches("error:").count()), (4, 1), "{talk}");
        assert!(talk.contains("the certificate failed") && talk.contains("certificate failed: "), "{talk}");
        assert_eq!(place.names().into_iter().collect::<Vec<_>>(), ["r.json"], "cells were written");
        let report = place.json("r.json");
        assert!(report["certificate"].as_str().unwrap().starts_with("failed: "), "{command}");
        assert!(report["fallback"]["points"].as_u64().unwrap() > 0, "{command}");
        same_counts(&report, &one, command);
        fs::remove_file(place.path("r.json")).unwrap();
    }
}

#[test]
fn each_process_records_its_ranks() {
    let place = Place::new();
    let run = "simulate sample:uniform:2000 --workers 5 --transport processes --processes 2";
    place.good(&format!("{run} --trace t.json --trace-level round"));
    let ranks_of = |name: &str| -> BTreeSet<u64> {
        let trace = place.json(name);
        let rows = trace["traceEvents"].as_array().unwrap();
        let rounds = rows.iter().filter(|row| row["ph"] == "B" && row["cat"] == "round");
        rounds.map(|row| row["pid"].as_u64().unwrap() - 1).collect()
    };
    let [first, second] = ["t.0.json", "t.1.json"].map(ranks_of);
    assert_eq!((first, second), (BTreeSet::from([0, 1, 2, 3]), BTreeSet::from([4, 5])));
    assert!(!place.path("t.json").exists());
}

#[test]
fn processes_end_with_one_error() {
    let place = Place::new();
    let many = "--transport processes --workers 3";
    place.file("bad.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 nan\n1 1 1\n");
    place.fails(&format!("triangulate bad.xyz -o m.vtu {many}"), 3, &["bad.xyz"]);
    place.fails(&format!("triangulate none.npy {many}"), 3, &["none.npy"]);
    for options in ["--view 5 --json r.json", "--workers leaves"] {
        for command in ["triangulate", "simulate"] {
            let line = format!("{command} sample:uniform:100 --transport processes {options}");
            let option = options.split(' ').next().unwrap();
            place.fails(&line, 2, &[option, "in one process"]);
        }
    }
    // The limit is for each process.
    place.good("triangulate sample:uniform:3000 --transport processes --workers 3 --max-memory 80M");
    place.fails(
        "triangulate sample:uniform:60000 --transport processes --workers 3 --max-memory 16M",
        5,
        &["--max-memory"],
    );
    let line = "simulate sample:uniform:100 --transport processes";
    place.fails(&format!("{line} --trace -"), 2, &["--trace"]);
    place.fails(&format!("{line} --trace none/t.json"), 1, &["does not exist"]);
    place.fails(&format!("{line} --trace t.json --json t.1.json"), 2, &["t.1.json", "the same file"]);
    place.fails(&format!("{line} --cost-trace c.jsonl"), 2, &["--cost-trace", "in one process"]);
    place.fails(&format!("{line} -o - --format npy"), 2, &["a stream"]);
    place.fails(&format!("{line} --supergraph knn --k 100"), 2, &["k is 100"]);
    place.fails(&format!("{line} --delivery-seed 3"), 2, &["--delivery-seed"]);
    for command in ["triangulate", "simulate"] {
        let line = format!("{command} sample:uniform:100 --processes 2");
        place.fails(&line, 2, &["--processes", "--transport processes"]);
    }
    place.fails("predict sample:uniform:100 --transport processes", 2, &["invalid value 'processes'"]);
    place.fails(&format!("triangulate sample:uniform:100 {many} -o no/m.vtu"), 1, &["no/m.vtu"]);
    for fault in ["die:2:partition", "spoil:1"] {
        let output = place.run(&format!("triangulate sample:uniform:500 {many} -o m.npy --fault {fault}"));
        assert!([4, 6].contains(&code(&output)), "{fault}: {}", stderr(&output));
        assert_eq!(stderr(&output).matches("error:").count(), 1, "{}", stderr(&output));
        assert!(!place.path("m.npy").exists());
    }
}

#[test]
fn sixteen_processes_write_what_one_writes() {
    let place = Place::new();
    place.good("triangulate sample:uniform:4000 -q --workers 16 -o one.npy -o one.vtu");
    let many = "--transport processes --processes 16";
    place.good(&format!("triangulate sample:uniform:4000 -q --workers 16 -o m.npy -o m.vtu {many}"));
    assert!(outputs(&place, "m") == outputs(&place, "one"));
}

/// A user who sets the variable of the place gets an error, whatever standard input is.
#[test]
fn a_place_in_no_run_is_refused() {
    let place = Place::new();
    let refused = |value: &str, input: Stdio| {
        let mut command = place.command("triangulate sample:uniform:100 --transport processes --processes 4");
        let output = command.env("SEPTET_PROCESS", value).stdin(input).output().unwrap();
        let talk = stderr(&output);
        assert_eq!(code(&output), 2, "{value}: {talk}");
        assert!(talk.contains("SEPTET_PROCESS"), "{value}: {talk}");
        assert_eq!(talk.matches("error:").count(), 1, "{value}: {talk}");
    };
    for value in ["1/4000000000", "1/4", "0/4", "4/4", "5/4", "-1/4", "1/", "/", "", "1", "1/4/7", "a/b"] {
        refused(value, Stdio::null());
        refused(value, Stdio::piped());
    }
    let greeting = |process: u32, processes: u32| {
        [b"septet\0\x01".as_slice(), &process.to_le_bytes(), &processes.to_le_bytes()].concat()
    };
    for (value, bytes) in
        [("1/4", vec![b'x'; 100]), ("1/4000000000", greeting(1, 4)), ("2/4", greeting(1, 4))]
    {
        let (mut stranger, launch) = std::os::unix::net::UnixStream::pair().unwrap();
        stranger.write_all(&bytes).unwrap();
        refused(value, Stdio::from(std::os::fd::OwnedFd::from(launch)));
    }
    // Other transports do not look at it.
    let mut command = place.command("triangulate sample:uniform:100");
    assert_eq!(code(&command.env("SEPTET_PROCESS", "1/4").output().unwrap()), 0);
}

/// A low limit of open files is an error of the start, and a moderate one is enough for many processes.
#[test]
fn processes_need_few_open_files() {
    let place = Place::new();
    let limited = |limit: u32, processes: u32| {
        let mut shell = Command::new("sh");
        let line = format!("ulimit -n {limit}; exec \"$0\" \"$@\"");
        shell.current_dir(place.0.path()).args(["-c", &line, env!("CARGO_BIN_EXE_septet")]);
        let rest = format!("triangulate sample:uniform:500 -q --transport processes --processes {processes}");
        shell.args(rest.split(' ')).output().unwrap()
    };
    let output = limited(128, 16);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let start = Instant::now();
    let output = limited(20, 16);
    assert_eq!(code(&output), 6, "{}", stderr(&output));
    assert!(stderr(&output).contains("open files"), "{}", stderr(&output));
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}

/// The names of the Unix sockets of a process. A socket without a name has an empty one.
#[cfg(target_os = "linux")]
fn sockets(of: u32) -> Vec<String> {
    let links = fs::read_dir(format!("/proc/{of}/fd")).into_iter().flatten().flatten();
    let targets = links.filter_map(|link| fs::read_link(link.path()).ok());
    let inodes: Vec<String> = targets
        .filter_map(|target| Some(target.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
        .collect();
    let table = fs::read_to_string("/proc/net/unix").unwrap();
    let rows = table.lines().skip(1).filter_map(|line| {
        let mut words = line.split_whitespace().skip(6);
        let inode = words.next()?;
        inodes.iter().any(|own| own == inode).then(|| words.collect::<String>())
    });
    rows.collect()
}

/// While processes run, their sockets have no names, and the folder of temporary files stays empty.
#[cfg(target_os = "linux")]
#[test]
fn no_socket_of_a_run_has_a_name() {
    let place = Place::new();
    fs::create_dir(place.path("tmp")).unwrap();
    let line = "triangulate sample:uniform:100000 -q --workers 4 --transport processes --processes 4";
    let mut child = place.command(line).env("TMPDIR", place.path("tmp")).spawn().unwrap();
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        for pid in children(child.id()).into_iter().chain([child.id()]) {
            let names = sockets(pid);
            assert!(names.iter().all(String::is_empty), "{names:?}");
            most = most.max(names.len());
        }
        assert_eq!(fs::read_dir(place.path("tmp")).unwrap().count(), 0);
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(child.wait().unwrap().success());
    assert!(most >= 3, "the sockets were not seen");
}

/// The processes that a process started.
#[cfg(target_os = "linux")]
fn children(of: u32) -> Vec<u32> {
    let listed = fs::read_to_string(format!("/proc/{of}/task/{of}/children")).unwrap_or_default();
    listed.split_whitespace().map(|pid| pid.parse().unwrap()).collect()
}

#[cfg(target_os = "linux")]
fn is_running(pid: u32) -> bool {
    let state = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    state.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim().starts_with('Z'))
}

/// Ends one of the processes at different times. All end within the 4 seconds that a process has to stop, and 10 seconds more
/// on a busy system. They leave no output.
#[cfg(target_os = "linux")]
#[test]
fn all_processes_end_with_one_of_them() {
    let place = Place::new();
    for (try_number, signal) in ["-KILL", "-TERM", "-INT"].into_iter().cycle().take(9).enumerate() {
        let line = "triangulate sample:uniform:200000 --workers 4 --transport processes --processes 4 -o m.vtu -o m.pvtu";
        let mut command = place.command(line);
        let temporary = tempfile::tempdir().unwrap();
        command.env("TMPDIR", temporary.path());
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let start = Instant::now();
        while children(child.id()).len() < 3 && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let others = children(child.id());
        assert_eq!(others.len(), 3);
        std::thread::sleep(Duration::from_millis(40 * try_number as u64));
        let victim = if try_number % 2 == 0 { others[try_number % 3] } else { child.id() };
        let victim_text = victim.to_string();
        let _ = Command::new("kill").args([signal, &victim_text]).status().unwrap();
        let killed = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            assert!(killed.elapsed() < Duration::from_secs(20), "{signal} {try_number}: still running");
            std::thread::sleep(Duration::from_millis(5));
        };
        while others.iter().any(|&pid| is_running(pid)) {
            assert!(
                killed.elapsed() < Duration::from_secs(14),
                "{signal} {try_number}: a process still runs"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(
            fs::read_dir(temporary.path()).unwrap().count(),
            0,
            "{signal} {try_number}: a file remains"
        );
        let is_first = victim == child.id();
        if !status.success() {
            assert!(!place.path("m.vtu").exists() && !place.path("m.pvtu").exists(), "{signal} {try_number}");
            if !is_first {
                assert!([6, 130].contains(&status.code().unwrap()), "{signal} {try_number}: {status}");
            }
        }
        for name in place.names() {
            let path = place.path(&name);
            if path.is_dir() { fs::remove_dir_all(path).unwrap() } else { fs::remove_file(path).unwrap() }
        }
    }
}
