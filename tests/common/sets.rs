//! Point sets.

use glam::{DVec2, DVec3};
use septet_core::generate::{Kind, Request, generate};
use septet_core::model::Points;
use septet_geometry::point::Point;

/// Random numbers in `[0, 1)`.
pub struct Draw(u64);

impl Draw {
    /// From a seed.
    pub fn new(seed: u64) -> Self {
        Draw(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1)
    }

    /// The next word (xorshift64*).
    pub fn word(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// The next number.
    pub fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.word() >> 11) as usize % n
    }

    /// In random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }

    /// A point of the unit cube or square.
    pub fn point<P: Point>(&mut self) -> P {
        let mut p = P::splat(0.0);
        for i in 0..P::DIM {
            p.set_coord(i, self.unit());
        }
        p
    }
}

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

/// The integer points `0..sides` times `step`.
pub fn grid(sides: [usize; 3], step: f64) -> Vec<DVec3> {
    let [a, b, c] = sides;
    let at = |i: usize| DVec3::new((i % a) as f64, (i / a % b) as f64, (i / a / b) as f64) * step;
    (0..a * b * c).map(at).collect()
}

/// The integer points of a rectangle.
pub fn flat_grid(a: usize, b: usize) -> Vec<DVec2> {
    (0..a * b).map(|i| DVec2::new((i % a) as f64, (i / a) as f64)).collect()
}
