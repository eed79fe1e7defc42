//! Both ends of a run: the input that the ranks read, and the results that stay with them.
//!
//! Rank 0, the coordinator, runs the same program as every rank ([`crate::programs`]) and owns no point. It announces the
//! number of points and the frame, which is here. It also chooses the supergraph (`graph::selection`), decides on
//! certificates (`result::decision`), and triangulates gathered stars (`splaying::region`). Neither the points nor the
//! results of the ranks pass through the coordinator ([`Source`], [`Share`]).

mod share;
mod source;

pub use share::{CellRows, Certificate, Choice, PieceRows, Seam, Selected, Share, merged_ledger};
pub use source::Source;
pub(crate) use source::announce;
