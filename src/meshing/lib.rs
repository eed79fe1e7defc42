//! septet-meshing: domains and what mesh generation asks of them, in the order the data flows.
//!
//! No input or output, no threads, no clock, no unordered maps. Signs are exact; distances and angles are
//! rounded and decide nothing that a sign could decide.

pub mod input;

pub mod defect;

pub mod bvh;

pub mod space;

pub mod planar;

pub mod simplices;

pub mod resolve;

pub mod facet;

pub mod contact;

pub mod exact;

mod crossed;

pub mod sides;

pub mod manifold;

pub mod domain;

pub mod angles;

pub mod distance;

pub mod executor;

pub mod octree;

pub mod size;

pub mod points;

pub mod generate;

pub mod mesh;

mod sum;

pub mod conformity;

pub mod improve;

pub mod quality;

mod check;

#[cfg(test)]
mod tests;

pub use check::check;
