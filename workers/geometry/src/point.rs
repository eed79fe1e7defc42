//! Points, their coordinates and the total order on them.
//!
//! A dimension is one implementation of [`Point`] (for [`DVec2`], [`DVec3`] and [`crate::higher::VecN`]). Every
//! algorithm of the project is written once, over this trait. A point with a weight ([`crate::site::Weighted`]) is also a [`Point`]: its position
//! decides everything but conflicts. The lexicographic order of coordinates ([`lex_cmp`]) breaks ties of all kinds, so
//! no result depends on the numbering of the input.

use std::cmp::Ordering;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Sub};

use bytemuck::Pod;
use glam::{DVec2, DVec3, DVec4};

use crate::filter::{self, Rounded};

/// A vector of a small fixed dimension with `f64` coordinates.
pub trait Vector:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Number of coordinates.
    const LEN: usize;
    /// Creates a vector with all coordinates equal to `value`.
    fn splat(value: f64) -> Self;
    /// Returns the `i`-th coordinate, `i < LEN`.
    fn coord(&self, i: usize) -> f64;
    /// Replaces the `i`-th coordinate, `i < LEN`.
    fn set_coord(&mut self, i: usize, value: f64);
    /// Computes the inner product, summed in the order of the coordinates.
    fn dot(self, other: Self) -> f64;
    /// Computes the squared Euclidean length.
    fn norm2(self) -> f64 {
        self.dot(self)
    }
}

macro_rules! vector {
    ($t:ty, $len:expr) => {
        impl Vector for $t {
            const LEN: usize = $len;
            #[inline]
            fn splat(value: f64) -> Self {
                <$t>::splat(value)
            }
            #[inline]
            fn coord(&self, i: usize) -> f64 {
                // Indexing a vector branches on the index; indexing an array does not.
                AsRef::<[f64; $len]>::as_ref(self)[i]
            }
            #[inline]
            fn set_coord(&mut self, i: usize, value: f64) {
                AsMut::<[f64; $len]>::as_mut(self)[i] = value;
            }
            #[inline]
            fn dot(self, other: Self) -> f64 {
                <$t>::dot(self, other)
            }
        }
    };
}
vector!(DVec2, 2);
vector!(DVec3, 3);
vector!(DVec4, 4);

/// A fixed-size tuple of vertex indices: `[u32; N]`.
pub trait Simplex:
    Copy + Debug + Eq + Ord + std::hash::Hash + Send + Sync + 'static + Pod + AsRef<[u32]> + AsMut<[u32]>
{
    /// Number of vertices.
    const LEN: usize;
    /// Creates a simplex with all entries equal to `v`.
    fn splat(v: u32) -> Self;
}

impl<const N: usize> Simplex for [u32; N]
where
    [u32; N]: Pod,
{
    const LEN: usize = N;
    fn splat(v: u32) -> Self {
        [v; N]
    }
}

/// An array of a fixed length: `[T; N]`.
pub trait Array<T>: AsRef<[T]> + AsMut<[T]> {
    /// Creates the array of the values of `f` at all positions.
    fn from_fn(f: impl FnMut(usize) -> T) -> Self;
}

impl<T, const N: usize> Array<T> for [T; N] {
    #[inline]
    fn from_fn(f: impl FnMut(usize) -> T) -> Self {
        std::array::from_fn(f)
    }
}

pub(crate) mod sealed {
    /// Prevents implementations of the point traits outside this crate.
    pub trait Sealed {}
}

impl sealed::Sealed for DVec2 {}
impl sealed::Sealed for DVec3 {}

/// A point of the plane, of space or of dimension 4 to 6, with or without a weight. Its implementations alone define the
/// dimensions.
///
/// Predicates take slices because their arity depends on the dimension: a *cell* has `DIM + 1` points. The determinants
/// of this trait are rounded; [`crate::predicates`] computes their exact signs.
pub trait Point: Vector + Pod + Default + sealed::Sealed {
    /// The dimension: 2 to 6.
    const DIM: usize;
    /// Whether points have weights.
    const IS_WEIGHTED: bool = false;
    /// Vectors one dimension higher, for the stereographic lift.
    type Lifted: Vector + Pod + Default;
    /// `[u32; DIM]`: a facet of a cell, or of the link of a vertex.
    type Facet: Simplex;
    /// `[u32; DIM + 1]`: a cell (triangle, tetrahedron or simplex of a higher dimension).
    type Cell: Simplex;
    /// `[u64; DIM + 1]`: a cell by input indices, as a row of a file.
    type Row: Pod + Ord + Send + Sync + AsMut<[u64]> + AsRef<[u64]>;
    /// The points of a cell: `[Self; DIM + 1]`, and 4 in the plane.
    type Corners: Array<Self> + Copy;
    /// A value for each axis: `[T; DIM]`, and 3 in the plane.
    type Axes<T: Clone + Debug + Send + Sync>: Array<T> + Clone + Debug + Send + Sync;
    /// The numbers that encode a separator: `[f64; 2 DIM + 3]`, and 9 in the plane.
    type SeparatorWords: Array<f64> + Copy + Debug + PartialEq + Send + Sync;

    /// Computes the orientation determinant of `DIM + 1` points in rounded arithmetic. It is positive for
    /// counter-clockwise triangles and for tetrahedra with `((p1-p0) x (p2-p0)) . (p3-p0) > 0`.
    fn rounded_orientation(cell: &[Self]) -> Rounded;
    /// Computes the in-sphere determinant in rounded arithmetic. It is positive if `q` lies strictly inside the
    /// circumsphere of the positively oriented `cell`.
    fn rounded_in_sphere(cell: &[Self], q: Self) -> Rounded;
    /// Computes the sphere through the origin and the `DIM` vectors of `rel` in rounded arithmetic. Returns `(w, v)`
    /// such that, for a positively oriented cell `(0, rel..)`, a point `q` lies inside iff `w |q|^2 - v . q < 0`.
    fn sphere_plane(rel: &[Self]) -> (f64, Self);
    /// Computes the normal `n` of the hyperplane through the origin and the `DIM - 1` vectors of `rel` in rounded
    /// arithmetic. The sign of `n . q` is the orientation of `(0, rel.., q)`.
    fn hull_normal(rel: &[Self]) -> Self;
    /// Creates a point from the first `DIM` numbers of a slice. Its weight is 0.
    fn from_coords(coords: &[f64]) -> Self;
    /// Returns the weight, a squared length; 0 for a point without a weight.
    #[inline]
    fn weight(&self) -> f64 {
        0.0
    }
    /// Replaces the weight of a point that has one.
    #[inline]
    fn set_weight(&mut self, _weight: f64) {}
    /// Returns the low part of the `i`-th coordinate: what its rounding lost, if the point is an image
    /// ([`crate::site`]); otherwise 0.
    #[inline]
    fn low(&self, _i: usize) -> f64 {
        0.0
    }
    /// Returns the largest absolute low part.
    #[inline]
    fn largest_low(&self) -> f64 {
        0.0
    }
}

/// A point without a weight: [`DVec2`] or [`DVec3`]. Its determinants take lifts from the caller.
pub trait Position: Point {
    /// Computes [`Point::rounded_in_sphere`], where `drops[i]` lowers the lift `|p_i - q|^2` of corner `i`.
    fn rounded_power(cell: &[Self], q: Self, drops: [f64; 4]) -> Rounded;
    /// Computes [`Point::sphere_plane`], where `lifts[i]` replaces the squared length of vector `i`.
    fn lifted_plane(rel: &[Self], lifts: [f64; 3]) -> (f64, Self);
}

impl Point for DVec2 {
    const DIM: usize = 2;
    type Lifted = DVec3;
    type Facet = [u32; 2];
    type Cell = [u32; 3];
    type Row = [u64; 3];
    type Corners = [Self; 4];
    type Axes<T: Clone + Debug + Send + Sync> = [T; 3];
    type SeparatorWords = [f64; 9];

    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_orientation(cell: &[Self]) -> Rounded {
        filter::orient_plane(cell)
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_in_sphere(cell: &[Self], q: Self) -> Rounded {
        filter::in_circle::<false>(cell, q, [0.0; 4])
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn sphere_plane(rel: &[Self]) -> (f64, Self) {
        let (a, b) = (rel[0], rel[1]);
        Self::lifted_plane(rel, [a.dot(a), b.dot(b), 0.0])
    }
    #[inline]
    fn hull_normal(rel: &[Self]) -> Self {
        DVec2::new(-rel[0].y, rel[0].x)
    }
    fn from_coords(c: &[f64]) -> Self {
        DVec2::new(c[0], c[1])
    }
}

impl Position for DVec2 {
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_power(cell: &[Self], q: Self, drops: [f64; 4]) -> Rounded {
        filter::in_circle::<true>(cell, q, drops)
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn lifted_plane(rel: &[Self], [aa, bb, _]: [f64; 3]) -> (f64, Self) {
        let (a, b) = (rel[0], rel[1]);
        let v = DVec2::new(b.y, -b.x) * aa + DVec2::new(-a.y, a.x) * bb;
        (a.x * b.y - a.y * b.x, v)
    }
}

impl Point for DVec3 {
    const DIM: usize = 3;
    type Lifted = DVec4;
    type Facet = [u32; 3];
    type Cell = [u32; 4];
    type Row = [u64; 4];
    type Corners = [Self; 4];
    type Axes<T: Clone + Debug + Send + Sync> = [T; 3];
    type SeparatorWords = [f64; 9];

    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_orientation(cell: &[Self]) -> Rounded {
        filter::orient_space(cell)
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_in_sphere(cell: &[Self], q: Self) -> Rounded {
        filter::in_sphere::<false>(cell, q, [0.0; 4])
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn sphere_plane(rel: &[Self]) -> (f64, Self) {
        let (a, b, c) = (rel[0], rel[1], rel[2]);
        Self::lifted_plane(rel, [a.dot(a), b.dot(b), c.dot(c)])
    }
    #[inline]
    fn hull_normal(rel: &[Self]) -> Self {
        rel[0].cross(rel[1])
    }
    fn from_coords(c: &[f64]) -> Self {
        DVec3::new(c[0], c[1], c[2])
    }
}

impl Position for DVec3 {
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn rounded_power(cell: &[Self], q: Self, drops: [f64; 4]) -> Rounded {
        filter::in_sphere::<true>(cell, q, drops)
    }
    #[expect(clippy::inline_always, reason = "see `filter`")]
    #[inline(always)]
    fn lifted_plane(rel: &[Self], [aa, bb, cc]: [f64; 3]) -> (f64, Self) {
        let (a, b, c) = (rel[0], rel[1], rel[2]);
        let bc = b.cross(c);
        let v = bc * aa + c.cross(a) * bb + a.cross(b) * cc;
        (a.dot(bc), v)
    }
}

/// Compares coordinates lexicographically. This order breaks every tie. Coordinates must be finite, and `-0.0` must
/// have been replaced by `0.0`.
#[inline]
pub fn lex_cmp<P: Point>(a: &P, b: &P) -> Ordering {
    // In nearly all calls the first coordinates differ, and this comparison suffices. Equal coordinates go to the loop.
    let (x, y) = (a.coord(0), b.coord(0));
    if x < y {
        return Ordering::Less;
    }
    if x > y {
        return Ordering::Greater;
    }
    for i in 0..P::DIM {
        match a.coord(i).total_cmp(&b.coord(i)) {
            Ordering::Equal => {}
            other => return other,
        }
        // Rounding preserves the order except for ties, which the low parts decide.
        if P::IS_WEIGHTED && a.low(i) != b.low(i) {
            return a.low(i).total_cmp(&b.low(i));
        }
    }
    Ordering::Equal
}

/// Returns `true` if `a` precedes `b` in the order of [`lex_cmp`]. Avoids an unpredictable branch if first coordinates
/// are rarely equal.
#[inline]
pub fn is_lex_smaller<P: Point>(a: &P, b: &P) -> bool {
    let (x, y) = (a.coord(0), b.coord(0));
    if x == y { lex_cmp(a, b).is_lt() } else { x < y }
}

/// Computes the squared distance, by the one expression that computes distances everywhere. The result is symmetric
/// in the arguments.
#[inline]
pub fn dist2<P: Point>(a: P, b: P) -> f64 {
    (a - b).norm2()
}
