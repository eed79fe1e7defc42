//! Points with heights, in all formats.

use std::path::Path;

use super::*;
use crate::read::{read_from, read_mesh};

const TERRAIN: ReadOptions = ReadOptions {
    dimension: None,
    format: None,
    raw: None,
    skip_invalid: false,
    columns: None,
    keep_columns: false,
    terrain: true,
    weights: None,
};

fn terrain(name: &str, data: &str, options: &ReadOptions) -> Result<PointFile, InputError> {
    read_from(data.as_bytes(), Path::new(name), None, options, &mut |_, _| {})
}

/// Returns the coordinates in the plane and the heights.
fn places(file: &PointFile) -> (Vec<f64>, Vec<f64>) {
    assert_eq!(file.points.dimension(), 2);
    (file.points.coordinates().to_vec(), file.heights.clone().unwrap())
}

#[test]
fn heights_leave_the_points() {
    let grid = "ncols 2\nnrows 1\ncellsize 2\n7 8\n";
    for (name, text) in [
        ("a.xyz", "1 1 7\n3 1 8\n"),
        ("a.csv", "height,latitude,longitude\n7,1,1\n8,1,3\n"),
        ("a.csv", "x,y,mass,elevation [m]\n1,1,2,7\n3,1,2,8\n"),
        ("a.obj", "v 1 1 7\nv 3 1 8\n"),
        ("a.off", "OFF 2 0 0\n1 1 7\n3 1 8\n"),
        ("a.node", "2 3 0 0\n1 1 1 7\n2 3 1 8\n"),
        ("a.node", "2 2 1 0\n1 1 1 7\n2 3 1 8\n"),
        ("a.node", "2 2 2 1\n0 1 1 7 5 1\n1 3 1 8 5 1\n"),
        ("a.asc", grid),
        ("-", grid),
    ] {
        let file = terrain(name, text, &TERRAIN).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(places(&file), (vec![1.0, 1.0, 3.0, 1.0], vec![7.0, 8.0]), "{name}");
        let plane = ReadOptions { dimension: Some(2), ..TERRAIN };
        assert_eq!(terrain(name, text, &plane).unwrap(), file, "{name}");
    }
    // Without the option, points have no heights.
    assert_eq!(good("a.xyz", "1 1 7\n3 1 8\n").heights, None);
}

#[test]
fn points_without_heights_are_refused() {
    for (name, text) in [
        ("a.xyz", "1 1\n3 1\n"),
        ("a.node", "2 2 0 1\n1 1 1 0\n2 3 1 0\n"),
        ("a.mesh", "MeshVersionFormatted 2\nDimension 2\nVertices\n1\n1 1 0\nEnd\n"),
    ] {
        let error = terrain(name, text, &TERRAIN).unwrap_err();
        assert!(matches!(error, InputError::NoHeights { .. }), "{name}: {error}");
        assert_eq!(error.exit_code() as u8, 3);
        assert!(error.to_string().contains("no z"), "{error}");
    }
    let named = terrain("a.csv", "x,y,depth\n1,1,7\n", &TERRAIN).unwrap_err();
    assert!(named.to_string().contains("names no z") && named.is_usage(), "{named}");
    let chosen = |columns: &str| {
        let columns = Some(columns.split(',').map(str::to_owned).collect());
        terrain("a.csv", "x,y,depth\n1,1,7\n", &ReadOptions { columns, ..TERRAIN })
    };
    assert_eq!(places(&chosen("x,y,depth").unwrap()), (vec![1.0, 1.0], vec![7.0]));
    assert!(chosen("x,y").unwrap_err().to_string().contains("2 columns instead of 3"));
    // Columns without names are not guessed.
    for text in ["1 2 3 4\n5 6 7 9\n", "0 0.5 2\n1 1.5 3\n2 2.5 4\n"] {
        let error = terrain("a.xyz", text, &TERRAIN).unwrap_err();
        assert!(matches!(error, InputError::Columns { .. }), "{error}");
    }
    let space = ReadOptions { dimension: Some(3), ..TERRAIN };
    let error = terrain("a.xyz", "1 1 7\n", &space).unwrap_err();
    assert!(matches!(error, InputError::TerrainInSpace { .. }) && error.is_usage(), "{error}");
}

#[test]
fn invalid_heights_are_invalid_points() {
    let text = "x,y,z,t\n1,1,7,1\n2,1,nan,2\n2,1,,3\n3,1,8,4\n";
    assert!(matches!(terrain("a.csv", text, &TERRAIN), Err(InputError::NotFinite { .. })));
    let options = ReadOptions { skip_invalid: true, keep_columns: true, ..TERRAIN };
    let file = terrain("a.csv", text, &options).unwrap();
    assert_eq!(places(&file), (vec![1.0, 1.0, 3.0, 1.0], vec![7.0, 8.0]));
    assert_eq!((file.skipped, file.source_index), (2, Some(vec![0, 3])));
    assert_eq!(file.columns[0].values, [1.0, 4.0]);
}

#[test]
fn the_faces_of_a_surface_are_cells() {
    let read = |text: &str, options: &CellOptions| cell_list(Path::new("a.obj"), text.as_bytes(), options);
    let vertices = "v 0 0 1\nv 1 0 2\nv 0 1 3\nv 1 1 4\n";
    let cells = read(&format!("{vertices}f 1 2 3\nf 2//1 4//1 -2\n"), &CellOptions::default()).unwrap();
    assert_eq!((cells.dimension, cells.cells), (2, vec![0, 1, 2, 1, 3, 2]));
    let square = read(&format!("{vertices}f 1 2 4 3\n"), &CellOptions::default()).unwrap_err();
    assert!(square.to_string().contains("4 corners"), "{square}");
    assert_eq!(square.line(), Some(5));
    for options in [CellOptions::default(), CellOptions { point_count: Some(4), ..CellOptions::default() }] {
        let error = read(&format!("{vertices}f 1 2 3\nf 1 2 5\n"), &options).unwrap_err();
        assert!(
            matches!(error, InputError::OutOfRangeIndex { value: 5, first: 1, limit: Some(4), cell: 1, .. }),
            "{error}"
        );
        assert_eq!(error.line(), Some(6));
    }
}

#[test]
fn one_file_has_points_heights_and_cells() {
    let folder = tempfile::tempdir().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 5\n1 0 6\n0 1 7\n3 0 1 2\n";
    for (name, text) in [
        ("a.obj", "v 0 0 5\nv 1 0 6\nv 0 1 7\nf 1 2 3\n"),
        ("a.off", "OFF 3 1 0\n0 0 5\n1 0 6\n0 1 7\n3 0 1 2\n"),
        ("a.ply", ply),
        (
            "a.mesh",
            "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 5 0\n1 0 6 0\n0 1 7 0\nTriangles\n1\n1 2 3 0\nEnd\n",
        ),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let (points, cells) = read_mesh(&path, &TERRAIN, &mut |_, _| {}).unwrap();
        assert_eq!(places(&points), (vec![0.0, 0.0, 1.0, 0.0, 0.0, 1.0], vec![5.0, 6.0, 7.0]), "{name}");
        assert_eq!((cells.dimension, cells.cells), (2, vec![0, 1, 2]), "{name}");
        let (points, cells) = read_mesh(&path, &PLAIN, &mut |_, _| {}).unwrap();
        assert_eq!((points.points.dimension(), points.heights, cells.dimension), (3, None, 2), "{name}");
        let solid = ReadOptions { dimension: Some(3), ..TERRAIN };
        let refused = read_mesh(&path, &solid, &mut |_, _| {});
        assert!(matches!(refused, Err(InputError::TerrainInSpace { .. })), "{name}");
    }
}

#[test]
fn flat_terrain_has_no_note() {
    let file = terrain("a.obj", "v 1 1 0\nv 3 1 0\n", &TERRAIN).unwrap();
    assert!(file.notes.is_empty(), "{:?}", file.notes);
}
