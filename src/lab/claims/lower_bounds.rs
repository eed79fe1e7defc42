//! Lower bounds on the charges, from points, cells, surfaces and sites alone.
//!
//! A second account of the same run cannot find a step that both accounts omit. These bounds do not come from charges:
//! they count the pairs, tests and visits that a machine needs for its result if it has no further knowledge of the
//! points. The tree is that of the run, but the points of its nodes, and the nodes that balls and edges reach, are
//! recomputed from the surfaces of its separators.

use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::result::view::MOST_POINTS;
use septet_core::spec::{Alpha, DEFAULT_ALPHA, Graph, Neighbours, Workers};
use septet_protocol::ledger::Ledger;

use super::floors::{FLOORS, Floor, Runs, SHARE, Term};
use super::lab::Lab;
use super::sample::Sample;
use super::sites::rounds_of;
use super::sizes::Sizes;
use super::sweeps::{LEAF, LIST};
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "lower-bounds",
    role: Role::Test,
    statistics: None,
    source: "Theorem 4.4, the counts of the machine",
    statement: "the work and depth of every phase count all operations of the phase",
    reading: Reading::AsPrinted,
    experiment: "Leaves of 60 points, on well-spaced sets, uniform sets and clusters: density graphs, lists of 12 neighbours, and \
                 independent sets of sites. The work and the depth of each phase, over sums of natural sizes such as pairs in \
                 leaves, balls at nodes, levels or rounds. All sizes are recomputed from points, cells, surfaces and sites",
    bound: "0.9 times the sum of natural sizes, each times the price of the primitives that the guide lists for the phase. \
            Samples are random, and some balls are smaller here than in the machine. Probes have no natural size",
    check: lower_bounds,
}];

/// The work and depth of the phases of a run, and the natural sizes of the run.
struct Measured {
    on: String,
    ledger: Ledger,
    sizes: Sizes,
}

fn lower_bounds(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(6000, u64::from(MOST_POINTS));
    let mut figures = Vec::new();
    for d in [2, 3] {
        for kind in [Kind::WellSpaced, Kind::Uniform, Kind::Clusters] {
            let sample = Sample::new(kind, n, d);
            let runs = [
                (Runs::Graphs, with_density(lab, sample)?),
                (Runs::Lists, with_lists(lab, sample)?),
                (Runs::Sites, of_sites(lab, sample)?),
            ];
            for (of, measured) in runs {
                let certain = of == Runs::Graphs && kind == Kind::WellSpaced;
                let floors = FLOORS.iter();
                let floors =
                    floors.filter(|floor| floor.runs == of || certain && floor.runs == Runs::WellSpaced);
                figures.extend(floors.flat_map(|floor| checked(&measured, floor, lab.seed())));
            }
        }
    }
    Ok(figures)
}

/// Returns the figures of a phase. A phase without charges, or without natural sizes, has no value and fails.
fn checked(Measured { on, ledger, sizes }: &Measured, floor: &Floor, seed: u64) -> [Figure; 2] {
    let phase = ledger.phases.iter().find(|total| total.phase.name() == floor.phase);
    let (work, depth) = phase.map_or((f64::NAN, f64::NAN), |p| (p.work as f64, p.depth as f64));
    let figure = |what: &str, value: f64, terms: &[Term]| {
        let what = format!("{what} of {} over {}", floor.phase, named(terms));
        Figure::at_least(what, on, seed, value / sizes.sum(terms), SHARE)
    };
    [figure("work", work, floor.work), figure("depth", depth, floor.depth)]
}

fn named(terms: &[Term]) -> String {
    let named = |(operations, natural): &Term| format!("{operations} x {}", natural.name());
    terms.iter().map(named).collect::<Vec<String>>().join(" + ")
}

/// Returns the configuration of a machine with one worker that builds this graph and keeps the surfaces of its
/// separators.
fn seen(spec: Spec, graph: Graph) -> Spec {
    spec.with(|c| {
        c.machine.workers = Workers::Count(1);
        c.tree.leaf = Some(LEAF);
        c.keep.view = Some(MOST_POINTS);
        c.recursion.graph = graph;
    })
}

fn with_density(lab: &mut Lab, sample: Sample) -> Result<Measured, ClaimError> {
    let seed = lab.seed();
    let points = lab.points(sample, seed)?;
    let graph = Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) };
    let run = lab.run(sample, seed, |spec| seen(spec, graph))?;
    let sizes = Sizes::of_density(&run, sample, &points, DEFAULT_ALPHA);
    Ok(Measured { on: sample.name(), ledger: run.ledger, sizes })
}

fn with_lists(lab: &mut Lab, sample: Sample) -> Result<Measured, ClaimError> {
    let seed = lab.seed();
    let points = lab.points(sample, seed)?;
    let run = lab.run(sample, seed, |spec| seen(spec, Graph::Knn { k: Neighbours::Count(LIST) }))?;
    let sizes = Sizes::of_lists(&run, &points);
    Ok(Measured { on: sample.name(), ledger: run.ledger, sizes })
}

fn of_sites(lab: &mut Lab, sample: Sample) -> Result<Measured, ClaimError> {
    let seed = lab.seed();
    let points = lab.points(sample, seed)?;
    let run = lab.independent(sample, |spec| spec.with(|c| c.tree.leaf = Some(LEAF)))?;
    let sizes = Sizes::of_rounds(&rounds_of(sample, &points, seed));
    Ok(Measured { on: format!("{}, sites", sample.name()), ledger: run.ledger, sizes })
}

#[cfg(test)]
mod tests {
    use septet_core::spec::Fault;

    use super::super::sites::Rounds;
    use super::super::{Extent, LabOptions};
    use super::*;

    fn brief(seed: u64, fault: Option<Fault>) -> Vec<Figure> {
        let options = LabOptions { extent: Extent::Brief, seed, fault, ..LabOptions::default() };
        lower_bounds(&mut Lab::new(options, |_| {})).unwrap()
    }

    /// The bounds have a slack of at least 5 %. On some set, half of the work of each phase is below its bound.
    #[test]
    fn half_of_the_work_of_a_phase_is_too_little() {
        for seed in [1, 2] {
            let figures = brief(seed, None);
            for figure in &figures {
                println!("{:.3} {}; {}", figure.value, figure.what, figure.on);
            }
            for figure in &figures {
                assert!(0.95 * figure.value >= figure.bound, "{figure:?}");
            }
            for floor in FLOORS {
                let start = format!("work of {} over", floor.phase);
                let of = figures.iter().filter(|figure| figure.what.starts_with(&start));
                let least = of.map(|figure| figure.value).fold(f64::INFINITY, f64::min);
                assert!(0.5 * least < SHARE, "{start}: {least}");
            }
        }
    }

    #[test]
    fn sizes_without_items_bound_nothing() {
        let sizes = Sizes::of_rounds(&Rounds::default());
        let sites = FLOORS.iter().find(|floor| floor.runs == Runs::Sites).unwrap();
        assert!(sizes.sum(sites.work).is_nan() && sizes.sum(sites.depth).is_nan());
        assert!(!Figure::at_least("work", "no sites", 1, 1.0 / sizes.sum(sites.work), SHARE).holds());
    }
}
