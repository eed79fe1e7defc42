//! The sites of a periodic box and their images near it.

use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::point::{Point, Position, Vector};
use septet_geometry::site::Weighted;
use septet_workers::config::cores::map;

use super::lattice::Lattice;
use crate::error::PeriodicError;
use crate::result::periodic::Steps;

/// The first width of the cover beyond the box, in distances of evenly spaced sites, in the plane and in space. The largest
/// void of 1e6 random sites near a face has about half this diameter.
const WIDTH: [f64; 2] = [5.0, 3.5];

/// Number of rows whose images one core finds in turn.
const CHUNK: usize = 1 << 14;

/// A factor that covers the rounding of the cover.
const SURE: f64 = 1.0 - 1e-9;

/// The sites of a box. The *base* site of a row is its image in the half-open box.
#[derive(Debug)]
pub(super) struct Sites<P: Position> {
    pub(super) lattice: Lattice,
    /// The base site of each row.
    bases: Vec<Weighted<P>>,
    /// The numbers of lengths from each row to its base site. Empty if they are 0.
    steps: Vec<Steps>,
    heaviest: f64,
}

/// Base sites, followed by images of them.
#[derive(Debug)]
pub(super) struct Images<P: Position> {
    pub(super) sites: Vec<Weighted<P>>,
    /// The row of each image after the base sites, and the number of lengths from the base site to it.
    of: Vec<(u32, Steps)>,
    base: usize,
}

impl<P: Position> Sites<P> {
    /// Finds the base sites of rows.
    ///
    /// # Errors
    /// Fails with the first row outside of the box, and the number of others, or with a row that is too far away.
    pub(super) fn of(lattice: Lattice, rows: Vec<Weighted<P>>) -> Result<Self, PeriodicError> {
        let (lattice, rows) = lattice.scaled(rows)?;
        let found = |&index: &u32| {
            let row = rows[index as usize];
            if is_finite(row) { lattice.base(row, index as usize) } else { Ok((row, [0; 3])) }
        };
        let found = map(&numbers(rows.len()), found);
        let is_outside =
            |found: &&Result<(Weighted<P>, Steps), _>| matches!(found, Err(PeriodicError::Outside { .. }));
        let outside = found.iter().filter(is_outside).count();
        let found: Result<(Vec<_>, Vec<_>), PeriodicError> = found.into_iter().collect();
        let (bases, mut steps) = found.map_err(|error| match error {
            PeriodicError::Outside { index, value, low, high, .. } => {
                PeriodicError::Outside { index, value, low, high, others: outside - 1 }
            }
            other => other,
        })?;
        if steps.iter().all(|steps| *steps == [0; 3]) {
            steps = Vec::new();
        }
        let weights = bases.iter().map(Point::weight).filter(|weight| weight.is_finite());
        let heaviest = weights.fold(f64::NEG_INFINITY, f64::max);
        Ok(Sites { lattice, bases, steps, heaviest })
    }

    /// Returns the numbers of lengths from all rows to their base sites. Empty if they are 0.
    pub(super) fn all_steps(&self) -> Vec<Steps> {
        self.steps.clone()
    }

    /// Returns the number of rows.
    pub(super) fn count(&self) -> u64 {
        self.bases.len() as u64
    }

    /// Returns the first width of the cover: a few distances of evenly spaced sites, larger if some weights are.
    pub(super) fn first_width(&self) -> f64 {
        let n = self.bases.len() as f64;
        let axes = self.lattice.axes();
        if !self.lattice.is_closed(P::DIM) {
            return f64::INFINITY;
        }
        let volume: f64 = axes.map(|axis| self.lattice.lengths[axis]).product();
        let spacing = (volume / n).powf(1.0 / P::DIM as f64);
        let mean = self.bases.iter().map(Point::weight).sum::<f64>() / n;
        let width = WIDTH[P::DIM - 2] * (spacing * spacing + (self.heaviest - mean).max(0.0)).sqrt();
        if width > 0.0 { width } else { f64::INFINITY }
    }

    /// Returns `true` if a cover of this width contains all images with numbers of lengths from -1 to 1.
    pub(super) fn has_all(&self, width: f64) -> bool {
        let is_wide = |axis: usize| width >= self.lattice.lengths[axis];
        // A width that is no number is too large.
        self.lattice.axes().all(is_wide) || width.is_nan()
    }

    /// Returns the base sites, and their images within `width` of the box; all images if the cover has all.
    pub(super) fn images(&self, width: f64) -> Images<P> {
        let width = if self.has_all(width) { None } else { Some(width) };
        let all = numbers(self.bases.len());
        let chunks: Vec<&[u32]> = all.chunks(CHUNK).collect();
        let of = map(&chunks, |rows| {
            let mut of = Vec::new();
            for &row in *rows {
                let site = self.bases[row as usize];
                if is_finite(site) {
                    each_steps(self.ranges(site, width), |steps| of.push((row, steps)));
                }
            }
            of
        });
        let of: Vec<(u32, Steps)> = of.concat();
        let base = self.bases.len();
        let mut sites = self.bases.clone();
        sites.extend(map(&of, |&(row, steps)| self.lattice.image(self.bases[row as usize], steps)));
        Images { sites, of, base }
    }

    /// Returns the numbers of lengths to the images of a base site within the width of the box, along each axis.
    fn ranges(&self, site: Weighted<P>, width: Option<f64>) -> [[i32; 2]; 3] {
        let mut ranges = [[0, 0]; 3];
        for axis in self.lattice.axes() {
            let (x, low, length) =
                (site.position().coord(axis), self.lattice.origin[axis], self.lattice.lengths[axis]);
            let reaches = |distance: f64| width.is_none_or(|width| distance <= width);
            ranges[axis] = [-i32::from(reaches(low + length - x)), i32::from(reaches(x - low))];
        }
        ranges
    }

    /// Returns `true` if the conflict region of a cell may leave the cover of this width.
    pub(super) fn leaves_cover(&self, corners: &[Weighted<P>], width: f64) -> bool {
        let ConflictRegion::Ball { centre, radius } = ConflictRegion::of_cell(corners, self.heaviest) else {
            return true;
        };
        let leaves = |axis: usize| {
            let (low, length) = (self.lattice.origin[axis], self.lattice.lengths[axis]);
            let width = width.min(length) * SURE - 1e-9 * low.abs() - 4.0 * f64::EPSILON * length;
            let (from, to) = (centre.coord(axis) - radius, centre.coord(axis) + radius);
            let is_inside = from > low - width && to < low + length + width;
            !is_inside
        };
        self.lattice.axes().any(leaves)
    }
}

/// Returns the numbers of rows. The machine refuses more rows than it can number.
fn numbers(rows: usize) -> Vec<u32> {
    (0..u32::try_from(rows).unwrap_or(u32::MAX)).collect()
}

/// Calls `f` with the combinations of numbers of lengths, except for zeros only.
fn each_steps([x, y, z]: [[i32; 2]; 3], mut f: impl FnMut(Steps)) {
    for i in x[0]..=x[1] {
        for j in y[0]..=y[1] {
            for k in z[0]..=z[1] {
                if [i, j, k] != [0; 3] {
                    f([i, j, k]);
                }
            }
        }
    }
}

fn is_finite<P: Point>(site: P) -> bool {
    septet_geometry::range::not_finite(&site).is_none()
}

impl<P: Position> Images<P> {
    /// Returns the number of images besides the base sites.
    pub(super) fn count(&self) -> u64 {
        self.of.len() as u64
    }

    /// Returns `true` if a site is a base site.
    pub(super) fn is_base(&self, site: u64) -> bool {
        site < self.base as u64
    }

    /// Returns the row of a site, and the number of lengths from its base site to it.
    pub(super) fn of(&self, site: u64) -> (u32, Steps) {
        match (site as usize).checked_sub(self.base) {
            Some(image) => self.of[image],
            None => (site as u32, [0; 3]),
        }
    }
}
