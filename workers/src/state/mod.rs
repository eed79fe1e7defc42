//! Values that most phases share: the points of a rank, its place in the tree, the frame, the task record.

pub mod frame;
pub mod subdomain;
pub mod table;
pub mod tasks;
