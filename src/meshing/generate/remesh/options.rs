//! Options of remeshing.

/// The default for the largest distance between the centre of a face and the surface, relative to f.
pub const DEFAULT_DISTANCE: f64 = 0.1;

/// The default size is the diagonal of the bounding box divided by this number.
pub const DEFAULT_PARTS: f64 = 30.0;

/// The options for the new boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The largest [`Deviation`](crate::conformity::Deviation), in the unit of the file. By default, the limit is
    /// [`DEFAULT_DISTANCE`] times f from the centres of faces to the surface, and [`LOOSE`](crate::conformity::LOOSE)
    /// times f in both directions.
    pub distance: Option<f64>,
}
