//! The verifier accepts what is Delaunay and rejects every planted fault, at the level meant for it.
//!
//! The valid meshes come from a brute-force lower hull with explicit heights ([`fixtures::brute`]),
//! which shares with the verifier nothing but the conversion of floats to integers.

mod faults;
mod fixtures;
mod random;
mod valid;
