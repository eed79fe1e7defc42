//! The bytes of the outputs. `tests/system/parts.rs` compares the pieces with the cells and owners of a run, and the golden
//! test has the hashes of all files.

use glam::{DVec2, DVec3};
use septet_common::sets::{flat_grid, grid, plane, space};
use septet_core::generate::Kind;

use super::*;

/// The outputs of five workers have the owner and the leaf of each cell.
fn options(workers: u32) -> WriteOptions<'static> {
    WriteOptions { with_owner: workers == 5, ..WriteOptions::default() }
}

/// Writes the outputs of one process.
fn written_alone(points: &Points, workers: u32) -> BTreeMap<String, Vec<u8>> {
    let directory = tempfile::tempdir().unwrap();
    let run = alone(points, workers);
    for output in outputs(directory.path()) {
        let view = run.view(points.coordinates());
        crate::write::write(&output, &view, &options(workers), &mut |_, _| {}).unwrap();
    }
    files(directory.path())
}

/// Writes the outputs of several processes.
fn written_apart(points: &Points, workers: u32, count: u32) -> BTreeMap<String, Vec<u8>> {
    let directory = tempfile::tempdir().unwrap();
    let outputs = outputs(directory.path());
    let owns = apart(points, workers, count);
    let write = |processes: &mut Processes<'_>, own: &Own| {
        write_shared(processes, &outputs, &own.mesh(), &options(workers), &|| false)
    };
    let listed = ["m.npy", "m.pvtu", "m.pieces", "m.vtk", "m.vtu"].map(|name| directory.path().join(name));
    for files in on_each(&owns, write) {
        assert_eq!(files.unwrap(), listed);
    }
    files(directory.path())
}

/// Compares the outputs for each number of processes and workers.
fn same(what: &str, points: &Points) {
    for workers in [1, 5, 8] {
        let expected = written_alone(points, workers);
        assert!(expected.len() as u32 == 5 + workers);
        for count in [1, 2, 3, 5].into_iter().filter(|count| *count <= workers) {
            let found = written_apart(points, workers, count);
            let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
            assert_eq!(names(&found), names(&expected), "{what}");
            for (name, bytes) in &found {
                let is_same = *bytes == expected[name];
                assert!(is_same, "{name}: {what}, {workers} workers on {count} processes");
            }
        }
    }
}

/// Replaces 1 % of the points by copies of points at the other end of the input.
fn with_copies<P: Copy>(mut points: Vec<P>) -> Vec<P> {
    let count = points.len();
    for i in (0..count).step_by(100) {
        points[count - 1 - i] = points[i];
    }
    points
}

#[test]
fn uniform_points() {
    let owns = apart(&Points::Space(space(Kind::Uniform, 500, 3)), 8, 3);
    let mut shares = owns.iter().flat_map(|own| &own.run.shares);
    assert!(shares.all(|own| own.owned > 20 && own.owned < own.ids.len()), "every worker has ghosts");
    same("plane", &Points::Plane(plane(Kind::Uniform, 500, 3)));
    same("space", &Points::Space(space(Kind::Uniform, 500, 3)));
}

#[test]
fn ties() {
    same("plane", &Points::Plane(flat_grid(13, 11)));
    same("space", &Points::Space(grid([6, 5, 7], 0.1)));
}

#[test]
fn duplicates_are_points_of_the_grid() {
    same("plane", &Points::Plane(with_copies(plane(Kind::Uniform, 500, 5))));
    same("space", &Points::Space(with_copies(space(Kind::Uniform, 500, 5))));
}

#[test]
fn flat_and_collinear_points() {
    let lifted: Vec<DVec3> = plane(Kind::Uniform, 60, 1).iter().map(|p| p.extend(0.25)).collect();
    same("flat", &Points::Space(with_copies(lifted)));
    let on_line: Vec<DVec2> = (0..40).map(|i| DVec2::splat(f64::from(i * 7 % 40))).collect();
    same("collinear", &Points::Plane(with_copies(on_line.clone())));
    same("collinear", &Points::Space(on_line.iter().map(|p| p.extend(p.x)).collect()));
}

#[test]
fn few_points() {
    for count in 0..=5 {
        let what = format!("{count} points");
        same(&what, &Points::Plane(plane(Kind::Uniform, 5, 2)[..count].to_vec()));
        same(&what, &Points::Space(space(Kind::Uniform, 5, 2)[..count].to_vec()));
    }
    same("equal points", &Points::Plane(vec![DVec2::ONE; 4]));
}

/// Every cell has the vertex 0, so the smallest vertices do not divide the cells.
#[test]
fn one_vertex_of_all_cells() {
    let around = (0..200).map(|i| DVec2::from_angle(f64::from(i)));
    let points: Vec<DVec2> = std::iter::once(DVec2::ZERO).chain(around).collect();
    same("star", &Points::Plane(points));
}

/// Rows that are not finite are points of the grid, but of no piece.
#[test]
fn dropped_points() {
    for height in [0.0, 1.0] {
        let lift = |p: &DVec3| DVec3::new(p.x, p.y, p.z * height);
        let mut points: Vec<DVec3> = space(Kind::Uniform, 120, 6).iter().map(lift).collect();
        (points[0].x, points[70].z, points[119].y) = (f64::NAN, f64::INFINITY, f64::NAN);
        same("dropped", &Points::Space(points));
    }
}

/// Large coordinates are scaled in the run, and come back.
#[test]
fn scaled_coordinates() {
    let scaled = |factor: f64| space(Kind::Uniform, 100, 4).iter().map(|p| *p * factor).collect();
    for factor in [1e100, 1e-100] {
        same("scaled", &Points::Space(scaled(factor)));
    }
}
