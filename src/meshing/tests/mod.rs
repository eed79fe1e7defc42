//! Tests of the whole crate.

mod brute;
mod conforming;
mod contacts;
mod defects;
mod followed;
mod good;
mod meshes;
mod qualities;
mod repaired;
pub mod shapes;
mod symmetry;
