//! The triangulation in memory: the adjacency within and across pieces.

use crate::common::sets::{plane, space};
use crate::common::{check, threaded};
use glam::DVec3;
use septet_core::generate::Kind;
use septet_core::spec::Workers;
use septet_core::triangulate;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

fn assert_symmetric_adjacency<P: Point>(points: &[P], workers: u32) {
    let spec = threaded(Workers::Count(workers), 2, 40);
    let run = triangulate(points, &spec).unwrap();
    let pieces = run.pieces().unwrap();
    let corners = P::DIM + 1;
    let (mut hull, mut crossing) = (0, 0);
    for (at, piece) in (0u32..).zip(pieces.pieces()) {
        for cell in 0..(piece.rows.len() / (2 * corners)) as u32 {
            let own: Vec<u64> = pieces.cell(at, cell).collect();
            for slot in 0..corners {
                let Some((other, next)) = pieces.neighbour(at, cell, slot) else {
                    hull += 1;
                    continue;
                };
                crossing += usize::from(other != at);
                let theirs: Vec<u64> = pieces.cell(other, next).collect();
                assert_eq!(own.iter().filter(|v| theirs.contains(v)).count(), P::DIM);
                assert!(!theirs.contains(&own[slot]));
                let back = (0..corners).filter(|&s| pieces.neighbour(other, next, s) == Some((at, cell)));
                assert_eq!(back.count(), 1);
            }
        }
    }
    assert_eq!(hull, run.hull_facets);
    assert_eq!(crossing > 0, workers > 1);
    assert_eq!(pieces.len() * corners, run.cells().len());
}

#[test]
fn adjacency_is_symmetric_in_space() {
    for workers in [1, 2, 5, 16] {
        assert_symmetric_adjacency(&space(Kind::Uniform, 3000, 4), workers);
        assert_symmetric_adjacency(&space(Kind::Grid, 1000, 4), workers);
    }
}

#[test]
fn adjacency_is_symmetric_in_the_plane() {
    for workers in [1, 2, 5, 16] {
        assert_symmetric_adjacency(&plane(Kind::Clusters, 3000, 4), workers);
    }
}

/// Bytes sent in a phase.
fn sent(run: &septet_core::Run, phase: Phase) -> u64 {
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
