//! `--transport processes`: the outputs, the report, and the end of all processes.
#![cfg(unix)]

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

/// Runs of 1, 2, 5 and 8 processes write the bytes of one process.
pub(super) fn same_bytes(place: &Place, input: &str, workers: u32) {
    place.good(&format!("triangulate {input} -q --workers {workers} -o one.npy -o one.vtu -o one.pvtu"));
    let expected = outputs(place, "one");
    assert_eq!(expected.len(), 3 + workers as usize, "{input}");
    for processes in [1, 2, 5, 8] {
        place.good(&format!(
            "triangulate {input} -q --workers {workers} -o m.npy -o m.vtu -o m.pvtu --transport processes \
             --processes {processes}"
        ));
        let found = outputs(place, "m");
        let names = |files: &[(String, Vec<u8>)]| files.iter().map(|file| file.0.clone()).collect::<Vec<_>>();
        assert_eq!(names(&found), names(&expected), "{input}, {processes} processes");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(found == expected, "{input}, {processes} processes: other bytes in {}", found.0);
        }
    }
}

#[test]
fn processes_write_the_bytes_of_one_process() {
    let place = Place::new();
    same_bytes(&place, "sample:uniform:3000", 8);
    same_bytes(&place, "sample:clusters:2000,d=2", 5);
    same_bytes(&place, "sample:graded:1000,d=2,lipschitz=0.3", 5);
    place.good("generate grid -n 1000 -q -o grid.npy");
    same_bytes(&place, "grid.npy", 3);
    let rows = |n: usize, row: &dyn Fn(usize) -> String| (0..n).map(row).collect::<String>();
    place.file("repeated.xyz", rows(300, &|i| format!("{} {} {}\n", i * 37 % 61, i * 23 % 59, i * 11 % 3)));
    place.file("flat.csv", rows(50, &|i| format!("{},{},0\n", i % 7, i / 7)));
    place.file("line.xyz", rows(20, &|i| format!("{i} {i} {i}\n")));
    place.file("seven.xyz", rows(7, &|i| format!("{} {} {}\n", i % 2, i / 2, i * i)));
    for input in ["repeated.xyz", "flat.csv", "line.xyz", "seven.xyz"] {
        same_bytes(&place, input, 8);
    }
    place.file("part-1.xyz", rows(100, &|i| format!("{} {} {}\n", i * 7 % 13, i * 5 % 11, i % 9)));
    place.file("part-2.xyz", rows(31, &|i| format!("{} {} {}\n", i * 7 % 17, i * 5 % 19, i % 4)));
    same_bytes(&place, "part-*.xyz", 3);
}

#[test]
fn processes_count_as_one_process_does() {
    let place = Place::new();
    place.good("triangulate sample:uniform:3000 -q --workers 7 --json one.json");
    let one = place.json("one.json");
    for processes in [1, 3, 7, 9] {
        let line = format!("--transport processes --processes {processes} --json m.json");
        place.good(&format!("triangulate sample:uniform:3000 -q --workers 7 {line}"));
        let found = place.json("m.json");
        for field in
            ["points", "simplices", "hull_facets", "certificate", "machine", "rounds", "traffic", "tree"]
        {
            assert_eq!(found[field], one[field], "{processes} processes: {field}");
        }
        let of_phases = |report: &Value| -> Vec<Value> {
            let mut phases = report["phases"].as_array().unwrap().clone();
            for phase in &mut phases {
                phase.as_object_mut().unwrap().remove("seconds");
            }
            phases
        };
        assert_eq!(of_phases(&found), of_phases(&one));
        assert_eq!(found["parameters"]["transport"], "processes");
        let rows = found["processes"].as_array().unwrap();
        assert_eq!(rows.len(), processes);
        let sum = |field: &str| rows.iter().map(|row| row[field].as_u64().unwrap()).sum::<u64>();
        assert_eq!((sum("workers"), sum("points")), (7, 3000));
        assert_eq!(sum("bytes_in"), sum("bytes_out"));
        assert_eq!(sum("bytes_in") > 0, processes > 1);
    }
}

#[test]
fn processes_end_with_one_error() {
    let place = Place::new();
    let many = "--transport processes --workers 3";
    place.file("bad.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 nan\n1 1 1\n");
    place.fails(&format!("triangulate bad.xyz -o m.vtu {many}"), 3, &["bad.xyz"]);
    place.fails(&format!("triangulate none.npy {many}"), 3, &["none.npy"]);
    for option in
        ["--with-owner -o m.vtu", "--trace t.json", "--view 5 --json r.json", "-o m.msh", "--workers leaves"]
    {
        let line = format!("triangulate sample:uniform:100 --transport processes {option}");
        place.fails(&line, 2, &[]);
    }
    place.fails("triangulate sample:uniform:100 --processes 2", 2, &["--processes", "--transport processes"]);
    place.fails("simulate sample:uniform:100 --transport processes", 2, &["triangulate"]);
    place.fails(&format!("triangulate sample:uniform:100 {many} -o no/m.vtu"), 1, &["no/m.vtu"]);
    for fault in ["die:2:partition", "spoil:1"] {
        let output = place.run(&format!("triangulate sample:uniform:500 {many} -o m.npy --fault {fault}"));
        assert!([4, 6].contains(&code(&output)), "{fault}: {}", stderr(&output));
        assert_eq!(stderr(&output).matches("error:").count(), 1, "{}", stderr(&output));
        assert!(!place.path("m.npy").exists());
    }
}

/// The processes that a process started.
fn children(of: u32) -> Vec<u32> {
    let listed = fs::read_to_string(format!("/proc/{of}/task/{of}/children")).unwrap_or_default();
    listed.split_whitespace().map(|pid| pid.parse().unwrap()).collect()
}

fn is_running(pid: u32) -> bool {
    let state = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    state.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim().starts_with('Z'))
}

/// Ends one of the processes at different times. All end within 5 seconds, and leave no output.
#[test]
fn all_processes_end_with_one_of_them() {
    let place = Place::new();
    for (try_number, signal) in ["-KILL", "-TERM", "-INT"].into_iter().cycle().take(9).enumerate() {
        let line = "triangulate sample:uniform:200000 --workers 4 --transport processes --processes 4 -o m.vtu -o m.pvtu";
        let mut child = place.command(line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
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
            assert!(killed.elapsed() < Duration::from_secs(5), "{signal} {try_number}: a process still runs");
            std::thread::sleep(Duration::from_millis(5));
        }
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
