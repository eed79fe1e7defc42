//! The state of remeshing, which its stages share.

use super::chord::Chord;
use super::features::SurfaceFeatures;
use super::surface::Surface;
use crate::bvh::Bvh;
use crate::generate::generator::Generator;
use crate::space::Space;

/// The generator of meshes with a remeshed boundary.
pub(super) struct Refinement<'a, P: Space, M> {
    pub(super) generator: Generator<'a, P, M>,
    pub(super) features: &'a SurfaceFeatures,
    pub(super) surface: Surface<P>,
    /// The distance requested, in scaled coordinates.
    pub(super) distance: Option<f64>,
    /// The ridge of each segment, and the position of the segment in it.
    pub(super) ridge_of: Vec<Option<(u32, u32)>>,
    /// The radius, relative to f, below which balls are not divided for thin sheets.
    pub(super) thinnest: f64,
    /// The Euler characteristic of the surface.
    pub(super) euler: i64,
    /// The number of vertices of the first boundary whose only fault is a wrong number of handles.
    pub(super) whole: Option<usize>,
    pub(super) chords: Vec<Chord<P>>,
    /// The chords that end at each corner.
    pub(super) at_corners: Vec<Vec<u32>>,
    /// The tree of the bounding boxes of the chords.
    pub(super) chord_tree: Bvh<P>,
}

/// Returns the edges of a face, ends ascending.
pub(super) fn edges_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [a, c], [b, c]]
}
