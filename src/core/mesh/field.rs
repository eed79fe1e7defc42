//! Sizes at points, as `--size-field` gives them.

use septet_geometry::point::Point;
use septet_meshing::size::cones::Cone;

use super::request::MeshError;

/// Sizes at points of the plane or of space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SizeField {
    /// 2 or 3.
    pub dimension: usize,
    /// The coordinates, and the size there in place of the next one.
    pub rows: Vec<([f64; 3], f64)>,
}

impl SizeField {
    /// The sizes as a size function takes them.
    ///
    /// # Errors
    /// [`MeshError::Dimension`].
    pub fn cones<P: Point>(&self) -> Result<Vec<Cone<P>>, MeshError> {
        if self.dimension != P::DIM {
            let what = "--size-field";
            return Err(MeshError::Dimension { what, expected: P::DIM, found: self.dimension });
        }
        Ok(self.rows.iter().map(|&(at, size)| Cone { at: P::from_coords(&at[..P::DIM]), size }).collect())
    }
}
