//! Section 4.1: from a supergraph to the triangulation by local hulls.

use std::rc::Rc;

use septet_core::generate::Kind;
use septet_protocol::ids::Phase;
use septet_verify::{Triangulation, VerifyOptions, verify};

use super::lab::{Lab, Specimen};
use super::measure::{degrees, density, edges, pairs};
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        name: "supergraph",
        role: Role::Test,
        statistics: None,
        source: "Section 4.2, Theorem 4.4",
        statement: "with a bounded radius-edge ratio DT(P) is a subgraph of DG_alpha(P)",
        reading: Reading::AsRead {
            instead: "of DG_alpha(P) with alpha = 1.25 * 2(1+L)/(1-L) for f-spaced sets",
            because: "the constant of Theorem 3.2 is too large to use",
        },
        experiment: "Edges of the triangulation that are not in the machine's graph, on f-spaced sets",
        bound: "0: the formula is proved in the interior and observed at boundaries",
        check: subgraph,
    },
    Claim {
        name: "lower-hull",
        role: Role::Test,
        statistics: None,
        source: "Lemma 4.2",
        statement: "DT(P) is isomorphic to the lower convex hull of the lifted points",
        reading: Reading::AsRead {
            instead: "of the points lifted to |p|^2 and a perturbation by lexicographic rank",
            because: "cospherical points have more than one triangulation",
        },
        experiment: "The machine's cells, checked in integer arithmetic: convexity of the lifted facets, cover, hull",
        bound: "0 faults, a theorem",
        check: lower_hull,
    },
    Claim {
        name: "local-hulls",
        role: Role::Test,
        statistics: None,
        source: "Lemmas 4.1 and 4.3",
        statement: "the hull of a vertex's graph neighbours gives the vertex's star in DT(P)",
        reading: Reading::AsPrinted,
        experiment: "Stars that splaying changed, rounds of splaying and points gathered, on f-spaced sets",
        bound: "0, by the lemma, if the graph contains DT(P)",
        check: local_hulls,
    },
    Claim {
        name: "hulls-depth",
        role: Role::Test,
        statistics: None,
        source: "Lemma 4.1",
        statement: "from G with degrees up to D_2, DT(P) takes O(T_CH(D_2)) with n processors, for any n",
        reading: Reading::AsPrinted,
        experiment: "Depth of the phase `hulls` over the largest degree of the graph, at several sizes",
        bound: "12 steps per neighbour: at most five dependent sweeps of two steps for each neighbour that enters the star, and two \
                more for the sort and the first simplex",
        check: hulls_depth,
    },
];

fn specimens(lab: &mut Lab) -> Result<Vec<Rc<Specimen>>, ClaimError> {
    let n = lab.size(8000, 40_000);
    let kinds = [Kind::WellSpaced, Kind::GradedPoint];
    let samples: Vec<Sample> =
        kinds.iter().flat_map(|&kind| [2, 3].map(|d| Sample::new(kind, n, d))).collect();
    lab.specimens(&samples, lab.by_extent(1, 5))
}

fn subgraph(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let graph = specimen.run.kept.graph.as_deref().unwrap_or_default();
        let all = edges(specimen.run.cells(), specimen.d);
        let missing = all.iter().filter(|edge| graph.binary_search(edge).is_err()).count();
        let what = format!("edges of DT(P), of {}, not in the graph of {} edges", all.len(), graph.len());
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, missing as f64, 0.0));
    }
    Ok(figures)
}

fn lower_hull(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut all = specimens(lab)?;
    let n = lab.size(4000, 20_000);
    // A set with ties in every cell, and a set without ties.
    let others = [Kind::Grid, Kind::Uniform];
    let samples: Vec<Sample> =
        others.iter().flat_map(|&kind| [2, 3].map(|d| Sample::new(kind, n, d))).collect();
    all.extend(lab.specimens(&samples, 1)?);
    let mut figures = Vec::new();
    for specimen in all {
        let coordinates: Vec<f64> =
            specimen.points.iter().flat_map(|p| p[..specimen.d].iter().copied()).collect();
        let options = VerifyOptions { perturbed: true, ..VerifyOptions::default() };
        let report = verify(
            &Triangulation {
                dimension: specimen.run.space,
                coordinates: &coordinates,
                cells: specimen.run.cells(),
            },
            &options,
            &mut |_, _, _| {},
        );
        let found: u64 = report.levels.iter().map(|level| level.fault_count).sum();
        let stopped = report.levels.iter().filter(|level| !level.passed).count() as u64;
        let what = format!("faults of {} cells ({} ties)", report.cells, report.ties);
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, found.max(stopped) as f64, 0.0));
    }
    Ok(figures)
}

fn local_hulls(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for specimen in specimens(lab)? {
        let run = &specimen.run;
        let gathered = run.fallback.as_ref().map_or(0, |fallback| fallback.1);
        let sum = run.stars_repaired + run.exchange_rounds + gathered;
        let what = format!("stars changed, of {}, rounds of splaying and points gathered", run.points.used);
        figures.push(Figure::at_most(what, &specimen.name, specimen.seed, sum as f64, 0.0));
    }
    Ok(figures)
}

fn hulls_depth(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    let sizes = lab.by_extent(&[2000, 8000][..], &[2000, 8000, 32_000, 128_000]);
    for d in [2, 3] {
        let samples: Vec<Sample> = sizes.iter().map(|&n| Sample::new(Kind::WellSpaced, n, d)).collect();
        for specimen in lab.specimens(&samples, 1)? {
            let hulls = specimen.run.ledger.phases.iter().find(|p| p.phase == Phase::Hulls);
            let depth = hulls.map_or(f64::NAN, |p| p.depth as f64);
            let graph = pairs(&specimen.points, &specimen.nearest2, density(specimen.alpha));
            let most = degrees(specimen.points.len(), &graph).into_iter().max().unwrap_or(0);
            let what = format!("depth of the hulls, {depth}, over the largest degree, {most}");
            figures.push(Figure::at_most(what, &specimen.name, specimen.seed, depth / most as f64, 12.0));
        }
    }
    Ok(figures)
}
