//! The input of the verifier: points and cells as flat arrays.

/// Points and cells to be verified.
#[derive(Clone, Copy, Debug)]
pub struct Triangulation<'a> {
    /// 2 or 3.
    pub dimension: usize,
    /// All points, `dimension` coordinates each.
    pub coordinates: &'a [f64],
    /// `dimension + 1` zero-based point indices per cell.
    pub cells: &'a [u64],
}

impl Triangulation<'_> {
    /// Returns the number of points.
    pub fn point_count(&self) -> usize {
        self.coordinates.len() / self.dimension
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / (self.dimension + 1)
    }
}
