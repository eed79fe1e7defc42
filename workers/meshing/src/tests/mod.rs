//! Tests of the whole crate.

mod brute;
mod contacts;
mod defects;
mod good;
mod shapes;
mod symmetry;
