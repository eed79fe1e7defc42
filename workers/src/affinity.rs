//! Threads that stay on one core each.
//!
//! **Why.** Between its phases a machine sleeps. The coordinator wakes its threads together and then sleeps itself; where the
//! scheduler puts two of them on one core, the other one idles until that is noticed (bench/README.md has what was
//! measured).
//!
//! **When.** Only if there are exactly as many threads as cores that the caller may use, so that every core gets one and runs
//! side by side share all of them evenly; and on Linux, where a set of cores is told and kept.

/// The cores for the threads of a pool or a machine.
#[derive(Clone, Debug, Default)]
pub struct Affinity(Vec<usize>);

impl Affinity {
    /// Those that the calling thread may use, if they are as many as `threads`; otherwise none to stay on.
    pub fn for_threads(threads: usize) -> Self {
        let allowed = system::allowed();
        Affinity(if allowed.len() == threads { allowed } else { Vec::new() })
    }

    /// Makes the calling thread, number `index` of them, stay on its core. Nothing happens if it has none or if the
    /// system refuses: threads run where they are put.
    pub fn stay(&self, index: usize) {
        if let Some(&core) = self.0.get(index) {
            system::stay(core);
        }
    }
}

#[cfg(target_os = "linux")]
mod system {
    use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
    use nix::unistd::Pid;

    /// The calling thread.
    const SELF: Pid = Pid::from_raw(0);

    /// The cores that the calling thread may use; none if the system does not tell.
    pub(super) fn allowed() -> Vec<usize> {
        let Ok(set) = sched_getaffinity(SELF) else { return Vec::new() };
        (0..CpuSet::count()).filter(|&core| set.is_set(core).unwrap_or(false)).collect()
    }

    pub(super) fn stay(core: usize) {
        let mut set = CpuSet::new();
        if set.set(core).is_ok() {
            let _ = sched_setaffinity(SELF, &set);
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    pub(super) fn allowed() -> Vec<usize> {
        Vec::new()
    }

    pub(super) fn stay(_core: usize) {}
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// The cores that a new thread may use after `first`.
    fn allowed(first: impl FnOnce() + Send) -> Vec<usize> {
        let cores = || {
            first();
            system::allowed()
        };
        std::thread::scope(|scope| scope.spawn(cores).join().unwrap_or_default())
    }

    #[test]
    fn each_thread_stays_on_a_core_of_its_own() {
        let all = allowed(|| {});
        let affinity = Affinity::for_threads(all.len());
        for (index, &core) in all.iter().enumerate() {
            assert_eq!(allowed(|| affinity.stay(index)), [core]);
        }
        assert_eq!(allowed(|| affinity.stay(all.len())), all);
    }

    #[test]
    fn threads_that_are_not_as_many_as_cores_go_anywhere() {
        let all = allowed(|| {});
        for threads in [0, all.len().saturating_sub(1), all.len() + 1] {
            let affinity = Affinity::for_threads(threads);
            assert_eq!(allowed(|| affinity.stay(0)), all);
        }
    }
}
