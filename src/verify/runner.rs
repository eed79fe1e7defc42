//! Parallel loops that report progress. Their results do not depend on the number of threads.

use std::ops::Range;

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
    /// Creates a pool of `threads`. For 0, or if the pool cannot be created, the global pool of rayon is used.
    pub fn new(threads: usize, progress: &'a mut dyn FnMut(&str, u64, u64)) -> Self {
        let pool = match threads {
            0 => None,
            _ => ThreadPoolBuilder::new().num_threads(threads).build().ok(),
        };
        Self { pool, progress }
    }

    /// Runs `work` on the threads.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
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
            let blocks = (end - done).div_ceil(BLOCK);
            let found: Vec<Tally> = self.on_threads(|| {
                (0..blocks)
                    .into_par_iter()
                    .map(|block| {
                        let from = done + block * BLOCK;
                        let mut tally = Tally::default();
                        work(from..end.min(from + BLOCK), &mut tally);
                        tally
                    })
                    .collect()
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
