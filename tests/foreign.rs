//! The files of small meshes, read by other programs.
//!
//! `SEPTET_PYTHON` names a Python interpreter with the packages that `tests/foreign/read_with_others.py` lists.
//! `tests/foreign/check_pieces.py` checks `.pvtu` files, `tests/foreign/check_mesh.py` meshes of domains, and
//! `tests/foreign/check_remesh.py` those with a remeshed boundary. `tests/foreign/check_terrain.py` checks heights, and `tests/foreign/check_solvers.py` groups in the formats of solvers. `tests/foreign/check_schemas.py` checks JSON reports. `tests/run` makes the interpreter and runs these tests,
//! which a plain `cargo test` ignores.

#[path = "foreign/solvers.rs"]
mod solvers;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use glam::DVec3;
use septet_common::sets::space;
use septet_core::generate::Kind;
use septet_core::model::{MeshView, Points};
use septet_io::read::{ReadOptions, read};
use septet_io::write::{WriteOptions, check_output, topology, write, write_points};

const EXTENSIONS: [&str; 8] = ["vtu", "ele", "msh", "msh41", "msh22", "mesh", "npy", "off"];

/// A mesh of a directory.
struct Mesh {
    dimension: usize,
    coordinates: Vec<f64>,
    cells: Vec<u64>,
    first_id: u64,
}

/// Awkward to print, yet near enough to the lattice to keep all cells positive.
fn coordinate(lattice: u64, salt: usize) -> f64 {
    let small = [-0.0, 1e-120, -3.3e-310, 2.5e-9, 0.0];
    match lattice {
        0 => small[salt % small.len()],
        _ => lattice as f64 / 3.0 + (salt % 7) as f64 * 1e-3,
    }
}

/// 2 x 2 x 2 cubes of six tetrahedra each.
fn cubes() -> Mesh {
    let at = |c: [u64; 3]| c[0] + 3 * (c[1] + 3 * c[2]);
    let lattice = |k: u64| (0..k * k * k).map(move |i| [i % k, i / k % k, i / k / k]);
    let coordinates: Vec<f64> =
        lattice(3).flatten().enumerate().map(|(salt, c)| coordinate(c, salt)).collect();
    let mut rows = Vec::new();
    for low in lattice(2) {
        for (path, even) in [
            ([0, 1, 2], true),
            ([1, 2, 0], true),
            ([2, 0, 1], true),
            ([0, 2, 1], false),
            ([2, 1, 0], false),
            ([1, 0, 2], false),
        ] {
            let mut corner = low;
            let mut cell = vec![at(corner)];
            for axis in path {
                corner[axis] += 1;
                cell.push(at(corner));
            }
            if !even {
                cell.swap(2, 3);
            }
            rows.push(cell);
        }
    }
    rows.sort();
    Mesh { dimension: 3, coordinates, cells: rows.concat(), first_id: 0 }
}

/// 3 x 3 squares of two triangles each.
fn squares() -> Mesh {
    let lattice = |k: u64| (0..k * k).map(move |i| [i % k, i / k]);
    let coordinates: Vec<f64> =
        lattice(4).flatten().enumerate().map(|(salt, c)| coordinate(c, salt)).collect();
    let mut rows = Vec::new();
    for [x, y] in lattice(3) {
        let low = x + 4 * y;
        rows.push([low, low + 1, low + 5]);
        rows.push([low, low + 5, low + 4]);
    }
    rows.sort_unstable();
    Mesh { dimension: 2, coordinates, cells: rows.concat(), first_id: 1 }
}

/// Three points and no cells.
fn no_cells(dimension: usize) -> Mesh {
    let coordinates = (0..3 * dimension).map(|salt| coordinate(1, salt)).collect();
    Mesh { dimension, coordinates, cells: Vec::new(), first_id: 0 }
}

/// Writes the mesh in all formats, and the expected contents of the files.
fn write_all(directory: &Path, mesh: &Mesh) {
    fs::create_dir(directory).unwrap();
    let count = mesh.cells.len() / (mesh.dimension + 1);
    let owner: Vec<u32> = (0..count as u32).map(|i| i % 3).collect();
    let owning_leaf: Vec<u64> = (0..count as u64).map(|i| i << 33).collect();
    let view = MeshView {
        dimension: mesh.dimension,
        coordinates: &mesh.coordinates,
        heights: None,
        cells: &mesh.cells,
        owner: Some(&owner),
        owning_leaf: Some(&owning_leaf),
        run: None,
        labels: None,
    };
    let options = WriteOptions { with_owner: true, first_id: mesh.first_id, ..WriteOptions::default() };
    for extension in EXTENSIONS {
        let path = directory.join("mesh").with_extension(extension);
        check_output(&path, &options).unwrap();
        for file in write(&path, &view, &options, &mut |_, _| {}).unwrap() {
            assert!(fs::metadata(&file).unwrap().len() > 0, "{}", file.display());
        }
        assert!(path.is_file());
    }
    let hull = topology::hull(mesh.dimension, view.point_count(), &mesh.cells).unwrap();
    // From zero: the sum of an empty iterator would be -0.
    let sum = mesh.coordinates.iter().fold(0.0, |sum, c| sum + c);
    let expected = serde_json::json!({
        "dimension": mesh.dimension,
        "points": view.point_count(),
        "cells": count,
        "hull": hull.len() / mesh.dimension,
        "coordinate_sum": sum,
        "first_id": mesh.first_id,
    });
    fs::write(directory.join("expected.json"), expected.to_string()).unwrap();
    let coordinates: Vec<u8> = mesh.coordinates.iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(directory.join("coordinates.f64"), coordinates).unwrap();
    let cells: Vec<u8> = mesh.cells.iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(directory.join("cells.i64"), cells).unwrap();
}

/// The interpreter.
fn python() -> OsString {
    std::env::var_os("SEPTET_PYTHON").expect(
        "SEPTET_PYTHON must name a Python interpreter with the packages of tests/requirements.txt: tests/run makes one",
    )
}

#[test]
#[ignore = "needs Python with vtk, meshio, gmsh and numpy"]
fn other_programs_read_what_we_write() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    write_all(&at("cubes"), &cubes());
    write_all(&at("squares"), &squares());
    write_all(&at("empty-space"), &no_cells(3));
    write_all(&at("empty-plane"), &no_cells(2));
    let python = python();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/read_with_others.py");
    let output = Command::new(&python).arg(script).arg(directory.path()).output();
    let output = output.unwrap_or_else(|e| panic!("cannot run {}: {e}", python.display()));
    let printed = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}\n{complained}");
    let last = printed.lines().last().unwrap_or_default();
    assert!(last.ends_with(" passed, 0 failed"), "{printed}\n{complained}");
    println!("{printed}");
}

/// The heights of a terrain are z for others.
#[test]
#[ignore = "needs Python with meshio and numpy"]
fn other_programs_read_the_heights_of_terrain() {
    let directory = tempfile::tempdir().unwrap();
    let row = |i: u64| format!("{},{},{}\n", i * 37 % 101, i * 23 % 97, 100.0 + (i * i) as f64 / 3.0);
    fs::write(directory.path().join("p.csv"), (0..90).fold("x,y,z\n".to_owned(), |text, i| text + &row(i)))
        .unwrap();
    let files = ["m.vtu", "m.vtk", "m.msh", "m.msh22", "m.mesh", "m.off", "m.ply", "m.obj"];
    let run = |program: OsString, words: &[&str]| {
        let output = Command::new(program).current_dir(directory.path()).args(words).output().unwrap();
        let printed =
            [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned()).concat();
        assert!(output.status.success(), "{words:?}: {printed}");
        printed
    };
    let mut words = vec!["triangulate", "p.csv", "--terrain", "-q", "-o", "m.npy"];
    words.extend(files.iter().flat_map(|file| ["-o", *file]));
    run(env!("CARGO_BIN_EXE_septet").into(), &words);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/foreign/check_terrain.py");
    // meshio does not know the ending .msh22.
    fs::rename(directory.path().join("m.msh22"), directory.path().join("m2.msh")).unwrap();
    let mut words = vec!["-B", script, "p.csv", "m.npy", "m2.msh"];
    words.extend(files.iter().filter(|file| !file.ends_with("22")));
    assert!(run(python(), &words).contains("ok 8 files"));
}

/// Rows of points that numpy saves as doubles, and whole numbers that it saves in every type; `numpy_arrays.py` has the same.
const AWKWARD: [[f64; 3]; 3] = [[0.1, -2.5e300, 7.0], [1e-5, 0.0, 1.0], [-3.3e-310, 1.0 / 3.0, 5e-324]];
const WHOLE: [[f64; 3]; 4] = [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0], [6.0, 7.0, 100.0], [9.0, 10.0, 11.0]];

/// Arrays go to numpy and come back from it, in each version of the format, type and order that is read.
#[test]
#[ignore = "needs Python with vtk, meshio, gmsh and numpy"]
fn numpy_reads_and_writes_the_same_arrays() {
    let python = python();
    let directory = tempfile::tempdir().unwrap();
    let points = Points::Space(AWKWARD.map(DVec3::from).to_vec());
    let ours = directory.path().join("ours.npy");
    write_points(&ours, &points, &WriteOptions::default(), &mut |_, _| {}).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/numpy_arrays.py");
    let output = Command::new(&python).arg("-B").arg(script).arg(directory.path()).output().unwrap();
    let printed = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned()).concat();
    assert!(output.status.success(), "{printed}");
    let mut count = 0;
    for entry in fs::read_dir(directory.path()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let expected = if name.starts_with("whole") { WHOLE.to_vec() } else { AWKWARD.to_vec() };
        let found = read(&path, &ReadOptions::default(), &mut |_, _| {}).unwrap();
        let Points::Space(found) = found.points else { panic!("{name}: points of the plane") };
        let bits = |rows: Vec<[f64; 3]>| rows.concat().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found.iter().map(DVec3::to_array).collect()), bits(expected), "{name}");
        count += 1;
    }
    // Ours; three versions and two orders of doubles; two orders of ten types.
    assert_eq!(count, 1 + 6 + 20, "{printed}");
}

/// Runs the checker of a `.pvtu` file. Returns its output, and whether the file passes.
fn checked_pieces(python: &OsString, directory: &Path, used: u64) -> (bool, String) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/check_pieces.py");
    let mut command = Command::new(python);
    command.current_dir(directory).arg("-B").arg(script).args(["m.vtu", "m.pvtu", &used.to_string()]);
    let output = command.output().unwrap_or_else(|e| panic!("cannot run {}: {e}", python.display()));
    let printed = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned()).concat();
    (output.status.success() && printed.starts_with("ok "), printed)
}

/// Triangulates on eight workers. Returns the number of vertices.
fn in_pieces(directory: &Path, command: &str, input: &str) -> u64 {
    let line = format!("{command} {input} --workers 8 -q -o m.vtu -o m.pvtu --json m.json");
    let made = Command::new(env!("CARGO_BIN_EXE_septet"))
        .current_dir(directory)
        .args(line.split_whitespace())
        .output()
        .unwrap();
    assert!(made.status.success(), "{line}: {}", String::from_utf8_lossy(&made.stderr));
    let report = fs::read(directory.join("m.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    report["points"]["used"].as_u64().unwrap()
}

/// VTK reads the pieces as one grid and as three update pieces.
#[test]
#[ignore = "needs Python with vtk and numpy"]
fn pieces_are_one_triangulation() {
    let python = python();
    let directory = tempfile::tempdir().unwrap();
    let made = |input: &str| in_pieces(directory.path(), "triangulate", input);
    // Clusters in which every fifth point occurs twice.
    let mut points = space(Kind::Clusters, 4000, 1);
    let again: Vec<DVec3> = points.iter().copied().step_by(5).collect();
    points.extend(again);
    let path = directory.path().join("twice.npy");
    write_points(&path, &Points::Space(points), &WriteOptions::default(), &mut |_, _| {}).unwrap();
    // The spheres in the cube and the circles in the square are closed.
    for (input, used, closed) in [
        ("sample:uniform:20000", 20_000, "; 2 regions, 0 open edges;"),
        ("sample:uniform:20000,d=2", 20_000, "; 2 regions, 0 open edges;"),
        ("twice.npy", 4000, ""),
        ("sample:uniform:7", 7, ""),
    ] {
        assert_eq!(made(input), used, "{input}");
        let (good, printed) = checked_pieces(&python, directory.path(), used);
        assert!(good, "{input}: {printed}");
        let ends = printed.split(" polygons, ").nth(1).unwrap_or_default();
        assert!(closed.is_empty() || ends.starts_with(&closed[2..]), "{input}: {printed}");
        println!("{input}: {}", printed.trim());
    }
    assert_eq!(in_pieces(directory.path(), "simulate", "sample:uniform:3000"), 3000);
    assert!(checked_pieces(&python, directory.path(), 3000).0);
    // A point too many, a piece twice, and a ghost that is marked as owned.
    assert!(!checked_pieces(&python, directory.path(), 2999).0);
    let piece = |number: u32| directory.path().join(format!("m.pieces/000{number}.vtu"));
    let [first, second] = [0, 1].map(|number| fs::read(piece(number)).unwrap());
    fs::write(piece(1), &first).unwrap();
    assert!(!checked_pieces(&python, directory.path(), 3000).0);
    let marks: &[u8] = &[0, 0, 0, 1, 1, 1];
    let at = second.windows(marks.len()).rposition(|found| found == marks).unwrap() + 3;
    fs::write(piece(1), [&second[..at], &[0], &second[at + 1..]].concat()).unwrap();
    assert!(!checked_pieces(&python, directory.path(), 3000).0);
    fs::write(piece(1), &second).unwrap();
    assert!(checked_pieces(&python, directory.path(), 3000).0);
}

/// Domains of `tests/domains/good`, options, their areas and volumes, and the facets outside.
const DOMAINS: [(&str, &str, &str); 11] = [
    ("cube", "--size 0.8 --lipschitz 0.25", "64"),
    ("l-shape", "--size 0.6", "24"),
    ("cubic-hole", "--lipschitz 0.25", "208"),
    ("tunnel", "--size 0.9", "48"),
    ("two-regions", "--size 0.8", "64"),
    ("dangling", "--lipschitz 0.25", "64"),
    ("slanted-box", "--size 1.2", "162"),
    ("wedge", "--lipschitz 0.25", "0.08682408883346517"),
    ("airfoil", "--lipschitz 0.12", "0.07846417655"),
    ("map", "--size 0.5", "80"),
    // Its facet 20 lies in a hole.
    ("../../data/example", "--size 0.6", "17.9375 20"),
];

/// Returns the output of the checker for a mesh, and whether the mesh passes.
fn checked(python: &OsString, domain: &Path, mesh: &Path, measure: &str) -> (bool, String) {
    checked_by("check_mesh.py", python, domain, mesh, measure)
}

fn checked_by(script: &str, python: &OsString, domain: &Path, mesh: &Path, measure: &str) -> (bool, String) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign").join(script);
    // The scripts import each other, and leave nothing beside themselves.
    let output = Command::new(python)
        .arg("-B")
        .arg(script)
        .arg(domain)
        .arg(mesh)
        .args(measure.split_whitespace())
        .output();
    let output = output.unwrap_or_else(|e| panic!("cannot run {}: {e}", python.display()));
    let printed = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned()).concat();
    (output.status.success() && printed.starts_with("ok "), printed)
}

/// Makes a mesh. Returns the domain's file and the stem of the mesh's files.
fn mesh(directory: &Path, name: &str, options: &str) -> (PathBuf, PathBuf) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/domains/good");
    let named = root.join(name);
    let domain = if named.extension().is_some() { named } else { named.with_extension("poly") };
    assert!(domain.is_file(), "{} is missing: run tests/run --setup", domain.display());
    let stem = directory.join(Path::new(name).file_stem().unwrap());
    let made = Command::new(env!("CARGO_BIN_EXE_septet"))
        .arg("mesh")
        .arg(&domain)
        .arg("-o")
        .arg(stem.with_extension("ele"))
        .args(options.split_whitespace())
        .output()
        .unwrap();
    assert!(made.status.success(), "{name}: {}", String::from_utf8_lossy(&made.stderr));
    (domain, stem)
}

#[test]
#[ignore = "needs Python and the test data"]
fn meshes_of_domains_pass_another_checker() {
    let directory = tempfile::tempdir().unwrap();
    let python = python();
    for (name, options, measure) in DOMAINS {
        let (domain, stem) = mesh(directory.path(), name, options);
        let (good, printed) = checked(&python, &domain, &stem, measure);
        assert!(good, "{name}: {printed}");
        println!("{name}: {}", printed.trim());
    }
}

/// Scans with every triangle kept: the checker finds their planes and volumes itself.
#[test]
#[ignore = "needs Python and the test data"]
fn meshes_of_scans_pass_another_checker() {
    let directory = tempfile::tempdir().unwrap();
    let python = python();
    let (domain, stem) = mesh(directory.path(), "../../data/hand.off", "--boundary exact");
    let (good, printed) = checked(&python, &domain, &stem, "");
    assert!(good, "hand.off: {printed}");
    println!("hand.off: {}", printed.trim());
}

/// A scan with a remeshed boundary, which stays within the requested distance and has the same handles. It has sheets closer than an eighth
/// of the size, which once were joined by a handle.
#[test]
#[ignore = "needs Python and the test data"]
fn remeshed_scans_pass_another_checker() {
    let python = python();
    let directory = tempfile::tempdir().unwrap();
    let options = "--boundary remesh --max-distance 0.012";
    let (domain, stem) = mesh(directory.path(), "../../data/rotor.off", options);
    let checked = |distance: &str| checked_by("check_remesh.py", &python, &domain, &stem, distance);
    let (good, printed) = checked("0.012");
    assert!(good, "{printed}");
    println!("rotor: {}", printed.trim());
    let (good, printed) = checked("0.001");
    assert!(!good && printed.contains("farther than 0.001"), "{printed}");
    let faces = fs::read_to_string(stem.with_extension("face")).unwrap();
    fs::write(stem.with_extension("face"), without(&faces, 7)).unwrap();
    let (good, printed) = checked("0.012");
    assert!(!good && printed.contains("is no face"), "{printed}");
}

/// A change of the text of a file.
type Spoiling = dyn Fn(&str) -> String;

/// The checker would not let these pass.
#[test]
#[ignore = "needs Python with vtk, meshio, gmsh and numpy"]
fn spoilt_meshes_are_refused_by_the_other_program() {
    let python = python();
    let directory = tempfile::tempdir().unwrap();
    let (domain, stem) = mesh(directory.path(), "two-regions", "--size 0.8");
    assert!(checked(&python, &domain, &stem, "64").0);
    // A cell, a face or an edge on a segment less; another region; a point moved by a millionth; cells turned over.
    let spoilt: [(&str, &str, &Spoiling); 6] = [
        ("ele", "the cells have", &|text| without(text, 30)),
        ("face", "is no face", &|text| without(text, 7)),
        ("edge", "has no edge", &|text| without(text, 3)),
        ("ele", "is no face", &|text| edited(text, 30, |words| words[5] = "9".into())),
        ("node", "failed", &|text| edited(text, 1, |words| words[2] = "1e-6".into())),
        ("ele", "is not positive", &|text| edited(text, 12, |words| words.swap(2, 3))),
    ];
    for (extension, words, spoil) in spoilt {
        let path = stem.with_extension(extension);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, spoil(&text)).unwrap();
        let (good, printed) = checked(&python, &domain, &stem, "64");
        assert!(!good && printed.contains(words), "{extension}: {printed}");
        fs::write(&path, text).unwrap();
    }
    assert!(!checked(&python, &domain, &stem, "64.000001").0);
}

/// A table with one row fewer, and with its new length.
fn without(table: &str, row: usize) -> String {
    let mut lines: Vec<String> = table.lines().map(str::to_owned).collect();
    lines.remove(row);
    let (count, rest) = lines[0].split_once(' ').unwrap();
    lines[0] = format!("{} {rest}", count.parse::<usize>().unwrap() - 1);
    lines.join("\n")
}

/// A table with the words of one line changed.
fn edited(table: &str, row: usize, change: impl Fn(&mut Vec<String>)) -> String {
    let mut lines: Vec<String> = table.lines().map(str::to_owned).collect();
    let mut words: Vec<String> = lines[row].split_whitespace().map(str::to_owned).collect();
    change(&mut words);
    lines[row] = words.join(" ");
    lines.join("\n")
}

/// Commands of the program that write a report each, and the name of its schema.
const REPORTS: [(&str, &str); 15] = [
    ("run", "triangulate sample:uniform:500 --workers 2 --json"),
    ("run", "simulate sample:clusters:800 --workers 3 --leaf 50 --view 100 --json"),
    ("run", "simulate sample:uniform:300,d=2 --supergraph knn --workers leaves --nodes none --json"),
    ("run", "triangulate sample:uniform:400 --workers 2 --transport processes --json"),
    ("mesh", "mesh tests/domains/good/cube.poly --size 1 --json"),
    ("scale", "scale -n 256,362,512,724,1024 --seeds 2 -d 2 --until partition -o"),
    ("scale", "scale -n 256,512 --seeds 2 -d 2 --timed --workers 1,2 -o"),
    ("fit", "fit DIR/5.json -y levels --json"),
    ("speedup", "fit DIR/6.json --speedup --json"),
    ("predict", "predict sample:uniform:800 --workers 1,2 --json"),
    ("rival", "rival incremental -n 300 --kind uniform --against --json"),
    ("rival", "rival splay -n 300 --kind uniform --json"),
    ("rival", "rival direct -n 300 --kind uniform --json"),
    ("claims", "reproduce separator-attempts ply --json"),
    ("cost", "simulate sample:clusters:800 --workers 3 --leaf 60 --cost-trace"),
];

/// The schemas are valid, reports match them, and a report with any other field does not.
#[test]
#[ignore = "needs Python with jsonschema"]
fn reports_match_their_schemas() {
    let directory = tempfile::tempdir().unwrap();
    let septet = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_septet"));
        let output = command.args(line.split(' ')).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    for (i, (name, line)) in REPORTS.iter().enumerate() {
        let schema = directory.path().join(format!("{i}.schema.json"));
        fs::write(schema, septet(&format!("schema {name}"))).unwrap();
        let line = line.replace("DIR", &directory.path().display().to_string());
        septet(&format!("{line} {}", directory.path().join(format!("{i}.json")).display()));
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/check_schemas.py");
    let output = Command::new(python()).arg(script).arg(directory.path()).output().unwrap();
    let printed = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned()).concat();
    assert!(output.status.success(), "{printed}");
    assert_eq!(printed.lines().count(), REPORTS.len(), "{printed}");
}
