//! The mesh in the memory of the verifier, and the first two levels: structure and orientation.
//!
//! `-0.0` is copied as `0.0`. If the largest coordinate is outside `2^-60` to `2^60`, all coordinates are multiplied by
//! a power of two that brings it near one, and weights by its square, provided that this is exact for all of them. The
//! scaling changes no sign of a determinant. The filter of [`super::predicates`] then stays in its range for any unit of length.

use std::array::from_fn;
use std::cmp::Ordering;
use std::ops::Range;

use rayon::prelude::*;

use super::dyadic::{power_of_two, sum_sign};
use super::exact::Site;
use super::fault::Fault;
use super::place::{FARTHEST, Place, Steps, Vertex};
use super::predicates::{in_sphere, orientation, power};
use super::rank::affine_dimension;
use super::report::Tally;
use super::runner::Runner;
use crate::triangulation::Sites;

/// A periodic box admits numbers below `2^900`, so that sums and products with numbers of lengths do not overflow.
const LARGEST: f64 = f64::from_bits((1023 + 900) << 52);

/// The vertex of a cell of places.
pub(super) type Corner<P, const D: usize> = Vertex<<P as Place<D>>::Steps>;

/// Points and cells that need not form a complex. `N` is `D + 1`. In a periodic box, a cell stands for all its translations.
pub(super) struct Soup<P: Place<D>, const D: usize, const N: usize> {
    /// All points.
    pub points: Vec<[f64; D]>,
    /// The lengths of the box. Those of axes that are not periodic are 0.
    pub lengths: [f64; D],
    /// The translation of each point into the box from 0 to the lengths. Empty without a box.
    bases: Vec<P::Steps>,
    /// The weights of all points. Empty without weights.
    pub weights: Vec<f64>,
    /// The vertices of the cells. After the level `orientation`, cells are positively oriented unless they are flat.
    pub cells: Vec<[Corner<P, D>; N]>,
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
    /// The dimension of the affine hull of the points and their images.
    pub dimension: i32,
}

/// If the largest length is outside `2^-60` to `2^60`, multiplies all coordinates and the lengths of the box by a power of two,
/// and all weights by its square, provided that this is exact.
fn normalise(coordinates: &mut [f64], lengths: &mut [f64], weights: &mut [f64]) {
    let largest = coordinates.iter().chain(&*lengths).fold(0.0f64, |m, x| m.max(x.abs()));
    let exponent = ((largest.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    if largest == 0.0 || exponent.abs() <= 60 {
        return;
    }
    let (half, rest) = (-exponent / 2, -exponent - -exponent / 2);
    let (up, up_rest) = (power_of_two(half), power_of_two(rest));
    let (down, down_rest) = (power_of_two(-half), power_of_two(-rest));
    let scaled = |x: f64| x * up * up_rest;
    let back = |x: f64| x * down_rest * down;
    let exact = coordinates.iter().chain(&*lengths).all(|&x| back(scaled(x)) == x);
    if exact && weights.iter().all(|&w| back(back(scaled(scaled(w)))) == w) {
        for x in coordinates.iter_mut().chain(lengths) {
            *x = scaled(*x);
        }
        for w in weights {
            *w = scaled(scaled(*w));
        }
    }
}

impl<P: Place<D>, const D: usize, const N: usize> Soup<P, D, N> {
    /// Copies the points, and the cells if their indices are valid. Returns the faults of coordinates, weights and indices.
    pub fn load(sites: &Sites<'_>, runner: &mut Runner<'_>) -> (Self, Tally) {
        let mesh = &sites.mesh;
        let coordinates: Vec<f64> = mesh.coordinates.iter().map(|x| x + 0.0).collect();
        let count = coordinates.len() / D;
        let mut tally = runner.each("points", count, |range, tally| {
            tally.checked += range.len() as u64;
            for i in range {
                if !mesh.coordinates[i * D..(i + 1) * D].iter().all(|x| x.is_finite()) {
                    tally.fault(Fault::NotFinite { point: i as u64 });
                }
                if sites.weights.and_then(|weights| weights.get(i)).is_some_and(|w| !w.is_finite()) {
                    tally.fault(Fault::WeightNotFinite { point: i as u64 });
                }
            }
        });
        let offsets = sites.periodic.map(|periodic| periodic.offsets).unwrap_or_default();
        let row = |cell: usize| -> [Corner<P, D>; N] {
            from_fn(|i| {
                let at = cell * N + i;
                let steps = P::steps_of(offsets.get(at * D..(at + 1) * D).unwrap_or_default());
                Vertex { row: mesh.cells[at] as u32, steps }
            })
        };
        let lengths = sites.periodic.map(|periodic| periodic.lengths).unwrap_or_default();
        let is_admitted = |axis: usize, steps: i32| {
            let is_open = lengths.get(axis).is_none_or(Option::is_none);
            steps.unsigned_abs() <= if is_open { 0 } else { FARTHEST.unsigned_abs() }
        };
        let m = mesh.cells.len() / N;
        tally.append(runner.each("cells", m, |range, tally| {
            tally.checked += range.len() as u64;
            for cell in range {
                check_indices(cell as u64, &mesh.cells[cell * N..(cell + 1) * N], count, tally);
                check_row(cell as u64, &row(cell), tally);
                let offsets = offsets.get(cell * N * D..(cell + 1) * N * D).unwrap_or_default();
                if !offsets.iter().enumerate().all(|(at, &steps)| is_admitted(at % D, steps)) {
                    tally.fault(Fault::OffsetNotAdmitted { cell: cell as u64 });
                }
            }
        }));
        let mut soup = Self::of_points(coordinates, sites);
        if tally.count == 0 {
            soup.find_bases(runner, &mut tally);
        }
        if tally.count == 0 {
            soup.cells = (0..m).map(row).collect();
        }
        (soup, tally)
    }

    /// Takes finite points and weights, without cells.
    fn of_points(mut coordinates: Vec<f64>, sites: &Sites<'_>) -> Self {
        let mut weights = sites.weights.unwrap_or_default().to_vec();
        let lengths = sites.periodic.map(|periodic| periodic.lengths).unwrap_or_default();
        let mut lengths = from_fn(|axis| lengths.get(axis).copied().flatten().unwrap_or(0.0));
        normalise(&mut coordinates, &mut lengths, &mut weights);
        let points: Vec<[f64; D]> = coordinates.chunks_exact(D).map(|p| from_fn(|k| p[k])).collect();
        let used = vec![false; points.len()];
        let (bases, cells, flat, concealed) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (duplicates, hidden, dimension) = (0, 0, -1);
        Self { points, lengths, bases, weights, cells, flat, used, duplicates, hidden, concealed, dimension }
    }

    /// Finds the translations of all points into the box.
    fn find_bases(&mut self, runner: &mut Runner<'_>, tally: &mut Tally) {
        if !P::IS_PERIODIC {
            return;
        }
        let numbers = || self.points.as_flattened().iter().chain(&self.lengths);
        if numbers().any(|x| x.abs() >= LARGEST) {
            let reason = "the numbers of the points and of the box spread over too many digits";
            return tally.fault(Fault::Shape { reason });
        }
        let of = |range: Range<usize>| -> Vec<Option<P::Steps>> { range.map(|i| self.base_of(i)).collect() };
        let bases = runner.map(self.points.len(), of).concat();
        if let Some(point) = bases.iter().position(Option::is_none) {
            tally.fault(Fault::TooFar { point: point as u64 });
        }
        self.bases = bases.into_iter().flatten().collect();
    }

    /// Returns the translation of a point into the box whose lower corner is the first point, unless there are too many lengths.
    fn base_of(&self, point: usize) -> Option<P::Steps> {
        let mut base = P::Steps::ZERO;
        for axis in self.periodic_axes() {
            let (x, length) = (self.points[point][axis], self.lengths[axis]);
            let low = self.points[0][axis];
            let estimate = -((x - low) / length).floor();
            if estimate.abs() > f64::from(FARTHEST) {
                return None;
            }
            // The quotient is rounded, so the estimate may be wrong by one.
            let inside = |steps: i32| {
                let sign = |steps: i32| {
                    let moved = P::of(&self.points[point], P::Steps::along(axis, steps), &self.lengths);
                    let [a, b, c] = moved.parts(axis);
                    sum_sign(&[a, b, c, -low])
                };
                sign(steps).is_ge() && sign(steps - 1).is_lt()
            };
            let around = [0, -1, 1].map(|more| estimate as i32 + more);
            base = base.plus(P::Steps::along(axis, around.into_iter().find(|&steps| inside(steps))?));
        }
        Some(base)
    }

    /// Returns the axes along which the box is periodic.
    pub fn periodic_axes(&self) -> impl Iterator<Item = usize> + Clone + use<P, D, N> {
        let lengths = self.lengths;
        (0..D).filter(move |&axis| lengths[axis] > 0.0)
    }

    /// Returns `true` if all axes are periodic.
    pub fn is_closed(&self) -> bool {
        self.periodic_axes().count() == D
    }

    /// Returns the position of a vertex.
    #[inline]
    pub fn place(&self, vertex: Corner<P, D>) -> P {
        P::of(&self.points[vertex.row as usize], vertex.steps, &self.lengths)
    }

    /// Returns the image of a point in the box, or the point itself without a box.
    #[inline]
    pub fn base(&self, row: u32) -> Corner<P, D> {
        Vertex { row, steps: self.bases.get(row as usize).copied().unwrap_or(P::Steps::ZERO) }
    }

    /// Returns a vertex with its weight, 0 without weights.
    #[inline]
    fn site(&self, vertex: Corner<P, D>) -> Site<P> {
        let weight = self.weights.get(vertex.row as usize).copied().unwrap_or(0.0);
        Site { place: self.place(vertex), weight }
    }

    /// Returns the in-sphere sign of a vertex: greater if its lift is strictly below the hyperplane through the lifts of the
    /// cell. `corners` are the positions of the cell.
    #[inline]
    pub fn in_sphere(&self, cell: u32, corners: &[P; N], vertex: Corner<P, D>) -> Ordering {
        if self.weights.is_empty() {
            in_sphere(corners, &self.place(vertex))
        } else {
            power(&self.cells[cell as usize].map(|v| self.site(v)), &self.site(vertex))
        }
    }

    /// Returns the positions of the vertices of a cell.
    #[inline]
    pub fn corners(&self, cell: u32) -> [P; N] {
        self.cells[cell as usize].map(|v| self.place(v))
    }

    /// Returns the positions of the vertices of a translated cell.
    #[inline]
    pub fn corners_at(&self, cell: u32, by: P::Steps) -> [P; N] {
        self.cells[cell as usize].map(|v| self.place(v.moved(by)))
    }

    /// Returns the vertices of the facet opposite to `slot`, without one if it is not there.
    #[inline]
    fn facet_of(&self, cell: u32, slot: usize) -> [Corner<P, D>; D] {
        let row = &self.cells[cell as usize];
        from_fn(|i| row[i + usize::from(i >= slot)])
    }

    /// Returns the settled vertices of the facet opposite to `slot`, and their translation.
    #[inline]
    pub fn settled(&self, cell: u32, slot: usize) -> ([Corner<P, D>; D], P::Steps) {
        let mut facet = self.facet_of(cell, slot);
        let by = Vertex::settle(&mut facet);
        (facet, by)
    }

    /// Returns the translation of the cell of the facet `twin` that joins it to the facet opposite to `slot`. Both are the same
    /// facet up to a translation.
    #[inline]
    pub fn across(&self, cell: u32, slot: usize, twin: u32) -> P::Steps {
        if !P::IS_PERIODIC {
            return P::Steps::ZERO;
        }
        let (_, there) = self.settled(twin / N as u32, twin as usize % N);
        self.settled(cell, slot).1.minus(there)
    }

    /// Returns the vertices of the facet opposite to `slot` as sorted input indices.
    pub fn facet(&self, cell: u32, slot: usize) -> Vec<u64> {
        let mut facet: Vec<u64> = self.facet_of(cell, slot).iter().map(|v| v.row as u64).collect();
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
        for v in self.cells.as_flattened() {
            self.used[v.row as usize] = true;
        }
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        let compare = |i: u32, j: u32| self.place(self.base(i)).lexicographic(&self.place(self.base(j)));
        runner.on_threads(&mut || order.par_sort_unstable_by(|&i, &j| compare(i, j).then(i.cmp(&j))));
        let groups: Vec<&[u32]> = order.chunk_by(|&i, &j| compare(i, j).is_eq()).collect();
        let open: Vec<usize> = (0..D).filter(|&axis| self.lengths[axis] == 0.0).collect();
        let spanned = affine_dimension(&self.points, &open);
        self.dimension = if spanned < 0 { -1 } else { spanned + (D - open.len()) as i32 };
        let empty = self.cells.is_empty();
        if empty && self.dimension == D as i32 {
            tally.fault(Fault::NoCells);
        }
        for group in groups {
            let Some((first, equals)) = heaviest(group, &self.weights) else { continue };
            self.duplicates += equals - 1;
            self.hidden += group.len() as u64 - equals;
            if !empty {
                let place = Coincident { group, first, weights: &self.weights };
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
        let row = |(i, row): (u32, &[Corner<P, D>; N])| {
            let mut row = *row;
            Vertex::settle(&mut row);
            (row, i)
        };
        let mut sorted: Vec<([Corner<P, D>; N], u32)> = (0..).zip(&self.cells).map(row).collect();
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

/// Checks that the indices of a cell are in range.
fn check_indices(cell: u64, row: &[u64], count: usize, tally: &mut Tally) {
    if let Some(&index) = row.iter().find(|&&v| v >= count as u64) {
        tally.fault(Fault::OutOfRange { cell, index });
    }
}

/// Checks that the vertices of a cell are distinct.
fn check_row<S: Steps>(cell: u64, row: &[Vertex<S>], tally: &mut Tally) {
    let repeated = (1..row.len()).find(|&i| row[..i].contains(&row[i]));
    if let Some(i) = repeated {
        tally.fault(Fault::RepeatedVertex { cell, vertex: row[i].row as u64 });
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
struct Coincident<'a> {
    group: &'a [u32],
    /// The first of the heaviest points.
    first: u32,
    /// All weights. Empty without weights.
    weights: &'a [f64],
}

impl Coincident<'_> {
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
