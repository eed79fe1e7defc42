//! Threads that stay on one core each.
//!
//! **Why.** Between its phases a machine sleeps, and the coordinator wakes its threads all at once before it sleeps itself.
//! A scheduler that puts two of them on one core while another is idle finds that out at its next tick, some milliseconds
//! later (Lozi et al., "The Linux scheduler: a decade of wasted cores", 2016); a run of a million points has some twenty
//! such moments.
//!
//! **When.** Only if there is one thread for each core that the caller may use: threads of a run that leaves cores to others go
//! where there is room.

use core_affinity::CoreId;

/// The cores for the threads of a pool or a machine.
#[derive(Clone, Debug, Default)]
pub struct Cores(Vec<CoreId>);

impl Cores {
    /// Those that the calling thread may use, if they are as many as `threads` and more than one; otherwise none to stay on.
    pub fn for_threads(threads: usize) -> Self {
        if threads < 2 {
            return Cores::default();
        }
        Cores(core_affinity::get_core_ids().filter(|cores| cores.len() == threads).unwrap_or_default())
    }

    /// Makes the calling thread, number `index` of them, stay on its core. Nothing happens if it has none or if the
    /// system does not do that: threads run where they are put.
    pub fn stay(&self, index: usize) {
        if let Some(&core) = self.0.get(index) {
            core_affinity::set_for_current(core);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cores that a new thread may use after `first`.
    fn allowed(first: impl FnOnce() + Send) -> Vec<CoreId> {
        let ids = || {
            first();
            core_affinity::get_core_ids().unwrap_or_default()
        };
        std::thread::scope(|scope| scope.spawn(ids).join().unwrap_or_default())
    }

    #[test]
    fn each_thread_stays_on_a_core_of_its_own() {
        let all = allowed(|| {});
        let cores = Cores::for_threads(all.len());
        for index in 0..all.len() {
            let own = allowed(|| cores.stay(index));
            assert_eq!(own, if all.len() > 1 { vec![all[index]] } else { all.clone() });
        }
        assert_eq!(allowed(|| cores.stay(all.len())), all);
    }

    #[test]
    fn threads_that_are_not_as_many_as_cores_go_anywhere() {
        let all = allowed(|| {});
        for threads in [0, 1, all.len() + 1] {
            let cores = Cores::for_threads(threads);
            assert_eq!(allowed(|| cores.stay(0)), all);
        }
    }
}
