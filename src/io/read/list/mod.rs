//! Lists of point files, which are read as one set of points.
//!
//! A pattern such as `part-*.npy` or a file of names such as `@parts.txt` names the files ([`FileList`]). The points are
//! numbered across the files in their order ([`read_list`]).

mod columns;
mod entries;
mod error;
mod files;
mod join;
pub(super) mod notes;
mod pattern;
#[cfg(test)]
mod tests;

pub(super) use columns::append as append_columns;
pub use error::{EntryFault, ListError};
pub use files::FileList;
pub(super) use join::empty;
pub use join::{PointList, read_list};
