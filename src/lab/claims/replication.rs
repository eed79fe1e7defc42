//! Section 4.3, steps 1 to 4, and Lemma 4.5: the recursion keeps O(n) points in total.

use std::rc::Rc;

use crate::experiment::fit::{ClusterRow, clustered};
use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, DEFAULT_ALPHA, Graph, Neighbours, Until, Words, Workers};

use super::bounds::{REPLICATION, ReplicationBounds};
use super::claim::LEVEL;
use super::counted::Counted;
use super::lab::{Lab, Runs};
use super::sample::Sample;
use super::sweeps::{LEAF, LIST, recursions, sizes};
use super::{Claim, ClaimError, Extent, Figure, Reading, Role, Statistics};

/// alpha of the overlap graphs.
const OVERLAP: f64 = 2.0;

/// Number of workers of the runs with lists. Bytes depend on it.
const WORKERS: u32 = 16;

/// Largest growth of the replication for each doubling of n, as a share of its mean.
const GROWTH: f64 = 0.065;

/// The smallest size of the tests of growth.
const SMALLEST: u64 = 512;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "replication",
    role: Role::Test,
    statistics: Some(Statistics {
        level: LEVEL,
        fault: "far-ghosts:1.2",
        caught: 6,
        of: 6,
        smallest: "far-ghosts:1.2",
    }),
    source: "Section 4.3 steps 1 to 4, Lemma 4.5",
    statement: "recursion on P_I u P_O and P_E u P_O down to some constant keeps O(n) points in total",
    reading: Reading::AsRead {
        instead: "every leaf gets the points outside whose balls reach it",
        because: "the union of separator sets fills small leaves, and these ghosts suffice for the edges at owned points",
    },
    experiment: "Leaves of 60 points: points of all leaves over points, for density graphs (alpha 2.5) and overlap graphs (alpha \
                 2) of nine kinds; for lists of 12 neighbours with 16 workers, items and visits of the descent and bytes, each \
                 over points. Growth on well-spaced, graded and jittered sets from 512 points: fit of a + b n^(-1/d) + c log2 n, \
                 where b is the effect of the boundary; the upper end of the one-sided 95 % interval of c over the mean",
    bound: "1.15 times the largest value over the seeds 1 to 3 for every kind, because constants of ply and dimension vary \
            with the kind; 1.5 times for bytes, which sum over few balls on thin sets and vary by up to 21 % between seeds; growth of 6.5 % per doubling, because a replication like log n has 8 % at these sizes",
    check: replication,
}];

fn replication(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    let n = if lab.brief() { 1 << 13 } else { 1 << 16 };
    // The bounds were measured at 2^16 points. A smaller graded set has a larger replication, so brief runs omit graded
    // sets.
    let brief = lab.brief();
    for bounds in REPLICATION.iter().filter(|bounds| !(brief && bounds.kind.is_graded())) {
        for d in [2, 3] {
            let sample = Sample::new(bounds.kind, n, d);
            figures.extend(members(lab, sample, bounds)?);
            if lab.has_detected(&figures) {
                return Ok(figures);
            }
            figures.extend(of_lists(lab, sample, bounds)?);
        }
    }
    // Brief sweeps do not separate the growth from the effect of the boundary.
    if !lab.brief() {
        figures.extend(growths(lab)?);
    }
    Ok(figures)
}

fn density() -> Graph {
    Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) }
}

/// Returns the runs up to a graph, with `seeds` seeds for each sample.
fn runs(lab: &mut Lab, samples: &[Sample], graph: Graph, seeds: u64) -> Result<Rc<Vec<Counted>>, ClaimError> {
    let lists = matches!(graph, Graph::Knn { .. });
    let change = move |spec: Spec| {
        spec.with(|c| {
            c.tree.leaf = Some(LEAF);
            c.machine.workers = Workers::Count(if lists { WORKERS } else { 1 });
            c.recursion.graph = graph;
        })
    };
    let names: Vec<String> = samples.iter().map(Sample::name).collect();
    let name = format!("{} graph {}", graph.kind().name(), names.join(" "));
    lab.counted(&Runs { name: &name, samples, seeds, until: Some(Until::Graph) }, change)
}

fn members(lab: &mut Lab, sample: Sample, bounds: &ReplicationBounds) -> Result<Vec<Figure>, ClaimError> {
    let (seed, d) = (lab.seed(), sample.d);
    let mut figures = Vec::new();
    let overlap = Graph::Overlap { alpha: Alpha::Value(OVERLAP), k: Neighbours::Auto };
    for (graph, bound) in [(density(), bounds.density), (overlap, bounds.overlap)] {
        let run = &runs(lab, &[sample], graph, 1)?[0];
        let found = run.per_point(|node| node.facts.compared());
        let what = format!("points of all leaves over points, {} graph", graph.kind().name());
        figures.push(Figure::at_most(what, sample.name(), seed, found, bound.of(d)));
    }
    Ok(figures)
}

fn of_lists(lab: &mut Lab, sample: Sample, bounds: &ReplicationBounds) -> Result<Vec<Figure>, ClaimError> {
    let (seed, d) = (lab.seed(), sample.d);
    let run = &runs(lab, &[sample], Graph::Knn { k: Neighbours::Count(LIST) }, 1)?[0];
    let items = run.per_point(|node| node.items.get("knn").copied().unwrap_or(0));
    let visits = run.per_point(|node| node.facts.visits);
    let lists = run.line.phases.iter().filter(|row| row.name().starts_with("knn"));
    let bytes = lists.map(|row| row.total.bytes).sum::<u64>();
    let bytes = bytes as f64 / run.line.n as f64;
    let figure = |what: &str, value, bound| {
        Figure::at_most(format!("{what} of lists per point"), sample.name(), seed, value, bound)
    };
    let mut figures =
        vec![figure("items", items, bounds.items.of(d)), figure("visits", visits, bounds.visits.of(d))];
    // A ball causes messages if it crosses the boundary of a subdomain. In the smaller sets of the brief extent, a
    // larger share of the balls crosses one.
    if lab.options.extent != Extent::Brief {
        figures.push(figure("bytes", bytes, bounds.bytes.of(d)));
    }
    Ok(figures)
}

fn growths(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for sweep in recursions(lab)? {
        figures.push(growth(&sweep.runs, &sweep.name, seed));
    }
    for kind in [Kind::GradedPoint, Kind::Jittered] {
        for d in [2, 3] {
            // In space, the effect of the boundary decays more slowly, so more octaves are necessary.
            let octaves = lab.by_extent(if d == 2 { 5 } else { 7 }, 10);
            let samples = sizes(SMALLEST, octaves, kind, d);
            let runs = runs(lab, &samples, density(), 1)?;
            let name = format!("{} {d}D n={SMALLEST}..{}", kind.name(), SMALLEST << octaves);
            figures.push(growth(&runs, &name, seed));
        }
    }
    Ok(figures)
}

/// Returns the figure of the growth of the replication per doubling of n, as a share of the mean and without the effect
/// of the boundary. All runs of one size form a cluster.
fn growth(runs: &[Counted], name: &str, seed: u64) -> Figure {
    let large = runs.iter().filter(|run| run.line.asked >= SMALLEST);
    let row = |run: &Counted| ClusterRow {
        cluster: run.line.asked,
        columns: vec![run.log(), (run.line.n as f64).powf(-1.0 / run.line.dimension as f64)],
        y: run.per_point(|node| node.facts.compared()),
    };
    let rows: Vec<ClusterRow> = large.map(row).collect();
    let mean = rows.iter().map(|row| row.y).sum::<f64>() / rows.len() as f64;
    let slope = clustered(&rows, 1).map(|slope| slope.times(1.0 / mean));
    let estimate = slope.map_or(f64::NAN, |s| s.value);
    let what = format!("growth of replication per doubling, mean {mean:.2}, estimated {estimate:.4}");
    let figure = Figure::at_most(what, name, seed, slope.map_or(f64::NAN, |s| s.upper()), GROWTH);
    figure.with_p(slope.map_or(f64::NAN, |s| s.p_below(GROWTH)))
}
