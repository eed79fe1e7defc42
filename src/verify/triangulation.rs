//! The input of the verifier: points, cells and weights as flat arrays.

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

impl<'a> Triangulation<'a> {
    /// Returns the triangulation with a weight for each point.
    ///
    /// A weight is the square of a length, of either sign. A point without weights has the weight 0.
    pub fn weighted(self, weights: &'a [f64]) -> Sites<'a> {
        Sites { mesh: self, weights: Some(weights) }
    }

    /// Returns the number of points.
    pub fn point_count(&self) -> usize {
        self.coordinates.len() / self.dimension
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / (self.dimension + 1)
    }
}

/// Cells of points that may have weights. The conversion of a [`Triangulation`] has none.
#[derive(Clone, Copy, Debug)]
pub struct Sites<'a> {
    /// The points and the cells.
    pub mesh: Triangulation<'a>,
    /// The weight of each point, or `None`. Cells of points with weights must be a regular triangulation.
    pub weights: Option<&'a [f64]>,
}

impl<'a> From<&Triangulation<'a>> for Sites<'a> {
    fn from(mesh: &Triangulation<'a>) -> Self {
        Sites { mesh: *mesh, weights: None }
    }
}
