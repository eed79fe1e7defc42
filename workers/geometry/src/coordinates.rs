//! Slices of points as callers have them, of any dimension and with or without weights.

use glam::{DVec2, DVec3};

use crate::higher::VecN;
use crate::point::{Point, sealed};
use crate::site::Weighted;

impl<const N: usize> sealed::Sealed for [f64; N] {}

/// Point types that callers use in slices: `[f64; 2]` to `[f64; 6]`, [`DVec2`], [`DVec3`], [`VecN`], and [`Weighted`] for
/// points with weights.
pub trait Coordinates: Sized + sealed::Sealed {
    /// Reinterprets the same memory as points.
    fn points(slice: &[Self]) -> PointSlice<'_>;
}

/// Borrowed points of any dimension, with or without weights.
#[derive(Clone, Copy, Debug)]
pub enum PointSlice<'a> {
    /// Points of the plane.
    Plane(&'a [DVec2]),
    /// Points of space.
    Space(&'a [DVec3]),
    /// Points of the plane with weights.
    WeightedPlane(&'a [Weighted<DVec2>]),
    /// Points of space with weights.
    WeightedSpace(&'a [Weighted<DVec3>]),
    /// Points of a higher dimension.
    Higher(HigherSlice<'a>),
}

/// Borrowed points of dimension 4, 5 or 6.
#[derive(Clone, Copy, Debug)]
pub enum HigherSlice<'a> {
    /// Points of dimension 4.
    Four(&'a [VecN<4>]),
    /// Points of dimension 5.
    Five(&'a [VecN<5>]),
    /// Points of dimension 6.
    Six(&'a [VecN<6>]),
}

impl HigherSlice<'_> {
    /// Returns the number of points.
    pub fn len(&self) -> usize {
        match self {
            HigherSlice::Four(points) => points.len(),
            HigherSlice::Five(points) => points.len(),
            HigherSlice::Six(points) => points.len(),
        }
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of coordinates of a point: 4, 5 or 6.
    pub fn dimension(&self) -> usize {
        match self {
            HigherSlice::Four(_) => 4,
            HigherSlice::Five(_) => 5,
            HigherSlice::Six(_) => 6,
        }
    }
}

impl PointSlice<'_> {
    /// Returns the number of points.
    pub fn len(&self) -> usize {
        match self {
            PointSlice::Plane(points) => points.len(),
            PointSlice::Space(points) => points.len(),
            PointSlice::WeightedPlane(points) => points.len(),
            PointSlice::WeightedSpace(points) => points.len(),
            PointSlice::Higher(points) => points.len(),
        }
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<P: Point> Coordinates for P {
    fn points(slice: &[P]) -> PointSlice<'_> {
        match (P::DIM, P::IS_WEIGHTED) {
            (2, false) => PointSlice::Plane(bytemuck::cast_slice(slice)),
            (4, false) => PointSlice::Higher(HigherSlice::Four(bytemuck::cast_slice(slice))),
            (5, false) => PointSlice::Higher(HigherSlice::Five(bytemuck::cast_slice(slice))),
            (6, false) => PointSlice::Higher(HigherSlice::Six(bytemuck::cast_slice(slice))),
            (_, false) => PointSlice::Space(bytemuck::cast_slice(slice)),
            (2, true) => PointSlice::WeightedPlane(bytemuck::cast_slice(slice)),
            (_, true) => PointSlice::WeightedSpace(bytemuck::cast_slice(slice)),
        }
    }
}

impl Coordinates for [f64; 2] {
    fn points(slice: &[[f64; 2]]) -> PointSlice<'_> {
        PointSlice::Plane(bytemuck::cast_slice(slice))
    }
}

impl Coordinates for [f64; 3] {
    fn points(slice: &[[f64; 3]]) -> PointSlice<'_> {
        PointSlice::Space(bytemuck::cast_slice(slice))
    }
}

macro_rules! arrays {
    ($d:literal, $slice:ident) => {
        impl Coordinates for [f64; $d] {
            fn points(slice: &[[f64; $d]]) -> PointSlice<'_> {
                PointSlice::Higher(HigherSlice::$slice(bytemuck::cast_slice(slice)))
            }
        }
    };
}
arrays!(4, Four);
arrays!(5, Five);
arrays!(6, Six);
