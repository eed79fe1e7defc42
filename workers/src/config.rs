//! The parameters of a run, which every rank has before it starts.

pub mod cores;
mod cost_log;
mod fault;
mod memory;
mod neighbours;
mod stop;

pub use cores::{Pool, map_in};
pub use cost_log::{ChargeRecord, ChargesByRank, CostLog};
pub use fault::{FAULTS, Factor, Fault, FaultForm, FaultTextError, Flip, Law};
pub(crate) use memory::Growth;
pub use memory::{MemoryLimit, MemoryUse, Probe, STEP};
pub use neighbours::{FALLBACK_K, Neighbours};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_geometry::separator::{DrawKey, Sampler, bisection_samples, node_samples};
use septet_protocol::ids::Phase;
pub use stop::Stop;

/// The rule for the supergraph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// This supergraph.
    Fixed(Supergraph),
    /// The nearest neighbours by this rule.
    Nearest(Neighbours),
    /// The best of a family by a sample of stars.
    Auto {
        /// The family.
        family: Family,
        /// The quantity that the choice keeps small.
        purpose: Purpose,
    },
}

/// A family of supergraphs with a parameter alpha, whose balls extend to the nearest neighbour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Density graphs.
    Density,
    /// Overlap graphs.
    Overlap,
}

impl Family {
    /// Returns the graph of the family with this alpha.
    pub fn with(self, alpha: f64) -> Supergraph {
        match self {
            Family::Density => Supergraph::Density { alpha },
            Family::Overlap => Supergraph::Overlap { alpha, k: 1 },
        }
    }
}

/// The quantity that the constants and the choices of a run keep small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Work and depth on the machine of the paper.
    #[default]
    Counting,
    /// Time on processors with caches.
    Timing,
}

impl Wanted {
    /// Returns the supergraph for a number of points, unless it depends on a sample or its k is invalid.
    pub fn fixed(self, points: u64) -> Option<Supergraph> {
        match self {
            Wanted::Fixed(rule) => Some(rule),
            Wanted::Nearest(k) => k.of(points).map(|k| Supergraph::Knn { k }),
            Wanted::Auto { .. } => None,
        }
    }
}

/// The reason why a run does not start with its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// k is not positive or not less than the number of points.
    Neighbours {
        /// The k of the configuration.
        k: u32,
    },
    /// The pieces are too large.
    Piece {
        /// Expected number of points of a worker.
        points: u64,
    },
}

/// The largest number of points that one worker can triangulate at once, with room for uneven subdomains.
pub const MOST_IN_A_PIECE: u64 = 1 << 25;

/// The rule by which children share separator points (paper, Section 4.3, and refinements).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetRule {
    /// The paper's rule: the separator points of both sides go to both children.
    Both,
    /// As [`SetRule::Both`], and every set has its own separator, which is drawn for the set with its copies.
    Own,
    /// The separator points of the side that has fewer of them go to the other child. Density graphs only.
    Smaller,
    /// Every point goes to each leaf that one of its edges can reach.
    Ghost,
}

/// The surfaces that split subproblems.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Partition {
    /// Sphere separators, as in the paper.
    #[default]
    Sphere,
    /// A baseline: planes across the longest side, at the median.
    Kd,
    /// A baseline: cuts of one Hilbert curve, at the median.
    Hilbert,
}

/// The correction of nearest-neighbour balls that cross separators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correction {
    /// All balls descend from the root together, once (Section 4.3, after Frieze, Miller and Teng 1993).
    #[default]
    Descent,
    /// The baseline: node by node from the leaves up. Each node corrects the balls that cross its separator by a descent.
    BottomUp,
    /// Node by node from the leaves up, in a constant number of stages at each node that does not punt (Frieze, Miller and
    /// Teng 1993).
    Stages,
    /// Well-separated pairs of nodes of fair split trees (Callahan and Kosaraju 1995).
    Pairs,
}

/// The repair of stars that disagree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Repair {
    /// Star splaying. Each cell that some star lacks also asks one leaf of the tree for a point in its circumsphere.
    #[default]
    Probe,
    /// Star splaying alone (Shewchuk 2005).
    Splay,
}

/// The task of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The Delaunay triangulation of the points.
    Delaunay {
        /// Whether rows with a coordinate that is not finite are removed. Otherwise, the run refuses them.
        skips_invalid: bool,
    },
    /// A maximal independent set of the density graph with alpha 1, whose radii are part of the input
    /// (`crate::graph::independent`).
    Independent {
        /// Points with smaller ids belong to the set from the start.
        fixed: u64,
    },
    /// A rule of the caller at items (`crate::evaluation`).
    Evaluation {
        /// The phase that is charged.
        phase: Phase,
    },
}

/// The rules of the partition tree.
#[derive(Clone, Copy, Debug)]
pub struct TreeRules {
    /// A subproblem of at most this many points is not split.
    pub leaf: u64,
    /// Largest expected number of samples of a draw. Small subproblems have fewer ([`node_samples`]).
    pub samples: u64,
    /// Number of great circles of a draw.
    pub tries: u32,
    /// The surfaces that split subproblems.
    pub partition: Partition,
    /// Whether separators move to the median: for `triangulate`, whose workers wait for the largest subdomain. The
    /// numbers of samples and great circles are then those of [`septet_geometry::separator::draw_bisecting`].
    pub balanced: bool,
}

/// The rules of the supergraph, of its separator sets, and of the repair of its stars.
#[derive(Clone, Copy, Debug)]
pub struct GraphRules {
    /// The supergraph.
    pub wanted: Wanted,
    /// Separator sets.
    pub sets: SetRule,
    /// The correction of nearest-neighbour balls.
    pub correction: Correction,
    /// The repair of stars that disagree.
    pub repair: Repair,
    /// Rounds of splaying before unresolved regions are gathered; `6 log2 n` if `None`.
    pub exchange_cap: Option<u32>,
}

/// The additional outputs of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// Whether the ranks keep the edges of the supergraph.
    pub with_edges: bool,
    /// Whether the ranks keep the members of the separator sets of the leaves.
    pub with_sets: bool,
    /// Whether the phases of the direct path are charged. A subdomain is then charged as an insertion by
    /// [`septet_geometry::dependence`], which triangulates it once more.
    pub with_prices: bool,
    /// Whether the phases of the direct path are charged by the operations of their workers, one after the other, if they
    /// are not charged as an insertion.
    pub with_operations: bool,
    /// Whether a counted run finds the neighbours of its cells, as every other run does.
    pub with_neighbours: bool,
    /// Whether the ranks keep the coordinates and the owners of the vertices of their cells.
    pub with_places: bool,
    /// Expected number of sampled points in the picture; 0 for no picture.
    pub view: u32,
}

/// Parameters of a run that all ranks share. They contain no points.
#[derive(Clone, Debug)]
pub struct WorkerConfig {
    /// Identifies the run in messages.
    pub run: u64,
    /// Seed of every random draw.
    pub seed: u64,
    /// The task.
    pub task: Task,
    /// Number of workers.
    pub workers: u32,
    /// Whether workers split down to the smallest leaves and count work and depth. If `false`, each worker
    /// triangulates its subdomain as a whole.
    pub counted: bool,
    /// The rules of the tree.
    pub tree: TreeRules,
    /// The rules of the supergraph.
    pub graph: GraphRules,
    /// The additional outputs of a run.
    pub shown: Shown,
    /// The phase after which the run stops and collects only the counts.
    pub until: Option<Phase>,
    /// A fault planted by a test.
    pub fault: Option<Fault>,
    /// The reasons to stop before the end.
    pub stop: Stop,
    /// The place for the charges of the ranks, if the run keeps them.
    pub cost_log: CostLog,
}

impl Shown {
    /// Returns `true` if the phases of the direct path are charged.
    pub(crate) fn charges_direct(self) -> bool {
        self.with_prices || self.with_operations
    }
}

impl Task {
    /// Returns `true` if rows with a coordinate that is not finite are removed.
    pub fn skips_invalid(self) -> bool {
        self == Task::Delaunay { skips_invalid: true }
    }
}

impl WorkerConfig {
    /// Returns the number of ranks: the workers and the coordinator.
    pub fn ranks(&self) -> u32 {
        self.workers + 1
    }

    /// Returns `true` if the run builds stars in small leaves. Otherwise each worker triangulates its subdomain as a whole, which
    /// is possible in the plane and in space only.
    pub fn by_stars<P: Point>(&self) -> bool {
        self.counted || P::DIM > 3
    }

    /// Returns `true` if the cells of the run get neighbours.
    pub fn has_neighbours(&self) -> bool {
        self.shown.with_neighbours || !self.counted
    }

    /// Returns the reason why a run with this number of points does not start, if there is one.
    pub fn refusal<P: Point>(&self, points: u64) -> Option<Refusal> {
        match self.graph.wanted {
            Wanted::Nearest(rule @ Neighbours::Count(k)) if rule.of(points).is_none() => {
                return Some(Refusal::Neighbours { k });
            }
            // One neighbour is the default, also of a single point.
            Wanted::Fixed(Supergraph::Overlap { k, .. })
                if k != 1 && Neighbours::Count(k).of(points).is_none() =>
            {
                return Some(Refusal::Neighbours { k });
            }
            _ => {}
        }
        let share = points / u64::from(self.workers);
        (!self.by_stars::<P>() && share > MOST_IN_A_PIECE).then_some(Refusal::Piece { points: share })
    }

    /// Returns the sampler of an attempt at a subproblem.
    pub(crate) fn sampler(&self, key: DrawKey, population: u64) -> Sampler {
        let target = if self.tree.balanced {
            bisection_samples(population)
        } else {
            node_samples(self.tree.samples, population)
        };
        Sampler::new(key, population, target)
    }
}

#[cfg(test)]
impl WorkerConfig {
    /// Creates a configuration for tests: one worker, 8 nearest neighbours.
    pub(crate) fn plain() -> Self {
        WorkerConfig {
            run: 1,
            seed: 5,
            task: Task::Delaunay { skips_invalid: false },
            workers: 1,
            counted: true,
            tree: TreeRules {
                leaf: 60,
                samples: 400,
                tries: 10,
                balanced: false,
                partition: Partition::Sphere,
            },
            graph: GraphRules {
                wanted: Wanted::Fixed(Supergraph::Knn { k: 8 }),
                sets: SetRule::Ghost,
                correction: Correction::Descent,
                repair: Repair::Probe,
                exchange_cap: None,
            },
            shown: Shown::default(),
            until: None,
            fault: None,
            stop: Stop::default(),
            cost_log: CostLog::default(),
        }
    }
}
