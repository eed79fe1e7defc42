//! A constrained triangulation with doubles, and the parts of the input that it keeps.

use glam::DVec3;

use crate::generate::GeneratedMesh;
use crate::mesh::Carrier;
use crate::space::Space;

/// An edge of the input that the mesh keeps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ends: [u32; 2],
    /// The feature that carries it.
    pub(super) carrier: Carrier,
}

/// A constrained triangulation, with the parts of the input that it keeps.
pub(super) struct Recovered<P: Space> {
    pub(super) mesh: GeneratedMesh<P>,
    /// The number of cells that rounding would have made flat or inverted.
    pub(super) rounded: u64,
    /// The number of vertices of the input, which come first.
    pub(super) given: u32,
    /// The patch of each face of the mesh.
    pub(super) patches: Vec<u32>,
    /// The facet of each patch.
    pub(super) facets: Vec<u32>,
    /// A point and the unit normal of the plane of each patch, from triangles of the input.
    pub(super) planes: Vec<[DVec3; 2]>,
    /// The edges of the input.
    pub(super) lines: Vec<Line>,
    /// Their parts, ends ascending, with the positions of the lines.
    pub(super) edges: Vec<([u32; 2], u32)>,
}
