//! The configuration of a run, in groups, and the checks that need no points.

mod constants;
mod control;
mod error;
mod graph;
mod machine;

pub(crate) use constants::TreeConstants;
pub use constants::{Constants, Purpose};
pub use control::{Control, Keep, Planted, Progress, ProgressFn, Until};
pub use error::ConfigError;
pub use graph::{Alpha, DEFAULT_ALPHA, Graph, GraphKind, alpha_of_spacing};
pub use machine::{DEFAULT_SEED, Machine, Transport, Workers, cores};
use septet_geometry::separator::LEAST_SAMPLES;
pub use septet_workers::config::Neighbours;
pub use septet_workers::config::{
    Correction, FAULTS, Factor as FaultFactor, Fault, FaultForm, FaultTextError, Law as FaultLaw, Partition,
    SetRule as SeparatorSets,
};

/// Returns the name of a rule of separator sets on the command line.
pub fn sets_name(sets: SeparatorSets) -> &'static str {
    match sets {
        SeparatorSets::Both => "both",
        SeparatorSets::Smaller => "smaller",
        SeparatorSets::Ghost => "ghost",
    }
}

/// Largest number of workers.
pub const MOST_WORKERS: u32 = 1 << 20;

/// Largest number of great circles of a draw.
const MOST_TRIES: u32 = 1000;

/// The configuration of [`crate::triangulate`], [`crate::simulate`], [`crate::count`] and [`crate::independent()`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Config {
    /// The machine.
    pub machine: Machine,
    /// The rule that divides subproblems: sphere separators, or the baseline.
    pub partition: Partition,
    /// The constants of the partition tree. [`crate::triangulate`] and [`crate::independent()`] ignore them.
    pub constants: Constants,
    /// The supergraph.
    pub graph: Graph,
    /// The rule that shares separator points between the children of a node.
    pub separator_sets: SeparatorSets,
    /// The correction of nearest-neighbour balls: one descent, or the bottom-up baseline ([`crate::simulate`] only).
    pub correction: Correction,
    /// Lipschitz constant of a set generated as f-spaced, which gives alpha by a formula.
    pub spacing: Option<f64>,
    /// Whether points that are not finite are dropped and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// The optional contents of the result.
    pub keep: Keep,
    /// Progress and cancellation.
    pub control: Control,
    /// Faults and limits that tests plant.
    pub planted: Planted,
    /// The last phase, for [`crate::count`] only. A run that stops there has no triangulation.
    pub until: Option<Until>,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            machine: Machine::default(),
            partition: Partition::Sphere,
            constants: Constants::default(),
            graph: Graph::default(),
            separator_sets: SeparatorSets::Ghost,
            correction: Correction::Descent,
            spacing: None,
            skip_invalid: false,
            keep: Keep::default(),
            control: Control::default(),
            planted: Planted::default(),
            until: None,
        }
    }
}

impl Config {
    /// Returns the configuration after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Config)) -> Self {
        change(&mut self);
        self
    }

    /// Checks the parameters that need no points.
    ///
    /// # Errors
    /// Returns an error for the first parameter that is out of range or that excludes another parameter.
    pub fn check(&self) -> Result<(), ConfigError> {
        self.check_machine()?;
        self.check_constants()?;
        match (self.graph.alpha(), self.graph.k()) {
            (Alpha::Value(alpha), _) if !(alpha >= 1.0 && alpha.is_finite()) => {
                return Err(ConfigError::Alpha { alpha });
            }
            (_, Neighbours::Log(factor)) if !(factor > 0.0 && factor.is_finite()) => {
                return Err(ConfigError::LogFactor { factor });
            }
            _ => {}
        }
        let kind = self.graph.kind();
        if self.separator_sets == SeparatorSets::Smaller && kind != GraphKind::Density {
            return Err(ConfigError::SmallerSide { graph: kind.name() });
        }
        Ok(())
    }

    fn check_constants(&self) -> Result<(), ConfigError> {
        let Constants { samples, tries, .. } = self.constants;
        match (samples, tries) {
            (Some(samples), _) if samples < LEAST_SAMPLES => {
                Err(ConfigError::Samples { samples, least: LEAST_SAMPLES })
            }
            (_, Some(_)) if self.partition == Partition::Kd => Err(ConfigError::TriesOfPlanes),
            (_, Some(tries)) if !(1..=MOST_TRIES).contains(&tries) => {
                Err(ConfigError::Tries { tries, most: MOST_TRIES })
            }
            _ => Ok(()),
        }
    }

    fn check_machine(&self) -> Result<(), ConfigError> {
        match self.machine.workers {
            Workers::Count(0) => return Err(ConfigError::NoWorkers),
            Workers::Count(workers) if workers > MOST_WORKERS => {
                return Err(ConfigError::TooManyWorkers { workers, most: MOST_WORKERS });
            }
            _ => {}
        }
        if self.machine.threads == 0 {
            return Err(ConfigError::NoThreads);
        }
        if self.machine.leaf == Some(0) {
            return Err(ConfigError::EmptyLeaf);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_parameters_are_named() {
        assert_eq!(Config::default().check(), Ok(()));
        let with = |f: &dyn Fn(&mut Config)| Config::default().with(f).check().unwrap_err();
        assert_eq!(with(&|c| c.machine.workers = Workers::Count(0)), ConfigError::NoWorkers);
        assert_eq!(with(&|c| c.machine.threads = 0), ConfigError::NoThreads);
        let density = |alpha: f64| with(&|c| c.graph = Graph::Density { alpha: Alpha::Value(alpha) });
        for alpha in [0.0, -1.0, 0.5, f64::INFINITY] {
            assert_eq!(density(alpha), ConfigError::Alpha { alpha });
        }
        assert!(matches!(density(f64::NAN), ConfigError::Alpha { .. }));
        for graph in [Graph::Overlap { alpha: Alpha::Auto }, Graph::Knn { k: Neighbours::Auto }] {
            let error = with(&|c| {
                c.graph = graph;
                c.separator_sets = SeparatorSets::Smaller;
            });
            assert_eq!(error, ConfigError::SmallerSide { graph: graph.kind().name() });
        }
        assert_eq!(with(&|c| c.machine.leaf = Some(0)), ConfigError::EmptyLeaf);
    }

    #[test]
    fn constants_out_of_range_are_refused() {
        let with = |f: &dyn Fn(&mut Constants)| Config::default().with(|c| f(&mut c.constants)).check();
        assert_eq!(with(&|c| c.samples = Some(36)), Ok(()));
        assert_eq!(with(&|c| c.samples = Some(35)), Err(ConfigError::Samples { samples: 35, least: 36 }));
        assert_eq!(with(&|c| c.tries = Some(1000)), Ok(()));
        for tries in [0, 1001] {
            assert_eq!(with(&|c| c.tries = Some(tries)), Err(ConfigError::Tries { tries, most: 1000 }));
        }
        let planes = Config::default().with(|c| (c.partition, c.constants.tries) = (Partition::Kd, Some(5)));
        assert_eq!(planes.check(), Err(ConfigError::TriesOfPlanes));
    }

    #[test]
    fn parameters_of_another_graph_are_refused() {
        let k = Graph::new(GraphKind::Density, Alpha::Auto, Neighbours::Count(3));
        assert_eq!(k, Err(ConfigError::Unused { graph: "density", parameter: "k" }));
        let alpha = Graph::new(GraphKind::Knn, Alpha::Value(2.0), Neighbours::Auto);
        assert_eq!(alpha, Err(ConfigError::Unused { graph: "knn", parameter: "alpha" }));
    }
}
