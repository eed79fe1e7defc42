//! The program from the view of scripts: exit codes, streams, files on disk.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

#[path = "cli/dimensions.rs"]
mod dimensions;

#[path = "cli/effects.rs"]
mod effects;

#[path = "cli/faults.rs"]
mod faults;

#[path = "cli/files.rs"]
mod files;

#[path = "cli/fold.rs"]
mod fold;

#[path = "cli/help.rs"]
mod help;

#[path = "cli/instruments.rs"]
mod instruments;

#[path = "cli/interrupts.rs"]
mod interrupts;

#[path = "cli/lists.rs"]
mod lists;

#[path = "cli/memory.rs"]
mod memory;

#[path = "cli/mesh.rs"]
mod mesh;
#[path = "cli/mesh_reports.rs"]
mod mesh_reports;

#[path = "cli/options.rs"]
mod options;

#[path = "cli/periodic.rs"]
mod periodic;
#[path = "cli/pieces.rs"]
mod pieces;

#[path = "cli/predict.rs"]
mod predict;

#[cfg(unix)]
#[path = "cli/process_formats.rs"]
mod process_formats;
#[path = "cli/process_rows.rs"]
mod process_rows;

#[path = "cli/processes.rs"]
mod processes;

#[path = "cli/queries.rs"]
mod queries;
#[path = "cli/raw.rs"]
mod raw;

#[path = "cli/repair.rs"]
mod repair;

#[path = "cli/report.rs"]
mod report;

#[path = "cli/reproduce.rs"]
mod reproduce;

#[path = "cli/verify.rs"]
mod verify;

#[path = "cli/scale.rs"]
mod scale;

#[path = "cli/rival.rs"]
mod rival;

#[path = "cli/schema.rs"]
mod schema;

#[path = "cli/stats.rs"]
mod stats;
#[path = "cli/terrain.rs"]
mod terrain;
#[path = "cli/weights.rs"]
mod weights;

/// A directory of one test and the program run in it.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        Place(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        fs::write(self.path(name), content).unwrap();
        self
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_septet"));
        command.current_dir(self.0.path()).env_remove("RUST_LOG").args(line.split_whitespace());
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    fn feed(&self, line: &str, input: &[u8]) -> Output {
        let mut command = self.command(line);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(input).unwrap();
        child.wait_with_output().unwrap()
    }

    /// Runs a line that must succeed.
    fn good(&self, line: &str) -> Output {
        let output = self.run(line);
        assert_eq!(code(&output), 0, "{line}: {}", stderr(&output));
        output
    }

    /// Runs a line that must fail with this code and these words, and leave the directory as it was.
    fn fails(&self, line: &str, expected: i32, words: &[&str]) {
        let before = self.names();
        let output = self.run(line);
        let talk = stderr(&output);
        assert_eq!(code(&output), expected, "{line}: {talk}");
        for word in words {
            assert!(talk.contains(word), "{line}: no `{word}` in: {talk}");
        }
        assert!(output.stdout.is_empty(), "{line}: data on standard output");
        assert_eq!(self.names(), before, "{line}: something was left behind");
    }

    fn names(&self) -> BTreeSet<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or(-1)
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const SQUARE: &str = "0 0\n1 0\n0 1\n1 1\n0.4 0.3\n";

#[test]
fn bad_input_data_is_exit_3_and_names_file_and_line() {
    let place = Place::new();
    place.file("nan.xyz", "0 0 0\n1 0 0\n0 nan 0\n0 0 1\n");
    place.fails("triangulate nan.xyz -o a.vtu", 3, &["nan.xyz", "line 3", "point 2", "--skip-invalid"]);
    place.file("word.csv", "0,0\n1,0\n0,oops\n");
    place.fails("triangulate word.csv -o a.vtu", 3, &["word.csv", "line 3", "oops"]);
    place.fails("triangulate missing.node -o a.vtu", 3, &["missing.node", "no such file", "help:"]);
    place.file("mixed.txt", "0 0 0\n1 0 0\n0 1\n");
    place.fails("triangulate mixed.txt -o a.vtu", 3, &["mixed.txt", "line 3", "2 coordinates"]);
    place.file("garbage.ply", [0x7f, 0x45, 0x4c, 0x46, 0, 1, 2, 3, 255, 254]);
    place.fails("triangulate garbage.ply -o a.vtu", 3, &["garbage.ply"]);
    place.file("garbage.dat", [0x7f, 0x45, 0x4c, 0x46, 0, 1, 2, 3, 255, 254]);
    place.fails("triangulate garbage.dat -o a.vtu", 3, &["garbage.dat", "unknown format"]);
    place.file("huge.node", "100000000000000 3 0 0\n0 0 0 0\n");
    place.fails("triangulate huge.node -o a.vtu", 3, &["huge.node", "100000000000000"]);
    place.file("huge.off", "OFF\n100000000000000 0 0\n0 0 0\n");
    place.fails("triangulate huge.off -o a.vtu", 3, &["huge.off"]);
    place.file("wide.xyz", "1 0 0\n0 1e-300 0\n0 0 1\n1 1 1\n1e300 0 0\n");
    place.fails("triangulate wide.xyz -o a.vtu", 3, &["wide.xyz", "point 1", "point 4"]);
    place.file("torn.xyz.gz", [0x1f, 0x8b, 8, 0, 1, 2]);
    place.fails("triangulate torn.xyz.gz -o a.vtu", 3, &["torn.xyz.gz", "gzip"]);
}

#[test]
fn truncated_binary_files_are_refused() {
    let place = Place::new();
    place.good("generate uniform -n 100 -o a.npy");
    let whole = fs::read(place.path("a.npy")).unwrap();
    place.file("cut.npy", &whole[..whole.len() - 9]);
    place.fails("triangulate cut.npy -o a.vtu", 3, &["cut.npy", "announced"]);
    place.good("generate uniform -n 100 -o a.ply");
    let whole = fs::read(place.path("a.ply")).unwrap();
    place.file("cut.ply", &whole[..whole.len() - 9]);
    place.fails("triangulate cut.ply -o a.vtu", 3, &["cut.ply"]);
}

#[test]
fn the_line_at_fault_is_shown() {
    let place = Place::new();
    place.file("nan.xyz", "0 0 0\n1 0 0\n0 nan 0\n0 0 1\n");
    let talk = stderr(&place.run("triangulate nan.xyz"));
    assert!(talk.starts_with("error:") && talk.contains("nan.xyz:3:1") && talk.contains("0 nan 0"), "{talk}");
    assert!(!talk.contains('\x1b'), "colours without a terminal: {talk:?}");
    let talk = stderr(&place.run("triangulate nan.xyz --color always"));
    assert!(talk.contains('\x1b'));
}

#[test]
fn impossible_options_are_exit_2() {
    let place = Place::new();
    place.file("p.xyz", SQUARE);
    for (options, word) in [
        ("--alpha 0", "alpha is 0"),
        ("--alpha -1", "alpha is -1"),
        ("--alpha x", "auto"),
        ("--workers 0", "worker"),
        ("--threads 0", "thread"),
        ("--leaf 0", "leaf"),
        ("--k 3", "no k"),
        ("--supergraph knn --k 5", "k is 5"),
        ("--supergraph knn --k 0", "k is 0"),
        ("--supergraph knn --alpha 2", "no alpha"),
        ("--supergraph knn --k -2ln", "-2"),
        ("--supergraph overlap --separator-sets smaller", "smaller"),
        ("--supergraph overlap --alpha 2 --k 5", "k is 5"),
        ("--supergraph overlap --alpha 2 --k 0", "k is 0"),
        ("--supergraph overlap --alpha 2 --k 2ln", "2ln"),
        ("--supergraph overlap --k 2", "--alpha"),
        ("--supergraph overlap --alpha 2 --k 2 --neighbours naive", "naive"),
        ("--supergraph overlap --alpha 2 --k 2 --neighbours fmt", "fmt"),
        ("--supergraph overlap --alpha 2 --k 2 --neighbours pairs", "pairs"),
        ("--supergraph voronoi", "possible values"),
        ("--delivery-seed 3", "--transport sim"),
        ("--no-such-option", "--no-such-option"),
        ("-d 7", "2 to 6"),
        ("--max-memory lots", "500M"),
        ("-o a.zzz", "unknown output format"),
        ("-o a.vtu -o ./a.vtu", "same file"),
    ] {
        place.fails(&format!("simulate p.xyz {options}"), 2, &[word]);
    }
    // The paper's recursion has these; `triangulate` would ignore them.
    for option in ["--supergraph knn", "--k 5", "--alpha 3", "--separator-sets both", "--separator-sets own"]
    {
        let name = option.split(' ').next().unwrap();
        place.fails(&format!("triangulate p.xyz {option}"), 2, &[name]);
    }
    place.fails("", 2, &["Usage"]);
    place.fails("triangulate", 2, &["INPUT"]);
    place.fails("triangulate sample:uniform:10,d=3 -d 2", 2, &["contradicts"]);
    place.fails("triangulate sample:nothing:10", 2, &["nothing", "well-spaced"]);
    place.fails("generate uniform -n 10 --lipschitz 0.5 -o a.xyz", 2, &["lipschitz"]);
    place.fails("generate graded -n 10 --lipschitz 1.5 -o a.xyz", 2, &["1.5"]);
    place.fails("generate nothing -n 10 -o a.xyz", 2, &["nothing"]);
}

#[test]
fn outputs_that_would_overwrite_the_input_are_refused() {
    let place = Place::new();
    place.file("a.node", "4 2 0 0\n1 0 0\n2 1 0\n3 0 1\n4 1 1\n");
    place.fails("triangulate a.node -o a.ele", 2, &["a.ele", "a.node", "all five files"]);
    place.fails("triangulate a.node -o ./a.node", 2, &["a.node"]);
    place.fails("triangulate a.node --json a.node", 2, &["a.node"]);
    place.good("triangulate a.node -o a.1.ele");
    assert!(place.names().contains("a.1.node"));
    // Ids count from one, as in the input.
    assert!(fs::read_to_string(place.path("a.1.ele")).unwrap().lines().nth(1).unwrap().contains('1'));
    place.good("verify a.node a.1.ele --perturbed");
    place.good("verify a.1.node a.1.ele");
}

#[test]
fn unwritable_outputs_are_found_before_any_work() {
    let place = Place::new();
    fs::create_dir(place.path("dir.vtu")).unwrap();
    for output in ["nowhere/a.vtu", "dir.vtu", "nowhere/a.ele"] {
        // The input does not exist: the output is looked at first.
        place.fails(&format!("triangulate missing.xyz -o {output}"), 1, &[output]);
    }
    place.fails("triangulate missing.xyz --json nowhere/a.json", 1, &["nowhere"]);
    place.fails("generate uniform -n 10 -o nowhere/a.xyz", 1, &["nowhere"]);
    if Path::new("/proc/self").exists() {
        place.fails("triangulate missing.xyz -o /proc/a.vtu", 1, &["/proc/a.vtu"]);
    }
}

#[test]
fn limits_are_exit_5() {
    let place = Place::new();
    place.fails("triangulate sample:uniform:1e9 --max-memory 1G -o a.vtu", 5, &["--max-memory"]);
    place.file("p.xyz", SQUARE);
    place.fails("triangulate p.xyz --max-memory 1000 -o a.vtu", 5, &["1000"]);
    place.fails("generate moment-curve -n 1e9 -o a.xyz", 5, &["too many"]);
}

#[test]
fn invalid_points_are_dropped_and_counted_when_asked() {
    let place = Place::new();
    place.file("p.csv", "x,y\n0,0\nnan,1\n1,0\n0,1\ninf,0\n1,1\n0,oops\n0.4,0.3\n0.4,0.3\n");
    let output = place.good("triangulate p.csv --skip-invalid --json r.json -o cells.npy -o a.vtu");
    assert!(stderr(&output).contains("3 invalid points skipped"));
    let points = &place.json("r.json")["points"];
    assert_eq!(points["input"], 9);
    assert_eq!(points["used"], 5);
    assert_eq!(points["duplicate"], 1);
    assert_eq!(points["refused"], 3);
    // A file of cells alone counts the rows of the input: the points kept are 0, 2, 3, 5 and 7.
    let bytes = fs::read(place.path("cells.npy")).unwrap();
    let body = &bytes[bytes.len() - 4 * 3 * 8..];
    let used: BTreeSet<u64> =
        body.chunks_exact(8).map(|c| u64::from_le_bytes(c.try_into().unwrap())).collect();
    assert_eq!(used.into_iter().collect::<Vec<_>>(), [0, 2, 3, 5, 7]);
    place.good("verify a.vtu a.vtu");
}

#[test]
fn points_come_from_standard_input_and_gzip() {
    let place = Place::new();
    let output = place.feed("triangulate - --json - -q", SQUARE.as_bytes());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(output.stderr.is_empty(), "quiet, yet: {}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["simplices"], &report["points"]["used"]), (&4.into(), &5.into()));

    let mut packed = Vec::new();
    let mut encoder = flate2::write::GzEncoder::new(&mut packed, flate2::Compression::fast());
    encoder.write_all(SQUARE.as_bytes()).unwrap();
    encoder.finish().unwrap();
    place.file("p.xyz.gz", &packed);
    place.good("triangulate p.xyz.gz -o a.off");
    place.good("verify p.xyz.gz a.off");
    let output = place.feed("triangulate - -o b.off", &packed);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(fs::read(place.path("a.off")).unwrap(), fs::read(place.path("b.off")).unwrap());
}

#[test]
fn generated_points_are_triangulated_from_standard_input() {
    let place = Place::new();
    let points = place.good("generate uniform -n 500 --seed 3");
    let output = place.feed("triangulate - -o a.npy", &points.stdout);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    place.good("generate uniform -n 500 --seed 3 -o p.npy");
    place.good("verify p.npy a.npy --perturbed");
    // A sample is the same set.
    place.good("triangulate sample:uniform:500,seed=3 -o b.npy");
    assert_eq!(fs::read(place.path("a.npy")).unwrap(), fs::read(place.path("b.npy")).unwrap());
}

#[test]
fn every_format_round_trips_through_verify() {
    let place = Place::new();
    for (d, outputs) in [
        (3, &["a.vtu", "a.1.ele", "a.msh", "a.msh22", "a.msh41", "a.mesh", "a.npy"][..]),
        (2, &["b.vtu", "b.1.ele", "b.msh", "b.msh22", "b.msh41", "b.mesh", "b.npy", "b.off"][..]),
    ] {
        for points in ["p.node", "p.xyz", "p.csv", "p.npy"] {
            place.good(&format!("generate grid -n 100 -d {d} -o {points}"));
        }
        let list: String = outputs.iter().flat_map(|o| [" -o ", o]).collect();
        place.good(&format!("triangulate p.node{list}"));
        for output in outputs {
            // The readers know .msh; the endings with a version are for writing.
            let readable = match output.split_once(".msh") {
                Some((stem, version)) if !version.is_empty() => {
                    let name = format!("{stem}-{version}.msh");
                    fs::rename(place.path(output), place.path(&name)).unwrap();
                    name
                }
                _ => (*output).to_owned(),
            };
            for points in ["p.node", "p.xyz", "p.csv", "p.npy"] {
                place.good(&format!("verify {points} {readable} --perturbed"));
            }
        }
        let own = if d == 3 { "a.vtu" } else { "b.vtu" };
        place.good(&format!("verify {own} {own}"));
    }
    place.good("triangulate p.node -o old.msh --msh-version 2.2");
    assert!(fs::read_to_string(place.path("old.msh")).unwrap().contains("2.2 0 8"));
    place.good("triangulate p.node -o owned.vtu --with-owner");
}

#[test]
fn verify_tells_good_from_bad() {
    let place = Place::new();
    place.file("p.xyz", "0 0\n2 0\n0 1\n3 3\n");
    place.file("good.ele", "2 3 0\n0 0 1 2\n1 1 3 2\n");
    place.file("flipped.ele", "2 3 0\n0 0 1 3\n1 0 3 2\n");
    place.file("hole.ele", "1 3 0\n0 0 1 2\n");
    place.file("from1.ele", "2 3 0\n1 1 2 3\n2 2 4 3\n");
    let output = place.good("verify p.xyz good.ele --json -");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], "septet-verify/1");
    assert_eq!((&report["passed"], report["levels"].as_array().unwrap().len()), (&true.into(), 6));
    assert!(stderr(&output).contains("empty spheres"));
    place.good("verify p.xyz from1.ele");
    place.fails("verify p.xyz flipped.ele", 4, &["empty spheres", "FAILED", "flipped.ele"]);
    place.fails("verify p.xyz hole.ele", 4, &["structure", "FAILED"]);
    let output = place.run("verify p.xyz flipped.ele --json - -q");
    assert_eq!(code(&output), 4);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["passed"], false);
}

#[test]
fn verify_explains_what_does_not_fit() {
    let place = Place::new();
    place.file("flat.xyz", "0 0\n2 0\n0 1\n3 3\n").file("space.xyz", "0 0 0\n2 0 0\n0 1 0\n3 3 1\n");
    place.file("tri.ele", "2 3 0\n0 0 1 2\n1 1 3 2\n").file("tet.ele", "1 4 0\n0 0 1 2 3\n");
    place.file("far.ele", "1 3 0\n0 0 1 9\n");
    place.fails("verify space.xyz tri.ele", 3, &["triangles", "help"]);
    place.fails("verify flat.xyz tet.ele", 3, &["dimension 3"]);
    place.fails("verify flat.xyz far.ele", 3, &["far.ele", "line 2", "9"]);
    place.fails("verify flat.xyz missing.ele", 3, &["missing.ele"]);
    place.fails("verify flat.xyz flat.xyz", 3, &["a table of points as cells", "give the cells"]);
    place.good("verify space.xyz tet.ele");
}

#[test]
fn points_of_lower_dimension_have_no_cells() {
    let place = Place::new();
    for (content, dimension) in [
        ("", -1),
        ("1 2 3\n", 0),
        ("1 2 3\n1 2 3\n", 0),
        ("0 0 0\n1 1 1\n2 2 2\n", 1),
        ("0 0 1\n1 0 1\n0 1 1\n1 1 1\n5 4 1\n", 2),
    ] {
        place.file("p.xyz", content);
        if content.is_empty() {
            place.file("p.node", "0 3 0 0\n");
        }
        let input = if content.is_empty() { "p.node" } else { "p.xyz" };
        let output = place.good(&format!("triangulate {input} --json r.json -o a.vtu -o a.npy"));
        let lines = stderr(&output).lines().filter(|l| l.contains("no cells")).count();
        assert_eq!(lines, 1, "{}", stderr(&output));
        let report = place.json("r.json");
        assert_eq!((&report["dimension"], &report["simplices"]), (&dimension.into(), &0.into()));
        assert_eq!(report["fallback"], Value::Null);
    }
}

#[test]
fn bytes_do_not_depend_on_workers_transport_or_command() {
    let place = Place::new();
    place.good("triangulate sample:clusters:3000 -o a.vtu");
    let reference = fs::read(place.path("a.vtu")).unwrap();
    for line in [
        "triangulate sample:clusters:3000 --workers 7 --leaf 200",
        "triangulate sample:clusters:3000 --workers 3 --threads 1 --transport sim --delivery-seed 5 --leaf 200",
        "simulate sample:clusters:3000 --workers leaves --leaf 300",
        "simulate sample:clusters:3000 --supergraph knn --k 10ln --leaf 300",
    ] {
        place.good(&format!("{line} -o b.vtu"));
        assert!(fs::read(place.path("b.vtu")).unwrap() == reference, "{line}");
    }
}

#[test]
fn tables_and_logs_go_to_standard_error() {
    let place = Place::new();
    let output = place.good("simulate sample:uniform:2000 --profile");
    let talk = stderr(&output);
    for words in ["Phases: modelled | measured", "Rounds (modelled)", "Tree levels (modelled)", "partition"] {
        assert!(talk.contains(words), "{talk}");
    }
    assert!(output.stdout.is_empty());
    let talk = stderr(&place.good("triangulate sample:uniform:2000 -v"));
    assert!(talk.contains("phase ended") && talk.contains("INFO"), "{talk}");
    let output =
        place.command("triangulate sample:uniform:2000 -q").env("RUST_LOG", "info").output().unwrap();
    assert!(stderr(&output).contains("phase ended"));
    assert!(place.good("triangulate sample:uniform:2000 -q").stderr.is_empty());
    assert!(place.names().is_empty(), "without -o nothing is written");
}

#[test]
fn every_help_has_an_example() {
    let place = Place::new();
    for sub in ["", "triangulate", "simulate", "generate", "verify", "completions", "man"] {
        let help = String::from_utf8(place.good(&format!("{sub} --help")).stdout).unwrap();
        let examples = help.split("Examples:").nth(1).unwrap_or_else(|| panic!("no example: {help}"));
        assert!(examples.contains(&format!("septet {sub}")), "{sub}: {help}");
    }
    let help = String::from_utf8(place.good("--help").stdout).unwrap();
    for code in ["0 ", "1 ", "2 ", "3 ", "4 ", "5 ", "6 ", "130 "] {
        assert!(help.lines().any(|l| l.trim_start().starts_with(code)), "{code}: {help}");
    }
    assert!(String::from_utf8(place.good("--version").stdout).unwrap().starts_with("septet "));
}

#[test]
fn completions_and_manual_are_written() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = String::from_utf8(place.good(&format!("completions {shell}")).stdout).unwrap();
        assert!(script.contains("separator-sets"), "{shell}");
    }
    place.fails("completions tcsh", 2, &["tcsh"]);
    let page = String::from_utf8(place.good("man").stdout).unwrap();
    assert!(page.contains(".TH septet"));
    for sub in ["TRIANGULATE", "SIMULATE", "GENERATE", "VERIFY", "COMPLETIONS"] {
        assert!(page.contains(&format!(".SH SEPTET {sub}")), "{sub}");
    }
    assert!(page.contains("separator\\-sets") && page.contains("130"));
}
