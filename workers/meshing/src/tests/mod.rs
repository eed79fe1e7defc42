//! Tests of the whole crate.

mod defects;
mod good;
mod shapes;
