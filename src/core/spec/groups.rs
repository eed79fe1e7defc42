//! One [`Spec`] of groups describes a run. The checks here need no points.

use septet_geometry::separator::LEAST_SAMPLES;
use septet_workers::config::{Correction, Neighbours, Partition, Repair, SetRule as SeparatorSets};

use super::constants::Constants;
use super::control::{Control, Keep, Planted};
use super::error::SpecError;
use super::graph::{Alpha, Graph, GraphKind};
use super::machine::{Machine, Workers};
use super::periodic::Periodic;
use super::value::Words;

/// Largest number of workers.
pub const MOST_WORKERS: u32 = 1 << 20;

/// Largest number of great circles of a draw.
const MOST_TRIES: u32 = 1000;

/// A run: how its points are read, its machine, its tree, its recursion, and what it keeps. The call chooses the
/// [`Task`](super::Task), and ignores the groups that its task does not use.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Spec {
    /// The rules for the points.
    pub input: InputRules,
    /// The machine.
    pub machine: Machine,
    /// The partition tree.
    pub tree: Tree,
    /// The paper's recursion. [`crate::triangulate`] and [`crate::independent()`] ignore it.
    pub recursion: Recursion,
    /// The optional contents of the result.
    pub keep: Keep,
    /// Progress and cancellation.
    pub control: Control,
    /// Faults and limits that tests plant.
    #[doc(hidden)]
    pub planted: Planted,
}

/// The rules for the points of a run.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct InputRules {
    /// Dimension of the points; by default, that of the file. Only readers of files use it and the next five rules.
    pub dimension: Option<usize>,
    /// Columns of the coordinates in a text table: names from the header row, or numbers from 1.
    pub columns: Option<Vec<String>>,
    /// Name of the format of the file.
    pub format: Option<String>,
    /// Type and number of the coordinates in a file without a header, such as `f64,3`.
    pub raw: Option<String>,
    /// Whether the other numeric columns of a text table are kept.
    pub keep_columns: bool,
    /// Whether the points are a terrain: they are triangulated in the plane, and their third coordinate is kept as a height.
    pub terrain: bool,
    /// Whether points that are not finite are dropped and counted; otherwise they are an error.
    pub skip_invalid: bool,
    /// The periodic box of the points, if there is one.
    pub periodic: Option<Periodic>,
}

impl InputRules {
    /// Sets the lower corner of the periodic box.
    pub(super) fn set_origin(&mut self, corner: Option<Vec<Option<f64>>>) -> Result<(), SpecError> {
        let Some(corner) = corner else { return Ok(()) };
        let needs = SpecError::Needs { option: "origin", needed: "periodic", word: "1,1,1" };
        // An axis without a number is refused when the box is checked against the points.
        let numbers = corner.into_iter().map(|number| number.unwrap_or(f64::NAN)).collect();
        self.periodic.as_mut().ok_or(needs)?.origin = numbers;
        Ok(())
    }

    /// Sets whether points outside of the periodic box are admitted.
    pub(super) fn set_wrap(&mut self, is_set: bool) -> Result<(), SpecError> {
        match &mut self.periodic {
            Some(periodic) => periodic.wrap = is_set,
            None if is_set => {
                return Err(SpecError::Needs { option: "wrap", needed: "periodic", word: "1,1,1" });
            }
            None => {}
        }
        Ok(())
    }
}

/// The rules of the partition tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Tree {
    /// The rule that divides subproblems: sphere separators, or the baseline.
    pub partition: Partition,
    /// Largest leaf, in points; by default, the dimension and the supergraph decide.
    pub leaf: Option<u64>,
    /// The constants of the draws. [`crate::triangulate`] and [`crate::independent()`] ignore them.
    pub constants: Constants,
}

/// The rules of the paper's recursion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Recursion {
    /// The supergraph of the Delaunay triangulation.
    pub graph: Graph,
    /// The rule that shares separator points between the children of a node.
    pub sets: SeparatorSets,
    /// The correction of nearest-neighbour balls across separators.
    pub neighbours: Correction,
    /// The repair of stars that disagree.
    pub repair: Repair,
    /// Lipschitz constant of a set generated as f-spaced, which gives alpha by a formula.
    pub spacing: Option<f64>,
}

impl Default for Recursion {
    fn default() -> Self {
        Recursion {
            graph: Graph::default(),
            sets: SeparatorSets::Ghost,
            neighbours: Correction::Descent,
            repair: Repair::Probe,
            spacing: None,
        }
    }
}

impl Spec {
    /// Returns the specification after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Spec)) -> Self {
        change(&mut self);
        self
    }

    /// Checks the parameters that need no points.
    ///
    /// # Errors
    /// Returns an error for the first parameter that is out of range or that excludes another parameter.
    pub fn check(&self) -> Result<(), SpecError> {
        self.check_machine()?;
        self.check_constants()?;
        match (self.recursion.graph.alpha(), self.recursion.graph.k()) {
            (Alpha::Value(alpha), _) if !(alpha >= 1.0 && alpha.is_finite()) => {
                return Err(SpecError::Alpha { alpha });
            }
            (_, Neighbours::Log(factor)) if !(factor > 0.0 && factor.is_finite()) => {
                return Err(SpecError::LogFactor { factor });
            }
            _ => {}
        }
        self.check_balls()?;
        let kind = self.recursion.graph.kind();
        if self.recursion.sets == SeparatorSets::Smaller && kind != GraphKind::Density {
            return Err(SpecError::SmallerSide { graph: kind.name() });
        }
        Ok(())
    }

    /// Checks the balls of an overlap graph.
    fn check_balls(&self) -> Result<(), SpecError> {
        let Graph::Overlap { alpha, k } = self.recursion.graph else { return Ok(()) };
        match (k, alpha) {
            (Neighbours::Log(factor), _) => Err(SpecError::OverlapLog { factor }),
            (Neighbours::Count(_), Alpha::Auto) => Err(SpecError::AutomaticAlpha { k }),
            (Neighbours::Count(k), _) if k > 1 && self.recursion.neighbours != Correction::Descent => {
                Err(SpecError::FirstBalls { correction: self.recursion.neighbours.name(), k })
            }
            (Neighbours::Auto | Neighbours::Count(_), _) => Ok(()),
        }
    }

    fn check_constants(&self) -> Result<(), SpecError> {
        let Constants { samples, tries, .. } = self.tree.constants;
        match (samples, tries) {
            (Some(samples), _) if samples < LEAST_SAMPLES => {
                Err(SpecError::Samples { samples, least: LEAST_SAMPLES })
            }
            (_, Some(_)) if self.tree.partition != Partition::Sphere => {
                Err(SpecError::TriesOfBaseline { partition: self.tree.partition.name() })
            }
            (_, Some(tries)) if !(1..=MOST_TRIES).contains(&tries) => {
                Err(SpecError::Tries { tries, most: MOST_TRIES })
            }
            _ => Ok(()),
        }
    }

    fn check_machine(&self) -> Result<(), SpecError> {
        match self.machine.workers {
            Workers::Count(0) => return Err(SpecError::NoWorkers),
            Workers::Count(workers) if workers > MOST_WORKERS => {
                return Err(SpecError::TooManyWorkers { workers, most: MOST_WORKERS });
            }
            _ => {}
        }
        if self.machine.threads == Some(0) {
            return Err(SpecError::NoThreads);
        }
        if self.tree.leaf == Some(0) {
            return Err(SpecError::EmptyLeaf);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_parameters_are_named() {
        assert_eq!(Spec::default().check(), Ok(()));
        let with = |f: &dyn Fn(&mut Spec)| Spec::default().with(f).check().unwrap_err();
        assert_eq!(with(&|c| c.machine.workers = Workers::Count(0)), SpecError::NoWorkers);
        assert_eq!(with(&|c| c.machine.threads = Some(0)), SpecError::NoThreads);
        let density =
            |alpha: f64| with(&|c| c.recursion.graph = Graph::Density { alpha: Alpha::Value(alpha) });
        for alpha in [0.0, -1.0, 0.5, f64::INFINITY] {
            assert_eq!(density(alpha), SpecError::Alpha { alpha });
        }
        assert!(matches!(density(f64::NAN), SpecError::Alpha { .. }));
        for graph in [GraphKind::Overlap, GraphKind::Knn].map(GraphKind::graph) {
            let error = with(&|c| {
                c.recursion.graph = graph;
                c.recursion.sets = SeparatorSets::Smaller;
            });
            assert_eq!(error, SpecError::SmallerSide { graph: graph.kind().name() });
        }
        assert_eq!(with(&|c| c.tree.leaf = Some(0)), SpecError::EmptyLeaf);
    }

    #[test]
    fn constants_out_of_range_are_refused() {
        let with = |f: &dyn Fn(&mut Constants)| Spec::default().with(|c| f(&mut c.tree.constants)).check();
        assert_eq!(with(&|c| c.samples = Some(36)), Ok(()));
        assert_eq!(with(&|c| c.samples = Some(35)), Err(SpecError::Samples { samples: 35, least: 36 }));
        assert_eq!(with(&|c| c.tries = Some(1000)), Ok(()));
        for tries in [0, 1001] {
            assert_eq!(with(&|c| c.tries = Some(tries)), Err(SpecError::Tries { tries, most: 1000 }));
        }
        let planes =
            Spec::default().with(|c| (c.tree.partition, c.tree.constants.tries) = (Partition::Kd, Some(5)));
        assert_eq!(planes.check(), Err(SpecError::TriesOfBaseline { partition: "kd" }));
    }

    #[test]
    fn balls_that_no_search_finds_are_refused() {
        let with = |alpha, k, correction| {
            let recursion = Recursion {
                graph: Graph::Overlap { alpha, k },
                neighbours: correction,
                ..Recursion::default()
            };
            Spec { recursion, ..Spec::default() }.check()
        };
        let (four, two) = (Neighbours::Count(4), Alpha::Value(2.0));
        assert_eq!(with(two, four, Correction::Descent), Ok(()));
        assert_eq!(with(Alpha::Auto, four, Correction::Descent), Err(SpecError::AutomaticAlpha { k: four }));
        let log = with(two, Neighbours::Log(2.0), Correction::Descent);
        assert_eq!(log, Err(SpecError::OverlapLog { factor: 2.0 }));
        for correction in [Correction::BottomUp, Correction::Stages, Correction::Pairs] {
            let refused = SpecError::FirstBalls { correction: correction.name(), k: 4 };
            assert_eq!(with(two, four, correction), Err(refused));
            assert_eq!(with(two, Neighbours::Count(1), correction), Ok(()));
        }
    }

    #[test]
    fn parameters_of_another_graph_are_refused() {
        let k = Graph::new(GraphKind::Density, Alpha::Auto, Neighbours::Count(3));
        assert_eq!(k, Err(SpecError::Unused { graph: "density", parameter: "k" }));
        let alpha = Graph::new(GraphKind::Knn, Alpha::Value(2.0), Neighbours::Auto);
        assert_eq!(alpha, Err(SpecError::Unused { graph: "knn", parameter: "alpha" }));
    }
}
