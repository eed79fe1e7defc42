//! Points of dimensions 4, 5 and 6.
//!
//! **Statement.** [`VecN`] is a vector of `N` coordinates, which glam does not have for `N > 4`. Its determinants are
//! those of `predicates::general`. The kernel of [`crate::incremental`] and the curve of
//! [`crate::separator`] exist in the plane and in space only, so points of these dimensions are triangulated by their
//! stars ([`crate::hull`]).
//!
//! **Work.** O(1) for a fixed dimension.

use std::ops::{Add, Div, Mul, Sub};

use bytemuck::{Pod, Zeroable};

use crate::filter::Rounded;
use crate::point::{Point, Vector, sealed};
use crate::predicates::general;

/// A vector of `N` coordinates. It is a [`Point`] for `N` of 4, 5 and 6.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct VecN<const N: usize>(pub [f64; N]);

impl<const N: usize> sealed::Sealed for VecN<N> {}

impl<const N: usize> Default for VecN<N> {
    fn default() -> Self {
        VecN([0.0; N])
    }
}

impl<const N: usize> Add for VecN<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        VecN(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<const N: usize> Sub for VecN<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        VecN(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl<const N: usize> Mul<f64> for VecN<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        VecN(self.0.map(|x| x * factor))
    }
}

impl<const N: usize> Div<f64> for VecN<N> {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        VecN(self.0.map(|x| x / divisor))
    }
}

impl<const N: usize> Vector for VecN<N> {
    const LEN: usize = N;
    #[inline]
    fn splat(value: f64) -> Self {
        VecN([value; N])
    }
    #[inline]
    fn coord(&self, i: usize) -> f64 {
        self.0[i]
    }
    #[inline]
    fn set_coord(&mut self, i: usize, value: f64) {
        self.0[i] = value;
    }
    #[inline]
    fn dot(self, other: Self) -> f64 {
        let mut sum = self.0[0] * other.0[0];
        for (a, b) in self.0.iter().zip(&other.0).skip(1) {
            sum += a * b;
        }
        sum
    }
}

macro_rules! point {
    ($d:literal) => {
        impl Point for VecN<$d> {
            const DIM: usize = $d;
            type Lifted = VecN<{ $d + 1 }>;
            type Facet = [u32; $d];
            type Cell = [u32; $d + 1];
            type Row = [u64; $d + 1];
            type Corners = [Self; $d + 1];
            type Axes<T: Clone + std::fmt::Debug + Send + Sync> = [T; $d];
            type SeparatorWords = [f64; 2 * $d + 3];

            fn rounded_orientation(cell: &[Self]) -> Rounded {
                general::rounded_orientation(cell)
            }
            fn rounded_in_sphere(cell: &[Self], q: Self) -> Rounded {
                general::rounded_in_sphere(cell, q)
            }
            fn sphere_plane(rel: &[Self]) -> (f64, Self) {
                general::sphere_plane(rel)
            }
            fn hull_normal(rel: &[Self]) -> Self {
                general::hull_normal(rel)
            }
            fn from_coords(coords: &[f64]) -> Self {
                VecN(std::array::from_fn(|i| coords[i]))
            }
        }
    };
}
point!(4);
point!(5);
point!(6);
