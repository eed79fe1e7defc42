//! The writers, format by format.

mod binary;
mod gmsh_and_medit;
mod pvtu;
mod solvers;
mod terrain;
mod tetgen_and_off;
mod vtk;

use binary::vtu_arrays;
use gmsh_and_medit::section;

use std::collections::HashMap;
use std::fs;

use super::*;
use septet_common::samples::{Sample, kuhn, no_cells, squares};

const NAMES: [&str; 18] = [
    "m.vtu", "m.vtk", "m.vtk.gz", "m.node", "m.msh", "m.msh22", "m.msh41", "m.mesh", "m.npy", "m.off",
    "m.stl", "m.obj", "m.ply", "m.xdmf", "m.inp", "m.su2", "m.bdf", "m.exo",
];

/// Writes a mesh under a name in a fresh directory; returns all files found there.
fn written(name: &str, sample: &Sample, options: &WriteOptions<'_>) -> HashMap<String, Vec<u8>> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    check_output(&path, options).unwrap();
    let mut last = (0, 0);
    let files = write(&path, &sample.view(), options, &mut |done, total| {
        assert!(done >= last.0 && done <= total);
        last = (done, total);
    });
    assert_eq!(last.0, last.1);
    let listed = files.unwrap();
    let found: HashMap<String, Vec<u8>> = fs::read_dir(directory.path())
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap()))
        .collect();
    assert_eq!(found.len(), listed.len());
    assert!(listed.iter().all(|f| found.contains_key(f.file_name().unwrap().to_str().unwrap())));
    found
}

fn one(name: &str, sample: &Sample) -> Vec<u8> {
    written(name, sample, &WriteOptions::default()).remove(name).unwrap()
}

fn text(bytes: &[u8]) -> Vec<&str> {
    std::str::from_utf8(bytes).unwrap().lines().collect()
}

fn numbers<T: std::str::FromStr>(line: &str) -> Vec<T>
where
    T::Err: std::fmt::Debug,
{
    line.split_whitespace().map(|word| word.parse().unwrap()).collect()
}

/// A mesh whose coordinates are awkward to print.
fn awkward(mut sample: Sample) -> Sample {
    for (i, c) in sample.coordinates.iter_mut().enumerate() {
        *c = match (*c == 0.0, i % 3) {
            (true, 0) => -0.0,
            (true, 1) => 1e-120 * (i as f64 + 0.1),
            (true, _) => -5e-324,
            _ => *c / 3.0 + i as f64 * 1e-17,
        };
    }
    sample
}

fn same_bits(lines: &[&str], sample: &Sample, skip: usize) {
    let d = sample.dimension;
    assert_eq!(lines.len() * d, sample.coordinates.len());
    for (line, point) in lines.iter().zip(sample.coordinates.chunks_exact(d)) {
        let row: Vec<f64> = numbers::<f64>(line).split_off(skip);
        for (axis, c) in point.iter().enumerate() {
            assert_eq!(row[axis].to_bits(), c.to_bits(), "{line}");
        }
    }
}

fn same_cells(lines: &[&str], sample: &Sample, skip: usize, base: u64) {
    let corners = sample.dimension + 1;
    assert_eq!(lines.len() * corners, sample.cells.len());
    for (line, cell) in lines.iter().zip(sample.cells.chunks_exact(corners)) {
        let row: Vec<u64> = numbers(line);
        let row: Vec<u64> = row[skip..skip + corners].iter().map(|v| v - base).collect();
        assert_eq!(row, cell);
    }
}

#[test]
fn meshes_without_cells_are_written_in_every_format() {
    for name in NAMES {
        for (dimension, points) in [(2, 0), (2, 3), (3, 0), (3, 4)] {
            let sample = no_cells(dimension, points);
            let files = written(name, &sample, &WriteOptions::default());
            assert!(files.values().all(|bytes| !bytes.is_empty()));
        }
    }
    let bytes = one("m.msh", &no_cells(3, 0));
    let lines = text(&bytes);
    assert_eq!(section(&lines, "Nodes"), ["0 0 0 0"]);
    assert_eq!(section(&lines, "Elements"), ["0 0 0 0"]);
    let (_, arrays) = vtu_arrays(&one("m.vtu", &no_cells(2, 3)));
    assert_eq!((arrays["Points"].len(), arrays["types"].len()), (72, 0));
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let sample = awkward(kuhn(12));
    let options = WriteOptions { with_owner: true, ..WriteOptions::default() };
    let with_threads = |threads: usize, name: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| written(name, &sample, &options))
    };
    for name in NAMES {
        let single = with_threads(1, name);
        assert!(single == with_threads(5, name), "{name}");
        assert!(single == with_threads(1, name), "{name}");
    }
}

#[test]
fn failures_leave_the_old_files_alone() {
    let directory = tempfile::tempdir().unwrap();
    let mut sample = squares(1);
    // The same triangle occurs twice, so neighbours are not defined.
    sample.cells = vec![0, 1, 3, 0, 1, 3];
    for name in ["m.node", "m.mesh"] {
        fs::write(directory.path().join(name), "old").unwrap();
        let path = directory.path().join(name);
        let error = write(&path, &sample.view(), &WriteOptions::default(), &mut |_, _| {});
        let error = error.unwrap_err();
        assert!(matches!(error, OutputError::Topology { .. }), "{error}");
        assert!(error.to_string().contains("[0, 1]"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 2);
}

#[test]
fn inconsistent_meshes_are_refused_before_anything_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("m.vtu");
    let sample = squares(1);
    let good = sample.view();
    let bad = [
        MeshView { dimension: 0, ..good },
        MeshView { coordinates: &good.coordinates[1..], ..good },
        MeshView { coordinates: &good.coordinates[2..], ..good },
        MeshView { cells: &good.cells[1..], ..good },
        MeshView { owner: Some(&[1]), ..good },
        MeshView { owning_leaf: Some(&[]), ..good },
    ];
    for mesh in bad {
        let error = write(&path, &mesh, &WriteOptions::default(), &mut |_, _| {}).unwrap_err();
        assert!(matches!(error, OutputError::InvalidMesh { .. }), "{error}");
    }
    let error = write(&path, &MeshView { dimension: 4, ..good }, &WriteOptions::default(), &mut |_, _| {})
        .unwrap_err();
    assert!(matches!(error, OutputError::OnlySpace { dimension: 4, .. }), "{error}");
    let options = WriteOptions { first_id: 2, ..WriteOptions::default() };
    let error = write(&path, &good, &options, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, OutputError::FirstId { first_id: 2 }));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn check_output_looks_at_the_whole_set() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("m.ele");
    assert_eq!(check_output(&path, &WriteOptions::default()).unwrap(), Format::Ele);
    fs::create_dir(directory.path().join("m.neigh")).unwrap();
    let error = check_output(&path, &WriteOptions::default()).unwrap_err();
    assert!(error.to_string().contains("m.neigh"), "{error}");
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}
