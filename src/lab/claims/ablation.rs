//! The effect of each part of the draw of a separator: runs in which one part is removed or replaced.

use std::rc::Rc;

use septet_core::Spec;
use septet_core::generate::Kind;
use septet_core::spec::{Alpha, DEFAULT_ALPHA, Fault, Graph, Until};
use septet_geometry::separator::Ablation;

use super::counted::Counted;
use super::exponent::{SHELLS, roots};
use super::lab::{Lab, Runs};
use super::sample::Sample;
use super::sweeps::LEAF;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// Number of seeds over which each mean is taken.
const SEEDS: u64 = 5;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "separator-ablation",
    role: Role::Illustration,
    statistics: None,
    source: "Section 2, Section 4.3 step 2",
    statement: "a separator is the best of several great circles through a centrepoint of the lift, after a conformal \
                map",
    reading: Reading::AsPrinted,
    experiment: "Shells, well-spaced and uniform sets of 9,600 points, leaves of 60, five seeds: the sizes of the \
                 separator sets of all nodes and of the root over the number of points, with one part of the draw \
                 removed or replaced",
    bound: "0: the figures show the effect of each part",
    check: table,
}];

fn table(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for kind in [Kind::Shells, Kind::WellSpaced, Kind::Uniform] {
        let sample = Sample::new(kind, SHELLS, 3);
        for ablation in std::iter::once(None).chain(Ablation::ALL.map(Some)) {
            let runs = runs(lab, sample, ablation)?;
            let mean = |of: &dyn Fn(&Counted) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
            let all =
                mean(&|run| run.per_point(|node| if node.facts.is_leaf() { 0 } else { node.crossing() }));
            let root = roots(&runs).sum::<f64>() / runs.len() as f64;
            let name = ablation.map_or("the whole draw", Ablation::name);
            for (what, value) in [("all nodes", all), ("the root", root)] {
                let what = format!("|B_O| of {what} over n, {name}");
                figures.push(Figure::at_least(what, sample.name(), seed, value, 0.0));
            }
        }
    }
    Ok(figures)
}

fn runs(lab: &mut Lab, sample: Sample, ablation: Option<Ablation>) -> Result<Rc<Vec<Counted>>, ClaimError> {
    let change = |spec: Spec| {
        spec.with(|c| {
            c.tree.leaf = Some(LEAF);
            c.recursion.graph = Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) };
            c.planted.fault = ablation.map(Fault::Ablate).or(c.planted.fault);
        })
    };
    let name = ablation.map_or("whole", Ablation::name);
    let name = format!("ablation {name} {}", sample.name());
    lab.counted(&Runs { name: &name, samples: &[sample], seeds: SEEDS, until: Some(Until::Graph) }, change)
}
