//! Parallel loops that report progress. Their results do not depend on the number of threads.
//!
//! A loop calls its work through a pointer, once for each block. The scheduler of rayon is therefore compiled once, and not
//! for each loop and dimension.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::report::Tally;

/// The number of items that a thread processes at a time. Results are appended in the order of the items.
const BLOCK: usize = 1 << 11;
/// The number of blocks between two calls of the progress function.
const BLOCKS: usize = 1 << 7;

/// Threads and the progress function.
pub(super) struct Runner<'a> {
    pool: Option<ThreadPool>,
    progress: &'a mut dyn FnMut(&str, u64, u64),
}

impl<'a> Runner<'a> {
    /// Creates a pool of `threads`; for 0, of one thread for each core.
    pub fn new(threads: usize, progress: &'a mut dyn FnMut(&str, u64, u64)) -> Self {
        Self { pool: ThreadPoolBuilder::new().num_threads(threads).build().ok(), progress }
    }

    /// Runs `work` once, on the threads.
    pub fn on_threads(&self, work: &mut (dyn FnMut() + Send)) {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Calls `work` with every number below `count`, in any order.
    fn numbers(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        self.on_threads(&mut || (0..count).into_par_iter().for_each(work));
    }

    /// Returns the values of `work` for the blocks of `0..total`, in order.
    pub fn map<T: Send>(&self, total: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
        let made: Vec<Mutex<Option<T>>> = (0..total.div_ceil(BLOCK)).map(|_| Mutex::new(None)).collect();
        self.numbers(made.len(), &|block| {
            let value = work(block * BLOCK..total.min((block + 1) * BLOCK));
            *made[block].lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
        });
        made.into_iter()
            .filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner))
            .collect()
    }

    /// Reports progress.
    pub fn report(&mut self, stage: &str, done: usize, total: usize) {
        (self.progress)(stage, done as u64, total as u64);
    }

    /// Runs `work` on blocks of `0..total` and appends the results in the order of the items. `work` counts the items that it
    /// checks.
    pub fn each(
        &mut self,
        stage: &str,
        total: usize,
        work: impl Fn(Range<usize>, &mut Tally) + Sync,
    ) -> Tally {
        let mut tally = Tally::default();
        let mut done = 0;
        while done < total {
            let end = total.min(done + BLOCK * BLOCKS);
            let found = self.map(end - done, |block| {
                let mut tally = Tally::default();
                work(done + block.start..done + block.end, &mut tally);
                tally
            });
            for later in found {
                tally.append(later);
            }
            done = end;
            self.report(stage, done, total);
        }
        tally
    }
}
