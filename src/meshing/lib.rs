//! septet-meshing: domains, size functions, mesh generation and quality. Modules are listed in the order of the data
//! flow.
//!
//! The crate uses no input or output, threads, clocks or unordered maps. Signs are exact. Distances and angles are
//! rounded, and they decide nothing that a sign can decide.
//!
#![doc = include_str!("overview.md")]

pub mod input;

pub mod defect;

pub mod bvh;

pub mod space;

pub mod planar;

pub mod frame;

pub mod simplices;

pub mod resolve;

pub mod facet;

pub mod contact;

pub mod exact;

mod crossed;

pub mod sides;

pub mod manifold;

pub mod digits;

pub mod flats;

pub mod domain;

pub mod angles;

pub mod joining;

pub mod distance;

pub mod executor;

pub mod octree;

pub mod size;

pub mod points;

pub mod generate;

mod worst;

pub mod constrained;
pub mod plane;

pub mod constrain;

pub mod mesh;

pub mod sum;

pub mod conformity;

pub mod improve;

pub mod quality;

pub mod repair;

mod check;

#[cfg(test)]
mod tests;

pub use check::{Accepted, accept, check};
