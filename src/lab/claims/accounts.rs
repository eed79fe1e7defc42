//! The comparison of the counts of the ledger with a second account, which is computed from the cost traces of runs.

use crate::accounts::{Difference, fold};
use crate::report::{CostHeader, ledger_counts, write_cost_trace};
use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::run::CostTrace;
use septet_core::spec::{Correction, Graph, Neighbours, Partition, SeparatorSets, Workers};
use septet_protocol::ledger::Ledger;

use super::lab::Lab;
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// Largest number of points in a leaf, small enough for several levels.
const LEAF: u64 = 200;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "accounts",
    role: Role::Test,
    statistics: None,
    source: "Theorem 4.4, on the machine",
    statement: "work and depth are the sum and the longest path of the prices of all primitives",
    reading: Reading::AsPrinted,
    experiment: "Cost traces of runs in the plane and in space, with repair and with each baseline, and of an independent \
                 set: a fold that shares no code with the ledger prices the rows and takes the longest paths",
    bound: "0 differences in the work and the depth of every phase and every total",
    check: accounts,
}];

/// A point set, and a change of the configuration.
struct Case {
    sample: Sample,
    name: &'static str,
    change: fn(&mut Spec),
}

fn cases(lab: &Lab) -> Vec<Case> {
    let n = lab.size(3000, 20_000);
    let case = |kind, d, name, change| Case { sample: Sample::new(kind, n, d), name, change };
    vec![
        case(Kind::WellSpaced, 3, "", |_| {}),
        case(Kind::Uniform, 2, "", |_| {}),
        case(Kind::Clusters, 3, ", which needs repair", |_| {}),
        case(Kind::Uniform, 3, ", separator points to both sides", |c| {
            c.recursion.sets = SeparatorSets::Both;
        }),
        case(Kind::Uniform, 3, ", own separators of the sets", |c| {
            c.recursion.sets = SeparatorSets::Own;
            c.tree.leaf = Some(500);
        }),
        case(Kind::Slab, 3, ", 12 nearest neighbours, some of which probe", |c| {
            c.recursion.graph = Graph::Knn { k: Neighbours::Count(12) };
            c.tree.leaf = Some(30);
        }),
        case(Kind::Uniform, 2, ", split by planes", |c| c.tree.partition = Partition::Kd),
        case(Kind::Uniform, 3, ", split along a curve", |c| c.tree.partition = Partition::Hilbert),
        case(Kind::Uniform, 2, ", bottom-up correction", |c| c.recursion.neighbours = Correction::BottomUp),
        case(Kind::Uniform, 3, ", correction in stages", |c| c.recursion.neighbours = Correction::Stages),
        case(Kind::Uniform, 3, ", well-separated pairs", |c| c.recursion.neighbours = Correction::Pairs),
    ]
}

fn accounts(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for Case { sample, name, change } in cases(lab) {
        let mut spec = Spec::default();
        let run = lab.run(sample, lab.seed(), |base| {
            spec = traced(base).with(change);
            spec.clone()
        })?;
        let header = CostHeader::of(&spec, &run.settled, run.points.used, run.space);
        let on = format!("{}{name}", sample.name());
        figures.push(figure(lab.seed(), on, &differences(header, run.kept.costs.as_ref(), &run.ledger)?));
    }
    figures.push(of_sites(lab)?);
    Ok(figures)
}

/// Compares both accounts of the computation of an independent set.
fn of_sites(lab: &mut Lab) -> Result<Figure, ClaimError> {
    let sample = Sample::new(Kind::Uniform, lab.size(3000, 20_000), 3);
    let mut spec = Spec::default();
    let run = lab.independent(sample, |base| {
        spec = traced(base);
        spec.clone()
    })?;
    let header = CostHeader::of(&spec, &run.settled, sample.n, sample.d);
    let on = format!("{}, independent set", sample.name());
    Ok(figure(lab.seed(), on, &differences(header, run.kept.costs.as_ref(), &run.ledger)?))
}

/// Returns the configuration of a machine with three workers that keeps the calls of primitives.
fn traced(base: Spec) -> Spec {
    base.with(|c| {
        c.machine.workers = Workers::Count(3);
        c.tree.leaf = Some(LEAF);
        c.keep.costs = true;
    })
}

fn figure(seed: u64, on: String, differences: &[Difference]) -> Figure {
    let first = differences.first().map_or_else(String::new, |first| format!("; the first: {first}"));
    let what = format!("counts that differ between ledger and cost trace{first}");
    Figure::at_most(what, on, seed, differences.len() as f64, 0.0)
}

/// Compares both accounts of a run. Without a trace, [`fold`] gets an empty text and rejects it.
fn differences(
    header: CostHeader,
    trace: Option<&CostTrace>,
    ledger: &Ledger,
) -> Result<Vec<Difference>, ClaimError> {
    let mut text = Vec::new();
    if let Some(trace) = trace {
        write_cost_trace(&mut text, header, trace)?;
    }
    Ok(fold(text.as_slice())?.differences(&ledger_counts(ledger)))
}
