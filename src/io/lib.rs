//! Files in and out: the formats of mesh generators, viewers and array libraries.

pub mod read;

pub mod write;
