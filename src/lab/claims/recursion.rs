//! Sections 4.3 and 4.4: construction of the graph by divide and conquer, and the sizes of its parts.

use crate::experiment::of_run;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, Neighbours, SeparatorSets};

use super::lab::Lab;
use super::measure::{degrees, density, overlap, pairs};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "graph-exact",
        role: Role::Test,
        statistics: None,
        source: "Lemma 4.5",
        statement: "the graph computed by the divide and conquer is the alpha-density graph of P",
        reading: Reading::AsPrinted,
        experiment: "Edges in only one of the machine's graph and the graph by definition over all pairs; separator sets both, \
                     smaller and ghost, alpha of the set's spacing",
        bound: "0, a theorem if radii are global",
        check: exact,
    },
    Claim {
        name: "subproblems-linear",
        role: Role::Test,
        statistics: None,
        source: "Section 4.4",
        statement: "a k-overlap graph has O(n) edges: the local hulls' sizes have a linear sum",
        reading: Reading::AsPrinted,
        experiment: "Twice the edges of the 2-overlap graph over n, for evenly and unevenly dense sets, from all pairs; \
                     the difference from the edges of the machine's graph",
        bound: "2 ply (alpha + 2)^d: each edge is charged to its smaller ball; growth by 1.5 from n to 4n (a quadratic sum: 4)",
        check: subproblems,
    },
];

fn exact(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(6000, 30_000);
    let mut figures = Vec::new();
    for (kind, d) in
        [(Kind::WellSpaced, 3), (Kind::WellSpaced, 2), (Kind::GradedPoint, 2), (Kind::Uniform, 3)]
    {
        let sample = Sample::new(kind, n, d);
        let specimen = lab.specimen(sample, lab.seed())?;
        // alpha is computed from the spacing. The value that the machine reports is not used.
        let alpha = specimen.alpha;
        let expected = pairs(&specimen.points, &specimen.nearest2, density(alpha));
        for (sets, name) in [
            (SeparatorSets::Both, "both"),
            (SeparatorSets::Smaller, "smaller"),
            (SeparatorSets::Ghost, "ghost"),
        ] {
            let run = lab.run(sample, specimen.seed, |spec| {
                spec.with(|c| {
                    c.recursion.sets = sets;
                    c.keep.graph = true;
                    c.tree.leaf = Some(400);
                })
            })?;
            let found = run.kept.graph.as_deref().unwrap_or_default();
            let missing = expected.iter().filter(|edge| found.binary_search(edge).is_err()).count();
            let extra = found.iter().filter(|edge| expected.binary_search(edge).is_err()).count();
            let levels = of_run(&run).tree.levels;
            let what =
                format!("edges in one graph alone, of {}, sets {name}, {levels} levels", expected.len());
            let sum = (missing + extra) as f64;
            figures.push(Figure::at_most(what, &specimen.name, specimen.seed, sum, 0.0));
        }
    }
    Ok(figures)
}

fn subproblems(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let alpha = 2.0;
    let sizes = lab.by_extent(&[2000, 8000][..], &[2000, 8000, 32_000]);
    let mut figures = Vec::new();
    for d in [2usize, 3] {
        for kind in [Kind::Uniform, Kind::GradedPoint, Kind::Clusters] {
            let mut smaller = None;
            for &n in sizes {
                let sample = Sample::new(kind, n, d);
                let specimen = lab.specimen(sample, lab.seed())?;
                let edges = pairs(&specimen.points, &specimen.nearest2, overlap(alpha));
                let points = specimen.points.len();
                let most = degrees(points, &edges).into_iter().max().unwrap_or(0);
                let sum = 2.0 * edges.len() as f64 / points as f64;
                let ply = if d == 2 { 5.0 } else { 12.0 };
                let bound = 2.0 * ply * (alpha + 2.0).powi(d as i32);
                let what = format!("sum of sizes over points, the largest size {most}");
                figures.push(Figure::at_most(what, &specimen.name, specimen.seed, sum, bound));
                if let Some(before) = smaller.replace(sum) {
                    let what = format!("growth of this sum from n/4 points, {before:.2} to {sum:.2}");
                    figures.push(Figure::at_most(what, &specimen.name, specimen.seed, sum / before, 1.5));
                }
                if n == sizes[0] {
                    let run = lab.run(sample, specimen.seed, |spec| {
                        spec.with(|c| {
                            c.recursion.graph =
                                Graph::Overlap { alpha: Alpha::Value(alpha), k: Neighbours::Auto };
                        })
                    })?;
                    let counted = of_run(&run).graph.map_or(0, |graph| graph.edges);
                    let off = counted.abs_diff(edges.len() as u64) as f64;
                    let what = format!("difference between the machine's edges, {counted}, and all pairs");
                    figures.push(Figure::at_most(what, &specimen.name, specimen.seed, off, 0.0));
                }
            }
        }
    }
    Ok(figures)
}
