//! Readers and writers of files: the formats of mesh generators, viewers and array libraries.

mod ending;
mod format;
#[cfg(test)]
mod guide_tests;
pub mod read;
mod spelling;
#[cfg(test)]
mod thread_wire;
pub mod write;

pub use ending::{extension, without_gz};
pub use format::{Files, Format, Role, Row, UnknownFormatName};
