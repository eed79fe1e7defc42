//! Who maps items to values.
//!
//! This crate starts no threads. What can be done for each item by itself goes through [`Cores::map`], which the caller
//! provides; since the values come back in the order of the items, nothing depends on how many cores there are.

/// Maps items.
pub trait Executor: Sync {
    /// The values of a function, in the order of the items.
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U>;
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sequential;

impl Executor for Sequential {
    fn map<T: Sync, U: Send>(&self, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
        items.iter().map(f).collect()
    }
}
