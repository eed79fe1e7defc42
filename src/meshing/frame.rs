//! The frame of a domain: the translation and the power of two between the file and the generator.
//!
//! **Statement.** Coordinates of the domain are `(x - c) 2^e`. The centre c is 0 on an axis unless every coordinate there
//! is at least `FAR` times the largest extent of the points. Then
//! 1. (in) `x - c` is exact for every point of the domain;
//! 2. (out) every *snapped* point p is written as the double `fl(p + c)`, and `fl(p + c) - c` equals p exactly. The
//!    mesh in memory therefore has the coordinates of the mesh in the file, and signs that are exact in the frame are
//!    exact for the numbers that are written.
//!
//! *Proof.* Let E be the extent and let all x lie in `[a, b]` with `a >= 4 E` (or in `[-b, -a]`) and `b - a <= E`. The
//! centre is a multiple of a power of two that is at most E, and `|c - (a + b) / 2| <= E / 2`. So `|x - c| <= E <= a / 4`,
//! and `x / 2 <= c <= 2 x`. By the lemma of Sterbenz, the difference `x - c` is exact. The same holds for a rounded sum
//! `fl(p + c)` with p in the hull of the domain, so a second rounding changes nothing. Factors `2^e` are exact. QED.
//!
//! A snapped point lies at most half a [`Frame::grid`] per axis from the point that was computed. Points on axes that are
//! not translated are not moved. Without this translation, the squared distances of a cube of side 1 at 1e6 lose the
//! digits that decide whether a ball contains its own corners.
//!
//! **Source.** Sterbenz, "Floating-point computation" (1974).
//!
//! **Work and depth.** O(1) for each point, and a reduction.

use septet_geometry::point::Point;
use septet_geometry::range::scale;

use crate::bvh::Bounds;

/// An axis is translated if its coordinates are at least this multiple of the extent.
const FAR: f64 = 4.0;

/// The smallest local feature size with which a mesh is attempted, in steps of the grid.
pub const FINEST: f64 = 64.0;

/// The coordinates of a domain relative to those of its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<P> {
    /// The point of the file that is the origin of the domain.
    pub centre: P,
    /// The exponent of the power of two that scales the coordinates to the exact range.
    pub exponent: i32,
    /// The step between adjacent doubles at the largest coordinate of a translated axis, in scaled coordinates. It is
    /// 0 if no axis is translated.
    grid: f64,
}

impl<P: Point> Frame<P> {
    /// Returns the frame with a centre for these points. The exponent is 0.
    pub fn around(points: impl IntoIterator<Item = P>) -> Self {
        let mut frame = Frame { centre: P::splat(0.0), exponent: 0, grid: 0.0 };
        let bounds = Bounds::of(points);
        let extent = (0..P::DIM).map(|i| bounds.high.coord(i) - bounds.low.coord(i)).fold(0.0, f64::max);
        if !(extent > 0.0 && extent.is_finite()) {
            return frame;
        }
        let unit = f64::from_bits(extent.to_bits() >> 52 << 52);
        for i in 0..P::DIM {
            let (low, high) = (bounds.low.coord(i), bounds.high.coord(i));
            let (least, most) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
            let centre = ((low + (high - low) * 0.5) / unit).round() * unit;
            if low * high > 0.0 && least >= FAR * extent && centre.is_finite() {
                frame.centre.set_coord(i, centre);
                frame.grid = frame.grid.max(most.next_up() - most);
            }
        }
        frame
    }

    /// Returns the frame with an exponent.
    #[must_use]
    pub fn scaled(self, exponent: i32) -> Self {
        Frame { exponent, grid: scale(P::splat(self.grid), exponent).coord(0), ..self }
    }

    /// Returns `true` if at least one axis is translated.
    pub fn is_translated(&self) -> bool {
        self.grid > 0.0
    }

    /// Returns the step between adjacent doubles at the largest coordinate of a translated axis, in scaled
    /// coordinates, or 0 if no axis is translated.
    pub fn grid(&self) -> f64 {
        self.grid
    }

    /// Converts a point of the file to the coordinates of the domain.
    pub fn inward(&self, p: P) -> P {
        scale(if self.is_translated() { p - self.centre } else { p }, self.exponent)
    }

    /// Converts a point of the domain to the coordinates of the file.
    pub fn outward(&self, p: P) -> P {
        let p = scale(p, -self.exponent);
        if self.is_translated() { p + self.centre } else { p }
    }

    /// Moves a point of the domain to the nearest point that can be written.
    pub fn snapped(&self, p: P) -> P {
        if self.is_translated() { self.inward(self.outward(p)) } else { p }
    }

    /// Returns `true` if [`Self::inward`] is exact for a point of the file.
    pub fn is_exact(&self, p: P) -> bool {
        (0..P::DIM).all(|i| {
            let (x, c) = (p.coord(i), self.centre.coord(i));
            // The rounding error of the difference (Knuth).
            let d = x - c;
            let back = x - d;
            (x - (d + back)) + (back - c) == 0.0
        })
    }

    /// Converts a length of the file to the coordinates of the domain.
    pub fn scaled_length(&self, x: f64) -> f64 {
        scale(P::splat(x), self.exponent).coord(0)
    }

    /// Converts a length of the domain to the unit of the file.
    pub fn length(&self, x: f64) -> f64 {
        scale(P::splat(x), -self.exponent).coord(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        /// Points of the domain and snapped points pass through the frame without a change.
        #[test]
        fn frames_are_exact(
            unit in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64), 4..20),
            power in -3..40i32, far in -1e12..1e12f64, side in 1e-3..1e3f64,
        ) {
            let offset = DVec3::new(far, -far * 0.37, 2f64.powi(power));
            let points: Vec<DVec3> = unit.iter().map(|&p| DVec3::from(p) * side + offset).collect();
            let frame = Frame::around(points.iter().copied()).scaled(power);
            for (&p, &q) in points.iter().zip(&points[1..]) {
                prop_assert!(frame.is_exact(p));
                prop_assert_eq!(frame.outward(frame.inward(p)), p);
                let inner = frame.snapped((frame.inward(p) * 0.3) + frame.inward(q) * 0.7);
                prop_assert_eq!(frame.inward(frame.outward(inner)), inner);
                prop_assert!(!frame.is_translated() || frame.is_exact(frame.outward(inner)));
            }
        }
    }

    #[test]
    fn only_far_axes_are_translated() {
        let cube = |at: DVec3| [at, at + DVec3::ONE];
        assert_eq!(Frame::around(cube(DVec3::ZERO)).grid(), 0.0);
        assert!(!Frame::around(cube(DVec3::splat(-0.5))).is_translated());
        let frame = Frame::around(cube(DVec3::new(447_000.0, 5_411_000.0, 2.0)));
        assert_eq!(frame.centre, DVec3::new(447_001.0, 5_411_001.0, 0.0));
        assert_eq!(frame.grid(), 2f64.powi(-30));
        assert!(frame.is_exact(DVec3::new(0.5, 1.0, 0.1)) && !frame.is_exact(DVec3::new(1e-9, 0.0, 0.0)));
    }
}
