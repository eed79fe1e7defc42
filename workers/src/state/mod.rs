//! Values that several phases share: the points of a rank, its part of the tree, the frame, small helpers.

pub(crate) mod bits;
pub mod blocks;
pub(crate) mod cells;
pub mod frame;
pub(crate) mod ghosts;
pub(crate) mod link_arena;
pub mod rows;
pub mod subdomain;
pub mod table;
pub mod tree;
