//! The shapes of cells: the part of quality that meshes and triangulations of points have in common.
//!
//! **Statement.** The result is a function of the set of cells, and not of their order, because histograms and sums are
//! ([`super::histogram`]). Parts of a triangulation can be measured anywhere and merged.
//!
//! **Work and depth.** O(1) per cell. Sequential.

use septet_geometry::point::Point;
use septet_geometry::range::scale;

use super::histogram::Histogram;
use super::{SLIVER_RATIO, SLIVERS, angles, estimate};
use crate::space::Space;
use crate::sum::ExactSum;

/// The shape of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The circumradius divided by the length of the shortest edge. It is infinite for flat cells.
    pub ratio: f64,
    /// The angles in degrees: dihedral angles in space, interior angles in the plane.
    pub angles: Vec<f64>,
    /// The area or volume.
    pub volume: f64,
}

impl Shape {
    /// Measures a cell with finite coordinates of any size. All values are rounded.
    pub fn of<P: Space>(corners: &[P]) -> Self {
        let mut points = [[0.0; 3]; 4];
        for (point, corner) in points.iter_mut().zip(corners) {
            (0..P::DIM).for_each(|i| point[i] = corner.coord(i));
        }
        // Angles do not depend on the scale. Coordinates near 1 leave room for products.
        let exponent = magnitude(corners);
        let near: Vec<P> = corners.iter().map(|&p| scale(p, -exponent)).collect();
        Shape {
            ratio: estimate::radius_edge_ratio(points, corners.len()),
            angles: angles::angles(&near),
            volume: angles::measure(corners).abs(),
        }
    }

    /// Returns the smallest and the largest angle.
    pub fn range(&self) -> [f64; 2] {
        let angles = || self.angles.iter().copied();
        [angles().fold(f64::INFINITY, f64::min), angles().fold(0.0, f64::max)]
    }
}

/// Returns the binary exponent of the largest difference of coordinates.
fn magnitude<P: Point>(corners: &[P]) -> i32 {
    let of = |p: &P| (0..P::DIM).map(|i| (p.coord(i) - corners[0].coord(i)).abs()).fold(0.0, f64::max);
    let most = corners.iter().map(of).fold(0.0, f64::max);
    if most > 0.0 && most.is_finite() { ((most.to_bits() >> 52) & 0x7ff) as i32 - 1023 } else { 0 }
}

/// The shapes of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// Radius-edge ratios of all cells.
    pub ratios: Histogram,
    /// All angles in degrees: dihedral angles in space, interior angles in the plane.
    pub angles: Histogram,
    /// The smallest angle of each cell.
    pub least_angles: Histogram,
    /// The largest angle of each cell.
    pub largest_angles: Histogram,
    /// Numbers of cells with an angle below each of [`SLIVERS`] and a radius-edge ratio below [`SLIVER_RATIO`].
    pub slivers: [u64; 3],
    /// The smallest and the largest measure of a cell.
    pub volumes: [f64; 2],
    /// The total measure of all cells.
    pub volume: ExactSum,
}

impl Default for Shapes {
    fn default() -> Self {
        let degrees = |bins| Histogram::new(0.0, 180.0, bins);
        Shapes {
            ratios: Histogram::new(0.5, 4.5, 80),
            angles: degrees(90),
            least_angles: degrees(90),
            largest_angles: degrees(90),
            slivers: [0; 3],
            volumes: [f64::INFINITY, f64::NEG_INFINITY],
            volume: ExactSum::default(),
        }
    }
}

impl Shapes {
    /// Adds a cell.
    pub fn add(&mut self, shape: &Shape) {
        let [least, largest] = shape.range();
        shape.angles.iter().for_each(|&angle| self.angles.add(angle));
        self.least_angles.add(least);
        self.largest_angles.add(largest);
        self.ratios.add(shape.ratio);
        if shape.ratio < SLIVER_RATIO {
            for (count, limit) in self.slivers.iter_mut().zip(SLIVERS) {
                *count += u64::from(least < limit);
            }
        }
        self.volumes = [self.volumes[0].min(shape.volume), self.volumes[1].max(shape.volume)];
        self.volume.add(shape.volume);
    }

    /// Adds the cells of another part.
    pub fn merge(&mut self, other: &Shapes) {
        for (own, other) in self.histograms_mut().into_iter().zip(other.histograms()) {
            own.merge(other);
        }
        self.slivers.iter_mut().zip(other.slivers).for_each(|(own, other)| *own += other);
        self.volumes = [self.volumes[0].min(other.volumes[0]), self.volumes[1].max(other.volumes[1])];
        self.volume.merge(&other.volume);
    }

    /// Appends the shapes to words, to be sent.
    pub fn append_to(&self, words: &mut Vec<u64>) {
        self.histograms().into_iter().for_each(|histogram| histogram.append_to(words));
        words.extend(self.slivers);
        words.extend(self.volumes.map(f64::to_bits));
        words.extend(self.volume.to_words());
    }

    /// Takes shapes from words. Returns `None` if there are too few.
    pub fn read_from(words: &mut impl Iterator<Item = u64>) -> Option<Self> {
        let mut shapes = Shapes::default();
        for histogram in shapes.histograms_mut() {
            *histogram = histogram.read_from(words)?;
        }
        for sliver in &mut shapes.slivers {
            *sliver = words.next()?;
        }
        for volume in &mut shapes.volumes {
            *volume = f64::from_bits(words.next()?);
        }
        shapes.volume = ExactSum::from_words(words)?;
        Some(shapes)
    }

    fn histograms(&self) -> [&Histogram; 4] {
        [&self.ratios, &self.angles, &self.least_angles, &self.largest_angles]
    }

    fn histograms_mut(&mut self) -> [&mut Histogram; 4] {
        [&mut self.ratios, &mut self.angles, &mut self.least_angles, &mut self.largest_angles]
    }
}
