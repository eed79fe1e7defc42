//! Tests of the whole crate.

mod brute;
mod contacts;
mod defects;
mod good;
pub mod shapes;
mod symmetry;
