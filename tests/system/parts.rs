//! The pieces of a `.pvtu` file: the parts of a triangulation that the workers hold.

use std::collections::BTreeMap;
use std::fs;

use glam::DVec3;
use septet_core::generate::Kind;
use septet_core::spec::{Spec, Transport, Workers};
use septet_core::{Outcome, simulate, triangulate};
use septet_geometry::point::Point;
use septet_io::write::{WriteOptions, write};

use crate::common::sets::{plane, space};
use crate::common::transports::each_transport;
use crate::common::{coordinates, with_workers};

fn keeping(workers: u32) -> Spec {
    with_workers(Workers::Count(workers), 60).with(|c| c.keep.owner = true)
}

/// The content of a piece. Points and cells of the worker come first.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    dimension: usize,
    owned_points: usize,
    owned_cells: usize,
    point_ids: Vec<u64>,
    /// Three coordinates per point.
    coordinates: Vec<f64>,
    cells: Vec<u64>,
    cell_ids: Vec<u64>,
    owner: Vec<u32>,
}

impl Part {
    /// Reads a piece, in which arrays are in the order of their declarations with the length before each.
    fn read(file: &[u8], dimension: usize) -> Self {
        let marker = b"encoding=\"raw\">\n   _";
        let start = file.windows(marker.len()).position(|bytes| bytes == marker).unwrap() + marker.len();
        let head = String::from_utf8_lossy(&file[..start]);
        let arrays: Vec<(&str, &[u8])> = head
            .lines()
            .filter(|line| line.contains("<DataArray"))
            .map(|line| {
                let value = |name: &str| line.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next();
                let at = start + value("offset").unwrap().parse::<usize>().unwrap();
                let length = u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
                (value("Name").unwrap(), &file[at + 8..at + 8 + length])
            })
            .collect();
        let named = |name: &str| {
            arrays.iter().filter(|(own, _)| *own == name).map(|(_, bytes)| *bytes).collect::<Vec<_>>()
        };
        let words = |name: &str| -> Vec<u64> {
            named(name)[0].chunks_exact(8).map(|word| u64::from_le_bytes(word.try_into().unwrap())).collect()
        };
        let owned = |types: &[u8]| {
            assert!(types.is_sorted() && types.iter().all(|kind| *kind <= 1));
            types.partition_point(|kind| *kind == 0)
        };
        let types = named("vtkGhostType");
        let owner = named("owner").concat();
        Part {
            dimension,
            owned_points: owned(types[0]),
            owned_cells: owned(types[1]),
            point_ids: words("GlobalPointIds"),
            coordinates: words("Points").into_iter().map(f64::from_bits).collect(),
            cells: words("connectivity"),
            cell_ids: words("GlobalCellIds"),
            owner: owner.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect(),
        }
    }
}

fn parts_of<P: Point>(points: &[P], run: &Outcome) -> Vec<Part> {
    let directory = tempfile::tempdir().unwrap();
    let coordinates = coordinates(points);
    let options = WriteOptions { with_owner: true, ..WriteOptions::default() };
    write(&directory.path().join("m.pvtu"), &run.view(&coordinates), &options, &mut |_, _| {}).unwrap();
    let piece = |worker: u32| fs::read(directory.path().join(format!("m.pieces/{:04}.vtu", worker - 1)));
    (1..=run.settled.workers).map(|worker| Part::read(&piece(worker).unwrap(), P::DIM)).collect()
}

/// The cells of a part as rows of input indices.
fn rows(part: &Part) -> Vec<Vec<u64>> {
    let row = |row: &[u64]| row.iter().map(|&v| part.point_ids[v as usize]).collect();
    part.cells.chunks_exact(part.dimension + 1).map(row).collect()
}

/// Checks the parts of a run against its cells and owners.
fn assert_parts<P: Point>(points: &[P], run: &Outcome, workers: u32) {
    let parts = parts_of(points, run);
    assert_eq!(parts.len(), workers as usize);
    let whole: Vec<&[u64]> = run.cells().chunks_exact(P::DIM + 1).collect();
    let owners = run.owner().unwrap();
    let point_owner = run.point_owner().unwrap();
    let (mut owned, mut number_of) = (Vec::<u64>::new(), BTreeMap::new());
    let mut ids: Vec<u64> = Vec::new();
    for (worker, part) in (1..).zip(&parts) {
        ids.extend(&part.point_ids[..part.owned_points]);
        assert!(part.point_ids[..part.owned_points].iter().all(|&p| point_owner[p as usize] == worker));
        let ascends = |ids: &[u64]| ids.is_sorted_by(|a, b| a < b);
        let (own, ghosts) = part.point_ids.split_at(part.owned_points);
        assert!(ascends(own) && ascends(ghosts));
        let rows = rows(part);
        let (own, ghosts) = rows.split_at(part.owned_cells);
        assert!(own.is_sorted() && ghosts.is_sorted());
        // The machine gives the same cells to the worker.
        let expected = whole.iter().zip(owners).filter(|(_, owner)| **owner == worker);
        assert!(expected.map(|(row, _)| row.to_vec()).eq(own.iter().cloned()));
        // All cells of its points, and no others.
        let touches = |row: &&&[u64]| row.iter().any(|&v| point_owner[v as usize] == worker);
        let mut all = rows.clone();
        all.sort();
        let mut expected: Vec<Vec<u64>> = whole.iter().filter(touches).map(|row| row.to_vec()).collect();
        expected.sort();
        assert_eq!(all, expected);
        // Every ghost point is a vertex of a cell.
        let mut used = part.cells.clone();
        used.sort_unstable();
        used.dedup();
        assert!((part.owned_points..part.point_ids.len()).all(|at| used.binary_search(&(at as u64)).is_ok()));
        let of_row = |row: &Vec<u64>| owners[whole.binary_search(&&row[..]).unwrap()];
        assert!(part.owner.iter().copied().eq(rows.iter().map(of_row)));
        for (number, row) in part.cell_ids.iter().zip(&rows) {
            assert_eq!(number_of.entry(row.clone()).or_insert(*number), number);
        }
        owned.extend(&part.cell_ids[..part.owned_cells]);
        for (at, &point) in part.point_ids.iter().enumerate() {
            let own = &part.coordinates[at * 3..(at + 1) * 3];
            assert!((0..P::DIM).all(|i| own[i] == points[point as usize].coord(i)));
        }
    }
    assert_eq!(owned, (0..whole.len() as u64).collect::<Vec<_>>());
    ids.sort_unstable();
    let set_aside = |p: &u64| run.left_out.duplicates.iter().any(|(again, _)| again == p);
    assert!(ids.into_iter().eq((0..points.len() as u64).filter(|p| !set_aside(p))));
}

fn assert_divided<P: Point>(points: &[P], workers: u32) {
    let spec = keeping(workers);
    assert_parts(points, &triangulate(points, &spec).unwrap(), workers);
    assert_parts(points, &simulate(points, &spec).unwrap(), workers);
}

#[test]
fn every_point_and_cell_is_in_the_part_of_its_worker() {
    for workers in [1, 3, 8] {
        assert_divided(&space(Kind::Uniform, 2000, 4), workers);
        assert_divided(&plane(Kind::Clusters, 1500, 4), workers);
    }
    let mut twice = space(Kind::Grid, 343, 4);
    twice.extend_from_within(..100);
    assert_divided(&twice, 4);
}

#[test]
fn workers_without_points_have_empty_parts() {
    let points = space(Kind::Uniform, 7, 4);
    assert_divided(&points, 8);
    let run = triangulate(&points, &keeping(8)).unwrap();
    let empty = parts_of(&points, &run).iter().filter(|part| part.point_ids.is_empty()).count();
    assert!(empty > 0);
}

/// Points that do not span the space are not divided.
#[test]
fn points_without_cells_are_in_the_first_part() {
    let points: Vec<DVec3> = [0.0, 1.0, 1.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
    let run = triangulate(&points, &keeping(3)).unwrap();
    let found: Vec<Vec<u64>> = parts_of(&points, &run).into_iter().map(|part| part.point_ids).collect();
    assert_eq!(found, [vec![0, 1, 3], vec![], vec![]]);
}

#[test]
fn parts_are_equal_over_every_transport() {
    let points = space(Kind::Uniform, 1500, 5);
    for counted in [false, true] {
        let mut reference = None;
        each_transport(|start| {
            let run = start.run(&points, &keeping(5), counted).unwrap();
            let parts = parts_of(&points, &run);
            assert!(*reference.get_or_insert_with(|| parts.clone()) == parts, "{start:?}");
        });
    }
    let with = |change: &dyn Fn(&mut Spec)| {
        let spec = keeping(5).with(|c| change(c));
        parts_of(&points, &triangulate(&points, &spec).unwrap())
    };
    let expected = with(&|c| c.machine.threads = Some(1));
    assert!(with(&|c| c.machine.threads = Some(2)) == expected);
    assert!(with(&|c| c.machine.transport = Transport::Sim { delivery_seed: 3 }) == expected);
}
