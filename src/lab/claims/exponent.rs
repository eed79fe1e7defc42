//! Section 2 (4): the size of separators grows like `m^(1-1/d)`, and planes do not have this property.

use std::rc::Rc;

use crate::experiment::fit::{ClusterRow, Estimate, clustered};
use septet_core::Config;
use septet_core::config::{Alpha, DEFAULT_ALPHA, Graph, Partition, Until};
use septet_core::generate::Kind;

use super::counted::Counted;
use super::lab::{Lab, Sample};
use super::sweeps::LEAF;
use super::{Claim, ClaimError, Extent, Figure, Reading, Role};

/// The smallest node of the fits.
const SMALLEST: u64 = 500;

/// Number of runs over each kind of points.
const RUNS: u64 = 5;

/// Number of samples of a draw. Fewer samples, as in the default for counting, do not show the exponent of large nodes.
const SAMPLES: u64 = 400;

/// Number of points on the shells.
pub(super) const SHELLS: u64 = 9600;

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "separator-exponent",
    role: Role::Test,
    statistics: None,
    source: "Section 2 (4), Section 4.3 step 2",
    statement: "|B_O| = O(alpha n^(1-1/d)) for sphere separators of neighbour balls, whatever the points",
    reading: Reading::AsPrinted,
    experiment: "Fit of log |B_O| against log m over all nodes of at least 500 points, leaves of 60, alpha 2.5, draws from \
                 400 samples, errors clustered by run: five well-spaced sets, and five sets of 9,600 points on shells of ratio 1.3, by spheres and by planes at the median; the end of the one-sided 95 % interval. On shells, the largest \
                 share of the root for spheres and the smallest for planes",
    bound: "1 - 1/d and 0.03 (in the plane 0.10, where the term of next order is larger) on well-spaced sets; 0.75 on shells, \
            where nodes are small, against at least 0.90 for planes, which cut all shells; 0.12 n at the root, as 1.3^-i decays \
            within a few shells, against at least 0.5 n",
    check: exponents,
}];

fn exponents(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for (d, bound) in [(2, 0.60), (3, 0.70)] {
        let sample = Sample::new(Kind::WellSpaced, points(lab.options.extent), d);
        let runs = separated(lab, sample, Partition::Sphere)?;
        let on = format!("{} {} runs", sample.name(), runs.len());
        figures.push(at_most(exponent(&runs), "spheres", Place { on: &on, seed }, bound));
    }
    let spheres = separated(lab, sample(), Partition::Sphere)?;
    let planes = separated(lab, sample(), Partition::Kd)?;
    let name = format!("{} {} runs", sample().name(), spheres.len());
    let place = Place { on: &name, seed };
    figures.push(at_most(exponent(&spheres), "spheres", place, 0.75));
    figures.push(at_least(exponent(&planes), "planes", place, 0.90));
    let largest = roots(&spheres).fold(0.0, f64::max);
    figures.push(Figure::at_most("|B_O| / n at the root, spheres", &name, seed, largest, 0.12));
    let smallest = roots(&planes).fold(f64::INFINITY, f64::min);
    figures.push(Figure::at_least("|B_O| / n at the root, planes", &name, seed, smallest, 0.5));
    Ok(figures)
}

/// The points of a figure, and the first seed.
#[derive(Clone, Copy)]
struct Place<'a> {
    on: &'a str,
    seed: u64,
}

fn at_most(found: Option<Estimate>, what: &str, at: Place<'_>, bound: f64) -> Figure {
    let upper = found.map_or(f64::NAN, |e| e.upper());
    let figure = Figure::at_most(named(found, what), at.on, at.seed, upper, bound);
    figure.with_p(found.map_or(f64::NAN, |e| e.p_below(bound)))
}

fn at_least(found: Option<Estimate>, what: &str, at: Place<'_>, bound: f64) -> Figure {
    let lower = found.map_or(f64::NAN, |e| e.lower());
    let figure = Figure::at_least(named(found, what), at.on, at.seed, lower, bound);
    figure.with_p(found.map_or(f64::NAN, |e| e.p_above(bound)))
}

fn named(found: Option<Estimate>, what: &str) -> String {
    let estimate = found.map_or(f64::NAN, |e| e.value);
    format!("exponent of |B_O| in m, {what}, estimated {estimate:.3}")
}

/// Returns the number of points of a well-spaced set.
fn points(extent: Extent) -> u64 {
    match extent {
        Extent::Brief => 1 << 13,
        Extent::Quick => 1 << 15,
        Extent::Full => 1 << 18,
    }
}

fn sample() -> Sample {
    Sample::new(Kind::Shells, SHELLS, 3)
}

/// Returns the runs over some points by these separators, up to the graph.
fn separated(lab: &mut Lab, sample: Sample, partition: Partition) -> Result<Rc<Vec<Counted>>, ClaimError> {
    let change = |config: Config| {
        config.with(|c| {
            c.machine.leaf = Some(LEAF);
            c.constants.samples = Some(SAMPLES);
            c.partition = partition;
            c.graph = Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) };
            c.until = Some(Until::Graph);
        })
    };
    lab.counted(&format!("separators {} {}", sample.name(), partition.name()), &[sample], RUNS, change)
}

/// Returns the exponent of |B_O| in m over all nodes of at least [`SMALLEST`] points.
fn exponent(runs: &[Counted]) -> Option<Estimate> {
    let mut rows = Vec::new();
    for (cluster, run) in (0..).zip(runs) {
        for node in run.splits().filter(|node| node.facts.population >= SMALLEST) {
            let log = (node.facts.population as f64).ln();
            // An empty set counts as one point, so that it has a logarithm.
            let y = (node.crossing().max(1) as f64).ln();
            rows.push(ClusterRow { cluster, columns: vec![log], y });
        }
    }
    clustered(&rows, 1)
}

/// Returns |B_O| / n at the root of each run.
pub(super) fn roots(runs: &[Counted]) -> impl Iterator<Item = f64> {
    let root = |run: &Counted| {
        run.nodes.iter().find(|node| node.level == 0).map(|node| (run.line.n, node.crossing()))
    };
    runs.iter().filter_map(root).map(|(n, crossing)| crossing as f64 / n as f64)
}
