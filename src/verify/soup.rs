//! The mesh in the memory of the verifier, and the first two levels: structure and orientation.
//!
//! `-0.0` is copied as `0.0`. If the largest coordinate is outside `2^-60` to `2^60`, all coordinates are multiplied by
//! a power of two that brings it near one, and weights by its square, provided that this is exact for all of them. The
//! scaling changes no sign of a determinant. The filter of [`super::predicates`] then stays in its range for any unit of length.

use std::array::from_fn;
use std::cmp::Ordering;
use std::ops::Range;

use rayon::prelude::*;

use super::exact::{Site, power_of_two};
use super::predicates::{in_sphere, lexicographic, orientation, power};
use super::report::{Fault, Tally};
use super::runner::Runner;
use crate::triangulation::Sites;

/// Points and cells that need not form a complex. `N` is `D + 1`.
pub(super) struct Soup<const D: usize, const N: usize> {
    /// All points.
    pub points: Vec<[f64; D]>,
    /// The weights of all points. Empty without weights.
    pub weights: Vec<f64>,
    /// The vertices of the cells. After the level `orientation`, cells are positively oriented unless they are flat.
    pub cells: Vec<[u32; N]>,
    /// The flat cells, in ascending order.
    pub flat: Vec<u32>,
    /// For each point, whether it is a vertex.
    pub used: Vec<bool>,
    /// Number of points that coincide with one of smaller index. With weights, both have the largest weight at that place.
    pub duplicates: u64,
    /// Number of hidden points, provided that [`Self::concealed`] are hidden.
    pub hidden: u64,
    /// One heaviest point for each place without a vertex. Empty without weights, and without cells.
    pub concealed: Vec<u32>,
    /// The dimension of the affine hull of the points.
    pub dimension: i32,
}

/// If the largest coordinate is outside `2^-60` to `2^60`, multiplies all coordinates by a power of two, and all weights by
/// its square, provided that this is exact.
fn normalise(coordinates: &mut [f64], weights: &mut [f64]) {
    let largest = coordinates.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let exponent = ((largest.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    if largest == 0.0 || exponent.abs() <= 60 {
        return;
    }
    let (half, rest) = (-exponent / 2, -exponent - -exponent / 2);
    let (up, up_rest) = (power_of_two(half), power_of_two(rest));
    let (down, down_rest) = (power_of_two(-half), power_of_two(-rest));
    let scaled = |x: f64| x * up * up_rest;
    let back = |x: f64| x * down_rest * down;
    let exact = coordinates.iter().all(|&x| back(scaled(x)) == x);
    if exact && weights.iter().all(|&w| back(back(scaled(scaled(w)))) == w) {
        for x in coordinates {
            *x = scaled(*x);
        }
        for w in weights {
            *w = scaled(scaled(*w));
        }
    }
}

impl<const D: usize, const N: usize> Soup<D, N> {
    /// Copies the points, and the cells if their indices are valid. Returns the faults of coordinates, weights and indices.
    pub fn load(sites: &Sites<'_>, runner: &mut Runner<'_>) -> (Self, Tally) {
        let mesh = &sites.mesh;
        let mut weights = sites.weights.unwrap_or_default().to_vec();
        let mut coordinates: Vec<f64> = mesh.coordinates.iter().map(|x| x + 0.0).collect();
        let count = coordinates.len() / D;
        let mut tally = runner.each("points", count, |range, tally| {
            tally.checked += range.len() as u64;
            for i in range {
                if !mesh.coordinates[i * D..(i + 1) * D].iter().all(|x| x.is_finite()) {
                    tally.fault(Fault::NotFinite { point: i as u64 });
                }
                if weights.get(i).is_some_and(|w| !w.is_finite()) {
                    tally.fault(Fault::WeightNotFinite { point: i as u64 });
                }
            }
        });
        let m = mesh.cells.len() / N;
        tally.append(runner.each("cells", m, |range, tally| {
            tally.checked += range.len() as u64;
            for cell in range {
                check_row(cell as u64, &mesh.cells[cell * N..(cell + 1) * N], count, tally);
            }
        }));
        let mut cells = Vec::new();
        if tally.count == 0 {
            normalise(&mut coordinates, &mut weights);
            cells = mesh.cells.chunks_exact(N).map(|row| from_fn(|i| row[i] as u32)).collect();
        }
        let points = coordinates.chunks_exact(D).map(|p| from_fn(|k| p[k])).collect();
        let used = vec![false; count];
        let (flat, concealed) = (Vec::new(), Vec::new());
        (
            Self { points, weights, cells, flat, used, duplicates: 0, hidden: 0, concealed, dimension: -1 },
            tally,
        )
    }

    /// Returns a point with its weight, 0 without weights.
    #[inline]
    fn site(&self, point: u32) -> Site<D> {
        let weight = self.weights.get(point as usize).copied().unwrap_or(0.0);
        Site { place: self.points[point as usize], weight }
    }

    /// Returns the in-sphere sign of a point: greater if its lift is strictly below the hyperplane through the lifts of the
    /// cell. `corners` are the coordinates of the cell.
    #[inline]
    pub fn in_sphere(&self, cell: u32, corners: &[[f64; D]; N], point: u32) -> Ordering {
        if self.weights.is_empty() {
            in_sphere(corners, &self.points[point as usize])
        } else {
            power(&self.cells[cell as usize].map(|v| self.site(v)), &self.site(point))
        }
    }

    /// Returns the coordinates of the vertices of a cell.
    #[inline]
    pub fn corners(&self, cell: u32) -> [[f64; D]; N] {
        self.cells[cell as usize].map(|v| self.points[v as usize])
    }

    /// Returns the vertices of the facet opposite to `slot` as sorted input indices.
    pub fn facet(&self, cell: u32, slot: usize) -> Vec<u64> {
        let row = self.cells[cell as usize];
        let mut facet: Vec<u64> = (0..N).filter(|&i| i != slot).map(|i| row[i] as u64).collect();
        facet.sort_unstable();
        facet
    }

    /// Returns `true` if the cell is flat.
    #[inline]
    pub fn is_flat(&self, cell: u32) -> bool {
        !self.flat.is_empty() && self.flat.binary_search(&cell).is_ok()
    }

    /// Checks the rest of the level `structure`: repeated cells, unused points and coincident points.
    pub fn structure(&mut self, perturbed: bool, runner: &mut Runner<'_>) -> Tally {
        let mut tally = Tally::default();
        self.repeated_cells(runner, &mut tally);
        for &v in self.cells.as_flattened() {
            self.used[v as usize] = true;
        }
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        let points = &self.points;
        let by_place =
            |&i: &u32, &j: &u32| lexicographic(&points[i as usize], &points[j as usize]).then(i.cmp(&j));
        runner.on_threads(&mut || order.par_sort_unstable_by(by_place));
        self.dimension = affine_dimension::<D, N>(points, &order);
        let empty = self.cells.is_empty();
        if empty && self.dimension == D as i32 {
            tally.fault(Fault::NoCells);
        }
        for group in order.chunk_by(|&i, &j| points[i as usize] == points[j as usize]) {
            let Some((first, equals)) = heaviest(group, &self.weights) else { continue };
            self.duplicates += equals - 1;
            self.hidden += group.len() as u64 - equals;
            if !empty {
                let place = Place { group, first, weights: &self.weights };
                if place.check(&self.used, perturbed, &mut tally) {
                    self.concealed.push(first);
                }
            }
        }
        self.hidden += self.concealed.len() as u64;
        tally
    }

    /// Finds cells with the same vertices by sorting.
    fn repeated_cells(&self, runner: &Runner<'_>, tally: &mut Tally) {
        let row = |(i, row): (u32, &[u32; N])| {
            let mut row = *row;
            row.sort_unstable();
            (row, i)
        };
        let mut sorted: Vec<([u32; N], u32)> = (0..).zip(&self.cells).map(row).collect();
        runner.on_threads(&mut || sorted.par_sort_unstable());
        for pair in sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            tally.fault(Fault::CellTwice { cells: [pair[0].1 as u64, pair[1].1 as u64] });
        }
    }

    /// Checks the level `orientation`: no cell is flat, and none is negative unless any order is allowed. Afterwards, all
    /// cells that are not flat are positively oriented.
    pub fn orient(&mut self, any_order: bool, runner: &mut Runner<'_>) -> Tally {
        let of =
            |cells: Range<usize>| cells.map(|c| orientation(&self.corners(c as u32))).collect::<Vec<_>>();
        let signs: Vec<Ordering> = runner.map(self.cells.len(), of).concat();
        let mut tally = Tally { checked: signs.len() as u64, ..Tally::default() };
        for (cell, sign) in signs.into_iter().enumerate() {
            match sign {
                Ordering::Greater => {}
                Ordering::Equal => {
                    self.flat.push(cell as u32);
                    tally.fault(Fault::Flat { cell: cell as u64 });
                }
                Ordering::Less => {
                    self.cells[cell].swap(N - 2, N - 1);
                    if !any_order {
                        tally.fault(Fault::Negative { cell: cell as u64 });
                    }
                }
            }
        }
        runner.report("orientation", self.cells.len(), self.cells.len());
        tally
    }
}

/// Checks that the indices of a cell are in range and distinct.
fn check_row(cell: u64, row: &[u64], count: usize, tally: &mut Tally) {
    if let Some(&index) = row.iter().find(|&&v| v >= count as u64) {
        tally.fault(Fault::OutOfRange { cell, index });
    }
    let repeated = (1..row.len()).find(|&i| row[..i].contains(&row[i]));
    if let Some(i) = repeated {
        tally.fault(Fault::RepeatedVertex { cell, vertex: row[i] });
    }
}

/// Returns the first of the heaviest points of a group, and the number of points with its weight. Without weights, all have
/// the same.
fn heaviest(group: &[u32], weights: &[f64]) -> Option<(u32, u64)> {
    let weight = |&i: &u32| weights.get(i as usize).copied().unwrap_or(0.0);
    let largest = group.iter().map(weight).fold(f64::NEG_INFINITY, f64::max);
    let mut equals = group.iter().filter(|i| weight(i) == largest);
    equals.next().map(|&first| (first, 1 + equals.count() as u64))
}

/// The points at one place, in ascending order.
struct Place<'a> {
    group: &'a [u32],
    /// The first of the heaviest points.
    first: u32,
    /// All weights. Empty without weights.
    weights: &'a [f64],
}

impl Place<'_> {
    /// Checks that exactly one point of the place is a vertex, a heaviest one. With weights, none need be. Returns `true` if
    /// none is, and the place must be hidden.
    fn check(&self, used: &[bool], perturbed: bool, tally: &mut Tally) -> bool {
        let smallest = self.first as u64;
        let weighs = |i: u64| self.weights.get(i as usize);
        let mut vertices = self.group.iter().filter(|&&i| used[i as usize]).map(|&i| i as u64);
        match (vertices.next(), vertices.next()) {
            (None, _) if !self.weights.is_empty() => return true,
            (None, _) => tally.fault(Fault::Unused { point: smallest }),
            (Some(a), Some(b)) => tally.fault(Fault::CoincidentVertices { points: [a, b] }),
            (Some(vertex), None) if weighs(vertex) != weighs(smallest) => {
                tally.fault(Fault::Lighter { vertex, heavier: smallest });
            }
            (Some(vertex), None) if perturbed && vertex != smallest => {
                tally.fault(Fault::NotRepresentative { vertex, smallest });
            }
            _ => {}
        }
        false
    }
}

/// Returns the exact dimension of the affine hull. `order` lists the points in lexicographic order. If the first and
/// the last point differ, they span a line. With a point off this line, they span a plane, and with a further point off
/// this plane, they span space.
fn affine_dimension<const D: usize, const N: usize>(points: &[[f64; D]], order: &[u32]) -> i32 {
    let (Some(&first), Some(&last)) = (order.first(), order.last()) else {
        return -1;
    };
    let mut frame = [points[first as usize]; N];
    frame[1] = points[last as usize];
    if frame[0] == frame[1] {
        return 0;
    }
    let Some(third) = points.iter().find(|p| !collinear(&frame[0], &frame[1], p)) else {
        return 1;
    };
    if D == 2 {
        return 2;
    }
    frame[2] = *third;
    let spanned = points.iter().any(|p| {
        let mut cell = frame;
        cell[N - 1] = *p;
        orientation(&cell).is_ne()
    });
    if spanned { 3 } else { 2 }
}

/// Returns `true` if three points are collinear, that is, if their projections to all pairs of axes are collinear.
fn collinear<const D: usize>(a: &[f64; D], b: &[f64; D], c: &[f64; D]) -> bool {
    let mut axes = (0..D).flat_map(|i| (0..i).map(move |j| [i, j]));
    axes.all(|pair| orientation(&[a, b, c].map(|p| pair.map(|k| p[k]))).is_eq())
}
