//! Queries against brute force: exact integers on grids, and definitions.

mod alpha;
mod clipped;
mod images;
mod linear;
mod locate;
mod natural;
mod power;
mod rows;
mod voronoi;

use septet_core::spec::Workers;
use septet_core::{Outcome, Spec, triangulate};
use septet_geometry::coordinates::Coordinates;
use septet_geometry::hash::mix;

use crate::{Dimension, Tessellation};

/// Triangulates points on some workers.
fn run<P: Dimension + Coordinates>(points: &[P], workers: u32) -> Outcome {
    let mut spec = Spec::default();
    spec.machine.workers = Workers::Count(workers);
    triangulate(points, &spec).unwrap()
}

fn made<P: Dimension + Coordinates>(points: &[P]) -> Tessellation<P> {
    Tessellation::new(points, &run(points, 1 + points.len() as u32 % 3)).unwrap()
}

/// Random whole numbers below `most`.
struct Draw(u64);

impl Draw {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = mix(self.0, 0x9E37_79B9_7F4A_7C15);
        (self.0 >> 11) % most
    }

    /// A random number from 0 to 1.
    fn unit(&mut self) -> f64 {
        self.below(1 << 53) as f64 / (1u64 << 53) as f64
    }

    fn point<P: Dimension>(&mut self, mut f: impl FnMut(&mut Self) -> f64) -> P {
        let mut p = P::default();
        (0..P::DIM).for_each(|i| p.set_coord(i, f(self)));
        p
    }

    /// Random points of a grid with a side of `side` steps, with coincident ones.
    fn grid<P: Dimension>(&mut self, n: usize, side: u64) -> Vec<P> {
        (0..n).map(|_| self.point(|draw| draw.below(side) as f64)).collect()
    }

    /// Random points of the unit cube.
    fn uniform<P: Dimension>(&mut self, n: usize) -> Vec<P> {
        (0..n).map(|_| self.point(Draw::unit)).collect()
    }
}

/// All points of a grid.
fn whole_grid<P: Dimension>(side: u64) -> Vec<P> {
    let point = |i: u64| {
        let mut p = P::default();
        (0..P::DIM).for_each(|axis| p.set_coord(axis, (i / side.pow(axis as u32) % side) as f64));
        p
    };
    (0..side.pow(P::DIM as u32)).map(point).collect()
}

/// Whole points at the distance 5 or 15 from the origin: many are cospherical.
fn spheres<P: Dimension>() -> Vec<P> {
    let mut points = Vec::new();
    for i in 0..31i32.pow(P::DIM as u32) {
        let mut p = P::default();
        (0..P::DIM).for_each(|axis| p.set_coord(axis, f64::from(i / 31i32.pow(axis as u32) % 31 - 15)));
        if [25.0, 225.0].contains(&p.norm2()) {
            points.push(p);
        }
    }
    points
}

/// Sets of points with whole coordinates below 100, with ties of all kinds.
fn whole_sets<P: Dimension + Coordinates>() -> Vec<Vec<P>> {
    let mut draw = Draw(7);
    let mut sets = vec![whole_grid(4), spheres()];
    sets.extend([(5, 3), (12, 3), (40, 4), (60, 8), (60, 60)].map(|(n, side)| draw.grid(n, side)));
    sets.retain(|set| run(set, 1).dimension == P::DIM as isize);
    sets
}

/// The coordinates times two as integers; 0 in the third place in the plane.
fn twice<P: Dimension>(p: P) -> [i128; 3] {
    std::array::from_fn(|i| if i < P::DIM { (2.0 * p.coord(i)) as i128 } else { 0 })
}

/// The exact orientation of points at halves of whole numbers.
fn orientation<P: Dimension>(cell: &[P]) -> i128 {
    let at: Vec<[i128; 3]> = cell.iter().map(|&p| twice(p)).collect();
    let rel = |i: usize| -> [i128; 3] { std::array::from_fn(|k| at[i][k] - at[0][k]) };
    let (a, b) = (rel(1), rel(2));
    if P::DIM == 2 {
        return a[0] * b[1] - a[1] * b[0];
    }
    let c = rel(3);
    c[0] * (a[1] * b[2] - a[2] * b[1])
        + c[1] * (a[2] * b[0] - a[0] * b[2])
        + c[2] * (a[0] * b[1] - a[1] * b[0])
}

/// The corners of a cell, and the corners with one replaced.
fn corners<P: Dimension>(t: &Tessellation<P>, cell: usize) -> Vec<P> {
    t.cells()[cell].as_ref().iter().map(|&v| t.point(v)).collect()
}

fn replaced<P: Dimension>(mut cell: Vec<P>, slot: usize, q: P) -> Vec<P> {
    cell[slot] = q;
    cell
}

/// A linear function.
fn linear<P: Dimension>(p: P) -> f64 {
    (0..P::DIM).map(|i| (i as f64 + 0.7) * p.coord(i)).sum::<f64>() - 0.3
}

/// Calls a test in both dimensions.
macro_rules! both {
    ($plane:ident, $space:ident, $test:ident) => {
        #[test]
        fn $plane() {
            $test::<glam::DVec2>();
        }
        #[test]
        fn $space() {
            $test::<glam::DVec3>();
        }
    };
}
use both;
