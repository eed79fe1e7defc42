//! Options of remeshing.

/// The largest distance between a face's centre and the surface, over f, where nothing is asked for.
pub const DEFAULT_DISTANCE: f64 = 0.1;

/// The size where nothing is asked for: the diagonal of the surface's box over this.
pub const DEFAULT_PARTS: f64 = 30.0;

/// How a surface is followed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The largest [`Deviation`](crate::conformity::Deviation), in the unit of the file. If not said, [`DEFAULT_DISTANCE`] times f, from the centres of
    /// faces to the surface, and [`LOOSE`](crate::conformity::LOOSE) times f both ways.
    pub distance: Option<f64>,
}
