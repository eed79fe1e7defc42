//! Parameters of a run, and the checks that refuse impossible ones before any work.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use septet_protocol::ids::Phase;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use septet_workers::config::{Correction, Fault, Partition, SetRule as SeparatorSets};
pub use septet_workers::transport::TransportKind as Transport;

/// How many workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workers {
    /// This many, at least one. It need not be a number of cores.
    Count(u32),
    /// One for every leaf of the partition tree: every split and merge is a message.
    Leaves,
}

/// Which supergraph of the Delaunay triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GraphKind {
    /// The alpha-density graph (paper, Section 4.2).
    Density,
    /// The alpha-overlap graph (Section 4.4).
    Overlap,
    /// The k-nearest-neighbour graph (Section 4.5).
    Knn,
}

/// alpha of a density or overlap graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// From the set's known spacing, else from a sample of stars.
    Auto,
    /// At least 1.
    Value(f64),
}

/// k of a nearest-neighbour graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Neighbours {
    /// 48, or all other points if there are fewer.
    Auto,
    /// This many, below the number of points.
    Count(u32),
    /// `ceil(c ln n)`.
    Log(f64),
}

/// A phase after which a run may stop, for what it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Until {
    /// The partition tree.
    Partition,
    /// The nearest-neighbour balls.
    Neighbours,
}

impl Until {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        self.phase().name()
    }

    /// The last phase.
    pub(crate) fn phase(self) -> Phase {
        match self {
            Until::Partition => Phase::Partition,
            Until::Neighbours => Phase::Neighbours,
        }
    }
}

/// What a run reports while it goes on.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// The phase.
    pub phase: &'static str,
    /// Its position among the phases, and their number.
    pub position: (usize, usize),
    /// Rounds so far.
    pub round: u32,
}

/// Receives progress, from the caller's thread.
pub type ProgressFn = Arc<dyn Fn(Progress) + Send + Sync>;

/// Parameters of [`crate::triangulate`] and [`crate::simulate`].
#[derive(Clone)]
pub struct Config {
    /// Number of workers.
    pub workers: Workers,
    /// Threads that run them.
    pub threads: usize,
    /// Seed of every random draw.
    pub seed: u64,
    /// Names the run in messages and traces; the seed if none. Runs that are traced into one file at the same
    /// time need names of their own.
    pub run: Option<u64>,
    /// The supergraph.
    pub graph: GraphKind,
    /// Its alpha.
    pub alpha: Alpha,
    /// Its k.
    pub k: Neighbours,
    /// How separator points are shared.
    pub sets: SeparatorSets,
    /// Largest leaf of the partition tree; by dimension and alpha if none.
    pub leaf: Option<u64>,
    /// How messages travel. Over channels the workers run on `threads` threads.
    pub transport: Transport,
    /// Lipschitz constant of a set generated as f-spaced, which gives alpha by a formula.
    pub spacing: Option<f64>,
    /// Drop points that are not finite, and count them, instead of refusing the set.
    pub skip_invalid: bool,
    /// Refuse to start if more memory than this is expected, in bytes.
    pub max_memory: Option<u64>,
    /// Keep the supergraph's edges in the result. [`crate::simulate`] only.
    pub keep_graph: bool,
    /// Keep the owning worker and home leaf of every cell in the result.
    pub with_owner: bool,
    /// Keep a picture of the run in the result ([`crate::Run::picture`]): about this many sampled points; 0
    /// for none, at most [`crate::result::view::MOST_POINTS`].
    pub view: u32,
    /// Rounds of exchange before unresolved regions are gathered; `6 log2 n` if none.
    pub exchange_cap: Option<u32>,
    /// What cuts subproblems: spheres, or the rival.
    pub partition: Partition,
    /// How nearest-neighbour balls are corrected: by one descent, or by the rival ([`crate::simulate`] only).
    pub correction: Correction,
    /// Record what leaves have to say to each other (`septet_lab::predict`); only where work and depth are
    /// counted. This takes a run of its own, with one worker.
    pub record_tasks: bool,
    /// A fault planted in the machine, for tests of what a machine without faults never shows.
    pub fault: Option<Fault>,
    /// Stop after this phase. [`crate::count`] only: what stops has no triangulation.
    pub until: Option<Until>,
    /// Set to stop the run.
    pub cancel: Option<Arc<AtomicBool>>,
    /// Told of phases and rounds.
    pub progress: Option<ProgressFn>,
}

impl std::fmt::Debug for Config {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Config")
            .field("workers", &self.workers)
            .field("threads", &self.threads)
            .field("seed", &self.seed)
            .field("run", &self.run)
            .field("graph", &self.graph)
            .field("alpha", &self.alpha)
            .field("k", &self.k)
            .field("sets", &self.sets)
            .field("leaf", &self.leaf)
            .field("transport", &self.transport)
            .finish_non_exhaustive()
    }
}

impl Default for Config {
    fn default() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        Config {
            workers: Workers::Count(cores as u32),
            threads: cores,
            seed: 1,
            run: None,
            graph: GraphKind::Density,
            alpha: Alpha::Auto,
            k: Neighbours::Auto,
            sets: SeparatorSets::Ghost,
            leaf: None,
            transport: Transport::Channel { threads: cores },
            spacing: None,
            skip_invalid: false,
            max_memory: None,
            keep_graph: false,
            with_owner: false,
            view: 0,
            exchange_cap: None,
            partition: Partition::Sphere,
            correction: Correction::Descent,
            record_tasks: false,
            fault: None,
            until: None,
            cancel: None,
            progress: None,
        }
    }
}

/// A combination of parameters that cannot be run.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ConfigError {
    /// No workers.
    #[error("at least one worker is needed (--workers 1)")]
    NoWorkers,
    /// More workers than ranks can be told apart.
    #[error("{workers} workers are too many: at most {most}")]
    TooManyWorkers {
        /// Asked for.
        workers: u32,
        /// Allowed.
        most: u32,
    },
    /// No threads.
    #[error("at least one thread is needed (--threads 1)")]
    NoThreads,
    /// alpha below 1, or not a number.
    #[error("alpha is {alpha}: it must be a number of at least 1 (Definition 2.2), or `auto`")]
    Alpha {
        /// As given.
        alpha: f64,
    },
    /// k out of range.
    #[error("k is {k}, but the set has {points} points: k must be at least 1 and below that, or `auto`")]
    K {
        /// As given.
        k: u64,
        /// Distinct points.
        points: u64,
    },
    /// A factor of log n out of range.
    #[error("the factor of log n is {factor}: it must be a positive number")]
    LogFactor {
        /// As given.
        factor: f64,
    },
    /// An alpha for a graph without one, or a k.
    #[error("a {graph} graph has no {parameter}: leave it out or choose another supergraph")]
    Unused {
        /// The graph.
        graph: &'static str,
        /// alpha or k.
        parameter: &'static str,
    },
    /// A rule that loses edges of this graph.
    #[error(
        "separator sets `smaller` hold for the density graph only: an edge of the {graph} graph can cross a \
         separator with one end's ball on its own side; use `both` or `ghost`"
    )]
    SmallerSide {
        /// The graph.
        graph: &'static str,
    },
    /// A record of tasks with a rule of sets that it does not cover.
    #[error("tasks are recorded with separator sets `ghost` only: leave out --tasks or --separator-sets")]
    TasksOfSets,
    /// A triangulation asked of a run that stops before it.
    #[error("a run that stops after the phase `{until}` has counts and no triangulation: use `count`")]
    Stops {
        /// The last phase.
        until: &'static str,
    },
    /// A record of tasks with the rival of the descent.
    #[error("tasks are recorded with --neighbours descent only: leave out --tasks or --neighbours")]
    TasksOfNaive,
    /// The rival of the descent where nothing is counted.
    #[error("the naive correction is there to be counted: use `simulate`, or leave out --neighbours")]
    NaiveUncounted,
    /// A leaf size of zero.
    #[error("a leaf holds at least one point (--leaf 1)")]
    EmptyLeaf,
}

/// More workers than this are refused.
pub const MOST_WORKERS: u32 = 1 << 20;

impl GraphKind {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            GraphKind::Density => "density",
            GraphKind::Overlap => "overlap",
            GraphKind::Knn => "knn",
        }
    }
}

impl Config {
    /// Checks what can be checked without points.
    ///
    /// # Errors
    /// The first parameter that is out of range, or does not go with another.
    pub fn check(&self) -> Result<(), ConfigError> {
        match self.workers {
            Workers::Count(0) => return Err(ConfigError::NoWorkers),
            Workers::Count(workers) if workers > MOST_WORKERS => {
                return Err(ConfigError::TooManyWorkers { workers, most: MOST_WORKERS });
            }
            _ => {}
        }
        if self.threads == 0 || matches!(self.transport, Transport::Channel { threads: 0 }) {
            return Err(ConfigError::NoThreads);
        }
        if self.leaf == Some(0) {
            return Err(ConfigError::EmptyLeaf);
        }
        if self.record_tasks && self.correction == Correction::Naive {
            return Err(ConfigError::TasksOfNaive);
        }
        if self.record_tasks && self.sets != SeparatorSets::Ghost {
            return Err(ConfigError::TasksOfSets);
        }
        let graph = self.graph.name();
        match (self.graph, self.alpha, self.k) {
            (GraphKind::Knn, Alpha::Value(_), _) => {
                return Err(ConfigError::Unused { graph, parameter: "alpha" });
            }
            (GraphKind::Density | GraphKind::Overlap, _, Neighbours::Count(_) | Neighbours::Log(_)) => {
                return Err(ConfigError::Unused { graph, parameter: "k" });
            }
            (_, Alpha::Value(alpha), _) if !(alpha >= 1.0 && alpha.is_finite()) => {
                return Err(ConfigError::Alpha { alpha });
            }
            (_, _, Neighbours::Log(factor)) if !(factor > 0.0 && factor.is_finite()) => {
                return Err(ConfigError::LogFactor { factor });
            }
            _ => {}
        }
        if self.sets == SeparatorSets::Smaller && self.graph != GraphKind::Density {
            return Err(ConfigError::SmallerSide { graph });
        }
        Ok(())
    }

    /// The smallest leaf that separator sets do not swallow: about 1,000 points in space at alpha 2.5 and
    /// 500 in the plane, growing with the volume of the alpha-balls.
    pub(crate) fn leaf_size(&self, dimension: usize, alpha: Option<f64>) -> u64 {
        if let Some(leaf) = self.leaf {
            return leaf;
        }
        let floor = if dimension == 3 { 1000.0 } else { 500.0 };
        let ratio = (alpha.unwrap_or(2.5) / 2.5).max(1.0);
        let growth = (0..dimension).fold(1.0, |g: f64, _| g * ratio);
        (floor * growth).min(1e9) as u64
    }
}

/// alpha of a maximal f-spaced set with an L-Lipschitz f: `2 (1 + L) / (1 - L)`, times 1.25 for cells at
/// the boundary (proved in the interior, observed at boundaries).
pub fn alpha_of_spacing(lipschitz: f64) -> f64 {
    1.25 * 2.0 * (1.0 + lipschitz) / (1.0 - lipschitz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_parameters_are_named() {
        let base = Config::default();
        assert_eq!(base.check(), Ok(()));
        let with = |f: &dyn Fn(&mut Config)| {
            let mut c = Config::default();
            f(&mut c);
            c.check().unwrap_err()
        };
        assert_eq!(with(&|c| c.workers = Workers::Count(0)), ConfigError::NoWorkers);
        assert_eq!(with(&|c| c.threads = 0), ConfigError::NoThreads);
        for alpha in [0.0, -1.0, 0.5, f64::INFINITY] {
            assert_eq!(with(&|c| c.alpha = Alpha::Value(alpha)), ConfigError::Alpha { alpha });
        }
        assert!(matches!(with(&|c| c.alpha = Alpha::Value(f64::NAN)), ConfigError::Alpha { .. }));
        for graph in [GraphKind::Overlap, GraphKind::Knn] {
            let error = with(&|c| {
                c.graph = graph;
                c.sets = SeparatorSets::Smaller;
            });
            assert_eq!(error, ConfigError::SmallerSide { graph: graph.name() });
        }
        assert!(matches!(with(&|c| c.k = Neighbours::Count(3)), ConfigError::Unused { .. }));
        assert_eq!(with(&|c| c.leaf = Some(0)), ConfigError::EmptyLeaf);
    }

    #[test]
    fn leaves_grow_with_alpha() {
        let config = Config::default();
        assert_eq!(config.leaf_size(3, None), 1000);
        assert_eq!(config.leaf_size(3, Some(5.0)), 8000);
        assert_eq!(config.leaf_size(2, Some(5.0)), 2000);
        assert!((alpha_of_spacing(0.0) - 2.5).abs() < 1e-15);
    }
}
