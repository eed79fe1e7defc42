//! The parts of a triangulation that the workers hold.

use std::collections::BTreeMap;

use glam::DVec3;
use septet_core::generate::Kind;
use septet_core::result::part::{Division, Part};
use septet_core::spec::{Spec, Transport, Workers};
use septet_core::{Outcome, TrafficTotal, simulate, triangulate};
use septet_geometry::point::Point;

use crate::common::sets::{plane, space};
use crate::common::transports::each_transport;
use crate::common::{coordinates, with_workers};

fn keeping(workers: u32) -> Spec {
    with_workers(Workers::Count(workers), 60).with(|c| {
        c.keep.owner = true;
        c.keep.point_owner = true;
    })
}

fn parts_of<P: Point>(points: &[P], run: &Outcome) -> Vec<Part> {
    let coordinates = coordinates(points);
    let division = Division::new(run.view(&coordinates)).unwrap();
    (1..=division.workers()).map(|worker| division.part(worker)).collect()
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
        for (number, row) in part.cell_ids.iter().zip(&rows) {
            assert_eq!(number_of.entry(row.clone()).or_insert(*number), number);
        }
        owned.extend(&part.cell_ids[..part.owned_cells]);
        for (at, &point) in part.point_ids.iter().enumerate() {
            let own = &part.coordinates[at * P::DIM..(at + 1) * P::DIM];
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

/// The workers of points stay with their ranks until the caller joins the shares.
#[test]
fn owners_of_points_send_no_messages() {
    let points = space(Kind::Uniform, 1500, 5);
    for counted in [false, true] {
        let run = |spec: &Spec| {
            if counted { simulate(&points, spec).unwrap() } else { triangulate(&points, spec).unwrap() }
        };
        let plain = run(&keeping(5).with(|c| c.keep.point_owner = false));
        let kept = run(&keeping(5));
        assert!(kept.point_owner().is_some() && plain.point_owner() == kept.point_owner());
        assert_eq!(TrafficTotal::of(&kept.ledger), TrafficTotal::of(&plain.ledger));
    }
}
