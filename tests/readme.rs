//! The commands of README run as a reader types them, in one folder, on small inputs of the names that they use.
//!
//! The build and the test command are left out, because they are running. The examples of the library run here too.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;

/// The lines of README's shell blocks.
fn commands(readme: &str) -> Vec<String> {
    let (mut found, mut inside) = (Vec::new(), false);
    for line in readme.lines() {
        match line {
            "```sh" => inside = true,
            "```" => inside = false,
            _ if inside => found.push(line.to_string()),
            _ => {}
        }
    }
    found
}

/// Files of the names that the commands read.
fn inputs(septet: &str, folder: &Path) {
    let rows: Vec<_> = (0..60).map(|i| format!("{},{},{}", i * 37 % 61, i * 23 % 59, i * 11 % 53)).collect();
    fs::write(folder.join("catalogue.csv"), rows.join("\n")).unwrap();
    let run = |line: &str| shell(septet, folder, line);
    run("septet generate uniform -n 200 -o points.node -q");
    run("septet generate uniform -n 200 -o scan.ply -q");
    let mut packed =
        GzEncoder::new(fs::File::create(folder.join("scan.ply.gz")).unwrap(), Compression::fast());
    packed.write_all(&fs::read(folder.join("scan.ply")).unwrap()).unwrap();
    packed.finish().unwrap();
    fs::copy(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good/cube.poly"),
        folder.join("part.poly"),
    )
    .unwrap();
}

/// Runs a line in bash, with the folder of `septet` first in `PATH`.
fn shell(septet: &str, folder: &Path, line: &str) {
    let program = Path::new(septet).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let folders = [program.to_path_buf()].into_iter().chain(std::env::split_paths(&others));
    let path = std::env::join_paths(folders).unwrap();
    let script = format!("set -o pipefail\n{line}");
    let output = Command::new("bash").args(["-c", &script]).current_dir(folder).env("PATH", path).output();
    let output = output.unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "`{line}` ended with {}:\n{errors}", output.status);
}

#[test]
fn the_commands_of_readme_run() {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let septet = env!("CARGO_BIN_EXE_septet");
    inputs(septet, folder.path());
    let mut run = 0;
    for line in commands(&readme) {
        let line = match line.strip_prefix("cargo run --release -- ") {
            Some(rest) => format!("septet {rest}"),
            None => line,
        };
        if line.starts_with("septet ") {
            shell(septet, folder.path(), &line);
            run += 1;
        } else {
            assert_eq!(line, "bash tests/run");
        }
    }
    assert_eq!(run, 9, "the main job and eight examples");
    for file in ["mesh.vtu", "points.1.ele", "hull.off", "part.vtu", "report.html", "runs.jsonl"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

/// The programs in tests/examples.
const EXAMPLES: [&str; 8] =
    ["triangulate", "neighbours", "voronoi_volumes", "verify", "counts", "trace", "mesh", "distributed"];

#[test]
fn the_examples_run() {
    let folder = tempfile::tempdir().unwrap();
    let programs = Path::new(env!("CARGO_BIN_EXE_septet")).parent().unwrap().join("examples");
    for name in EXAMPLES {
        let program = programs.join(name);
        assert!(program.exists(), "{} is missing: run cargo build --examples", program.display());
        let output = Command::new(program).env("TMPDIR", folder.path()).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "example {name} ended with {}:\n{errors}", output.status);
    }
}
