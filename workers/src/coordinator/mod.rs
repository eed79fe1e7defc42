//! The duties of rank 0, the coordinator.
//!
//! The coordinator runs the same program as every rank ([`crate::programs`]): it leads the root of the tree and owns no
//! point. In some phases it has further duties, which are here: it distributes the input, triangulates gathered stars,
//! decides on certificates and collects the result.

mod region;
mod share;
mod source;
mod verdict;

pub(crate) use region::Region;
pub use share::{CellRows, Certificate, Choice, Counted, PieceRows, Selected, Share};
pub use source::Source;
pub(crate) use source::distribute;
pub(crate) use verdict::judge;
