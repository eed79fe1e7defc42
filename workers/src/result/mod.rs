//! The result: the merged certificate, the decision on it, the owned cells, and the data for pictures.

pub(crate) mod certified;
pub mod collect;
mod decision;
mod facets;
pub mod merge;
mod totals;
pub mod view;
