//! septet-workers.
