//! The verifier accepts Delaunay triangulations, and rejects every planted fault at the level that defines it.
//!
//! The valid meshes come from a brute-force lower hull with explicit heights ([`fixtures::regular`]),
//! which shares nothing with the verifier.

mod dimensions;
mod faults;
mod fixtures;
mod periodic;
mod random;
mod valid;
mod weights;
