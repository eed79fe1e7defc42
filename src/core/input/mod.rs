//! The input of a run: the rows of the caller, and their use.

mod prepared;
pub mod sequential;
mod whole;

pub(crate) use prepared::Prepared;
pub(crate) use whole::Whole;
