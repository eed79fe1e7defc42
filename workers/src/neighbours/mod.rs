//! Nearest neighbours across subdomains: balls at leaves, their descent of the tree, and the replies.

pub(crate) mod balls;
pub(crate) mod bottom_up;
pub(crate) mod chunked_lists;
pub(crate) mod descent;
pub(crate) mod fair_split;
pub(crate) mod launch;
pub(crate) mod lists;
pub(crate) mod replies;
pub(crate) mod results;
pub(crate) mod router;
pub(crate) mod search;
pub(crate) mod stages;
pub(crate) mod tallies;
pub(crate) mod walk;
