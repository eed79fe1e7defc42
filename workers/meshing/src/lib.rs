//! septet-meshing: domains and what mesh generation asks of them, in the order the data flows.
//!
//! No input or output, no threads, no clock, no unordered maps. Signs are exact; distances and angles are
//! rounded and decide nothing that a sign could decide.

pub mod input;

pub mod bvh;

pub mod space;

pub mod planar;
