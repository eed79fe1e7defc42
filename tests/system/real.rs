//! The vertices of real surface meshes and scans.

use crate::common::{base, check, data};
use septet::config::Workers;
use septet::geometry::point::Point;
use septet::model::Points;
use septet::{Config, triangulate};

fn one_and_five<P: Point>(name: &str, points: &[P]) {
    let alone = check(points, &Config { workers: Workers::Count(1), ..base() });
    let five = Config { workers: Workers::Count(5), leaf: Some(300), ..base() };
    let five = triangulate(points, &five).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(alone.cells() == five.cells(), "{name}: other cells with five workers");
    assert_eq!((&alone.fallback, &five.fallback), (&None, &None), "{name}");
    let (rounds, graph) = (five.exchange_rounds, five.settled.supergraph);
    println!("{name}: {} points, {} cells, {rounds} rounds, {graph:?}", points.len(), alone.cell_count());
}

#[test]
fn meshes_and_scans() {
    for (name, points) in data::all() {
        match points {
            Points::Plane(points) => one_and_five(&name, &points),
            Points::Space(points) => one_and_five(&name, &points),
        }
    }
}
