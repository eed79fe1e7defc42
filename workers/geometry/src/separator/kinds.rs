//! A separator of any kind: a surface, or a cut of a curve.

use super::curve_cut::{CurveCube, CurveCut};
use super::surface::{Quadric, Side, Surface, places};
use crate::point::Point;

/// A separator: the interior points, the others, and a one-sided crossing test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Separator<P> {
    /// A sphere or a plane.
    Quadric(Quadric<P>),
    /// A cut of a Hilbert curve, whose sides are unions of cubes.
    Curve(CurveCut<P>),
}

impl<P> From<Quadric<P>> for Separator<P> {
    fn from(surface: Quadric<P>) -> Self {
        Separator::Quadric(surface)
    }
}

impl<P> From<CurveCut<P>> for Separator<P> {
    fn from(cut: CurveCut<P>) -> Self {
        Separator::Curve(cut)
    }
}

impl<P: Point> Separator<P> {
    /// Creates the axis-aligned cut at a coordinate ([`Quadric::plane`]).
    pub fn plane(axis: usize, at: f64) -> Self {
        Quadric::plane(axis, at).into()
    }

    /// Returns the side of a point, equal on all workers.
    #[inline]
    pub fn side(&self, x: P) -> Side {
        match self {
            Separator::Quadric(surface) => surface.side(x),
            Separator::Curve(cut) => cut.side(x),
        }
    }

    /// Returns `true` if the closed ball may contain points of both sides. See [`Quadric::crosses`] for the guarantee.
    #[inline]
    pub fn crosses(&self, x: P, radius: f64) -> bool {
        match self {
            Separator::Quadric(surface) => surface.crosses(x, radius),
            Separator::Curve(cut) => cut.reaches(x, radius, cut.side(x).opposite()),
        }
    }

    /// Returns `true` if `x` lies on the given side or the ball may cross.
    #[inline]
    pub fn reaches(&self, x: P, radius: f64, side: Side) -> bool {
        match self {
            Separator::Quadric(surface) => surface.reaches(x, radius, side),
            Separator::Curve(cut) => cut.reaches(x, radius, side),
        }
    }

    /// Counts the balls that cross and have interior centres, and those that cross and have exterior centres. Balls are
    /// pairs of centre and radius.
    pub fn count_crossing(&self, balls: impl Iterator<Item = (P, f64)>) -> [u64; 2] {
        match self {
            Separator::Quadric(surface) => surface.count_crossing(balls),
            Separator::Curve(cut) => {
                let mut crossing = [0; 2];
                for (x, radius) in balls {
                    let side = cut.side(x);
                    crossing[side as usize] += u64::from(cut.reaches(x, radius, side.opposite()));
                }
                crossing
            }
        }
    }

    /// Returns the radius of a ball around `x` that does not cross, or 0 if none is found.
    pub fn clearance(&self, x: P) -> f64 {
        match self {
            Separator::Quadric(surface) => surface.clearance(x),
            Separator::Curve(cut) => cut.clearance(x),
        }
    }

    /// Returns `true` if the separator is a sphere.
    pub fn is_sphere(&self) -> bool {
        matches!(self, Separator::Quadric(surface) if surface.is_sphere())
    }

    /// Returns the surface and the location of its interior, rounded, for reports. Returns `None` if it exceeds the range
    /// of floats, and for a cut of a curve, which is no single surface.
    pub fn surface(&self) -> Option<Surface<P>> {
        match self {
            Separator::Quadric(surface) => surface.surface(),
            Separator::Curve(_) => None,
        }
    }

    /// Returns the cube of the curve, if the separator is a cut of a curve.
    pub fn curve_cube(&self) -> Option<CurveCube<P>> {
        match self {
            Separator::Quadric(_) => None,
            Separator::Curve(cut) => Some(cut.cube()),
        }
    }

    /// The number of numbers that encode a separator: 9, and `2 DIM + 3` above three dimensions.
    pub const WORDS: usize = 2 * places::<P>() + 3;

    /// Encodes the separator as numbers: origin (3), unit, a, b (3), c of a surface; for a cut of a curve, the low corner of
    /// the cube (3), minus its side, and the position on the curve in the places of `a` and `c`. Above three dimensions, `DIM` replaces 3.
    pub fn to_array(&self) -> P::SeparatorWords {
        match self {
            Separator::Quadric(surface) => surface.to_array(),
            Separator::Curve(cut) => cut.to_array(),
        }
    }

    /// Decodes [`Separator::to_array`]. Returns `None` if the numbers do not describe a separator.
    pub fn from_array(words: &[f64]) -> Option<Self> {
        if words.get(places::<P>()).is_some_and(|&unit| unit < 0.0) {
            CurveCut::from_array(words).map(Separator::Curve)
        } else {
            Quadric::from_array(words).map(Separator::Quadric)
        }
    }
}
