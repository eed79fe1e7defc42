//! What every rank knows of a run before it starts.

mod fault;

mod stop;

mod text;

use std::sync::Arc;

pub use fault::{Fault, FaultTextError};
use septet_geometry::graph::Supergraph;
use septet_geometry::separator::{DrawKey, Sampler, bisection_samples};
pub use stop::Stop;
pub use text::ConfigTextError;

/// The supergraph asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// This one.
    Fixed(Supergraph),
    /// A density graph whose alpha a sample of stars chooses, else 48 nearest neighbours.
    AutoDensity,
    /// An overlap graph, likewise.
    AutoOverlap,
}

/// How separator points are shared (paper, Section 4.3, and its refinements).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetRule {
    /// The paper's: the separator points of both sides go to both children.
    Both,
    /// Those of the side that has fewer go to the other child. Density graphs only.
    Smaller,
    /// Every point also goes to each leaf that an edge of it can reach; nearest-neighbour balls fetch.
    Ghost,
}

/// What cuts a subproblem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Partition {
    /// Sphere separators, as in the paper.
    #[default]
    Sphere,
    /// The rival: planes across the longest side, at the median.
    Kd,
}

impl Partition {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Partition::Sphere => "sphere",
            Partition::Kd => "kd",
        }
    }
}

/// How nearest-neighbour balls find what lies beyond separators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correction {
    /// All balls descend from the root together, once (Section 4.3, after Frieze, Miller and Teng 1993).
    #[default]
    Descent,
    /// The rival: node by node from the leaves up, each correcting the balls that cross its separator by a
    /// descent of its own.
    Naive,
}

impl Correction {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Correction::Descent => "descent",
            Correction::Naive => "naive",
        }
    }
}

/// What a run makes of its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Task {
    /// Their Delaunay triangulation.
    #[default]
    Delaunay,
    /// A maximal independent set of the density graph (alpha 1) of the radii that the points bring along
    /// (`crate::graph::independent`).
    Independent {
        /// Points of smaller ids are in the set from the start.
        fixed: u64,
    },
}

/// The rules of the partition tree.
#[derive(Clone, Copy, Debug)]
pub struct TreeRules {
    /// A subproblem of at most this many points is not split.
    pub leaf: u64,
    /// What cuts subproblems.
    pub partition: Partition,
    /// Separators halve: where only the answer is wanted, and all wait for the largest piece.
    pub balanced: bool,
}

/// The rules of the supergraph and its separator sets.
#[derive(Clone, Copy, Debug)]
pub struct GraphRules {
    /// The supergraph.
    pub wanted: Wanted,
    /// Separator sets.
    pub sets: SetRule,
    /// How nearest-neighbour balls are corrected.
    pub correction: Correction,
}

/// What is collected beside the result.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// Send the graph's edges to the coordinator.
    pub collect_graph: bool,
    /// Send the home leaf of every cell with it.
    pub with_leaves: bool,
    /// Sampled points that the workers show of themselves, expected over all of them; 0 for no picture.
    pub view: u32,
    /// Record what leaves have to say to each other. One worker only.
    pub record_tasks: bool,
}

/// Parameters of a run that every rank shares. They hold no point.
#[derive(Clone, Debug)]
pub struct WorkerConfig {
    /// Identifies the run in messages.
    pub run: u64,
    /// Seed of every random draw.
    pub seed: u64,
    /// What is made of the points.
    pub task: Task,
    /// Number of workers.
    pub workers: u32,
    /// Split to the floor and count work and depth; else a worker triangulates its piece at once.
    pub counted: bool,
    /// The rules of the tree.
    pub tree: TreeRules,
    /// The rules of the supergraph.
    pub graph: GraphRules,
    /// What is collected beside the result.
    pub shown: Shown,
    /// Stop after this phase and collect the counts alone.
    pub until: Option<septet_protocol::ids::Phase>,
    /// Rounds of exchange before unresolved regions are gathered; `6 log2 n` if none.
    pub exchange_cap: Option<u32>,
    /// A fault planted by a test.
    pub fault: Option<Fault>,
    /// Asks workers in the caller's process to give up; those of other processes are ended with it.
    pub stop: Stop,
}

impl WorkerConfig {
    /// Who is a sample of a subproblem's attempt.
    pub(crate) fn sampler(&self, key: DrawKey, population: u64) -> Sampler {
        if self.tree.balanced {
            Sampler::with_target(key, population, bisection_samples(population))
        } else {
            Sampler::of(key, population)
        }
    }
}

#[cfg(test)]
impl WorkerConfig {
    /// For tests: one worker, 8 nearest neighbours.
    pub(crate) fn plain() -> Self {
        WorkerConfig {
            run: 1,
            seed: 5,
            task: Task::Delaunay,
            workers: 1,
            counted: true,
            tree: TreeRules { leaf: 60, balanced: false, partition: Partition::Sphere },
            graph: GraphRules {
                wanted: Wanted::Fixed(Supergraph::Knn { k: 8 }),
                sets: SetRule::Ghost,
                correction: Correction::Descent,
            },
            shown: Shown::default(),
            until: None,
            exchange_cap: None,
            fault: None,
            stop: Stop::default(),
        }
    }
}

/// Cores that a worker has to itself.
pub type Pool = Option<Arc<rayon::ThreadPool>>;

/// Maps items, in order, on the worker's own cores if it has any.
pub fn map_in<T: Sync, U: Send>(pool: &Pool, items: &[T], f: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    use rayon::prelude::*;
    match pool {
        Some(pool) if items.len() > 1 => pool.install(|| items.par_iter().map(&f).collect()),
        _ => items.iter().map(f).collect(),
    }
}
