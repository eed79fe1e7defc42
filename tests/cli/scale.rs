//! `septet scale` and `septet fit` as scripts see them.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Place, code, stderr};

const SWEEP: &str = "scale -n 300..1200,per-octave=2 --kind uniform,well-spaced -d 2 --workers 1,leaves --seeds 2 \
                     --leaf 60 -o runs.jsonl";

fn lines(place: &Place, name: &str) -> Vec<Value> {
    let text = fs::read_to_string(place.path(name)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Returns a line without its measured values and without its sweep.
fn counts(line: &Value) -> Value {
    let mut line = line.clone();
    for key in ["seconds", "sweep"] {
        line.as_object_mut().unwrap().remove(key);
    }
    for phase in line["phases"].as_array_mut().unwrap() {
        phase["seconds"] = Value::Null;
    }
    line
}

#[test]
fn a_sweep_is_kept_taken_up_repeated_and_fitted() {
    let place = Place::new();
    place.good(SWEEP);
    let all = lines(&place, "runs.jsonl");
    assert_eq!(all.len(), 5 * 2 * 2 * 2);
    let whole = fs::read_to_string(place.path("runs.jsonl")).unwrap();

    // Nothing is run again.
    place.good(SWEEP);
    assert_eq!(fs::read_to_string(place.path("runs.jsonl")).unwrap(), whole);
    // Cut in the middle of a line: the missing runs are repeated.
    let keep: usize = whole.lines().take(30).map(|l| l.len() + 1).sum();
    fs::write(place.path("runs.jsonl"), &whole[..keep + 100]).unwrap();
    let talk = stderr(&place.good(SWEEP));
    assert!(talk.contains("incomplete line") && talk.contains("30 of 40"), "{talk}");
    let again = lines(&place, "runs.jsonl");
    assert_eq!(again.iter().map(counts).collect::<Vec<_>>(), all.iter().map(counts).collect::<Vec<_>>());

    // Each line holds the command that makes it again.
    for (at, line) in [(3, &all[3]), (38, &all[38])] {
        let command = line["command"].as_str().unwrap().strip_prefix("septet ").unwrap();
        place.good(&command.replace(" -o run.jsonl", &format!(" -o {at}.jsonl")));
        assert_eq!(counts(&lines(&place, &format!("{at}.jsonl"))[0]), counts(line), "{command}");
    }

    let other = SWEEP.replace("--seeds 2", "--seeds 3");
    place.fails(&other, 2, &["other options", "choose another file"]);
    place.file("points.jsonl", "1 2 3\n");
    place.fails(&SWEEP.replace("runs.jsonl", "points.jsonl"), 3, &["points.jsonl, line 1"]);

    place.fails("fit runs.jsonl -y levels -x n/leaf --resample 20", 3, &["2 seeds", "--seeds 3"]);
    let fit = place.good("fit runs.jsonl -y levels -x n/leaf --json fit.json");
    let text = String::from_utf8(fit.stdout).unwrap();
    assert!(text.contains("conclusion:") && text.contains("uniform, 2D"), "{text}");
    let answer = place.json("fit.json");
    assert_eq!(answer["schema"], "septet-fit/2");
    assert_eq!(answer["series"].as_array().unwrap().len(), 2, "kinds apart, workers together");
    let rounds = place.good("fit runs.jsonl -y rounds --phase partition --json -");
    let rounds: Value = serde_json::from_slice(&rounds.stdout).unwrap();
    assert_eq!(
        rounds["series"].as_array().unwrap().len(),
        4,
        "rounds of other numbers of workers are listed separately"
    );
    place.good("fit runs.jsonl 3.jsonl -y level-depth --phase partition --margin 0.1");
    place.fails("fit runs.jsonl -y depth", 2, &["mixes", "--phase"]);
    place.fails("fit runs.jsonl -y speed", 2, &["no count `speed`", "levels"]);
    place.fails("fit runs.jsonl -y depth --phase hull", 2, &["no run has a phase `hull`"]);
    place.fails("fit runs.jsonl -y level-depth --phase partition --margin 2", 2, &["margin"]);
    place.fails("fit runs.jsonl --speedup", 3, &["septet scale", "--timed"]);
    place.fails("fit none.jsonl -y levels", 3, &["none.jsonl"]);
    place.file("empty.jsonl", "");
    for options in ["", " -y levels", " --speedup"] {
        let words = ["empty.jsonl: there are no runs", "septet scale"];
        place.fails(&format!("fit empty.jsonl{options}"), 3, &words);
    }
}

#[test]
fn impossible_sweeps_are_refused_before_a_file_is_made() {
    let place = Place::new();
    for (line, words) in [
        ("scale -n 10..5 -o a.jsonl", &["empty"][..]),
        ("scale -n 1k -o a.jsonl", &["`1k`"]),
        ("scale -n 100 --kind cube -o a.jsonl", &["cube", "well-spaced"]),
        ("scale -n 100 --weak --workers leaves -o a.jsonl", &["--weak"]),
        ("scale -n 100 --timed --until partition -o a.jsonl", &["--timed"]),
        ("scale -n 100 --workers 0 -o a.jsonl", &["worker"]),
        ("scale -n 100 --seeds 0 -o a.jsonl", &["seeds"]),
        ("scale -n 100 --supergraph knn --alpha 3 -o a.jsonl", &["alpha"]),
    ] {
        place.fails(line, 2, words);
    }
    place.fails("scale -n 100 -o none/a.jsonl", 1, &["none/a.jsonl"]);
    // A file that is not a sweep is not overwritten, whether its lines are complete or not.
    for text in ["precious notes", "precious notes\nand more", "{\"schema\":\"septet-fit/2\""] {
        fs::write(place.path("notes"), text).unwrap();
        place.fails("scale -n 100 -o notes", 3, &["notes"]);
        assert_eq!(fs::read_to_string(place.path("notes")).unwrap(), text);
    }
}

/// A corrupt sweep is named, and its text is not quoted at length.
#[test]
fn errors_of_fits_name_the_file_and_stay_short() {
    let place = Place::new();
    place.good("scale -n 2^8..2^9 --kind uniform --workers leaves --seeds 1 -o r.jsonl -q");
    let sweep = fs::read_to_string(place.path("r.jsonl")).unwrap();
    let garbage = "(".repeat(5000);
    place.file("kind.jsonl", sweep.replace("\"supergraph\":\"", &format!("\"supergraph\":\"{garbage}")));
    place.file("line.jsonl", format!("{{\"n\":\"{garbage}\"}}\n"));
    for (line, name) in
        [("fit kind.jsonl -y rounds --phase merge", "kind.jsonl"), ("fit line.jsonl", "line.jsonl")]
    {
        place.fails(line, 3, &[name]);
        let talk = stderr(&place.run(line));
        assert!(talk.len() < 1500, "{} bytes", talk.len());
    }
}

#[test]
fn timed_sweeps_give_speed_up() {
    let place = Place::new();
    place.good("scale -n 400,800 --kind uniform --workers 1,2 --seeds 2 --timed -o t.jsonl");
    let programs: Vec<_> = lines(&place, "t.jsonl").iter().map(|l| l["program"].clone()).collect();
    assert_eq!(programs.iter().filter(|p| **p == "serial").count(), 4, "once a set");
    assert_eq!(programs.iter().filter(|p| **p == "triangulate").count(), 8);
    let text = String::from_utf8(place.good("fit t.jsonl --speedup").stdout).unwrap();
    assert!(text.contains("speed-up") && text.contains("efficiency"), "{text}");
    // A weak sweep of the same numbers of points a worker.
    place.good("scale -n 200 --kind uniform --workers 1,2,4 --seeds 1 --weak --until partition -o w.jsonl");
    let sizes: Vec<_> = lines(&place, "w.jsonl").iter().map(|l| l["asked"].as_u64().unwrap()).collect();
    assert_eq!(sizes, [200, 400, 800]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_holds_whole_lines() {
    let place = Place::new();
    let line = "scale -n 500,100000 --kind uniform --seeds 40 --until neighbours -o runs.jsonl";
    let mut child = place.command(line).stderr(Stdio::piped()).spawn().unwrap();
    let there = || fs::read_to_string(place.path("runs.jsonl")).map_or(0, |text| text.lines().count());
    let start = Instant::now();
    while there() < 41 && start.elapsed() < Duration::from_mins(2) {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait().map(|_| ()).and_then(|()| child.wait_with_output()).unwrap();
    let talk = stderr(&output);
    assert_eq!(code(&output), 130, "{talk}");
    assert!(talk.contains("of 80 runs are in runs.jsonl") && talk.contains("same command"), "{talk}");
    let text = fs::read_to_string(place.path("runs.jsonl")).unwrap();
    assert!(text.ends_with('\n') && lines(&place, "runs.jsonl").len() >= 41);
}
