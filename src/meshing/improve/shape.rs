//! The quality of a cell.
//!
//! **Statement.** The quality is the smallest sine of the angles (in space: dihedral angles), negative if the cell is
//! inverted. The smallest angle of a cell is always acute, so its sine is the smallest among the acute angles.
//!
//! **Source.** Klingner and Shewchuk (2007) for the sine.

use septet_geometry::point::{Point, dist2};

/// The quality of one cell, or the least of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grade {
    /// The smallest sine of all angles. Negative for an inverted cell.
    pub(super) sine: f64,
    /// The sine of the smallest angle.
    pub(super) least: f64,
}

/// The smallest gain of a change, relative to the target. Smaller gains would need many rounds.
const GAIN: f64 = 0.01;

impl Grade {
    /// The grade of no cell.
    pub(super) const BEST: Grade = Grade { sine: f64::INFINITY, least: f64::INFINITY };

    /// Returns the grade of both.
    pub(super) fn and(self, other: Grade) -> Grade {
        Grade { sine: self.sine.min(other.sine), least: self.least.min(other.least) }
    }

    /// Returns `true` if cells of this grade may replace cells of the `old` one. The least sine rises, and the least
    /// angle does not fall below the `wanted` one, unless it was below before; then it does not fall.
    pub(super) fn may_replace(self, old: Grade, wanted: f64) -> bool {
        self.sine > old.sine && self.least >= old.least.min(wanted)
    }

    /// Returns `true` if cells of this grade are worth a change of cells of the `old` one: they reach the `wanted` sine,
    /// or the least sine rises by at least [`GAIN`] of it.
    pub(super) fn is_worth(self, old: Grade, wanted: f64) -> bool {
        self.may_replace(old, wanted) && (self.sine >= wanted || self.sine - old.sine >= GAIN * wanted)
    }
}

/// Returns the smallest sine of the angles of a cell, negative if the cell is inverted.
pub fn least_sine<P: Point>(p: &[P]) -> f64 {
    grade(p).sine
}

/// Returns the grade of a cell.
pub(super) fn grade<P: Point>(p: &[P]) -> Grade {
    if P::DIM == 2 {
        // sin = 2 area / (product of the two sides).
        let [a, b, c] = [dist2(p[1], p[2]), dist2(p[0], p[2]), dist2(p[0], p[1])];
        let sine = P::hull_normal(&[p[1] - p[0]]).dot(p[2] - p[0]) / (a * b).max(b * c).max(c * a).sqrt();
        return Grade { sine, least: sine };
    }
    let [u, v, w] = [p[1] - p[0], p[2] - p[0], p[3] - p[0]];
    // The normals of the faces point into the cell. Their lengths are twice the areas.
    let [n1, n2, n3] = [P::hull_normal(&[v, w]), P::hull_normal(&[w, u]), P::hull_normal(&[u, v])];
    let normals = [(n1 + n2 + n3) * -1.0, n1, n2, n3];
    let areas = normals.map(septet_geometry::point::Vector::norm2);
    let volume = n3.dot(w);
    let [mut least, mut acute] = [f64::INFINITY; 2];
    for (i, j, k, l) in [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)] {
        // The faces at edge ij are opposite k and l. sin = 6 volume |e| / (2 area 2 area').
        let squared = dist2(p[i], p[j]) / (areas[k] * areas[l]);
        least = least.min(squared);
        if normals[k].dot(normals[l]) <= 0.0 {
            acute = acute.min(squared);
        }
    }
    let [sine, least] = [least, acute].map(|squared| volume * squared.sqrt());
    // A flat cell divides by zero areas.
    if sine.is_nan() || volume <= 0.0 {
        let sine = if sine.is_nan() { 0.0 } else { sine };
        return Grade { sine, least: sine.min(0.0) };
    }
    Grade { sine, least }
}
