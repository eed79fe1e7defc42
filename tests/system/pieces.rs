//! The triangulation in memory: pieces whose adjacency is whole within and across.

use crate::common::sets::{plane, space};
use crate::common::threaded;
use septet::config::Workers;
use septet::generate::Kind;
use septet::geometry::point::Point;
use septet::triangulate;

fn adjacency_is_whole<P: Point>(points: &[P], workers: u32) {
    let config = threaded(Workers::Count(workers), 2, 40);
    let run = triangulate(points, &config).unwrap();
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
fn in_space() {
    for workers in [1, 2, 5, 16] {
        adjacency_is_whole(&space(Kind::Uniform, 3000, 4), workers);
        adjacency_is_whole(&space(Kind::Grid, 1000, 4), workers);
    }
}

#[test]
fn in_the_plane() {
    for workers in [1, 2, 5, 16] {
        adjacency_is_whole(&plane(Kind::Clusters, 3000, 4), workers);
    }
}
