//! Lemma 4.1 and Section 4.4: the local hull of a point with many neighbours.
//!
//! The points lie on a sphere, and one more point at its centre. The centre is a neighbour of all, whatever n is.

use septet_core::Outcome;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, Correction, Graph, Neighbours};
use septet_protocol::ids::Phase;

use crate::experiment::fit::{ClusterRow, clustered};

use super::lab::Lab;
use super::sample::Sample;
use super::sweeps::LEAF;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// alpha of the overlap graph. Every ball of the sphere is then a neighbour of the ball around the centre.
const ALPHA: f64 = 2.0;

/// Bound on the exponent of n in the work of the hulls.
const EXPONENT: f64 = 1.2;

/// Bound on the depth of the hulls over the square of log2 n.
const DEPTH: f64 = 6.0;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "hubs",
    role: Role::Test,
    statistics: None,
    source: "Lemma 4.1, Section 4.4",
    statement: "some subproblem might be of size as large as n, but the sum of all subproblem sizes is O(n)",
    reading: Reading::AsRead {
        instead: "the hull of a point with m neighbours takes O(m log m) expected work and O(log^2 m) depth",
        because: "the cost of all hulls is near-linear only if the cost of each is near-linear in its size",
    },
    experiment: "Points on a sphere and its centre, overlap graph with alpha 2, 1,000 to 8,000 points: fit of the log of \
                 the work of the phase `hulls` against log n, and its depth over the square of log2 n",
    bound: "exponent 1.2: m log m has 1.11 at these sizes; depth 6 log2^2 n: a chain has about 4 log2 m rounds, of 8 steps, \
            and the nearest 24 candidates are added one by one, with at most 10 steps each",
    check: hubs,
}];

fn hubs(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let (mut figures, mut rows) = (Vec::new(), Vec::new());
    let seed = lab.seed();
    for (cluster, n) in (0..).zip([1000, 2000, 4000, 8000]) {
        let sample = Sample::new(Kind::Sphere, n, 3);
        let run = lab.run_with_centre(sample, |spec| {
            spec.with(|c| {
                c.tree.leaf = Some(LEAF);
                c.recursion.graph = Graph::Overlap { alpha: Alpha::Value(ALPHA), k: Neighbours::Auto };
                c.recursion.neighbours = Correction::Descent;
            })
        })?;
        let (work, depth) = of_hulls(&run);
        rows.push(ClusterRow { cluster, columns: vec![(n as f64).ln()], y: work.ln() });
        let log = (n as f64).log2();
        let what = format!("depth of the hulls, {depth}, over log2^2 n");
        figures.push(Figure::at_most(what, sample.name(), seed, depth / (log * log), DEPTH));
    }
    let exponent = clustered(&rows, 1).map_or(f64::NAN, |estimate| estimate.value);
    let name = "sphere 3D and its centre";
    figures.push(Figure::at_most("exponent of n in the work of the hulls", name, seed, exponent, EXPONENT));
    Ok(figures)
}

/// Returns the work and the depth of the phase.
fn of_hulls(run: &Outcome) -> (f64, f64) {
    let hulls = run.ledger.phases.iter().find(|p| p.phase == Phase::Hulls);
    hulls.map_or((f64::NAN, f64::NAN), |p| (p.work as f64, p.depth as f64))
}
