//! The dimensions of queries: the plane and space.

use glam::{DVec2, DVec3};
use septet_geometry::point::Position;
use septet_meshing::space::Space;

/// The plane or space, with what queries need to know about it.
pub trait Dimension: Position + Space {
    /// The edges of a cell: pairs of its corners. In space, the other two corners `j` and `k` follow in the order that makes
    /// `(v, i, j, k)` an even permutation; in the plane, `(v, i, j)` is one, and the last entry is not used.
    const EDGES: &'static [[usize; 4]];
}

impl Dimension for DVec2 {
    const EDGES: &'static [[usize; 4]] = &[[0, 1, 2, 0], [1, 2, 0, 0], [2, 0, 1, 0]];
}

impl Dimension for DVec3 {
    const EDGES: &'static [[usize; 4]] =
        &[[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];
}
