//! The runs that several claims share, over sizes from 8 leaves up.

use std::rc::Rc;

use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, DEFAULT_ALPHA, Graph, Neighbours, Until};
use septet_protocol::ledger::PhaseTotal;

use super::counted::Counted;
use super::figure::largest;
use super::lab::{Lab, Runs};
use super::sample::Sample;
use super::{ClaimError, Extent};

/// Largest leaf, in points. The separator sets `both` and `smaller` need larger leaves, but these runs use `ghost`.
pub(super) const LEAF: u64 = 60;

/// The smallest number of points of a sweep. Its tree has at least 8 leaves.
const SMALLEST: u64 = 512;

/// k of the sweep of nearest-neighbour lists.
pub(super) const LIST: u32 = 12;

/// The runs of a sweep, and the name of their points.
#[derive(Clone)]
pub(super) struct Sweep {
    pub(super) name: String,
    /// The phases that every run must charge. A run probes only if a ball is large, so probes are not among them.
    pub(super) phases: &'static [&'static str],
    pub(super) runs: Rc<Vec<Counted>>,
}

/// The phases of a complete run with a density graph.
const OF_RECURSIONS: &[&str] =
    &["partition", "radii", "neighbours", "summaries", "separator-sets", "graph", "hulls", "check", "merge"];

/// The phases of a run up to the graph of nearest-neighbour lists that go down the tree or run within its leaves.
const OF_LISTS: &[&str] = &["partition", "summaries", "knn-radii", "knn"];

/// The phases of a run up to the neighbour balls.
const OF_TREES: &[&str] = &["partition", "radii", "neighbours"];

/// Returns the phases that some sweep must charge.
#[cfg(test)]
pub(super) fn all_phases() -> impl Iterator<Item = &'static str> {
    [OF_RECURSIONS, OF_LISTS, OF_TREES].into_iter().flatten().copied()
}

impl Sweep {
    /// Returns the dimension of the points.
    pub(super) fn dimension(&self) -> usize {
        self.runs.first().map_or(3, |run| run.line.dimension)
    }

    /// Returns the largest value of all runs. It is undefined if there is no run or a value is undefined.
    pub(super) fn largest(&self, value: impl Fn(&Counted) -> f64) -> f64 {
        largest(self.runs.iter().map(value))
    }

    /// Returns `true` if every run must charge the phase.
    pub(super) fn must_have(&self, phase: &str) -> bool {
        self.phases.contains(&phase)
    }

    /// Returns `true` if a run charged the phase.
    pub(super) fn has(&self, phase: &str) -> bool {
        self.runs.iter().any(|run| run.line.phase(phase).is_some_and(|phase| phase.total.depth > 0))
    }

    /// Returns a count of a phase in a run. Without charges, the count of a phase that must occur is undefined, and
    /// that of another phase is 0.
    pub(super) fn count(&self, run: &Counted, phase: &str, of: impl Fn(&PhaseTotal) -> u64) -> f64 {
        let missing = if self.must_have(phase) { f64::NAN } else { 0.0 };
        let total = run.line.phase(phase).map(|row| &row.total);
        let charged = total.filter(|total| total.work > 0 && total.depth > 0);
        charged.map_or(missing, |total| of(total) as f64)
    }
}

/// The sizes and seeds of a sweep: the number of octaves, of sizes per octave, and of seeds for each size.
struct Extents {
    octaves: u32,
    parts: u32,
    seeds: u64,
}

/// Sizes per octave.
const PARTS: u32 = 8;

/// Returns samples of eight sizes per octave.
pub(super) fn sizes(smallest: u64, octaves: u32, kind: Kind, d: usize) -> Vec<Sample> {
    samples(smallest, &Extents { octaves, parts: PARTS, seeds: 1 }, kind, d)
}

fn samples(smallest: u64, extents: &Extents, kind: Kind, d: usize) -> Vec<Sample> {
    let size = |i: u32| (smallest as f64 * (f64::from(i) / f64::from(extents.parts)).exp2()).round() as u64;
    (0..=extents.octaves * extents.parts).map(|i| Sample::new(kind, size(i), d)).collect()
}

/// Returns the sweeps of the paper's recursion over well-spaced sets in the plane and in space.
pub(super) fn recursions(lab: &mut Lab) -> Result<Vec<Sweep>, ClaimError> {
    let leaf = |spec: Spec| spec.with(|c| c.tree.leaf = Some(LEAF));
    let extents = extents(lab, [4, 7, 10]);
    sweeps(lab, &extents, ("recursion", Kind::WellSpaced, OF_RECURSIONS), None, leaf)
}

/// Returns the sweeps of nearest-neighbour lists over uniform sets, up to the graph.
pub(super) fn lists(lab: &mut Lab) -> Result<Vec<Sweep>, ClaimError> {
    let lists = |spec: Spec| {
        spec.with(|c| {
            c.tree.leaf = Some(LEAF);
            c.recursion.graph = Graph::Knn { k: Neighbours::Count(LIST) };
        })
    };
    let extents = extents(lab, [4, 5, 8]);
    sweeps(lab, &extents, ("lists", Kind::Uniform, OF_LISTS), Some(Until::Graph), lists)
}

/// Returns the sweeps of the tree and the neighbour balls over uniform sets, which have no spacing.
pub(super) fn trees(lab: &mut Lab) -> Result<Vec<Sweep>, ClaimError> {
    let stop = |spec: Spec| {
        spec.with(|c| {
            c.tree.leaf = Some(LEAF);
            c.recursion.graph = Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) };
        })
    };
    let extents = Extents { parts: 2, ..extents(lab, [5, 8, 12]) };
    sweeps(lab, &extents, ("tree", Kind::Uniform, OF_TREES), Some(Until::Neighbours), stop)
}

/// Returns the sizes and seeds of a sweep. `octaves` contains the number of octaves for the brief, the quick and the
/// full extent. A depth is a sawtooth in the number of points. More sizes per octave are therefore better than more
/// seeds per size.
fn extents(lab: &Lab, octaves: [u32; 3]) -> Extents {
    let [brief, quick, full] = octaves;
    match lab.options.extent {
        Extent::Brief => Extents { octaves: brief, parts: PARTS, seeds: 1 },
        Extent::Quick => Extents { octaves: quick, parts: PARTS, seeds: 1 },
        Extent::Full => Extents { octaves: full, parts: 2 * PARTS, seeds: 2 },
    }
}

/// Returns the sweeps in the plane and in space. The first word identifies their runs in the laboratory, which computes
/// them only once. All runs must charge the phases.
fn sweeps(
    lab: &mut Lab,
    extents: &Extents,
    (what, kind, phases): (&str, Kind, &'static [&'static str]),
    until: Option<Until>,
    change: impl Fn(Spec) -> Spec,
) -> Result<Vec<Sweep>, ClaimError> {
    let mut all = Vec::new();
    for d in [2, 3] {
        let samples = samples(SMALLEST, extents, kind, d);
        let name = format!("{what} {d}");
        let runs = Runs { name: &name, samples: &samples, seeds: extents.seeds, until };
        let runs = lab.counted(&runs, &change)?;
        let sizes = || samples.iter().map(|sample| sample.n);
        let (least, most) = (sizes().min().unwrap_or(0), sizes().max().unwrap_or(0));
        let name = format!("{} {d}D n={least}..{most}, {} runs", kind.name(), runs.len());
        all.push(Sweep { name, phases, runs });
    }
    Ok(all)
}
