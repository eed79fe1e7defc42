//! Options without effect: each pair of options is refused with exit code 2, and the message names both.

use std::fs;
use std::path::Path;

use super::Place;

/// A line, and the two options or values that its message names.
type Pair = (&'static str, [&'static str; 2]);

const PAIRS: [Pair; 105] = [
    // The report holds the picture.
    ("triangulate p.xyz --view 10", ["--view", "--json"]),
    ("simulate p.xyz --view 0 -o a.vtu", ["--view", "--json"]),
    ("simulate p.xyz --nodes none", ["--nodes", "--json"]),
    ("predict sample:grid:27 --skip-invalid", ["--skip-invalid", "sample"]),
    ("mesh cube.poly -o m.vtu --view 10", ["--view", "--json"]),
    ("triangulate p.xyz --trace-level round", ["--trace-level", "--trace"]),
    ("mesh cube.poly -o m.vtu --trace-level round", ["--trace-level", "--trace"]),
    // Outputs.
    ("triangulate p.xyz --format vtu", ["--format", "-o OUT"]),
    ("mesh cube.poly --json m.json --format vtu", ["--format", "-o OUT"]),
    ("triangulate p.xyz --msh-version 2.2", ["--msh-version", "-o OUT.msh"]),
    ("triangulate p.xyz -o a.vtu --msh-version 4.1", ["--msh-version", "-o OUT.msh"]),
    ("triangulate p.xyz -o a.msh22 --msh-version 2.2", ["--msh-version", "-o OUT.msh"]),
    ("triangulate p.xyz -o a.msh --format vtu --msh-version 2.2", ["--msh-version", "-o OUT.msh"]),
    ("mesh cube.poly -o m.vtu --msh-version 2.2", ["--msh-version", "-o OUT.msh"]),
    ("mesh cube.poly --json m.json --order 2", ["--order", "-o OUT"]),
    ("triangulate p.xyz --with-owner", ["--with-owner", "-o OUT.vtu"]),
    ("triangulate p.xyz --with-owner -o a.msh --json r.json", ["--with-owner", "-o OUT.vtk"]),
    ("triangulate p.xyz --keep-columns", ["--keep-columns", "-o OUT.vtu"]),
    ("simulate p.xyz --keep-columns -o a.npy", ["--keep-columns", "-o OUT.vtk"]),
    // A sample is not a file, and only a table has columns.
    ("triangulate sample:grid:27 --columns 1,2,3", ["--columns", "sample"]),
    ("triangulate sample:grid:27 --input-format xyz", ["--input-format", "sample"]),
    ("triangulate sample:grid:27 --skip-invalid", ["--skip-invalid", "sample"]),
    ("triangulate sample:grid:27 --keep-columns -o a.vtu", ["--keep-columns", "sample"]),
    ("triangulate sample:grid:27 --terrain", ["--terrain", "sample"]),
    ("rival incremental sample:grid:27 --skip-invalid", ["--skip-invalid", "sample"]),
    ("rival incremental -n 27 --kind grid --columns 1,2,3", ["--columns", "sample"]),
    ("verify sample:grid:27 a.ele --columns 1,2,3", ["--columns", "sample"]),
    ("triangulate p.ply --columns 1,2,3", ["--columns", ".ply"]),
    ("triangulate p.ply --keep-columns -o a.vtu", ["--keep-columns", ".ply"]),
    ("verify p.ply a.ele --columns 1,2,3", ["--columns", ".ply"]),
    ("triangulate p.xyz --input-format ply --columns 1,2", ["--columns", ".ply"]),
    // Raw coordinates have no columns, no other format, and no name of another format.
    ("triangulate sample:grid:27 --raw f64,3", ["--raw", "sample"]),
    ("triangulate p.bin --raw f64,3 --columns 1,2,3", ["--columns", "--raw"]),
    ("simulate p.bin --raw f64,3 --input-format xyz", ["--input-format", "--raw"]),
    ("simulate p.bin --raw f64,3 --keep-columns -o a.vtu", ["--keep-columns", ".raw"]),
    ("triangulate p.xyz --raw f64,3", ["--raw", ".xyz"]),
    ("verify p.ply a.ele --raw f64,3", ["--raw", ".ply"]),
    ("triangulate p.bin --raw i32,3", ["--raw", "f32be"]),
    // Parameters of another setting.
    ("triangulate p.xyz --delivery-seed 3", ["--delivery-seed", "--transport sim"]),
    ("mesh cube.poly -o m.vtu --delivery-seed 3", ["--delivery-seed", "--transport sim"]),
    ("scale -n 100 --delivery-seed 3 -o r.jsonl", ["--delivery-seed", "--transport sim"]),
    ("triangulate p.xyz --part-bytes 4096", ["--part-bytes", "--transport processes"]),
    ("simulate p.xyz --part-bytes 1M", ["--part-bytes", "--transport processes"]),
    ("triangulate p.xyz --first-row 8589934592", ["--first-row", "--transport processes"]),
    ("simulate p.xyz --first-row 1", ["--first-row", "--transport processes"]),
    ("simulate p.xyz --k 3", ["--k", "density"]),
    ("simulate p.xyz --supergraph overlap --k 3", ["--k", "overlap"]),
    ("simulate p.xyz --supergraph knn --alpha 3", ["--alpha", "knn"]),
    ("generate uniform -n 9 --lipschitz 0.3 -o a.xyz", ["lipschitz", "uniform"]),
    ("generate uniform -n 9 --ratio 2 -o a.xyz", ["ratio", "uniform"]),
    ("mesh cube.poly -o m.vtu --boundary exact --max-distance 1", ["--max-distance", "--boundary remesh"]),
    ("mesh cube.poly -o m.vtu --max-distance 1", ["--max-distance", "--boundary remesh"]),
    ("mesh cube.off -o m.vtu --boundary exact --feature-angle 9", ["--feature-angle", "--boundary remesh"]),
    ("mesh cube.poly -o m.vtu --feature-angle 9", ["--feature-angle", "--boundary remesh"]),
    ("mesh cube.poly -o m.vtu --singularity point", ["--singularity", "--min-size"]),
    ("mesh cube.poly -o m.vtu --lipschitz 0.5 --radius-edge 2", ["--lipschitz", "--radius-edge"]),
    ("mesh cube.poly -o m.vtu --size 1 --min-size 2", ["--min-size", "--size"]),
    ("mesh cube.poly -o m.vtu --improve --no-improve", ["--improve", "--no-improve"]),
    ("mesh cube.poly -o m.vtu --strict --weld 1", ["--strict", "--weld"]),
    ("mesh cube.poly -o m.vtu --strict --repair", ["--strict", "--repair"]),
    ("mesh cube.off -o m.vtu --keep-surface --boundary remesh", ["--keep-surface", "--boundary remesh"]),
    ("mesh cube.off -o m.vtu --keep-surface --max-distance 1", ["--max-distance", "--boundary remesh"]),
    ("mesh cube.off -o m.vtu --size none --boundary remesh", ["--size none", "--boundary remesh"]),
    ("mesh cube.poly -o m.vtu --size none --min-size 1", ["--size none", "--min-size"]),
    ("mesh cube.poly -o m.vtu --size none --size-field s.txt", ["--size none", "--size-field"]),
    ("mesh cube.poly -o m.vtu --size none --keep-surface", ["--size none", "--keep-surface"]),
    ("mesh cube.poly -o m.vtu --size none --no-improve", ["--size none", "--no-improve"]),
    // A sweep that stops early, and one without graded kinds.
    ("scale -n 100 --until neighbours --supergraph knn -o r.jsonl", ["--supergraph", "--until neighbours"]),
    ("scale -n 100 --until partition --supergraph overlap -o r.jsonl", ["--supergraph", "--until partition"]),
    ("scale -n 100 --until neighbours --supergraph knn --k 9 -o r.jsonl", ["--supergraph", "--until"]),
    ("scale -n 100 --until neighbours --separator-sets both -o r.jsonl", ["--separator-sets", "--until"]),
    ("scale -n 100 --until partition --neighbours naive -o r.jsonl", ["--neighbours", "--until partition"]),
    ("scale -n 100 --until partition --alpha 3 --leaf 9 -o r.jsonl", ["--alpha", "--until"]),
    (
        "scale -n 100 --until partition --constants timing --alpha 3 --leaf 9 -o r.jsonl",
        ["--alpha", "--until"],
    ),
    ("scale -n 100 --partition kd --tries 3 -o r.jsonl", ["--tries", "partition kd"]),
    ("simulate p.xyz --partition kd --tries 3", ["--tries", "partition kd"]),
    ("simulate p.xyz --partition hilbert --tries 3", ["--tries", "partition hilbert"]),
    ("scale -n 100 --until partition --timed -o r.jsonl", ["--timed", "--until"]),
    ("scale -n 100 --neighbours naive --timed -o r.jsonl", ["--timed", "--neighbours"]),
    ("scale -n 100 --lipschitz 0.3 -o r.jsonl", ["--lipschitz", "--kind graded"]),
    // Without a count, `fit` lists the counts.
    ("fit r.jsonl -x n", ["-x", "-y"]),
    ("fit r.jsonl --phase hulls", ["--phase", "-y"]),
    ("fit r.jsonl --margin 0.1", ["--margin", "-y"]),
    ("fit r.jsonl --resample 9", ["--resample", "-y"]),
    ("fit r.jsonl --json -", ["--json", "-y"]),
    ("fit r.jsonl --speedup -x n", ["--speedup", "-x"]),
    ("fit r.jsonl --speedup -y levels", ["--speedup", "-y"]),
    ("fit r.jsonl --speedup --margin 0.1", ["--speedup", "--margin"]),
    ("fit r.jsonl --speedup --resample 9", ["--speedup", "--resample"]),
    ("fit r.jsonl -y level-depth --phase partition -x n", ["-x", "level-depth"]),
    // A list of claims runs none, and JSON on standard output takes the place of the tables.
    ("reproduce --list --quick", ["--list", "--quick"]),
    ("reproduce --list --full", ["--list", "--full"]),
    ("reproduce --list --seed 3", ["--list", "--seed"]),
    ("reproduce --list --neighbours naive", ["--list", "--neighbours"]),
    ("reproduce --list --threads 2", ["--list", "--threads"]),
    ("reproduce --list --figures", ["--list", "--figures"]),
    ("reproduce --list --json c.json", ["--list", "--json"]),
    ("reproduce --list --journal c.jsonl", ["--list", "--journal"]),
    ("reproduce --quick --full", ["--quick", "--full"]),
    ("reproduce levels --figures --json -", ["--figures", "--json -"]),
    // A set is given or generated.
    ("rival incremental p.xyz -n 9 --kind grid", ["--kind", "INPUT"]),
    ("rival incremental p.xyz -n 9", ["--number", "INPUT"]),
    ("rival incremental -n 9", ["--number", "--kind"]),
    ("verify p.xyz a.ele --threads 0", ["--threads", "0"]),
    ("triangulate p.xyz -q -v", ["--quiet", "--verbose"]),
];

/// The options that `mesh --check` does not use.
const NOT_FOR_CHECKS: [&str; 31] = [
    "-o m.vtu",
    "--format vtu",
    "--msh-version 2.2",
    "--order 2",
    "--boundary exact",
    "--feature-angle 9",
    "--max-distance 1",
    "--size 1",
    "--size-field sizes.txt",
    "--singularity point",
    "--lipschitz 0.5",
    "--radius-edge 2",
    "--min-size 1",
    "--improve",
    "--no-improve",
    "--keep-surface",
    "--conforming",
    "--by-recursion",
    "--workers 2",
    "--leaf 9",
    "--threads 1",
    "--seed 3",
    "--transport sim",
    "--delivery-seed 3",
    "--max-memory 1G",
    "--json m.json",
    "--trace t.json",
    "--trace-level round",
    "--view 9",
    "--profile",
    "--svg figures",
];

#[test]
fn options_without_effect_are_refused() {
    let place = Place::new();
    let domain = |name| fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good").join(name));
    place.file("cube.poly", domain("cube.poly").unwrap()).file("cube.off", domain("cube.off").unwrap());
    place.file("p.xyz", super::SQUARE).file("p.bin", [0; 24]);
    place.good("generate grid -n 27 -o p.ply");
    for (line, words) in PAIRS {
        place.fails(line, 2, &words);
    }
    for option in NOT_FOR_CHECKS {
        let name = if option == "-o m.vtu" { "--output" } else { option.split(' ').next().unwrap() };
        place.fails(&format!("mesh cube.poly --check {option}"), 2, &["--check", name]);
    }
}

/// The help of `mesh` has no option that the list for `--check` lacks.
#[test]
fn every_option_of_mesh_is_in_the_list_for_checks() {
    let help = String::from_utf8(Place::new().good("mesh --help").stdout).unwrap();
    let named =
        |line: &str| line.split([' ', '[', '.']).find_map(|word| word.strip_prefix("--")).map(str::to_owned);
    let options = help.lines().filter(|line| line.trim_start().starts_with('-')).filter_map(named);
    // A check uses the options that say which domains are accepted.
    let general =
        ["check", "weld", "repair", "strict", "output", "quiet", "verbose", "color", "help", "version"];
    for option in options.filter(|name| !general.contains(&name.as_str())) {
        let listed = |entry: &&str| entry.split(' ').next() == Some(&format!("--{option}"));
        assert!(NOT_FOR_CHECKS.iter().any(listed), "--{option}");
    }
}
