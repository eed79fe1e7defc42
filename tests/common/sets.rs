//! Point sets.

use glam::{DVec2, DVec3};
use septet_core::generate::{Kind, Request, generate};
use septet_core::model::Points;
pub use septet_geometry::hash::Draw;

/// Returns a generated set in either dimension.
fn generated(kind: Kind, n: u64, dimension: usize, seed: u64) -> Points {
    let request = Request { kind, n, dimension, seed, lipschitz: None, ratio: None };
    generate(&request, &mut |_, _, _| {}).unwrap_or_else(|e| panic!("{request:?}: {e}")).points
}

/// Returns a generated set in space.
pub fn space(kind: Kind, n: u64, seed: u64) -> Vec<DVec3> {
    match generated(kind, n, 3, seed) {
        Points::Space(points) => points,
        Points::Plane(_) | Points::Higher(_) => unreachable!(),
    }
}

/// Returns a generated set in the plane.
pub fn plane(kind: Kind, n: u64, seed: u64) -> Vec<DVec2> {
    match generated(kind, n, 2, seed) {
        Points::Plane(points) => points,
        Points::Space(_) | Points::Higher(_) => unreachable!(),
    }
}

/// Returns the integer points `0..sides` times `step`.
pub fn grid(sides: [usize; 3], step: f64) -> Vec<DVec3> {
    let [a, b, c] = sides;
    let at = |i: usize| DVec3::new((i % a) as f64, (i / a % b) as f64, (i / a / b) as f64) * step;
    (0..a * b * c).map(at).collect()
}

/// Returns the integer points of a rectangle.
pub fn flat_grid(a: usize, b: usize) -> Vec<DVec2> {
    (0..a * b).map(|i| DVec2::new((i % a) as f64, (i / a) as f64)).collect()
}
