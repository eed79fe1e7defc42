//! The input of the verifier: points, cells, weights and offsets as flat arrays.

/// Points and cells to be verified.
#[derive(Clone, Copy, Debug)]
pub struct Triangulation<'a> {
    /// 2 to 6. Weights and periodic boxes have 2 or 3.
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
        Sites { mesh: self, weights: Some(weights), periodic: None }
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

/// Cells of points that may have weights and images in a periodic box. The conversion of a [`Triangulation`] has none.
#[derive(Clone, Copy, Debug)]
pub struct Sites<'a> {
    /// The points and the cells.
    pub mesh: Triangulation<'a>,
    /// The weight of each point, or `None`. Cells of points with weights must be a regular triangulation.
    pub weights: Option<&'a [f64]>,
    /// The periodic box of the points, or `None`.
    pub periodic: Option<PeriodicBox<'a>>,
}

/// A box that repeats along its axes, and the images of points that are vertices. The cells are one of each class of translated
/// cells.
///
/// The points may lie anywhere: a point stands for all its images.
#[derive(Clone, Copy, Debug)]
pub struct PeriodicBox<'a> {
    /// The length along each axis, or `None` for an axis that is not periodic.
    pub lengths: &'a [Option<f64>],
    /// `dimension` whole numbers of lengths for each index of [`Triangulation::cells`]: a vertex lies at its point plus these
    /// numbers times the lengths. Numbers of axes that are not periodic are 0.
    pub offsets: &'a [i32],
}

impl<'a> From<&Triangulation<'a>> for Sites<'a> {
    fn from(mesh: &Triangulation<'a>) -> Self {
        Sites { mesh: *mesh, weights: None, periodic: None }
    }
}
