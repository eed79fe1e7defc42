//! The triangulation in memory: the adjacency within and across pieces.

use crate::common::sets::{plane, space};
use crate::common::{check, threaded};
use glam::DVec3;
use septet_core::generate::Kind;
use septet_core::spec::Workers;
use septet_core::{Neighbour, Outcome, simulate, triangulate};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

fn assert_symmetric_adjacency<P: Point>(run: &Outcome, workers: u32) {
    let corners = P::DIM + 1;
    let (mut hull, mut crossing, mut cells) = (0, 0, 0);
    let share = |rank: u32| &run.shares[rank as usize - 1];
    for own in &run.shares {
        cells += own.cell_count();
        for cell in 0..own.cell_count() {
            let ids: Vec<u64> = own.cell_ids(cell).collect();
            for slot in 0..corners {
                let (other, next) = match own.neighbour(cell, slot).unwrap() {
                    Neighbour::Hull => {
                        hull += 1;
                        continue;
                    }
                    Neighbour::Local(next) => (own, next as usize),
                    Neighbour::Remote { rank, cell } => (share(rank), cell as usize),
                };
                crossing += usize::from(other.rank != own.rank);
                let theirs: Vec<u64> = other.cell_ids(next).collect();
                assert_eq!(ids.iter().filter(|v| theirs.contains(v)).count(), P::DIM);
                assert!(!theirs.contains(&ids[slot]));
                let back = (0..corners).filter(|&s| match other.neighbour(next, s) {
                    Some(Neighbour::Local(at)) => other.rank == own.rank && at as usize == cell,
                    Some(Neighbour::Remote { rank, cell: at }) => rank == own.rank && at as usize == cell,
                    _ => false,
                });
                assert_eq!(back.count(), 1);
            }
        }
    }
    assert_eq!(hull, run.hull_facets);
    assert_eq!(crossing > 0, workers > 1);
    assert_eq!(cells * corners, run.cells().len());
}

/// A triangulation and a simulation have neighbours.
fn assert_adjacency<P: Point>(points: &[P], workers: u32) {
    let spec = threaded(Workers::Count(workers), 2, 40).with(|spec| spec.keep.neighbours = true);
    assert_symmetric_adjacency::<P>(&triangulate(points, &spec).unwrap(), workers);
    assert_symmetric_adjacency::<P>(&simulate(points, &spec).unwrap(), workers);
}

#[test]
fn adjacency_is_symmetric_in_space() {
    for workers in [1, 2, 5, 16] {
        assert_adjacency(&space(Kind::Uniform, 3000, 4), workers);
        assert_adjacency(&space(Kind::Grid, 1000, 4), workers);
    }
}

#[test]
fn adjacency_is_symmetric_in_the_plane() {
    for workers in [1, 2, 5, 16] {
        assert_adjacency(&plane(Kind::Clusters, 3000, 4), workers);
    }
}

/// Without a request, a simulation finds no neighbours, and sends no messages for them.
#[test]
fn a_simulation_has_neighbours_on_request() {
    let points = space(Kind::Uniform, 1000, 4);
    let spec = threaded(Workers::Count(4), 2, 40);
    let plain = simulate(&points, &spec).unwrap();
    assert!(plain.shares.iter().all(|share| !share.has_neighbours() && share.neighbour(0, 0).is_none()));
    let kept = simulate(&points, &spec.clone().with(|spec| spec.keep.neighbours = true)).unwrap();
    assert!(plain.cells() == kept.cells());
    assert!(sent(&kept, Phase::Collect) > sent(&plain, Phase::Collect));
    let others = |run: &Outcome| {
        run.ledger.phases.iter().filter(|p| p.phase != Phase::Collect).copied().collect::<Vec<_>>()
    };
    assert!(others(&kept) == others(&plain));
}

/// Bytes sent in a phase.
fn sent(run: &Outcome, phase: Phase) -> u64 {
    run.ledger.phases.iter().filter(|p| p.phase == phase).map(|p| p.bytes).sum()
}

/// The interface exchange sends at most `most` bytes per byte of the ghost layer. The subdomains are small.
fn assert_small_interface_exchange<P: Point>(points: &[P], most: f64) {
    let run = check(points, &threaded(Workers::Count(16), 2, 40));
    let (halo, seam) = (sent(&run, Phase::Halo), sent(&run, Phase::Seam));
    assert!(halo > 0 && seam > 0, "{halo} {seam}");
    // A worker that did not get a point would have to repair stars.
    assert_eq!(run.stars_repaired, 0);
    assert!((seam as f64) < most * halo as f64, "{halo} bytes of halos, {seam} of seams");
}

#[test]
fn most_ghosts_arrive_before_subdomains_are_triangulated() {
    assert_small_interface_exchange(&space(Kind::Uniform, 40_000, 4), 0.2);
    assert_small_interface_exchange(&space(Kind::WellSpaced, 4_000, 4), 0.7);
    assert_small_interface_exchange(&plane(Kind::Uniform, 40_000, 4), 0.15);
}

#[test]
fn a_distant_outlier_does_not_enlarge_the_ghost_layers() {
    let spec = threaded(Workers::Count(8), 2, 40);
    let mut points = space(Kind::Uniform, 40_000, 4);
    let usual = sent(&check(&points, &spec), Phase::Halo);
    points.push(DVec3::new(1e9, 0.0, 0.0));
    let stray = sent(&check(&points, &spec), Phase::Halo);
    assert!(stray < 2 * usual, "{stray} bytes of halos, {usual} without it");
}
