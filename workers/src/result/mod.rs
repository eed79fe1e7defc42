//! The result: the certificate's merge, the owned cells, and the sampled picture.

pub mod merge;
pub mod view;
