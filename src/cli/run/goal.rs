//! `septet triangulate` and `septet simulate`: the subcommand with its options.

use std::path::Path;

use septet_core::Spec;
use septet_core::spec::Task;

use crate::effects::{excludes, needs};
use crate::errors::Failure;
use crate::given::Options;
use crate::options::{RunArgs, SimulateArgs, TriangulateArgs};
use crate::weights::GivenWeights;

/// The subcommand with its options.
#[derive(Clone, Copy, Debug)]
pub enum Goal<'a> {
    /// `septet triangulate`.
    Triangulate(&'a TriangulateArgs),
    /// `septet simulate`.
    Simulate(&'a SimulateArgs),
}

impl<'a> Goal<'a> {
    /// Returns the name of the subcommand.
    pub(super) fn name(self) -> &'static str {
        match self {
            Goal::Triangulate(_) => "triangulate",
            Goal::Simulate(_) => "simulate",
        }
    }

    /// Returns what the run computes.
    pub(super) fn task(self) -> Task {
        match self {
            Goal::Triangulate(_) => Task::Triangulate,
            Goal::Simulate(_) => Task::Simulate,
        }
    }

    /// Returns the options of both subcommands.
    pub fn args(self) -> &'a RunArgs {
        match self {
            Goal::Triangulate(args) => &args.run,
            Goal::Simulate(args) => &args.run,
        }
    }

    /// Returns the file of the cost trace.
    pub(super) fn cost_trace(self) -> Option<&'a Path> {
        match self {
            Goal::Triangulate(_) => None,
            Goal::Simulate(args) => args.cost_trace.as_deref(),
        }
    }

    /// Returns the weights of the points, if they are given.
    pub(super) fn weights(self) -> Option<GivenWeights<'a>> {
        self.args().weights.given()
    }

    /// Returns the file of the rows of hidden points.
    pub(super) fn hidden(self) -> Option<&'a Path> {
        self.args().hidden_rows.as_deref()
    }

    /// Returns the file of the offsets of vertices.
    pub(super) fn offsets(self) -> Option<&'a Path> {
        self.args().offsets.as_deref()
    }

    /// Returns the file of break lines.
    pub(super) fn breaklines(self) -> Option<&'a Path> {
        match self {
            Goal::Triangulate(args) => args.breaklines.as_deref(),
            Goal::Simulate(_) => None,
        }
    }

    /// Whether the numbers of the triangulation are printed and reported.
    pub(super) fn has_stats(self) -> bool {
        match self {
            Goal::Triangulate(args) => args.stats,
            Goal::Simulate(_) => false,
        }
    }

    /// Returns the options of the run, as given.
    pub(super) fn given(self) -> &'a Options<Spec> {
        match self {
            Goal::Triangulate(args) => args.given.options(),
            Goal::Simulate(args) => args.given.options(),
        }
    }

    /// Returns the checked specification, as requested.
    pub fn requested(self) -> Result<Spec, Failure> {
        let (given, args) = (self.given(), self.args());
        needs("--nodes", given.has("nodes"), "--json", args.json.is_some())?;
        needs("--hidden", self.hidden().is_some(), "--weights or --radii", self.weights().is_some())?;
        needs("--offsets", self.offsets().is_some(), "--periodic", given.has("periodic"))?;
        excludes("--stats", self.has_stats(), "--periodic", given.has("periodic"))?;
        excludes("--terrain", given.has("terrain"), "--periodic", given.has("periodic"))?;
        if self.breaklines().is_some() {
            needs("--breaklines", true, "--terrain", given.has("terrain"))?;
            excludes("--breaklines", true, "--stats", self.has_stats())?;
            excludes("--breaklines", true, "--with-owner", given.has("with-owner"))?;
        }
        let spec = given.spec()?.with(|c| {
            c.keep.costs = self.cost_trace().is_some();
            c.planted.fault = args.fault;
        });
        spec.check()?;
        Ok(spec)
    }
}
