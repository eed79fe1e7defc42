//! Section 2 (4) and Definition 2.2: overlap graphs of balls that extend to the k-th neighbour, and their separator sets.
//!
//! The edges are compared with all pairs. The separators of a tree do not depend on the balls. So the trees of all k are
//! equal, and the sizes of their separator sets differ by k alone.

use std::rc::Rc;

use crate::experiment::fit::{ClusterRow, clustered};
use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Correction, Graph, Neighbours, SeparatorSets, Until, Words};

use super::counted::Counted;
use super::lab::{Lab, Runs};
use super::measure::{X, kth_nearest2, overlap, pairs};
use super::sample::Sample;
use super::sweeps::LEAF;
use super::{Claim, ClaimError, Extent, Figure, Reading, Role};

/// The neighbours to which the balls extend.
const ORDERS: [u32; 5] = [1, 2, 4, 8, 16];

/// alpha of the graphs whose edges are compared.
const ALPHA: f64 = 2.0;

/// Number of runs for each k. A fit needs at least three.
const RUNS: u64 = 3;

/// The smallest node of the fits, in points. In smaller nodes, the balls of 16 neighbours meet most separators.
const SMALLEST: u64 = 4096;

/// The bounds on the exponent of k in the plane and in space.
const EXPONENTS: [(usize, f64, f64); 2] = [(2, 0.35, 0.65), (3, 0.20, 0.50)];

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "overlap-k",
    role: Role::Test,
    statistics: None,
    source: "Definition 2.2, Section 2 (4), Section 4.4",
    statement: "the (alpha, k)-overlap graph of a k-ply system has separators with |B_O| = O(alpha k^(1/d) n^(1-1/d))",
    reading: Reading::AsRead {
        instead: "the balls extend to the k-th neighbour",
        because: "the ply of given balls is not a parameter of a point set; the ply of these is at most the kissing \
                  number times k",
    },
    experiment: "k of 1, 2, 4, 8 and 16. Edges in only one of the machine's graph and the graph by definition over all \
                 pairs, alpha 2, for separator sets ghost and both, on uniform sets, clusters and two lattices, whose \
                 distances tie, with every fifth point twice. Fit of log |B_O| against log k over the nodes of at least \
                 4,096 points in three uniform sets: the points whose balls meet the separator, alpha 1",
    bound: "0 edges, by definition; 0.35 to 0.65 in the plane and 0.20 to 0.50 in space, around 1/d: the mean radius of \
            the first 16 balls grows with exponent 0.54 and 0.37, and large balls meet the separators of most of a node",
    check: |lab| Ok([edges(lab)?, exponents(lab)?].concat()),
}];

fn edges(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(2000, 6000);
    let mut figures = Vec::new();
    for kind in [Kind::Uniform, Kind::Clusters, Kind::Grid, Kind::Fcc] {
        for d in [2, 3] {
            let sample = Sample::new(kind, n, d);
            let points = lab.points(sample, lab.seed())?;
            for k in ORDERS {
                figures.extend(of_order(lab, sample, &points, k)?);
            }
        }
    }
    Ok(figures)
}

/// Compares the edges of one k.
fn of_order(lab: &mut Lab, sample: Sample, points: &[X], k: u32) -> Result<Vec<Figure>, ClaimError> {
    let expected = pairs(points, &kth_nearest2(points, k as usize), overlap(ALPHA));
    let mut figures = Vec::new();
    for sets in [SeparatorSets::Ghost, SeparatorSets::Both] {
        let change = |spec: Spec| {
            with_balls(spec, ALPHA, k).with(|c| {
                c.recursion.sets = sets;
                c.keep.graph = true;
            })
        };
        let run = lab.graph_with_repeats(sample, points.len() / 5, change)?;
        let found = run.kept.graph.unwrap_or_default();
        let missing = expected.iter().filter(|edge| found.binary_search(edge).is_err()).count();
        let extra = found.iter().filter(|edge| expected.binary_search(edge).is_err()).count();
        let what = format!("edges in one graph alone, of {}, k = {k}, sets {}", expected.len(), sets.name());
        figures.push(Figure::at_most(what, sample.name(), lab.seed(), (missing + extra) as f64, 0.0));
    }
    Ok(figures)
}

/// Returns the configuration with an overlap graph of balls to the k-th neighbour, in leaves of one size.
fn with_balls(spec: Spec, alpha: f64, k: u32) -> Spec {
    spec.with(|c| {
        c.tree.leaf = Some(LEAF);
        c.recursion.graph = Graph::Overlap { alpha: Alpha::Value(alpha), k: Neighbours::Count(k) };
        // The bottom-up correction finds first neighbours only.
        c.recursion.neighbours = Correction::Descent;
    })
}

fn exponents(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let (n, seed) = (points(lab.options.extent), lab.seed());
    let mut figures = Vec::new();
    for (d, least, most) in EXPONENTS {
        let sample = Sample::new(Kind::Uniform, n, d);
        let mut rows = Vec::new();
        for k in ORDERS {
            rows.extend(separator_sets(&of_balls(lab, sample, k)?, k));
        }
        let exponent = clustered(&rows, 1).map_or(f64::NAN, |estimate| estimate.value);
        let what = format!("exponent of |B_O| in k, {} nodes", rows.len() / ORDERS.len());
        figures.push(Figure::at_least(&*what, sample.name(), seed, exponent, least));
        figures.push(Figure::at_most(what, sample.name(), seed, exponent, most));
    }
    Ok(figures)
}

/// Returns the number of points of a uniform set.
fn points(extent: Extent) -> u64 {
    match extent {
        Extent::Brief => 1 << 13,
        Extent::Quick => 1 << 15,
        Extent::Full => 1 << 18,
    }
}

/// Returns the runs with balls to the k-th neighbour, up to the graph.
fn of_balls(lab: &mut Lab, sample: Sample, k: u32) -> Result<Rc<Vec<Counted>>, ClaimError> {
    let name = format!("balls to neighbour {k} {}", sample.name());
    let runs = Runs { name: &name, samples: &[sample], seeds: RUNS, until: Some(Until::Graph) };
    lab.counted(&runs, |spec| with_balls(spec, 1.0, k))
}

/// Returns the sizes of the separator sets of the large nodes. The nodes of one run form a cluster.
fn separator_sets(runs: &[Counted], k: u32) -> Vec<ClusterRow> {
    let of_run = |(cluster, run): (u64, &Counted)| {
        let large = run.splits().filter(|node| node.facts.population >= SMALLEST);
        // An empty set counts as one point, so that it has a logarithm.
        let row = |size: u64| ClusterRow {
            cluster,
            columns: vec![f64::from(k).ln()],
            y: (size.max(1) as f64).ln(),
        };
        large.map(|node| row(node.crossing())).collect::<Vec<_>>()
    };
    (0..).zip(runs).flat_map(of_run).collect()
}
