//! The result of a check: defects, measures, and the distances between boundary and surface.

use super::defect::MeshDefect;

/// The result of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conformity {
    /// The defects. Within each kind of check, they are sorted by features from corners to facets.
    pub defects: Vec<MeshDefect>,
    /// Area or volume of the domain and of the mesh, in the unit of the file.
    pub measure: [f64; 2],
    /// Length or area of the outer boundary of the domain and of the mesh, in the unit of the file.
    pub boundary: [f64; 2],
    /// The distances between a remeshed boundary and its surface. `None` for exact boundaries.
    pub deviation: Option<Deviation>,
}

impl Conformity {
    /// Returns `true` if no other check ran because the arrays are inconsistent.
    pub fn is_shapeless(&self) -> bool {
        self.measure == [0.0; 2] && !self.is_clean()
    }

    /// Returns `true` if there are no defects.
    pub fn is_clean(&self) -> bool {
        self.defects.is_empty()
    }
}

/// The distances between a remeshed boundary and its surface, in the unit of the file. The two distances are lower
/// bounds for the two one-sided Hausdorff distances. Each is attained at a sampled point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The largest distance to the surface, over the centre of each face and the points that divide its edges in
    /// thirds.
    pub of_boundary: f64,
    /// The largest distance from a vertex of the surface to the boundary.
    pub of_surface: f64,
    /// The number of boundary edges shorter than half the size at both ends. Such edges are caused by thin sheets,
    /// ridges that meet, and the requested distance.
    pub finer: u64,
    /// Euler characteristics of boundary and surface. If they differ, the numbers of handles differ.
    pub euler: [i64; 2],
}
