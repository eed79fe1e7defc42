//! The verifier accepts Delaunay triangulations, and rejects every planted fault at the level that defines it.
//!
//! The valid meshes come from a brute-force lower hull with explicit heights ([`fixtures::brute`]),
//! which shares only the conversion of floats to integers with the verifier.

mod faults;
mod fixtures;
mod random;
mod valid;
