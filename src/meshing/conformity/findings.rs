//! What a check found: defects, measures, and how far a boundary is from its surface.

use super::defect::MeshDefect;

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conformity {
    /// What is wrong: by features from corners to facets within each kind of check.
    pub defects: Vec<MeshDefect>,
    /// Area or volume of the domain and of the mesh, in the unit of the file.
    pub measure: [f64; 2],
    /// Length or area of the domain's boundary towards the outside and of the mesh's, in the unit of the file.
    pub boundary: [f64; 2],
    /// Of a boundary that follows a surface, how far they are from each other.
    pub deviation: Option<Deviation>,
}

impl Conformity {
    /// Do the arrays not even fit together, so that nothing else could be looked at?
    pub fn is_shapeless(&self) -> bool {
        self.measure == [0.0; 2] && !self.is_clean()
    }

    /// Is nothing wrong?
    pub fn is_clean(&self) -> bool {
        self.defects.is_empty()
    }
}

/// How far a boundary and the surface that it follows are from each other, in the unit of the file. Both are lower bounds of
/// the two halves of the Hausdorff distance, each attained at a place that was looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The largest distance from the surface, of the middle of each face and of the thirds of its edges.
    pub of_boundary: f64,
    /// The largest distance of a vertex of the surface from the boundary.
    pub of_surface: f64,
    /// Edges of the boundary that are shorter than half the size at both their ends: what thin sheets, ridges that meet and the
    /// distance asked for have made of it.
    pub finer: u64,
    /// Euler characteristics of boundary and surface: if they differ, one has handles that the other has not.
    pub euler: [i64; 2],
}
