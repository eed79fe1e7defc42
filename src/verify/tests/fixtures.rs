//! Meshes for the tests.

use std::cmp::Ordering;

use num_bigint::BigInt;

use crate::{Fault, Report, Sites, Triangulation, VerifyOptions, verify};

/// A mesh that owns its arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    pub dimension: usize,
    pub coordinates: Vec<f64>,
    pub cells: Vec<u64>,
    pub weights: Option<Vec<f64>>,
}

impl Mesh {
    pub fn new<const D: usize, const N: usize>(points: &[[f64; D]], cells: &[[u64; N]]) -> Self {
        let (coordinates, cells) = (points.as_flattened().to_vec(), cells.as_flattened().to_vec());
        Self { dimension: D, coordinates, cells, weights: None }
    }

    pub fn view(&self) -> Sites<'_> {
        let (coordinates, cells) = (&self.coordinates, &self.cells);
        let mesh = Triangulation { dimension: self.dimension, coordinates, cells };
        self.weights.as_deref().map_or((&mesh).into(), |weights| mesh.weighted(weights))
    }

    pub fn verify(&self, options: VerifyOptions) -> Report {
        verify(self.view(), &options, &mut |_, _, _| {})
    }

    /// Returns the levels that ran and failed with default options.
    pub fn failed(&self) -> Vec<&'static str> {
        failed(&self.verify(VerifyOptions::default()))
    }

    /// Returns the first fault of a level.
    pub fn fault(&self, level: &str) -> Fault {
        let report = self.verify(VerifyOptions::default());
        report.level(level).unwrap().faults[0].clone()
    }

    /// Returns the mesh as a set of simplices: sorted rows, in order.
    pub fn as_set(&self) -> Vec<Vec<u64>> {
        let sorted = |row: &[u64]| {
            let mut row = row.to_vec();
            row.sort_unstable();
            row
        };
        let mut rows: Vec<_> = self.cells.chunks_exact(self.dimension + 1).map(sorted).collect();
        rows.sort_unstable();
        rows
    }

    /// Appends another mesh of the same dimension.
    pub fn append(&mut self, other: &Mesh) {
        let shift = (self.coordinates.len() / self.dimension) as u64;
        self.coordinates.extend_from_slice(&other.coordinates);
        self.cells.extend(other.cells.iter().map(|v| v + shift));
        if let (Some(weights), Some(more)) = (&mut self.weights, &other.weights) {
            weights.extend(more);
        }
    }
}

pub fn failed(report: &Report) -> Vec<&'static str> {
    let bad = report.levels.iter().filter(|level| !level.passed && level.stopped_by.is_none());
    bad.map(|level| level.name).collect()
}

pub const PERTURBED: VerifyOptions = VerifyOptions { perturbed: true, any_order: false, threads: 1 };

/// Returns a determinant by Laplace expansion.
fn determinant(rows: &[Vec<BigInt>]) -> BigInt {
    let Some((first, rest)) = rows.split_first() else {
        return BigInt::from(1);
    };
    let mut sum = BigInt::ZERO;
    for (k, x) in first.iter().enumerate() {
        let without = |row: &Vec<BigInt>| {
            let mut row = row.clone();
            row.remove(k);
            row
        };
        let minor: Vec<_> = rest.iter().map(without).collect();
        let term = x * determinant(&minor);
        sum = if k % 2 == 0 { sum + term } else { sum - term };
    }
    sum
}

/// Increasing `k`-subsets of `items`.
pub fn subsets(items: &[usize], k: usize) -> Vec<Vec<usize>> {
    if k == 0 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (i, &first) in items.iter().enumerate() {
        for rest in subsets(&items[i + 1..], k - 1) {
            all.push([vec![first], rest].concat());
        }
    }
    all
}

/// Splits a finite `x` into `(m, e)` with `x = m 2^e`.
fn parts(x: f64) -> (i64, i32) {
    let (mut m, mut e) = (x, 0);
    while m != m.trunc() {
        (m, e) = (m * 2.0, e - 1);
    }
    while m.abs() >= 2f64.powi(53) {
        (m, e) = (m / 2.0, e + 1);
    }
    (m as i64, e)
}

/// Returns positions and heights `|p|^2 - w` as integers, in units of one power of two and of its square.
pub fn integers<const D: usize>(points: &[[f64; D]], weights: &[f64]) -> Vec<Vec<BigInt>> {
    let of_points = points.iter().flatten().filter(|&&x| x != 0.0).map(|&x| parts(x).1);
    let of_weights = weights.iter().filter(|&&w| w != 0.0).map(|&w| parts(w).1.div_euclid(2));
    let low = of_points.chain(of_weights).min().unwrap_or(0);
    let whole = |x: f64, low: i32| {
        let (m, e) = parts(x);
        BigInt::from(m) << if m == 0 { 0 } else { e - low }
    };
    let lift = |(p, &w): (&[f64; D], &f64)| {
        let mut row: Vec<BigInt> = p.iter().map(|&x| whole(x, low)).collect();
        row.push(row.iter().map(|x| x * x).sum::<BigInt>() - whole(w, 2 * low));
        row
    };
    points.iter().zip(weights).map(lift).collect()
}

/// Returns the first row of the heaviest sites at each position, in lexicographic order.
pub fn representatives(lifted: &[Vec<BigInt>]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..lifted.len()).collect();
    // The lowest lift is the heaviest.
    order.sort_by(|&i, &j| lifted[i].cmp(&lifted[j]).then(i.cmp(&j)));
    let place = |i: usize| lifted[i].split_last().map(|(_, place)| place);
    order.dedup_by(|i, j| place(*i) == place(*j));
    order
}

/// Returns the sign of the orientation of rows, of which the first `size` numbers count.
pub fn turn(rows: &[&Vec<BigInt>], size: usize) -> Ordering {
    let differences = |row: &&Vec<BigInt>| (0..size).map(|k| &row[k] - &rows[0][k]).collect();
    let matrix: Vec<Vec<BigInt>> = rows[1..].iter().map(differences).collect();
    determinant(&matrix).cmp(&BigInt::ZERO)
}

/// Returns the canonical Delaunay triangulation of a few points. See [`regular`].
pub fn brute<const D: usize>(points: &[[f64; D]]) -> Mesh {
    Mesh { weights: None, ..regular(points, &vec![0.0; points.len()]) }
}

/// Returns the canonical regular triangulation of a few sites. It is the lower hull of the heights
/// `(|p|^2 - w) B^(n+1) + B^rank` for a large `B`. All simplices are tested against all sites.
pub fn regular<const D: usize>(points: &[[f64; D]], weights: &[f64]) -> Mesh {
    let mut lifted = integers(points, weights);
    let order = representatives(&lifted);
    let n = points.len() as u64;
    let coordinates = lifted.iter().flat_map(|row| &row[..D]);
    let width = 16 + 8 * coordinates.map(BigInt::bits).max().unwrap_or(0);
    for (rank, &i) in order.iter().enumerate() {
        lifted[i][D] <<= width * (n + 1);
        lifted[i][D] += BigInt::from(1) << (width * (rank as u64 + 1));
    }
    let mut cells = Vec::new();
    for mut cell in subsets(&order, D + 1) {
        let mut rows: Vec<&Vec<BigInt>> = cell.iter().map(|&i| &lifted[i]).collect();
        match turn(&rows, D) {
            Ordering::Equal => continue,
            Ordering::Less => {
                cell.swap(D - 1, D);
                rows.swap(D - 1, D);
            }
            Ordering::Greater => {}
        }
        let empty = order.iter().filter(|i| !cell.contains(i)).all(|&q| {
            rows.push(&lifted[q]);
            let above = turn(&rows, D + 1);
            rows.pop();
            above.is_gt()
        });
        if empty {
            cells.extend(cell.iter().map(|&i| i as u64));
        }
    }
    let (coordinates, weights) = (points.as_flattened().to_vec(), Some(weights.to_vec()));
    Mesh { dimension: D, coordinates, cells, weights }
}

/// A small random number generator (splitmix64).
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    /// Returns points with integer coordinates below `end`.
    pub fn points<const D: usize>(&mut self, count: usize, end: u64) -> Vec<[f64; D]> {
        (0..count).map(|_| std::array::from_fn(|_| self.below(end) as f64)).collect()
    }
}

/// The corners of the unit cube, number `4 x + 2 y + z`.
pub fn cube() -> Vec<[f64; 3]> {
    (0..8u32).map(|i| [i / 4, i / 2 % 2, i % 2].map(f64::from)).collect()
}

/// Returns `side^3` cubes, each cut as `rows` cuts the unit cube. `place` moves the points.
pub fn tiled(side: usize, rows: &[u64], mut place: impl FnMut([f64; 3]) -> [f64; 3]) -> Mesh {
    let triple = |i: usize, side: usize| [i / (side * side), i / side % side, i % side];
    let mut mesh = Mesh { dimension: 3, coordinates: Vec::new(), cells: Vec::new(), weights: None };
    for i in 0..(side + 1).pow(3) {
        mesh.coordinates.extend(place(triple(i, side + 1).map(|x| x as f64)));
    }
    for corner in (0..side.pow(3)).map(|i| triple(i, side)) {
        for &v in rows {
            let [x, y, z] = triple(v as usize, 2);
            let at = ((corner[0] + x) * (side + 1) + corner[1] + y) * (side + 1) + corner[2] + z;
            mesh.cells.push(at as u64);
        }
    }
    mesh
}

/// Returns `side^3` cubes, each cut into six tetrahedra around a diagonal (Kuhn). For the cubic lattice, this is a
/// Delaunay triangulation.
pub fn kuhn(side: usize, place: impl FnMut([f64; 3]) -> [f64; 3]) -> Mesh {
    let rows = [[0, 4, 6, 7], [0, 2, 3, 7], [0, 1, 5, 7], [0, 5, 4, 7], [0, 3, 1, 7], [0, 6, 2, 7]];
    tiled(side, rows.as_flattened(), place)
}

/// The canonical triangulation of the cubic lattice. The perturbation does not depend on translation, so it is the
/// triangulation of one cube, repeated.
pub fn canonical_lattice(side: usize) -> Mesh {
    tiled(side, &brute(&cube()).cells, |p| p)
}
