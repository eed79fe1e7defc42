//! Heights of terrain, in every format.

use std::fs;
use std::path::Path;

use super::*;
use crate::format::Role;
use crate::read::{CellOptions, ReadOptions, read, read_cells};

/// Returns a mesh of squares, and heights that are awkward to print.
fn terrain() -> (Sample, Vec<f64>) {
    let mesh = squares(3);
    let heights = (0..mesh.coordinates.len() / 2).map(|i| 1e5 + (i * i) as f64 / 3.0).collect();
    (mesh, heights)
}

#[test]
fn every_format_holds_heights() {
    let (mesh, heights) = terrain();
    let view = MeshView { heights: Some(&heights), ..mesh.view() };
    let place = tempfile::tempdir().unwrap();
    let options = ReadOptions { terrain: true, ..ReadOptions::default() };
    let is_read = |name: &&&str| Format::of_path(Path::new(name)).unwrap().has(Role::Points);
    for name in NAMES.iter().filter(is_read).filter(|name| **name != "m.npy") {
        let path = place.path().join(name);
        write(&path, &view, &WriteOptions::default(), &mut |_, _| {}).unwrap();
        let found = read(&path, &options, &mut |_, _| {}).unwrap_or_else(|error| panic!("{name}: {error}"));
        if *name == "m.stl" {
            // An .stl file has the corners of triangles.
            assert!(found.heights.unwrap().iter().all(|height| heights.contains(height)), "{name}");
            continue;
        }
        assert_eq!(found.points.coordinates(), mesh.coordinates, "{name}");
        assert_eq!(found.heights.as_deref(), Some(&heights[..]), "{name}");
        let cells = if *name == "m.node" { place.path().join("m.ele") } else { path };
        if Format::of_path(&cells).unwrap().has(Role::Cells) {
            let cells = read_cells(&cells, &CellOptions::default(), &mut |_, _| {}).unwrap();
            assert_eq!((cells.dimension, &cells.cells), (2, &mesh.cells), "{name}");
        }
    }
}

#[test]
fn cells_alone_have_the_same_bytes() {
    let (mesh, heights) = terrain();
    let place = tempfile::tempdir().unwrap();
    let bytes = |name: &str, heights: Option<&[f64]>| {
        let path = place.path().join(name);
        let view = MeshView { heights, ..mesh.view() };
        write(&path, &view, &WriteOptions::default(), &mut |_, _| {}).unwrap();
        fs::read(&path).unwrap()
    };
    assert_eq!(bytes("a.npy", Some(&heights)), bytes("b.npy", None));
    assert_eq!(bytes("a.ele", Some(&heights)), bytes("b.ele", None));
    let zeros = vec![0.0; heights.len()];
    for format in ["vtu", "vtk", "off", "obj", "ply", "stl", "msh", "msh22"] {
        assert_eq!(
            bytes(&format!("a.{format}"), Some(&zeros)),
            bytes(&format!("b.{format}"), None),
            "{format}"
        );
    }
}

#[test]
fn normals_are_those_of_the_slopes() {
    let mut mesh = squares(1);
    mesh.cells.truncate(3);
    let heights: Vec<f64> = mesh.coordinates.chunks_exact(2).map(|point| point[0]).collect();
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("m.stl");
    let view = MeshView { heights: Some(&heights), owner: None, owning_leaf: None, ..mesh.view() };
    write(&path, &view, &WriteOptions::default(), &mut |_, _| {}).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let normal: Vec<f64> =
        text.lines().nth(1).unwrap().split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(normal[0] == -normal[2] && normal[1] == 0.0 && normal[2] > 0.7, "{normal:?}");
}

#[test]
fn heights_of_other_meshes_are_refused() {
    let (mesh, heights) = terrain();
    let solid = kuhn(1);
    let of_solid = vec![0.0; solid.coordinates.len() / 3];
    let place = tempfile::tempdir().unwrap();
    for (view, heights) in [(mesh.view(), &heights[1..]), (solid.view(), &of_solid[..])] {
        let view = MeshView { heights: Some(heights), ..view };
        let error = write(&place.path().join("m.vtu"), &view, &WriteOptions::default(), &mut |_, _| {});
        assert!(error.unwrap_err().to_string().contains("heights"));
    }
}

#[test]
fn heights_differ_from_those_of_the_first_points() {
    let mut left_out = septet_core::LeftOut::default();
    assert_eq!(left_out.height_difference(&[1.0], 0), None);
    left_out.duplicates = vec![(12, 10), (13, 11)];
    assert_eq!(left_out.height_difference(&[1.0, 4.0, 3.0, 4.5], 10), Some(2.0));
    assert_eq!(left_out.height_difference(&[1.0, 4.0, 3.0], 10), Some(2.0));
}
