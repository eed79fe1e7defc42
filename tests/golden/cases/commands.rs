//! The program from the view of scripts: files, reports without measured values, exit codes.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

use super::Case;
use crate::record::{Record, sha256};

/// Keys of reports whose values are measured, or name the program or its machine.
const MEASURED: [&str; 13] = [
    "version",
    "seconds",
    "read_seconds",
    "mesh_seconds",
    "judge_seconds",
    "write_seconds",
    "total_seconds",
    "triangulate_seconds",
    "serial_seconds",
    "rss_before_bytes",
    "peak_rss_bytes",
    "host",
    "cores",
];

/// Every case of the program.
pub fn cases() -> Vec<Case> {
    vec![
        Case::new("command-wrong-inputs", wrong_inputs),
        Case::new("command-files", files),
        Case::new("command-reports", reports),
        Case::new("command-verify", verify),
        Case::new("command-generate", generate),
        Case::new("command-scale-and-fit", scale_and_fit),
        Case::new("command-predict", predict),
        Case::new("command-mesh", mesh),
        Case::new("command-rival", rival),
    ]
}

/// The longest one.
pub fn last() -> Case {
    Case::new("command-reproduce", reproduce)
}

/// A directory and the program run in it.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        Place(tempfile::tempdir().expect("a directory"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn file(&self, name: &str, content: &str) -> &Self {
        fs::write(self.path(name), content).expect("a file");
        self
    }

    fn run(&self, line: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_septet"));
        command.current_dir(self.0.path()).env_remove("RUST_LOG").args(line.split_whitespace());
        command.output().expect("the program runs")
    }

    /// Runs a line and records how it ended.
    fn code(&self, record: &mut Record, name: &str, line: &str) -> Output {
        let output = self.run(line);
        record.output(name, "exit", output.status.code().unwrap_or(-1));
        output
    }

    fn bytes(&self, record: &mut Record, name: &str, file: &str) {
        match fs::read(self.path(file)) {
            Ok(bytes) => record.output(name, file, format_args!("{} {}", bytes.len(), sha256(&bytes))),
            Err(_) => record.output(name, file, "missing"),
        }
    }

    /// The hash of a report, and of each of its fields: a difference is found by name.
    fn report(&self, record: &mut Record, name: &str, file: &str) {
        let text = fs::read(self.path(file)).unwrap_or_default();
        let Ok(mut value) = serde_json::from_slice::<Value>(&text) else {
            return record.output(name, file, "no JSON");
        };
        strip(&mut value);
        for (key, value) in value.as_object().into_iter().flatten() {
            record.value(name, key, &value.to_string());
        }
    }

    /// The hash of each line of a file of reports.
    fn journal(&self, record: &mut Record, name: &str, file: &str) {
        let text = fs::read_to_string(self.path(file)).unwrap_or_default();
        for (i, line) in text.lines().enumerate() {
            let mut value: Value = serde_json::from_str(line).unwrap_or_default();
            strip(&mut value);
            record.value(name, &format!("line-{}", i + 1), &value.to_string());
        }
    }
}

/// Removes the measured values.
fn strip(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|key, _| !MEASURED.contains(&key.as_str()));
            map.values_mut().for_each(strip);
        }
        Value::Array(items) => items.iter_mut().for_each(strip),
        _ => {}
    }
}

const SQUARE: &str = "0 0\n1 0\n0 1\n1 1\n0.4 0.3\n";

fn wrong_inputs(record: &mut Record) {
    let place = Place::new();
    place.file("good.xyz", SQUARE);
    place.file("nan.xyz", "0 0 0\n1 0 0\n0 nan 0\n0 0 1\n");
    place.file("word.csv", "0,0\n1,0\n0,oops\n");
    place.file("mixed.txt", "0 0 0\n1 0 0\n0 1\n");
    place.file("huge.off", "OFF\n100000000000000 0 0\n0 0 0\n");
    place.file("wide.xyz", "1 0 0\n0 1e-300 0\n0 0 1\n1 1 1\n1e300 0 0\n");
    place.file("bad.json", "{\"schema\": \"septet-run/2\"}");
    place.file("open.off", "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n");
    let lines = [
        ("nan", "triangulate nan.xyz -o a.vtu"),
        ("skipped", "triangulate nan.xyz --skip-invalid -o a.vtu"),
        ("word", "triangulate word.csv -o a.vtu"),
        ("missing", "triangulate missing.node -o a.vtu"),
        ("mixed", "triangulate mixed.txt -o a.vtu"),
        ("huge", "triangulate huge.off -o a.vtu"),
        ("wide", "triangulate wide.xyz -o a.vtu"),
        ("no-workers", "triangulate good.xyz --workers 0 -o a.vtu"),
        ("no-leaf", "simulate good.xyz --leaf 0"),
        ("alpha", "simulate good.xyz --alpha 0.5"),
        ("k-of-density", "simulate good.xyz --k 3"),
        ("alpha-of-knn", "simulate good.xyz --supergraph knn --alpha 2"),
        ("smaller-of-overlap", "simulate good.xyz --supergraph overlap --separator-sets smaller"),
        ("no-option", "triangulate good.xyz --no-such-option"),
        ("no-command", "triangle good.xyz"),
        ("no-directory", "triangulate good.xyz -o nowhere/a.vtu"),
        ("no-format", "triangulate good.xyz -o a.unknown"),
        ("memory", "triangulate sample:uniform:100000 --max-memory 1K --json a.json"),
        ("seed-of-channel", "triangulate good.xyz --delivery-seed 3 -o a.vtu"),
        (
            "dead-worker",
            "simulate sample:uniform:500 --leaf 50 --workers 3 --threads 2 --fault die:2:partition",
        ),
        ("no-fault", "simulate sample:uniform:500 --fault refuse-draws:0"),
        ("open-surface", "mesh open.off -o a.vtu"),
        ("torn-report", "report bad.json -o page.html"),
        ("sizes", "scale -n none -o runs.jsonl"),
        ("claim", "reproduce no-such-claim"),
        ("fit-missing", "fit missing.jsonl -y levels"),
        ("negative-size", "mesh open.off --size -1 -o a.vtu"),
    ];
    for (name, line) in lines {
        place.code(record, name, line);
    }
}

fn files(record: &mut Record) {
    let place = Place::new();
    for (set, sample) in [("space", "sample:uniform:300,seed=3"), ("plane", "sample:clusters:300,d=2,seed=3")]
    {
        let outputs: Vec<String> = ["vtu", "msh", "msh22", "mesh", "off", "npy", "ele"]
            .iter()
            .map(|e| format!("{set}.{e}"))
            .collect();
        let wanted: Vec<String> = outputs.iter().map(|o| format!("-o {o}")).collect();
        let line = format!("triangulate {sample} --workers 3 --threads 2 --with-owner {}", wanted.join(" "));
        place.code(record, set, &line);
        let beside = ["node", "neigh", "face", "edge"].iter().map(|e| format!("{set}.{e}"));
        for file in outputs.into_iter().chain(beside) {
            place.bytes(record, set, &file);
        }
    }
}

fn reports(record: &mut Record) {
    let place = Place::new();
    let runs = [
        ("triangulate-3d", "triangulate sample:uniform:600 --workers 5 --threads 2 --view 100"),
        (
            "triangulate-2d",
            "triangulate sample:grid:600,d=2 --workers leaves --leaf 50 --transport sim --threads 1",
        ),
        ("simulate-3d", "simulate sample:uniform:600 --workers 5 --threads 2 --leaf 50 --view 100"),
        ("simulate-2d", "simulate sample:clusters:600,d=2 --workers leaves --leaf 50 --threads 2"),
        (
            "simulate-knn",
            "simulate sample:line:500 --workers 3 --threads 2 --leaf 50 --supergraph knn --k 10ln",
        ),
        (
            "simulate-both",
            "simulate sample:graded:500 --workers 3 --threads 2 --leaf 50 --separator-sets both",
        ),
        ("simulate-planes", "simulate sample:slab:500 --workers 3 --threads 2 --leaf 50 --partition kd"),
        (
            "simulate-naive",
            "simulate sample:uniform:500 --workers 3 --threads 2 --leaf 50 --neighbours naive",
        ),
        (
            "simulate-refused",
            "simulate sample:uniform:500 --workers 9 --threads 2 --leaf 50 --fault refuse-draws:2",
        ),
        ("simulate-spoilt", "simulate sample:uniform:500 --workers 3 --threads 2 --leaf 50 --fault spoil:1"),
    ];
    for (name, line) in runs {
        let file = format!("{name}.json");
        place.code(record, name, &format!("{line} --json {file}"));
        place.report(record, name, &file);
    }
}

fn verify(record: &mut Record) {
    let place = Place::new();
    for dimension in [2, 3] {
        for kind in ["uniform", "grid"] {
            let sample = format!("sample:{kind}:400,d={dimension}");
            let name = format!("{kind}-{dimension}d");
            let made = format!("triangulate {sample} --workers 3 --threads 2 -o {name}.npy -o {name}.ele");
            place.code(record, &name, &made);
            let line = format!("verify {sample} {name}.npy --perturbed --threads 2 --json {name}.json");
            place.code(record, &format!("{name}/good"), &line);
            place.report(record, &format!("{name}/good"), &format!("{name}.json"));
            // Without its last cells the file is not a triangulation.
            let text = fs::read_to_string(place.path(&format!("{name}.ele"))).unwrap_or_default();
            let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).collect();
            let head = lines.first().copied().unwrap_or_default().split_once(' ').unwrap_or_default();
            let kept = lines.len().saturating_sub(4);
            let torn = format!("{kept} {}\n{}\n", head.1, lines[1..=kept].join("\n"));
            place.file(&format!("{name}-torn.ele"), &torn);
            let line = format!("verify {sample} {name}-torn.ele --threads 2 --json {name}-torn.json");
            place.code(record, &format!("{name}/torn"), &line);
            place.report(record, &format!("{name}/torn"), &format!("{name}-torn.json"));
            let line = format!("verify {sample},seed=9 {name}.npy --threads 2 --json {name}-other.json");
            place.code(record, &format!("{name}/other"), &line);
            place.report(record, &format!("{name}/other"), &format!("{name}-other.json"));
        }
    }
}

fn generate(record: &mut Record) {
    let place = Place::new();
    let kinds = "uniform poisson ball sphere grid fcc jittered clusters slab line moment-curve shells well-spaced graded graded-line";
    for kind in kinds.split(' ') {
        for dimension in [2, 3] {
            let file = format!("{kind}-{dimension}.npy");
            place.code(record, kind, &format!("generate {kind} -n 300 -d {dimension} --seed 5 -o {file}"));
            place.bytes(record, kind, &file);
        }
    }
}

fn scale_and_fit(record: &mut Record) {
    let place = Place::new();
    let sweep = "scale -n 200..800,per-octave=2 --kind uniform,clusters -d 2 --workers 1,leaves --seeds 3 --leaf 60 \
                 --threads 2 -o runs.jsonl";
    place.code(record, "scale", sweep);
    place.journal(record, "scale", "runs.jsonl");
    let partition = "scale -n 500,1000 --kind uniform --workers leaves --seeds 2 --leaf 40 --threads 2 --until partition \
                     -o tree.jsonl";
    place.code(record, "until", partition);
    place.journal(record, "until", "tree.jsonl");
    for (name, line) in [
        ("levels", "fit runs.jsonl -y levels"),
        ("depth", "fit runs.jsonl -y depth --phase partition --resample 20"),
        ("level-depth", "fit runs.jsonl -y level-depth --phase partition"),
        ("bytes", "fit runs.jsonl -y bytes --phase separator-sets -x n/leaf"),
    ] {
        let file = format!("{name}.json");
        place.code(record, &format!("fit-{name}"), &format!("{line} --json {file}"));
        place.report(record, &format!("fit-{name}"), &file);
    }
}

fn predict(record: &mut Record) {
    let place = Place::new();
    let line = "predict sample:uniform:800 --workers 1,2,4,8 --threads 1 --leaf 40 --json predicted.json";
    place.code(record, "predict", line);
    place.report(record, "predict", "predicted.json");
}

fn mesh(record: &mut Record) {
    let place = Place::new();
    let good = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/domains/good/");
    for (name, file, options) in [
        ("box", "slanted-box.poly", "--size 1.2"),
        ("hole", "cubic-hole.poly", "--size 1.5 --improve"),
        ("stl", "cube.stl", "--size 1"),
        ("ply", "cube.ply", "--size 1 --boundary exact"),
        ("smesh", "cube-points.smesh", "--size 1 --radius-edge 3"),
        ("line", "cube.obj", "--size 1 --min-size 0.3 --singularity line"),
        ("map", "map.poly", "--size 0.6 --lipschitz 0.3"),
    ] {
        fs::copy(format!("{good}{file}"), place.path(file)).expect("a domain");
        if name == "smesh" {
            fs::copy(format!("{good}cube-points.node"), place.path("cube-points.node")).expect("its points");
        }
        let outputs = format!("-o {name}.vtu -o {name}.msh -o {name}.ele --json {name}.json --view 5000");
        let line = format!("mesh {file} {options} --workers 3 --threads 2 --leaf 60 {outputs}");
        place.code(record, name, &line);
        for ending in ["vtu", "msh", "ele"] {
            place.bytes(record, name, &format!("{name}.{ending}"));
        }
        place.report(record, name, &format!("{name}.json"));
    }
}

fn rival(record: &mut Record) {
    let place = Place::new();
    place.code(record, "rival", "rival incremental sample:uniform:400 --against --json rival.json");
    place.report(record, "rival", "rival.json");
}

fn reproduce(record: &mut Record) {
    let place = Place::new();
    place.code(record, "list", "reproduce --list");
    let claims = "reproduce separator-split merged-per-round --seed 3 --threads 2 --json claims.json";
    place.code(record, "claims", claims);
    place.report(record, "claims", "claims.json");
    let failed =
        "reproduce separator-attempts separator-split --threads 2 --fault small-sphere --json failed.json";
    place.code(record, "failed", failed);
    place.report(record, "failed", "failed.json");
}
