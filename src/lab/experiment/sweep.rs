//! A sweep: its runs, their order, and the command that repeats each run.

use std::fmt::Write;

use thiserror::Error;

use septet_core::Remedy;
use septet_core::generate::{Kind, Request};
use septet_core::spec::{
    Alpha, Commands, Correction, Matters, Purpose, Row, Spec, SpecError, Tree, Until, Words, Workers,
    options_of,
};

use super::line::{Program, RunOptions};

/// A set of runs with different sizes, kinds, workers and seeds.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Numbers of points, ascending; numbers of points per worker if `weak`.
    pub sizes: Vec<u64>,
    /// The sizes as written on the command line.
    pub sizes_text: String,
    /// Kinds of sets.
    pub kinds: Vec<Kind>,
    /// Number of coordinates: 2 or 3.
    pub dimension: usize,
    /// Lipschitz constant of graded kinds.
    pub lipschitz: Option<f64>,
    /// Numbers of workers.
    pub workers: Vec<Workers>,
    /// The first seed of the sets and of the runs.
    pub first_seed: u64,
    /// Number of consecutive seeds.
    pub seeds: u64,
    /// Whether sizes count points per worker.
    pub weak: bool,
    /// Whether the sweep also times `triangulate` for each counted run, and the serial kernel once for each set.
    pub timed: bool,
    /// The last phase of the counted runs, if they stop before their end.
    pub until: Option<Until>,
    /// The remaining options.
    pub spec: Spec,
}

/// A reason why a sweep cannot run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The sweep has no runs.
    #[error("the sweep has no {what}")]
    Empty {
        /// Sizes, kinds, workers or seeds.
        what: &'static str,
    },
    /// The sizes count points per worker, but there is one worker per leaf, so the numbers of workers and points are
    /// unknown before the run.
    #[error(
        "the number of workers of `leaves` is unknown before the run, so sizes cannot count points per worker"
    )]
    WeakLeaves,
    /// The number of workers depends on the computer, so the sweep would not repeat.
    #[error("the workers of a sweep are numbers or `leaves`: `auto` depends on the computer")]
    AutoWorkers,
    /// The total number of points does not fit into 64 bits.
    #[error("{n} points for each of {workers} workers are too many")]
    TooMany {
        /// Number of points per worker.
        n: u64,
        /// Number of workers.
        workers: u32,
    },
    /// Times are requested for runs that do not triangulate.
    #[error("runs that stop before the triangulation cannot be compared with triangulations")]
    TimedUntil,
    /// Times are requested for a correction of neighbour balls that exists only so that it can be counted.
    #[error(
        "runs with another correction than `descent` cannot be compared with triangulations, which do not use it"
    )]
    TimedCorrection,
    /// An option is given that no phase up to `until` uses.
    #[error("{option} has no effect on runs that stop after the phase {}", .until.name())]
    Unreached {
        /// The option.
        option: &'static str,
        /// The last phase of the runs.
        until: Until,
    },
    /// alpha is given for runs that stop before the supergraph. In such runs, alpha determines only the leaf size, and
    /// only for constants for little time.
    #[error(
        "alpha has no effect on runs that stop before the supergraph, unless it decides the size of leaves"
    )]
    AlphaOfLeaf,
    /// A Lipschitz constant is given for kinds that have none.
    #[error("a Lipschitz constant has no effect without a graded kind")]
    LipschitzUnused,
    /// The parameters of the runs are invalid.
    #[error(transparent)]
    Spec(#[from] SpecError),
}

impl SweepError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(match self {
            Self::Empty { .. } => Remedy::of("name at least one"),
            Self::WeakLeaves => Remedy::of("omit {weak}, or give numbers to {workers}"),
            Self::TimedUntil => Remedy::of("omit {timed} or {until}"),
            Self::TimedCorrection => Remedy::of("omit {timed} or {neighbours}"),
            Self::Unreached { option, until } => {
                let remedy = Remedy::of("omit ").option(option);
                remedy.then(" or ").set("until", until.name())
            }
            Self::AlphaOfLeaf => {
                Remedy::of("omit {alpha} or {until}, or use {constants=timing} without {leaf}")
            }
            Self::LipschitzUnused => Remedy::of("omit {lipschitz}, or add {kind=graded}"),
            Self::Spec(error) => return error.remedy(),
            Self::AutoWorkers | Self::TooMany { .. } => return None,
        })
    }
}

/// One run of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job {
    /// The program.
    pub program: Program,
    /// The set.
    pub request: Request,
    /// The workers.
    pub workers: Workers,
}

impl Sweep {
    /// Checks all conditions that can be checked before the first run.
    ///
    /// # Errors
    /// See [`SweepError`].
    pub fn check(&self) -> Result<(), SweepError> {
        let parts = [
            ("sizes", self.sizes.is_empty()),
            ("kinds", self.kinds.is_empty()),
            ("workers", self.workers.is_empty()),
            ("seeds", self.seeds == 0),
        ];
        if let Some((what, _)) = parts.into_iter().find(|part| part.1) {
            return Err(SweepError::Empty { what });
        }
        if self.timed && self.until.is_some() {
            return Err(SweepError::TimedUntil);
        }
        if self.timed && self.spec.recursion.neighbours != Correction::Descent {
            return Err(SweepError::TimedCorrection);
        }
        if self.lipschitz.is_some() && !self.kinds.iter().any(|kind| kind.is_graded()) {
            return Err(SweepError::LipschitzUnused);
        }
        self.until.map_or(Ok(()), |until| self.check_reached(until))?;
        for &workers in &self.workers {
            if workers == Workers::Auto {
                return Err(SweepError::AutoWorkers);
            }
            self.spec.clone().with(|c| c.machine.workers = workers).check()?;
            for &n in &self.sizes {
                match workers {
                    Workers::Leaves if self.weak => return Err(SweepError::WeakLeaves),
                    Workers::Count(p) if self.weak && n.checked_mul(u64::from(p)).is_none() => {
                        return Err(SweepError::TooMany { n, workers: p });
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Checks that the phases up to `until` use every option. Defaults are accepted, because [`Sweep::command`] spells
    /// them out.
    fn check_reached(&self, until: Until) -> Result<(), SweepError> {
        let is_unreached = |row: &&Row| row.first_use > until && row.is_changed(&self.spec);
        if let Some(row) = options_of(Commands::SCALE).find(is_unreached) {
            return Err(SweepError::Unreached { option: row.name, until });
        }
        let Tree { leaf, constants, .. } = self.spec.tree;
        let decides_leaf = leaf.is_none() && constants.purpose == Purpose::Timing;
        let has_alpha = self.spec.recursion.graph.alpha() != Alpha::Auto;
        if until < Until::Graph && has_alpha && !decides_leaf {
            return Err(SweepError::AlphaOfLeaf);
        }
        Ok(())
    }

    /// Returns all runs. Small runs precede large ones, so an interrupted sweep has complete octaves. Runs on the
    /// same set are adjacent.
    pub fn jobs(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        for &size in &self.sizes {
            for &kind in &self.kinds {
                for seed in (0..self.seeds).map(|i| self.first_seed.wrapping_add(i)) {
                    self.jobs_of_set(size, kind, seed, &mut jobs);
                }
            }
        }
        jobs
    }

    fn jobs_of_set(&self, size: u64, kind: Kind, seed: u64, jobs: &mut Vec<Job>) {
        let (dimension, lipschitz) = (self.dimension, self.lipschitz_of(kind));
        let request = |n| Request { kind, n, dimension, seed, lipschitz, ratio: None };
        let mut sets: Vec<u64> = Vec::new();
        for &workers in &self.workers {
            let n = match workers {
                Workers::Count(p) if self.weak => size * u64::from(p),
                _ => size,
            };
            jobs.push(Job { program: Program::Simulate, request: request(n), workers });
            if self.timed {
                jobs.push(Job { program: Program::Triangulate, request: request(n), workers });
                sets.push(n);
            }
        }
        sets.dedup();
        let serial = |n| Job { program: Program::Serial, request: request(n), workers: Workers::Count(1) };
        jobs.extend(sets.into_iter().map(serial));
    }

    fn lipschitz_of(&self, kind: Kind) -> Option<f64> {
        self.lipschitz.filter(|_| kind.is_graded())
    }

    /// Returns the words that identify this sweep: all options, including defaults. Sweeps with equal words are the
    /// same sweep. Threads and limits are omitted, because no count depends on them.
    pub fn words(&self) -> String {
        let kinds: Vec<&str> = self.kinds.iter().map(|k| k.name()).collect();
        let workers: Vec<String> = self.workers.iter().map(ToString::to_string).collect();
        let mut text = format!(
            "-n {} --kind {} -d {} --workers {} --seed {} --seeds {}",
            self.sizes_text,
            kinds.join(","),
            self.dimension,
            workers.join(","),
            self.first_seed,
            self.seeds
        );
        if self.weak {
            text.push_str(" --weak");
        }
        if self.timed {
            text.push_str(" --timed");
        }
        self.common_words(self.lipschitz, &mut text);
        text
    }

    /// Returns the command that repeats this run only.
    pub fn command(&self, job: &Job) -> String {
        let Request { kind, n, dimension, seed, .. } = job.request;
        let workers = job.workers;
        let mut text = format!(
            "septet scale -n {n} --kind {} -d {dimension} --workers {workers} --seed {seed} --seeds 1",
            kind.name()
        );
        if self.timed {
            text.push_str(" --timed");
        }
        self.common_words(self.lipschitz_of(kind), &mut text);
        text.push_str(" -o run.jsonl");
        text
    }

    fn common_words(&self, lipschitz: Option<f64>, text: &mut String) {
        // Writing to a string cannot fail.
        for row in options_of(Commands::SCALE).filter(|row| row.matters >= Matters::Counts) {
            if let Some(value) = row.get(&self.spec).text() {
                let _ = write!(text, " --{} {value}", row.name);
            }
        }
        if let Some(until) = self.until {
            let _ = write!(text, " --until {}", until.name());
        }
        if let Some(lipschitz) = lipschitz {
            let _ = write!(text, " --lipschitz {lipschitz}");
        }
    }

    /// Returns the options of a run, for its line.
    pub fn settings(&self, workers: Workers) -> RunOptions {
        let rows = options_of(Commands::SCALE).filter(|row| row.matters >= Matters::Counts);
        RunOptions {
            workers: workers.to_string(),
            weak: self.weak,
            threads: self.spec.machine.thread_count(),
            lipschitz: self.lipschitz,
            until: self.until,
            options: rows.map(|row| (row.key.to_owned(), row.get(&self.spec))).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use septet_core::spec::{Graph, Neighbours, Partition, SeparatorSets, Transport};

    fn sweep() -> Sweep {
        Sweep {
            sizes: vec![100, 200],
            sizes_text: "100,200".to_string(),
            kinds: vec![Kind::Uniform, Kind::GradedPoint],
            dimension: 2,
            lipschitz: Some(0.5),
            workers: vec![Workers::Count(1), Workers::Count(4)],
            first_seed: 3,
            seeds: 2,
            weak: false,
            timed: false,
            until: None,
            spec: Spec::default(),
        }
    }

    #[test]
    fn jobs_are_all_combinations_small_first() {
        let jobs = sweep().jobs();
        assert_eq!(jobs.len(), 16);
        assert!(jobs.windows(2).all(|w| w[0].request.n <= w[1].request.n));
        assert_eq!(jobs[0].request.lipschitz, None);
        assert_eq!(jobs[4].request.lipschitz, Some(0.5));
        let weak = Sweep { weak: true, ..sweep() };
        assert_eq!(weak.jobs()[1].request.n, 400);
        let timed = Sweep { timed: true, ..sweep() };
        let serial = timed.jobs().into_iter().filter(|j| j.program == Program::Serial).count();
        assert_eq!(serial, 8, "the serial kernel once a set");
    }

    #[test]
    fn impossible_sweeps_are_refused() {
        let refused = |change: &dyn Fn(&mut Sweep)| {
            let mut s = sweep();
            change(&mut s);
            s.check().unwrap_err()
        };
        assert_eq!(sweep().check(), Ok(()));
        assert_eq!(refused(&|s| s.seeds = 0), SweepError::Empty { what: "seeds" });
        assert_eq!(refused(&|s| s.sizes.clear()), SweepError::Empty { what: "sizes" });
        let leaves = refused(&|s| (s.weak, s.workers) = (true, vec![Workers::Leaves]));
        assert_eq!(leaves, SweepError::WeakLeaves);
        assert_eq!(refused(&|s| s.workers = vec![Workers::Auto]), SweepError::AutoWorkers);
        let timed = refused(&|s| (s.timed, s.until) = (true, Some(Until::Partition)));
        assert_eq!(timed, SweepError::TimedUntil);
        let timed = refused(&|s| (s.timed, s.spec.recursion.neighbours) = (true, Correction::BottomUp));
        assert_eq!(timed, SweepError::TimedCorrection);
        let stops = |s: &mut Sweep, until| s.until = Some(until);
        let k = refused(&|s| {
            stops(s, Until::Neighbours);
            s.spec.recursion.graph = Graph::Knn { k: Neighbours::Auto };
        });
        assert_eq!(k, SweepError::Unreached { option: "supergraph", until: Until::Neighbours });
        let sets = refused(&|s| {
            stops(s, Until::Neighbours);
            s.spec.recursion.sets = SeparatorSets::Both;
        });
        assert_eq!(sets, SweepError::Unreached { option: "separator-sets", until: Until::Neighbours });
        let naive = |until| {
            let mut s = sweep();
            (s.until, s.spec.recursion.neighbours) = (Some(until), Correction::BottomUp);
            s.check()
        };
        let option = "neighbours";
        assert_eq!(naive(Until::Partition), Err(SweepError::Unreached { option, until: Until::Partition }));
        assert_eq!(naive(Until::Neighbours), Ok(()));
        let alpha = |purpose, leaf| {
            let mut s = sweep();
            s.spec.tree.constants.purpose = purpose;
            (s.until, s.spec.tree.leaf) = (Some(Until::Partition), leaf);
            s.spec.recursion.graph = Graph::Density { alpha: Alpha::Value(5.0) };
            s.check()
        };
        assert_eq!(alpha(Purpose::Timing, None), Ok(()));
        assert_eq!(alpha(Purpose::Timing, Some(9)), Err(SweepError::AlphaOfLeaf));
        assert_eq!(alpha(Purpose::Counting, None), Err(SweepError::AlphaOfLeaf));
        assert_eq!(refused(&|s| s.kinds = vec![Kind::Uniform]), SweepError::LipschitzUnused);
        let none = refused(&|s| s.workers = vec![Workers::Count(0)]);
        assert_eq!(none, SweepError::Spec(SpecError::NoWorkers));
    }

    #[test]
    fn words_tell_sweeps_apart() {
        let base = sweep().words();
        assert!(base.contains("-n 100,200 --kind uniform,graded -d 2 --workers 1,4 --seed 3 --seeds 2"));
        let changes: [&dyn Fn(&mut Sweep); 11] = [
            &|s| s.seeds = 4,
            &|s| s.weak = true,
            &|s| s.until = Some(Until::Neighbours),
            &|s| s.spec.tree.leaf = Some(7),
            &|s| s.spec.tree.constants.purpose = Purpose::Timing,
            &|s| s.spec.tree.constants.samples = Some(64),
            &|s| s.spec.tree.constants.tries = Some(5),
            &|s| s.spec.tree.partition = Partition::Kd,
            &|s| s.spec.recursion.neighbours = Correction::BottomUp,
            &|s| s.spec.recursion.graph = Graph::Density { alpha: Alpha::Value(3.0) },
            &|s| s.spec.machine.transport = Transport::Sim { delivery_seed: 4 },
        ];
        for change in changes {
            let mut other = sweep();
            change(&mut other);
            assert_ne!(other.words(), base);
        }
        let threads = Sweep { spec: Spec::default().with(|c| c.machine.threads = Some(9)), ..sweep() };
        assert_eq!(threads.words().replace("channel", ""), base.replace("channel", ""));
    }
}
