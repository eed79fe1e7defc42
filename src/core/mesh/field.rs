//! The size field of a request: sizes at points.

use septet_geometry::point::Point;
use septet_meshing::size::cones::Cone;

use super::error::MeshError;

/// Sizes at points of the plane or of space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SizeField {
    /// Either 2 or 3.
    pub dimension: usize,
    /// Coordinates and the size there. Coordinates beyond the dimension are ignored.
    pub rows: Vec<([f64; 3], f64)>,
}

impl SizeField {
    /// Converts the sizes to cones of a size function.
    ///
    /// # Errors
    /// Returns [`MeshError::Dimension`].
    pub fn cones<P: Point>(&self) -> Result<Vec<Cone<P>>, MeshError> {
        if self.dimension != P::DIM {
            let what = "size field";
            return Err(MeshError::Dimension { what, expected: P::DIM, found: self.dimension });
        }
        Ok(self.rows.iter().map(|&(at, size)| Cone { at: P::from_coords(&at[..P::DIM]), size }).collect())
    }
}
