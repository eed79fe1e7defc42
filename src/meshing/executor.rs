//! Maps functions over lists.
//!
//! This crate starts no threads. Independent computations for the items of a list go through [`Executor::map`], which
//! the caller implements. Values are returned in the order of the items, so results do not depend on the number of
//! cores.

/// Maps a function over a list.
pub trait Executor: Sync {
    /// Returns the values of `f`, in the order of the items.
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U>;
}

/// Maps sequentially.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sequential;

impl Executor for Sequential {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.iter().map(f).collect()
    }
}
