//! Readers and writers of files: the formats of mesh generators, viewers and array libraries.

mod ending;
mod exit_code;
pub mod read;
mod spelling;
#[cfg(test)]
mod thread_wire;
pub mod write;

pub use ending::{extension, without_gz};
