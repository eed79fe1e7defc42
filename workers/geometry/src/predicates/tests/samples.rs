//! Calls that are difficult in different ways. Each is a cell and a query, as `DIM + 2` points.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::point::Point;
use crate::predicates::Sign;
use crate::range::{HIGHEST, LOWEST};

/// Kinds of calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Random in the unit cube.
    Random,
    /// On a sphere, rounded, and moved by up to two units in the last place of each coordinate.
    Cospherical,
    /// On a plane (a line), rounded, and moved by up to two units in the last place of each coordinate.
    Coplanar,
    /// Small integers.
    Grid,
    /// Integers of up to 20 bits, far from the origin.
    FarGrid,
    /// Multiples of a tenth, rounded.
    Decimal,
    /// Numbers of 24 bits.
    Single,
    /// Points near each other, whose exponents spread over many values.
    Spread,
    /// Any exponents that the range admits.
    Wild,
    /// Small multiples of the lowest bit that the range admits.
    Lowest,
    /// Cospherical at the top of the range.
    Highest,
}

pub const KINDS: [Kind; 11] = [
    Kind::Random,
    Kind::Cospherical,
    Kind::Coplanar,
    Kind::Grid,
    Kind::FarGrid,
    Kind::Decimal,
    Kind::Single,
    Kind::Spread,
    Kind::Wild,
    Kind::Lowest,
    Kind::Highest,
];

pub struct Samples {
    rng: ChaCha8Rng,
}

/// `2^e` for normal exponents.
pub fn two_to(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
}

impl Samples {
    pub fn new(seed: u64) -> Self {
        Samples { rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    pub fn unit(&mut self) -> f64 {
        self.rng.random()
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.rng.random_range(0..n)
    }

    fn signed(&mut self) -> f64 {
        self.unit() * 2.0 - 1.0
    }

    fn point<P: Point>(&mut self, mut coordinate: impl FnMut(&mut Self) -> f64) -> P {
        let mut p = P::default();
        for i in 0..P::DIM {
            p.set_coord(i, coordinate(self) + 0.0);
        }
        p
    }

    fn direction<P: Point>(&mut self) -> P {
        loop {
            let p: P = self.point(Self::signed);
            if p.norm2() > 0.01 && p.norm2() <= 1.0 {
                return p / p.norm2().sqrt();
            }
        }
    }

    /// Moves every coordinate by up to two units in the last place.
    fn nudged<P: Point>(&mut self, mut p: P) -> P {
        for i in 0..P::DIM {
            for _ in 0..self.below(3) {
                p.set_coord(
                    i,
                    if self.below(2) == 0 { p.coord(i).next_up() } else { p.coord(i).next_down() },
                );
            }
            p.set_coord(i, p.coord(i) + 0.0);
        }
        p
    }

    fn wild(&mut self) -> f64 {
        let lowest = LOWEST + 53;
        let exponent = lowest + self.below((HIGHEST - lowest) as u64) as i32;
        (self.signed() * two_to(53)).trunc() * two_to(exponent - 53)
    }

    fn points<P: Point>(&mut self, kind: Kind) -> Vec<P> {
        let n = P::DIM + 2;
        match kind {
            Kind::Random => (0..n).map(|_| self.point(Self::unit)).collect(),
            Kind::Cospherical | Kind::Highest => {
                let centre: P = self.point(Self::unit);
                // Small spheres far from the origin have few digits; large ones have many.
                let radius = two_to(-(self.below(20) as i32));
                let factor = if kind == Kind::Highest { two_to(HIGHEST - 2) } else { 1.0 };
                let scaled = |p: P| p * factor;
                (0..n)
                    .map(|_| {
                        let p = centre + self.direction::<P>() * radius;
                        scaled(self.nudged(p))
                    })
                    .collect()
            }
            Kind::Coplanar => {
                let (o, u, v): (P, P, P) = (self.point(Self::unit), self.direction(), self.direction());
                // In the plane, the points are collinear.
                let v = if P::DIM == 2 { u } else { v };
                (0..n)
                    .map(|_| {
                        let p = o + u * self.signed() + v * self.signed();
                        self.nudged(p)
                    })
                    .collect()
            }
            Kind::Grid => (0..n).map(|_| self.point(|s| s.below(4) as f64)).collect(),
            Kind::FarGrid => {
                let (bits, far) = (self.below(20) + 1, self.below(1 << 32) as f64);
                (0..n).map(|_| self.point(|s| far + s.below(1 << bits) as f64)).collect()
            }
            Kind::Decimal => (0..n).map(|_| self.point(|s| s.below(5) as f64 * 0.1)).collect(),
            Kind::Single => (0..n).map(|_| self.point(|s| f64::from(s.signed() as f32))).collect(),
            Kind::Spread => {
                let depth = self.below(70) as i32;
                (0..n)
                    .map(|_| {
                        self.point(|s| {
                            let e = s.below(depth as u64 + 1) as i32;
                            s.signed() * two_to(-e)
                        })
                    })
                    .collect()
            }
            Kind::Wild => (0..n).map(|_| self.point(Self::wild)).collect(),
            Kind::Lowest => {
                let top = self.below(6) + 2;
                (0..n).map(|_| self.point(|s| (s.below(top) as f64 - 2.0) * two_to(LOWEST))).collect()
            }
        }
    }

    /// Returns a cell and a query of distinct points. The cell is positive unless it is flat.
    pub fn call<P: Point>(&mut self, kind: Kind) -> (Vec<P>, P) {
        loop {
            let mut cell: Vec<P> = self.points(kind);
            let distinct = (0..cell.len()).all(|i| !cell[..i].contains(&cell[i]));
            if !distinct {
                continue;
            }
            let q = cell.pop().expect("DIM + 2 points");
            if super::exact::orientation(&cell) == Sign::Negative {
                cell.swap(0, 1);
            }
            return (cell, q);
        }
    }
}
