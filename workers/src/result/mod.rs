//! The result: the merged certificate, the owned cells, and the data for pictures.

pub(crate) mod certified;
pub mod collect;
pub mod merge;
pub mod view;
