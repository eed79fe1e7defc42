//! Interrupts: the exit code, the message, and no output that is left half-written.

use super::*;

/// Waits until a command has a handler for interrupts and has begun.
#[cfg(unix)]
fn wait_for_handler(child: &mut std::process::Child) {
    let has_handler = |pid: u32| {
        let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        // The interrupt is signal 2, which has the second bit.
        Some(u64::from_str_radix(caught.trim(), 16).ok()? & 2 != 0)
    };
    let start = Instant::now();
    // Other systems than Linux do not tell, so that the wait is long there.
    while has_handler(child.id()) == Some(false) && start.elapsed() < Duration::from_secs(20) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before the interrupt");
        std::thread::sleep(Duration::from_millis(5));
    }
    let rest = if cfg!(target_os = "linux") { 300 } else { 800 };
    std::thread::sleep(Duration::from_millis(rest));
}

#[cfg(unix)]
#[test]
fn the_first_interrupt_ends_cleanly() {
    let place = Place::new();
    for line in [
        "triangulate sample:uniform:3e6 --workers 64 -o a.vtu --json r.json",
        "simulate sample:uniform:3e5 --workers 64 -o a.ele --json r.json",
        "generate well-spaced -n 1e6 -o a.xyz",
        // Waits for standard input for ever.
        "triangulate - -o a.vtu",
    ] {
        let mut command = place.command(line);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for_handler(&mut child);
        let pid = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        let mut errors = BufReader::new(child.stderr.take().unwrap());
        let mut talk = String::new();
        while !talk.contains("interrupted") && errors.read_line(&mut talk).unwrap() > 0 {}
        drop(child.stdin.take());
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if start.elapsed() > Duration::from_secs(10) {
                child.kill().unwrap();
                panic!("{line}: still running");
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        errors.read_to_string(&mut talk).unwrap();
        assert_eq!(status.code(), Some(130), "{line}: {talk}");
        assert!(talk.contains("interrupted"), "{line}: {talk}");
        assert!(place.names().is_empty(), "{line}: left {:?}", place.names());
    }
}

/// A small compressed file is a large text, and a pipe never ends. An interrupt ends the command within 10 seconds, also on a
/// busy system. It reaches the first process only.
#[cfg(unix)]
#[test]
fn an_interrupt_while_reading_acts_soon() {
    let place = Place::new();
    let mut member = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    (0..50_000).for_each(|i| writeln!(member, "{} {} {}", i % 7, i % 11, i).unwrap());
    let member = member.finish().unwrap();
    place.file("large.xyz.gz", member.repeat(1000));
    assert!(Command::new("mkfifo").arg(place.path("pipe.xyz.gz")).status().unwrap().success());
    // The pipe stays open, so that it has no end.
    let open = |path: PathBuf| fs::File::options().read(true).write(true).open(path).unwrap();
    let mut pipe = open(place.path("pipe.xyz.gz"));
    for (line, input) in [
        ("triangulate large.xyz.gz -q", false),
        ("triangulate large.xyz.gz -q --transport processes --processes 3", false),
        ("triangulate pipe.xyz.gz -q", true),
        ("triangulate pipe.xyz.gz -q --transport processes --processes 3", true),
        ("triangulate - -q --transport processes --processes 3", false),
        ("triangulate - -o a.vtu", false),
        ("triangulate @- -o a.vtu", false),
        ("mesh - -o a.vtu", false),
        ("mesh - --check", false),
        ("verify - cells.ele", false),
        ("verify -", false),
        ("report - -o a.html", false),
        ("fold -", false),
    ] {
        if input {
            pipe.write_all(&member[..1000]).unwrap();
        }
        let mut command = place.command(line);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // Standard input stays open and silent.
        let _silent = child.stdin.take();
        wait_for_handler(&mut child);
        assert!(child.try_wait().unwrap().is_none(), "{line}: it ended before the interrupt");
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let start = Instant::now();
        let output = child.wait_with_output().unwrap();
        assert!(start.elapsed() < Duration::from_secs(10), "{line}: {:?}", start.elapsed());
        assert_eq!(code(&output), 130, "{line}: {}", stderr(&output));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_writing_leaves_nothing_half_written() {
    let place = Place::new();
    let mut command = place.command("triangulate sample:grid:64000 -q -o a.ele -o b.ele -o c.ele");
    let mut child = command.spawn().unwrap();
    let writing = || {
        let entries = fs::read_dir(place.0.path()).unwrap().flatten();
        entries.filter_map(|e| e.metadata().ok()).any(|m| m.len() > 0)
    };
    while !writing() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let pid = child.id().to_string();
    let _ = Command::new("kill").args(["-INT", &pid]).status().unwrap();
    let code = child.wait().unwrap().code();
    // It may have been faster than the signal.
    assert!(matches!(code, Some(0 | 130)), "{code:?}");
    for set in ["a", "b", "c"] {
        let files = place.names().iter().filter(|n| n.starts_with(&format!("{set}."))).count();
        assert!(files == 0 || files == 5, "{:?}", place.names());
    }
    assert!(!place.names().iter().any(|n| n.ends_with(".partial")), "{:?}", place.names());
}
