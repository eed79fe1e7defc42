//! What has counts to be held against bounds.

use septet_core::Run;
use septet_core::run::count::RunCounts;

use crate::experiment::{Line, of_counts, of_run};

/// One or several runs that were counted.
pub trait Counted {
    /// A line for each.
    fn lines(&self) -> Vec<Line>;
}

impl Counted for Line {
    fn lines(&self) -> Vec<Line> {
        vec![self.clone()]
    }
}

impl Counted for Run {
    fn lines(&self) -> Vec<Line> {
        vec![of_run(self)]
    }
}

impl Counted for RunCounts {
    fn lines(&self) -> Vec<Line> {
        vec![of_counts(self)]
    }
}

impl<C: Counted> Counted for [C] {
    fn lines(&self) -> Vec<Line> {
        self.iter().flat_map(Counted::lines).collect()
    }
}

impl<C: Counted, const N: usize> Counted for [C; N] {
    fn lines(&self) -> Vec<Line> {
        self.as_slice().lines()
    }
}

impl<C: Counted> Counted for Vec<C> {
    fn lines(&self) -> Vec<Line> {
        self.as_slice().lines()
    }
}

impl<C: Counted + ?Sized> Counted for &C {
    fn lines(&self) -> Vec<Line> {
        (**self).lines()
    }
}
