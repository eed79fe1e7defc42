//! The vertices of real surface meshes and scans.

use crate::common::{base, check, data};
use septet_core::model::Points;
use septet_core::spec::Workers;
use septet_core::triangulate;
use septet_geometry::point::Point;

fn one_and_five<P: Point>(name: &str, points: &[P]) {
    let alone = check(points, &base().with(|c| c.machine.workers = Workers::Count(1)));
    let five = base().with(|c| {
        c.machine.workers = Workers::Count(5);
        c.tree.leaf = Some(300);
    });
    let five = triangulate(points, &five).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(alone.cells() == five.cells(), "{name}: other cells with five workers");
    assert_eq!((&alone.fallback, &five.fallback), (&None, &None), "{name}");
    let (rounds, graph) = (five.exchange_rounds, five.settled.supergraph);
    println!("{name}: {} points, {} cells, {rounds} rounds, {graph:?}", points.len(), alone.cell_count());
}

#[test]
#[ignore = "needs the test data"]
fn five_workers_triangulate_meshes_and_scans_like_one() {
    for (name, points) in data::all() {
        match points {
            Points::Plane(points) => one_and_five(&name, &points),
            Points::Space(points) => one_and_five(&name, &points),
            Points::Higher(_) => unreachable!("the data are in the plane and in space"),
        }
    }
}
