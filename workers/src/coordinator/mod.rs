//! The duties of rank 0, the coordinator.
//!
//! The coordinator runs the same program as every rank ([`crate::programs`]): it leads the root of the tree and owns no
//! point. In some phases it has further duties, which are here: it distributes the input, triangulates gathered stars,
//! decides on certificates and collects the result.

mod decision;
mod region;
mod share;
mod source;

pub(crate) use decision::decide;
pub(crate) use region::Region;
pub use share::{CellRows, Certificate, Choice, MachineCounts, PieceRows, Selected, Share};
pub use source::Source;
pub(crate) use source::distribute;
