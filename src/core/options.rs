//! The options of the library: one set for each call, made of the groups of [`crate::config`].
//!
//! Each set offers only the options that its call uses. Sets and groups are `#[non_exhaustive]`: start from the default
//! and change fields.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::config::{Config, Correction, DEFAULT_SEED, Partition, SeparatorSets, Workers};
pub use crate::config::{Constants, Control, Graph, Keep, Machine, Planted, Transport};
use crate::mesh::field::SizeField;
use crate::mesh::{Boundary, DEFAULT_FEATURE_ANGLE, DEFAULT_LIPSCHITZ, MeshRequest, SingularityRequest};

/// Options of `triangulate`.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct TriangulateOptions {
    /// The machine.
    pub machine: Machine,
    /// The rule that divides the points among workers.
    pub partition: Partition,
    /// Whether points that are not finite are dropped and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// Whether the result has the worker and the leaf of each cell.
    pub with_owner: bool,
    /// Whether the result has the worker that holds each point. A `.pvtu` file needs it.
    pub with_point_owner: bool,
    /// Expected number of points in the picture of the result; 0 for no picture.
    pub view: u32,
    /// Progress and cancellation.
    pub control: Control,
    #[doc(hidden)]
    pub planted: Planted,
}

impl TriangulateOptions {
    /// Returns the configuration of the run.
    pub fn config(&self) -> Config {
        Config {
            machine: self.machine.clone(),
            partition: self.partition,
            skip_invalid: self.skip_invalid,
            keep: Keep {
                owner: self.with_owner,
                point_owner: self.with_point_owner,
                view: self.view,
                ..Keep::default()
            },
            control: self.control.clone(),
            planted: self.planted,
            ..Config::default()
        }
    }
}

/// Options of `simulate`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SimulateOptions {
    /// The machine.
    pub machine: Machine,
    /// The supergraph of the Delaunay triangulation.
    pub graph: Graph,
    /// The rule that shares separator points between the children of a node.
    pub separator_sets: SeparatorSets,
    /// The correction of nearest-neighbour balls beyond separators.
    pub correction: Correction,
    /// Lipschitz constant of an f-spaced set, which gives alpha by a formula.
    pub spacing: Option<f64>,
    /// The rule that divides subproblems.
    pub partition: Partition,
    /// The constants of the partition tree.
    pub constants: Constants,
    /// Whether points that are not finite are dropped and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// The optional contents of the result.
    pub keep: Keep,
    /// Progress and cancellation.
    pub control: Control,
    #[doc(hidden)]
    pub planted: Planted,
}

impl Default for SimulateOptions {
    fn default() -> Self {
        let Config { machine, graph, separator_sets, correction, spacing, .. } = Config::default();
        SimulateOptions {
            machine,
            graph,
            separator_sets,
            correction,
            spacing,
            partition: Partition::default(),
            constants: Constants::default(),
            skip_invalid: false,
            keep: Keep::default(),
            control: Control::default(),
            planted: Planted::default(),
        }
    }
}

impl SimulateOptions {
    /// Returns the configuration of the run.
    pub fn config(&self) -> Config {
        Config {
            machine: self.machine.clone(),
            partition: self.partition,
            constants: self.constants,
            graph: self.graph,
            separator_sets: self.separator_sets,
            correction: self.correction,
            spacing: self.spacing,
            skip_invalid: self.skip_invalid,
            keep: self.keep,
            control: self.control.clone(),
            planted: self.planted,
            until: None,
        }
    }
}

/// Options of `distributed::triangulate`. All processes of a run must have equal options, except for the threads, the limit
/// of the memory, and the control.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DistributedOptions {
    /// Number of workers of all processes, at least one for each process; by default, one for each process.
    pub workers: Option<u32>,
    /// Number of threads on which this process runs its workers; 1 by default.
    pub threads: usize,
    /// Seed of every random draw.
    pub seed: u64,
    /// Largest memory forecast that this process accepts, in bytes.
    pub max_memory: Option<u64>,
    /// The rule that divides the points among workers.
    pub partition: Partition,
    /// Whether points that are not finite are dropped and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// Progress and cancellation.
    pub control: Control,
    #[doc(hidden)]
    pub planted: Planted,
}

impl Default for DistributedOptions {
    fn default() -> Self {
        DistributedOptions {
            workers: None,
            threads: 1,
            seed: DEFAULT_SEED,
            max_memory: None,
            partition: Partition::default(),
            skip_invalid: false,
            control: Control::default(),
            planted: Planted::default(),
        }
    }
}

impl DistributedOptions {
    /// Returns the configuration of a run on this number of processes.
    pub fn config(&self, processes: u32) -> Config {
        let machine = Machine::default().with(|machine| {
            machine.workers = Workers::Count(self.workers.unwrap_or(processes));
            machine.threads = self.threads;
            machine.seed = self.seed;
            machine.max_memory = self.max_memory;
        });
        Config {
            machine,
            partition: self.partition,
            skip_invalid: self.skip_invalid,
            control: self.control.clone(),
            planted: self.planted,
            ..Config::default()
        }
    }
}

/// Options of `independent`.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct IndependentOptions {
    /// The machine.
    pub machine: Machine,
    /// The rule that divides the sites.
    pub partition: Partition,
    /// Progress and cancellation.
    pub control: Control,
}

impl IndependentOptions {
    /// Returns the configuration of the run.
    pub fn config(&self) -> Config {
        Config {
            machine: self.machine.clone(),
            partition: self.partition,
            control: self.control.clone(),
            ..Config::default()
        }
    }
}

/// The sizes of a mesh, in the unit of the domain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sizes {
    /// The largest size anywhere.
    pub most: Option<f64>,
    /// The smallest size anywhere: it overrides every other size.
    pub least: Option<f64>,
    /// Sizes at points.
    pub field: Option<SizeField>,
    /// A point or segment towards which sizes decrease to the smallest size.
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
    /// The part of the boundary that is kept; by default, the kind of the domain decides.
    pub boundary: Option<Boundary>,
    /// The sizes.
    pub sizes: Sizes,
    /// Edges whose faces turn by more than this angle, in degrees, are ridges.
    pub feature_angle: f64,
    /// The largest distance between a surface and its remeshed boundary.
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
    /// Returns the request for the mesh.
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
            machine: self.machine.clone(),
            cancel: self.cancel.clone(),
        }
    }
}
