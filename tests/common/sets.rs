//! Generated point sets.

use glam::{DVec2, DVec3};
use septet::generate::{Kind, Request, generate};
use septet::model::Points;

/// A generated set in either dimension.
fn generated(kind: Kind, n: u64, dimension: usize, seed: u64) -> Points {
    let request = Request { kind, n, dimension, seed, lipschitz: None };
    generate(&request, &mut |_, _, _| {}).unwrap_or_else(|e| panic!("{request:?}: {e}")).points
}

/// A generated set in space.
pub fn space(kind: Kind, n: u64, seed: u64) -> Vec<DVec3> {
    match generated(kind, n, 3, seed) {
        Points::Space(points) => points,
        Points::Plane(_) => unreachable!(),
    }
}

/// A generated set in the plane.
pub fn plane(kind: Kind, n: u64, seed: u64) -> Vec<DVec2> {
    match generated(kind, n, 2, seed) {
        Points::Plane(points) => points,
        Points::Space(_) => unreachable!(),
    }
}
