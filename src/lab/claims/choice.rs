//! Theorem 4.4 with an unknown alpha: the choice of the supergraph is part of the whole, and it is good.

use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, Neighbours, Spec};
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Ledger;

use super::lab::Lab;
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The smallest work of the choice: half of the expected 64 stars, each with the pairs of 10 candidates.
const LEAST_WORK: f64 = 0.5 * 64.0 * 10.0 * 10.0;

/// The bound on `T_n` of the choice, over the best of the fixed graphs.
const NEAR: f64 = 1.25;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "whole-sum",
        role: Role::Test,
        statistics: None,
        source: "Theorem 4.4",
        statement: "DT(P) takes O(log n) time with n processors",
        reading: Reading::AsRead {
            instead: "the whole includes the choice of alpha and the repair of stars",
            because: "the paper assumes that alpha is known and that the graph contains DT(P)",
        },
        experiment: "Uniform and clustered sets, with a known alpha and without: the sum of `phases[].work` against \
                     `machine.total.work`; the work of the choice if alpha is unknown",
        bound: "0 operations; at least the pairs of 10 candidates of 32 sampled stars, half of the expected sample",
        check: whole,
    },
    Claim {
        name: "choice-near-best",
        role: Role::Test,
        statistics: None,
        source: "Theorem 4.4",
        statement: "alpha is known",
        reading: Reading::AsRead {
            instead: "a sample of stars finds an alpha that is nearly best, at a cost that is part of T_n",
            because: "the points of a user come without an alpha",
        },
        experiment: "T_n of a run with an unknown alpha, choice included, over the least T_n of the density graphs with alpha \
                     2.5, 4 and 6 and of the graphs of 12, 16, 20, 24 and 48 nearest neighbours",
        bound: "1.25, stated before the run",
        check: near_best,
    },
];

/// Returns the run with this graph, as if nothing were known of the points.
fn with_graph(spec: Spec, graph: Graph) -> Spec {
    spec.with(|c| {
        c.recursion.spacing = None;
        c.recursion.graph = graph;
    })
}

fn whole(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let (n, seed) = (lab.size(2048, 8192), lab.seed());
    let mut figures = Vec::new();
    for kind in [Kind::Uniform, Kind::Clusters] {
        for d in [2, 3] {
            let sample = Sample::new(kind, n, d);
            for alpha in [Alpha::Auto, Alpha::Value(2.5)] {
                let ledger = lab.run(sample, seed, |spec| with_graph(spec, Graph::Density { alpha }))?.ledger;
                let sum: u64 = ledger.phases.iter().map(|phase| phase.work).sum();
                let off = sum.abs_diff(ledger.totals.sum().work) as f64;
                let what = format!("operations of the phases, {sum}, minus the total");
                figures.push(Figure::at_most(what, sample.name(), seed, off, 0.0));
                if alpha == Alpha::Auto {
                    let work = work_of(&ledger, Phase::Choice);
                    figures.push(Figure::at_least(
                        "work of the choice",
                        sample.name(),
                        seed,
                        work,
                        LEAST_WORK,
                    ));
                }
            }
        }
    }
    Ok(figures)
}

fn work_of(ledger: &Ledger, phase: Phase) -> f64 {
    ledger.phases.iter().find(|total| total.phase == phase).map_or(0.0, |total| total.work as f64)
}

fn near_best(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let kinds: &[Kind] = lab.by_extent(
        &[Kind::Uniform, Kind::WellSpaced, Kind::Clusters],
        &[
            Kind::Uniform,
            Kind::WellSpaced,
            Kind::Clusters,
            Kind::Jittered,
            Kind::Slab,
            Kind::Line,
            Kind::Sphere,
            Kind::GradedPoint,
        ],
    );
    let (n, seed) = (lab.size(2048, 8192), lab.seed());
    let mut figures = Vec::new();
    for &kind in kinds {
        for d in [2, 3] {
            let sample = Sample::new(kind, n, d);
            let chosen = steps(lab, sample, Graph::Density { alpha: Alpha::Auto })?;
            let mut best = (f64::INFINITY, String::new());
            for graph in fixed() {
                let own = steps(lab, sample, graph)?;
                if own < best.0 {
                    best = (own, format!("{graph:?}"));
                }
            }
            let what = format!("T_n of the choice, {chosen}, over the least, of {}", best.1);
            figures.push(Figure::at_most(what, sample.name(), seed, chosen / best.0, NEAR));
            if lab.has_detected(&figures) {
                return Ok(figures);
            }
        }
    }
    Ok(figures)
}

/// Returns the graphs with which the choice is compared.
fn fixed() -> impl Iterator<Item = Graph> {
    let density = [2.5, 4.0, 6.0].map(|alpha| Graph::Density { alpha: Alpha::Value(alpha) });
    let lists = [12, 16, 20, 24, 48].map(|k| Graph::Knn { k: Neighbours::Count(k) });
    density.into_iter().chain(lists)
}

/// Returns `T_n` of a whole run.
fn steps(lab: &mut Lab, sample: Sample, graph: Graph) -> Result<f64, ClaimError> {
    let run = lab.run(sample, lab.seed(), |spec| with_graph(spec, graph))?;
    Ok(run.ledger.totals.sum().brent as f64)
}
