//! The input of a run: the rows of the caller.

mod held;
pub mod sequential;
mod whole;

pub(crate) use held::Held;
pub(crate) use whole::Whole;
