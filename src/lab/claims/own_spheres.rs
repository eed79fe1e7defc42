//! Section 4.3, steps 1 to 5: the recursion on sets that draw their own separators.
//!
//! Each set with more points than the largest leaf draws a separator for itself, copies included. The sizes of all sets, of
//! their sides and of their parts are facts of the nodes of one run.

use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Graph, SeparatorSets};
use septet_core::{Outcome, Spec};
use septet_protocol::ledger::NodeFacts;

use super::lab::Lab;
use super::measure::{density, kth_nearest2, pairs};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// alpha of the graphs.
const ALPHA: f64 = 2.5;

/// Largest leaf in the plane and in space, as for the other rules that copy separator points.
const LEAVES: [u64; 2] = [500, 1000];

/// Bounds on the points of the solved sets over those of rule `both`, in the plane and in space.
const MEMBERS: [f64; 2] = [2.0, 4.0];

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "own-spheres",
    role: Role::Test,
    statistics: None,
    source: "Section 4.3, steps 1 to 5",
    statement: "each subproblem draws a sphere for P_I u P_O with both bounds, and the union of the graphs is the \
                alpha-density graph",
    reading: Reading::AsRead {
        instead: "a set is also solved directly if one of its children would have more than 93 % of its points",
        because: "most balls of a small set meet every sphere",
    },
    experiment: "Separator sets own and both, alpha 2.5, leaves of 500 points in the plane and 1,000 in space. Edges in \
                 only one of the machine's graph and the graph by definition over all pairs; the larger side of a \
                 divided set over the points of the set, the largest over all sets; sets with more points than the \
                 largest leaf that are not divided; the points of all solved sets for \
                 own over those for both",
    bound: "0 edges; (d+1)/(d+2) + 0.05; 0 sets, by step 1; 2 in the plane: the spheres see the copies, so the sets do not grow faster than \
            those of `both`; 4 in space, where rule `both` stops at 1,000 owned points, while sets of more than 1,000 points, \
            copies included, are divided again and copied again (2.9 measured on graded sets of 8,000 points)",
    check,
}];

fn check(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let n = lab.size(8000, 30_000);
    let mut figures = Vec::new();
    for kind in [Kind::Uniform, Kind::WellSpaced, Kind::Clusters, Kind::GradedPoint] {
        for d in [2, 3] {
            figures.extend(of_sample(lab, Sample::new(kind, n, d))?);
        }
    }
    Ok(figures)
}

fn of_sample(lab: &mut Lab, sample: Sample) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let points = lab.points(sample, seed)?;
    let expected = pairs(&points, &kth_nearest2(&points, 1), density(ALPHA));
    let mut run = |sets| lab.run(sample, seed, |spec| with_sets(spec, sample.d, sets));
    let [own, both] = [run(SeparatorSets::Own)?, run(SeparatorSets::Both)?];
    let found = own.kept.graph.as_deref().unwrap_or_default();
    let missing = expected.iter().filter(|edge| found.binary_search(edge).is_err()).count();
    let extra = found.iter().filter(|edge| expected.binary_search(edge).is_err()).count();
    let sizes = [&own, &both].map(|run| solved(run) as f64 / points.len() as f64);
    let divided: Vec<&NodeFacts> = facts(&own).filter(|facts| facts.set_inside > 0).collect();
    let side = divided.iter().map(|facts| larger_side(facts)).fold(0.0, f64::max);
    let leaf = LEAVES[sample.d - 2];
    let large = facts(&own).filter(|facts| facts.compared() > leaf).count();
    let bound = (sample.d + 1) as f64 / (sample.d + 2) as f64 + 0.05;
    let figure = |what: String, value, bound| Figure::at_most(what, sample.name(), seed, value, bound);
    Ok(vec![
        figure(format!("edges in one graph alone, of {}", expected.len()), (missing + extra) as f64, 0.0),
        figure(format!("largest side of {} divided sets", divided.len()), side, bound),
        figure("sets above the largest leaf that are not divided".to_string(), large as f64, 0.0),
        figure(
            format!(
                "points of solved sets over those of sets both, {:.2} and {:.2} per point",
                sizes[0], sizes[1]
            ),
            sizes[0] / sizes[1],
            MEMBERS[sample.d - 2],
        ),
    ])
}

/// Returns the configuration with a density graph and a rule for separator sets.
fn with_sets(spec: Spec, d: usize, sets: SeparatorSets) -> Spec {
    spec.with(|c| {
        c.tree.leaf = Some(LEAVES[d - 2]);
        c.recursion.graph = Graph::Density { alpha: Alpha::Value(ALPHA) };
        c.recursion.sets = sets;
        c.keep.graph = true;
    })
}

fn facts(run: &Outcome) -> impl Iterator<Item = &NodeFacts> {
    run.ledger.part.nodes.values()
}

/// Returns the number of points of all sets in which all pairs are compared.
fn solved(run: &Outcome) -> u64 {
    facts(run).map(NodeFacts::compared).sum()
}

/// Returns the larger side of a divided set, over the points of the set.
fn larger_side(facts: &NodeFacts) -> f64 {
    let larger = facts.set_inside.max(facts.members - facts.set_inside);
    larger as f64 / facts.members as f64
}
