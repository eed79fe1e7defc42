//! The duties of rank 0, the coordinator.
//!
//! The coordinator runs the same program as every rank ([`crate::programs`]): it leads the root of the tree and owns no
//! point. In some phases it has further duties. Two are here: it distributes the input and collects the result. It also
//! decides on certificates (`result::decision`), and triangulates gathered stars (`splaying::region`).

mod share;
mod source;

pub use share::{CellRows, Certificate, Choice, MachineCounts, OwnedPoints, PieceRows, Selected, Share};
pub use source::Source;
pub(crate) use source::distribute;
