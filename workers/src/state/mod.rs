//! Values that most phases share: the points of a rank, its place in the tree, the frame, the task record.

pub(crate) mod bits;
pub(crate) mod cells;
pub mod frame;
pub(crate) mod link_arena;
pub mod subdomain;
pub mod table;
