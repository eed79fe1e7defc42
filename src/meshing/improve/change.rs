//! A change of a few cells, before it is applied.

use super::shape::Grade;
use crate::mesh::Carrier;

/// The number of the vertex that a change inserts.
pub(super) const NEW: u32 = u32::MAX - 1;

/// The kind of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A vertex moves.
    Move,
    /// An edge or a face is replaced.
    Flip,
    /// The boundary of a remeshed surface loses cells.
    Peel,
    /// A vertex is inserted.
    Insert,
    /// A vertex is merged with a neighbour.
    Merge,
}

/// A vertex at a new place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<P> {
    /// The vertex, or [`NEW`].
    pub(super) vertex: u32,
    pub(super) at: P,
    pub(super) carrier: Carrier,
    pub(super) size: f64,
}

/// Cells, faces and edges that replace others.
#[derive(Clone, Debug)]
pub(super) struct Change<P> {
    pub(super) kind: Kind,
    /// The grade of the cells afterwards.
    pub(super) grade: Grade,
    /// The cells that are replaced. If a vertex moves, the cells around it.
    pub(super) old: Vec<u32>,
    /// The new cells, positively oriented, with their regions.
    pub(super) new: Vec<([u32; 4], u32)>,
    /// Faces on facets that vanish, ascending.
    pub(super) lost_faces: Vec<[u32; 3]>,
    /// New faces, ascending, with their facets.
    pub(super) made_faces: Vec<([u32; 3], u32)>,
    /// Edges on segments that vanish, ascending.
    pub(super) lost_edges: Vec<[u32; 2]>,
    /// New edges, ascending, with their segments.
    pub(super) made_edges: Vec<([u32; 2], u32)>,
    /// An edge that must not be an edge of the boundary when the change is applied.
    pub(super) fresh: Option<[u32; 2]>,
    /// The vertex that moves or is new.
    pub(super) placed: Option<Placed<P>>,
    /// The volume that the mesh loses.
    pub(super) shrinks: f64,
}

impl<P> Change<P> {
    /// Creates a change without faces and edges.
    pub(super) fn of(kind: Kind, grade: Grade, old: Vec<u32>, new: Vec<([u32; 4], u32)>) -> Self {
        Change {
            kind,
            grade,
            old,
            new,
            lost_faces: Vec::new(),
            made_faces: Vec::new(),
            lost_edges: Vec::new(),
            made_edges: Vec::new(),
            fresh: None,
            placed: None,
            shrinks: 0.0,
        }
    }
}

/// Sorts three vertices.
pub(super) fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}
