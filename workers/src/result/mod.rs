//! The result: the certificate's merge, the owned cells, and the sampled picture.

pub(crate) mod certify;
pub mod collect;
pub mod merge;
pub mod view;
