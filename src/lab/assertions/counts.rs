//! The counts that checks accept.

use septet_core::Outcome;

use crate::experiment::{Line, of_run};

/// One or several counted runs.
pub trait HasCounts {
    /// Returns a line for each run.
    fn lines(&self) -> Vec<Line>;
}

impl HasCounts for Line {
    fn lines(&self) -> Vec<Line> {
        vec![self.clone()]
    }
}

impl HasCounts for Outcome {
    fn lines(&self) -> Vec<Line> {
        vec![of_run(self)]
    }
}

impl<C: HasCounts> HasCounts for [C] {
    fn lines(&self) -> Vec<Line> {
        self.iter().flat_map(HasCounts::lines).collect()
    }
}

impl<C: HasCounts, const N: usize> HasCounts for [C; N] {
    fn lines(&self) -> Vec<Line> {
        self.as_slice().lines()
    }
}

impl<C: HasCounts> HasCounts for Vec<C> {
    fn lines(&self) -> Vec<Line> {
        self.as_slice().lines()
    }
}

impl<C: HasCounts + ?Sized> HasCounts for &C {
    fn lines(&self) -> Vec<Line> {
        (**self).lines()
    }
}
