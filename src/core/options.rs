//! The options of the library, one set for each call, in groups that can grow.
//!
//! Each set offers what its call heeds, and nothing else. Sets and groups are `#[non_exhaustive]`: start from the
//! default and change fields.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::config::{
    Alpha, Config, Correction, Fault, GraphKind, Neighbours, Partition, ProgressFn, SeparatorSets, Workers,
};
use crate::mesh::field::SizeField;
use crate::mesh::{Boundary, DEFAULT_FEATURE_ANGLE, DEFAULT_LIPSCHITZ, MeshRequest, SingularityRequest};

/// How messages travel between workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Transport {
    /// Over channels between threads.
    #[default]
    Channel,
    /// On one thread, every message encoded and decoded.
    Sim {
        /// Seed of the order of delivery.
        delivery_seed: u64,
    },
}

/// The machine that a call runs on. Results do not depend on workers, threads and transport.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Machine {
    /// Number of workers; the number of cores by default.
    pub workers: Workers,
    /// Number of threads that run them; the number of cores by default.
    pub threads: usize,
    /// How their messages travel.
    pub transport: Transport,
    /// Seed of every random draw.
    pub seed: u64,
    /// The name of the run in traces; the seed if none. Runs traced at the same time need different names.
    pub run: Option<u64>,
    /// Largest leaf of the partition tree, in points; chosen by dimension and supergraph if none.
    pub leaf: Option<u64>,
    /// Refuse to start if more memory is expected, in bytes.
    pub max_memory: Option<u64>,
}

impl Default for Machine {
    fn default() -> Self {
        let Config { workers, threads, seed, .. } = Config::default();
        let transport = Transport::Channel;
        Machine { workers, threads, transport, seed, run: None, leaf: None, max_memory: None }
    }
}

impl Machine {
    fn transport(&self) -> crate::config::Transport {
        match self.transport {
            Transport::Channel => crate::config::Transport::Channel { threads: self.threads },
            Transport::Sim { delivery_seed } => crate::config::Transport::Sim { delivery_seed },
        }
    }

    fn config(&self) -> Config {
        Config {
            workers: self.workers,
            threads: self.threads,
            transport: self.transport(),
            seed: self.seed,
            run: self.run,
            leaf: self.leaf,
            max_memory: self.max_memory,
            ..Config::default()
        }
    }
}

/// How a caller follows a call and ends it.
#[derive(Clone, Default)]
#[non_exhaustive]
pub struct Control {
    /// Set to `true`, it ends the call with [`crate::Error::Interrupted`].
    pub cancel: Option<Arc<AtomicBool>>,
    /// Called with phases and rounds, on the caller's thread.
    pub progress: Option<ProgressFn>,
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}

/// What tests plant in a machine.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct Planted {
    /// A fault.
    pub fault: Option<Fault>,
    /// Rounds of exchange before unresolved regions are gathered.
    pub exchange_cap: Option<u32>,
}

impl Planted {
    fn into(self, config: Config) -> Config {
        Config { fault: self.fault, exchange_cap: self.exchange_cap, ..config }
    }
}

/// Options of `triangulate`.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct TriangulateOptions {
    /// The machine.
    pub machine: Machine,
    /// What divides the points among workers.
    pub partition: Partition,
    /// Whether points that are not finite are left out and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// Whether the result has the worker and the leaf of each cell.
    pub with_owner: bool,
    /// About this many points are kept in the result's picture; 0 for no picture.
    pub view: u32,
    /// Progress and cancellation.
    pub control: Control,
    #[doc(hidden)]
    pub planted: Planted,
}

impl TriangulateOptions {
    /// The parameters of the run.
    pub fn config(&self) -> Config {
        let config = Config {
            partition: self.partition,
            skip_invalid: self.skip_invalid,
            with_owner: self.with_owner,
            view: self.view,
            cancel: self.control.cancel.clone(),
            progress: self.control.progress.clone(),
            ..self.machine.config()
        };
        self.planted.into(config)
    }
}

/// The supergraph of the Delaunay triangulation that `simulate` builds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Graph {
    /// The density graph (paper, Section 4.2).
    Density {
        /// Its alpha.
        alpha: Alpha,
    },
    /// The overlap graph (Section 4.4).
    Overlap {
        /// Its alpha.
        alpha: Alpha,
    },
    /// The graph of k nearest neighbours (Section 4.5).
    Knn {
        /// Its k.
        k: Neighbours,
    },
}

impl Default for Graph {
    fn default() -> Self {
        Graph::Density { alpha: Alpha::Auto }
    }
}

/// What `simulate` keeps in its result besides cells and counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Keep {
    /// Whether the edges of the supergraph are kept.
    pub graph: bool,
    /// Whether the worker and the leaf of each cell are kept.
    pub owner: bool,
    /// Whether the record of tasks is kept, for predictions. It takes a run of its own, with one worker.
    pub tasks: bool,
    /// About this many points are kept in the result's picture; 0 for no picture.
    pub view: u32,
}

/// Options of `simulate`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SimulateOptions {
    /// The machine.
    pub machine: Machine,
    /// The supergraph.
    pub graph: Graph,
    /// How separator points are shared between the children of a node.
    pub separator_sets: SeparatorSets,
    /// How nearest-neighbour balls are corrected beyond separators.
    pub correction: Correction,
    /// The Lipschitz constant of an f-spaced set, which gives alpha by a formula.
    pub spacing: Option<f64>,
    /// What divides the points.
    pub partition: Partition,
    /// Whether points that are not finite are left out and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// What is kept in the result.
    pub keep: Keep,
    /// Progress and cancellation.
    pub control: Control,
    #[doc(hidden)]
    pub planted: Planted,
}

impl Default for SimulateOptions {
    fn default() -> Self {
        let Config { sets, correction, partition, .. } = Config::default();
        SimulateOptions {
            machine: Machine::default(),
            graph: Graph::default(),
            separator_sets: sets,
            correction,
            spacing: None,
            partition,
            skip_invalid: false,
            keep: Keep::default(),
            control: Control::default(),
            planted: Planted::default(),
        }
    }
}

impl SimulateOptions {
    /// The parameters of the run.
    pub fn config(&self) -> Config {
        let (graph, alpha, k) = match self.graph {
            Graph::Density { alpha } => (GraphKind::Density, alpha, Neighbours::Auto),
            Graph::Overlap { alpha } => (GraphKind::Overlap, alpha, Neighbours::Auto),
            Graph::Knn { k } => (GraphKind::Knn, Alpha::Auto, k),
        };
        let config = Config {
            graph,
            alpha,
            k,
            sets: self.separator_sets,
            correction: self.correction,
            spacing: self.spacing,
            partition: self.partition,
            skip_invalid: self.skip_invalid,
            keep_graph: self.keep.graph,
            with_owner: self.keep.owner,
            record_tasks: self.keep.tasks,
            view: self.keep.view,
            cancel: self.control.cancel.clone(),
            progress: self.control.progress.clone(),
            ..self.machine.config()
        };
        self.planted.into(config)
    }
}

/// Options of `independent`.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct IndependentOptions {
    /// The machine.
    pub machine: Machine,
    /// What divides the sites.
    pub partition: Partition,
    /// Progress and cancellation.
    pub control: Control,
}

impl IndependentOptions {
    /// The parameters of the run.
    pub fn config(&self) -> Config {
        Config {
            partition: self.partition,
            cancel: self.control.cancel.clone(),
            progress: self.control.progress.clone(),
            ..self.machine.config()
        }
    }
}

/// The sizes that a mesh is to have, in the unit of the domain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sizes {
    /// The largest size anywhere.
    pub most: Option<f64>,
    /// The smallest size anywhere: it overrides every other size.
    pub least: Option<f64>,
    /// Sizes at points.
    pub field: Option<SizeField>,
    /// A place towards which sizes fall to the smallest one.
    pub singularity: Option<SingularityRequest>,
    /// The Lipschitz constant of the size function, between 0 and 1.
    pub lipschitz: f64,
}

impl Default for Sizes {
    fn default() -> Self {
        Sizes { most: None, least: None, field: None, singularity: None, lipschitz: DEFAULT_LIPSCHITZ }
    }
}

/// Options of `mesh::make`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeshOptions {
    /// The machine.
    pub machine: Machine,
    /// What is kept of the boundary; decided by the kind of the domain if none.
    pub boundary: Option<Boundary>,
    /// The sizes.
    pub sizes: Sizes,
    /// Edges whose faces turn by more than this, in degrees, are ridges.
    pub feature_angle: f64,
    /// The largest distance between the boundary of a remeshed surface and the surface.
    pub max_distance: Option<f64>,
    /// Whether slivers are removed.
    pub improve: bool,
    /// Cancellation; progress is not reported.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl Default for MeshOptions {
    fn default() -> Self {
        MeshOptions {
            machine: Machine::default(),
            boundary: None,
            sizes: Sizes::default(),
            feature_angle: DEFAULT_FEATURE_ANGLE,
            max_distance: None,
            improve: false,
            cancel: None,
        }
    }
}

impl MeshOptions {
    /// The parameters of the mesh.
    pub fn request(&self) -> MeshRequest {
        let sizes = self.sizes.clone();
        MeshRequest {
            boundary: self.boundary,
            size: sizes.most,
            field: sizes.field,
            singularity: sizes.singularity,
            min_size: sizes.least,
            lipschitz: sizes.lipschitz,
            feature_angle: self.feature_angle,
            max_distance: self.max_distance,
            improve: self.improve,
            leaf: self.machine.leaf,
            workers: self.machine.workers,
            threads: self.machine.threads,
            transport: self.machine.transport(),
            seed: self.machine.seed,
            max_memory: self.machine.max_memory,
            cancel: self.cancel.clone(),
        }
    }
}
