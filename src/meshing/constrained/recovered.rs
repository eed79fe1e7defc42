//! A constrained triangulation with doubles, and the parts of the input that it keeps.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::generate::StageCounts;
use crate::mesh::Carrier;

/// An edge of the input that the mesh keeps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ends: [u32; 2],
    /// The feature that carries it.
    pub(super) carrier: Carrier,
}

/// A constrained triangulation, with the parts of the input that it keeps.
pub(super) struct Recovered {
    pub(super) at: Vec<DVec3>,
    pub(super) carriers: Vec<Carrier>,
    /// Positive cells inside the domain.
    pub(super) cells: Vec<[u32; 4]>,
    /// The component of each cell.
    pub(super) labels: Vec<u32>,
    /// The number of cells that rounding would have made flat or inverted.
    pub(super) rounded: u64,
    /// The number of vertices of the input, which come first.
    pub(super) given: u32,
    /// The faces on patches, vertices ascending, with their patches.
    pub(super) faces: BTreeMap<[u32; 3], u32>,
    /// The facet of each patch.
    pub(super) facets: Vec<u32>,
    /// A point and the unit normal of the plane of each patch, from triangles of the input.
    pub(super) planes: Vec<[DVec3; 2]>,
    /// The edges of the input.
    pub(super) lines: Vec<Line>,
    /// Their parts, ends ascending, with the positions of the lines.
    pub(super) edges: Vec<([u32; 2], u32)>,
    /// The counts of the stages so far.
    pub(super) stages: Vec<StageCounts>,
}
