//! Readers and writers of files: the formats of mesh generators, viewers and array libraries.

pub mod read;

mod spelling;
pub mod write;
