//! All options of a run, as given or by default.

use std::path::PathBuf;

use serde::Serialize;

use septet_core::spec::{Constants, Spec, sets_name};

use super::context::RunContext;

/// The options of a run as requested, except `leaf`. Other fields of the report contain the values that the run used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameters {
    /// `triangulate` or `simulate`.
    pub command: &'static str,
    /// The input as given on the command line.
    pub input: String,
    /// The outputs as given on the command line.
    pub outputs: Vec<PathBuf>,
    /// A number, or `leaves`.
    pub workers: String,
    /// Number of threads that run the workers.
    pub threads: usize,
    /// `density`, `overlap` or `knn`.
    pub supergraph: &'static str,
    /// A number, or `auto`.
    pub alpha: String,
    /// A number, `auto`, or a factor of ln n such as `10ln`.
    pub k: String,
    /// `both`, `smaller` or `ghost`.
    pub separator_sets: &'static str,
    /// `sphere` or `kd`.
    pub partition: &'static str,
    /// `descent` or `naive`.
    pub neighbours: &'static str,
    /// `counting` or `timing`; `simulate` only.
    pub constants: &'static str,
    /// A number, or `auto`.
    pub samples: String,
    /// A number, or `auto`.
    pub tries: String,
    /// Largest number of points in a leaf, as the run used it.
    pub leaf: u64,
    /// Whether septet chose the leaf size.
    pub leaf_auto: bool,
    /// `channel` or `sim`.
    pub transport: &'static str,
    /// Seed of the delivery order; `sim` only.
    pub delivery_seed: Option<u64>,
    /// Lipschitz constant of a generated f-spaced set.
    pub lipschitz: Option<f64>,
    /// Whether invalid points are dropped.
    pub skip_invalid: bool,
    /// Memory limit in bytes.
    pub max_memory: Option<u64>,
    /// Whether the owner and the owning leaf of each cell are kept.
    pub with_owner: bool,
    /// Number of points requested for the picture.
    pub view: u32,
    /// Maximum number of splaying rounds before the fallback. `None` for `6 log2 n`.
    pub exchange_cap: Option<u32>,
}

impl Parameters {
    /// Returns the parameters of a configuration.
    pub(super) fn of(spec: &Spec, context: &RunContext<'_>, leaf: u64) -> Self {
        let Spec { machine, tree, recursion, keep, .. } = spec;
        let (graph, constants) = (recursion.graph, tree.constants);
        Parameters {
            command: context.command,
            input: context.input.to_owned(),
            outputs: context.outputs.to_vec(),
            workers: machine.workers.to_string(),
            threads: machine.thread_count(),
            supergraph: graph.kind().name(),
            alpha: graph.alpha().to_string(),
            k: graph.k().to_string(),
            separator_sets: sets_name(spec.recursion.sets),
            partition: spec.tree.partition.name(),
            neighbours: spec.recursion.neighbours.name(),
            constants: constants.purpose.name(),
            samples: Constants::text(constants.samples),
            tries: Constants::text(constants.tries),
            leaf,
            leaf_auto: tree.leaf.is_none(),
            transport: machine.transport.name(),
            delivery_seed: machine.transport.delivery_seed(),
            lipschitz: spec.recursion.spacing,
            skip_invalid: spec.input.skip_invalid,
            max_memory: machine.max_memory,
            with_owner: keep.owner,
            view: keep.view,
            exchange_cap: spec.planted.exchange_cap,
        }
    }
}
