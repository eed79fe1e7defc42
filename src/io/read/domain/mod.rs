//! Readers of domains: piecewise linear complexes and closed surfaces.
//!
//! The readers return the content of the file. [`septet_meshing::check`] decides whether it is a domain.

mod any;
mod map;
pub mod poly;
pub mod surface;
#[cfg(test)]
mod tests;

pub use any::{AnyInput, DomainFile};
pub use map::MapFile;
