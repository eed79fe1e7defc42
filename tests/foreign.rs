//! The files of small meshes, read by other programs.
//!
//! `SEPTET_PYTHON` names a Python interpreter with the packages that
//! `tests/foreign/read_with_others.py` lists. Without it only the writers run, unless
//! `SEPTET_REQUIRE_FOREIGN=1` asks for the comparison.

use std::fs;
use std::path::Path;
use std::process::Command;

use septet::io::write::{WriteOptions, check_output, topology, write};
use septet::model::MeshView;

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

/// Writes the mesh in all formats, and what must be found in the files.
fn write_all(directory: &Path, mesh: &Mesh) {
    fs::create_dir(directory).unwrap();
    let count = mesh.cells.len() / (mesh.dimension + 1);
    let owner: Vec<u32> = (0..count as u32).map(|i| i % 3).collect();
    let home_leaf: Vec<u64> = (0..count as u64).map(|i| i << 33).collect();
    let view = MeshView {
        dimension: mesh.dimension,
        coordinates: &mesh.coordinates,
        cells: &mesh.cells,
        owner: Some(&owner),
        home_leaf: Some(&home_leaf),
        labels: None,
    };
    let options = WriteOptions { with_owner: true, first_id: mesh.first_id, ..WriteOptions::default() };
    for extension in EXTENSIONS {
        let path = directory.join("mesh").with_extension(extension);
        check_output(&path).unwrap();
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

#[test]
fn other_programs_read_what_we_write() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    write_all(&at("cubes"), &cubes());
    write_all(&at("squares"), &squares());
    write_all(&at("empty-space"), &no_cells(3));
    write_all(&at("empty-plane"), &no_cells(2));
    let Some(python) = std::env::var_os("SEPTET_PYTHON") else {
        let required = std::env::var_os("SEPTET_REQUIRE_FOREIGN").is_some_and(|v| v == "1");
        assert!(
            !required,
            "SEPTET_REQUIRE_FOREIGN=1, but SEPTET_PYTHON names no Python interpreter; make one \
             with the packages vtk, meshio, gmsh and numpy"
        );
        return;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign/read_with_others.py");
    let output = Command::new(&python).arg(script).arg(directory.path()).output();
    let output = output.unwrap_or_else(|e| panic!("cannot run {}: {e}", python.display()));
    let said = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{complained}");
    let last = said.lines().last().unwrap_or_default();
    assert!(last.ends_with(" passed, 0 failed"), "{said}\n{complained}");
    println!("{said}");
}
