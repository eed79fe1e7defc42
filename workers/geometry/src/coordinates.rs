//! Slices of points as callers have them, of either dimension and with or without weights.

use glam::{DVec2, DVec3};

use crate::point::{Point, sealed};
use crate::site::Weighted;

impl sealed::Sealed for [f64; 2] {}
impl sealed::Sealed for [f64; 3] {}

/// Point types that callers use in slices: `[f64; 2]`, `[f64; 3]`, [`DVec2`], [`DVec3`], and [`Weighted`] for points
/// with weights.
pub trait Coordinates: Sized + sealed::Sealed {
    /// Reinterprets the same memory as points of the plane or of space.
    fn points(slice: &[Self]) -> PointSlice<'_>;
}

/// Borrowed points of either dimension, with or without weights.
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
}

impl PointSlice<'_> {
    /// Returns the number of points.
    pub fn len(&self) -> usize {
        match self {
            PointSlice::Plane(points) => points.len(),
            PointSlice::Space(points) => points.len(),
            PointSlice::WeightedPlane(points) => points.len(),
            PointSlice::WeightedSpace(points) => points.len(),
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
