//! Nearest neighbours across subdomains: balls at leaves, their descent of the tree, and the answers.

pub(crate) mod answers;
pub(crate) mod balls;
pub(crate) mod bottom_up;
pub(crate) mod chains;
pub(crate) mod done;
pub(crate) mod forwards;
pub(crate) mod query;
pub(crate) mod walk;
