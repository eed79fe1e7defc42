//! Faults of the machine, and the end of a long step, as scripts see them.

use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Place, code, stderr};

#[test]
fn a_failed_certificate_is_exit_4_with_its_counts() {
    let place = Place::new();
    for command in ["triangulate", "simulate"] {
        let line =
            format!("{command} sample:uniform:2000 --workers 3 --fault spoil:1 -o a.vtu --json r.json");
        let output = place.run(&line);
        let talk = stderr(&output);
        assert_eq!(code(&output), 4, "{talk}");
        assert!(talk.contains("the certificate failed") && talk.contains("disagreements"), "{talk}");
        assert_eq!(place.names().into_iter().collect::<Vec<_>>(), ["r.json"], "cells were written");
        let report = place.json("r.json");
        let certificate = report["certificate"].as_str().unwrap();
        assert!(
            certificate.starts_with("failed: ") && certificate.contains(" of 2000 stars"),
            "{certificate}"
        );
        let proved = &report["how_proved"];
        assert_eq!((&report["simplices"], &proved["hypothesis"]), (&0.into(), &0.into()));
        assert_eq!(proved["direct"], 0);
        assert_eq!(report["points"]["used"], 2000);
        assert!(report["machine"]["messages"].as_u64().unwrap() > 0);
        assert!(report["fallback"]["points"].as_u64().unwrap() > 0);
        assert_eq!(report["machine"]["paper"]["work"].is_null(), command == "triangulate");
        std::fs::remove_file(place.path("r.json")).unwrap();
    }
}

#[test]
fn a_dead_worker_is_exit_6_and_leaves_nothing() {
    let place = Place::new();
    for (options, phase) in
        [("", "hulls"), ("--transport sim", "partition"), ("--threads 1", "certificate"), ("", "collect")]
    {
        let fault = format!("--workers 3 --fault die:2:{phase}");
        let line =
            format!("triangulate sample:uniform:2000 {options} {fault} -o a.vtu -o b.ele --json r.json");
        place.fails(&line, 6, &["worker 2 failed", phase]);
    }
    place.fails("triangulate sample:uniform:2000 --fault nothing", 2, &["`nothing`", "refuse-draws"]);
}

#[test]
fn a_flipped_bit_is_exit_4_or_6_and_leaves_nothing() {
    let place = Place::new();
    for (kind, expected) in [("move", 4), ("fingerprint", 6)] {
        for transport in ["channel", "sim"] {
            let machine = format!("--workers 3 --transport {transport} --fault flip:{kind}:1");
            let output = place.run(&format!("triangulate sample:uniform:2000 {machine} -o a.vtu"));
            assert_eq!(code(&output), expected, "{kind}: {}", stderr(&output));
            assert!(place.names().is_empty(), "{kind}: cells were written");
        }
    }
    let line = "triangulate sample:uniform:2000 --fault flip:mov:1";
    place.fails(line, 2, &["no kind of messages `mov`", "move"]);
}

#[test]
fn faults_are_not_offered() {
    let place = Place::new();
    for line in ["triangulate --help", "simulate --help", "scale --help"] {
        let text = String::from_utf8(place.good(line).stdout).unwrap();
        assert!(!text.contains("--fault") && !text.contains("\\-\\-fault"), "{line}");
    }
}

#[test]
fn the_planning_run_is_billed_apart() {
    let place = Place::new();
    place.good("simulate sample:uniform:3000 --leaf 300 --workers leaves --json leaves.json");
    let leaves = place.json("leaves.json");
    let workers = leaves["machine"]["workers"].to_string();
    place.good(&format!("simulate sample:uniform:3000 --leaf 300 --workers {workers} --json count.json"));
    let plan = &leaves["plan"];
    for count in ["rounds", "messages", "bytes"] {
        assert!(plan[count].as_u64().unwrap() > 0, "{plan}");
    }
    // One worker grows the tree by itself. It exchanges the survey, the points with the frame, and the totals with the
    // coordinator.
    assert_eq!(plan["messages"], 6, "{plan}");
    assert_eq!(place.json("count.json")["plan"], Value::Null);
}

/// The kernel is at work on millions of points when the signal comes: it gives up within the step.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_long_step() {
    let place = Place::new();
    let line = "triangulate sample:uniform:2000000 --workers 2 -v -o a.vtu --json r.json";
    let mut command = place.command(line);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut errors = std::io::BufReader::new(child.stderr.take().unwrap());
    let mut talk = String::new();
    // The pieces are triangulated in the phase after the partition.
    while !talk.contains("partition") {
        assert!(std::io::BufRead::read_line(&mut errors, &mut talk).unwrap() > 0, "{talk}");
    }
    std::thread::sleep(Duration::from_secs(2));
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let start = Instant::now();
    std::io::Read::read_to_string(&mut errors, &mut talk).unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130), "{talk}");
    assert!(
        !talk.contains("radii"),
        "the pieces were triangulated before the signal, or all the same: {talk}"
    );
    assert!(start.elapsed() < Duration::from_secs(10), "it took {:?}", start.elapsed());
    assert!(place.names().is_empty(), "left {:?}", place.names());
}
