//! Readers and writers of files: the formats of mesh generators, viewers and array libraries.

mod ending;
pub mod read;

mod spelling;
pub mod write;

pub use ending::{extension, without_gz};
