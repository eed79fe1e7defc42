//! Lower bounds on the charges, from points, cells and the sizes of nodes alone.
//!
//! A second account of the same run cannot find a step that both accounts omit. These bounds do not come from charges:
//! they count the pairs, tests and visits that a machine without further knowledge needs for its result.

use std::rc::Rc;

use crate::experiment::of_run;
use septet_core::Config;
use septet_core::config::{Alpha, DEFAULT_ALPHA, Graph, Neighbours};
use septet_core::generate::Kind;

use super::counted::Counted;
use super::floors::{FLOORS, Floor, Least, Natural};
use super::lab::{Lab, Sample, Specimen};
use super::measure::{degrees, density, kth_nearest2, nearest, pairs, stars};
use super::sweeps::{LEAF, LIST};
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "lower-bounds",
    role: Role::Test,
    statistics: None,
    source: "Theorem 4.4, the counts of the machine",
    statement: "the work and depth of every phase count all operations of the phase",
    reading: Reading::AsPrinted,
    experiment: "Leaves of 60 points, density graphs of well-spaced sets and lists of 12 neighbours of uniform sets: the work of \
                 each phase over a natural size (pairs in leaves, candidates times link facets, points times levels, ghosts, \
                 visits times points, cells), and its depth over a natural depth (1, levels, largest degree), both from points, cells and node \
                 sizes alone",
    bound: "For each phase, the number of operations that each item of the natural size needs: for a pair, a distance and a \
            comparison; for a point at a level, its side, its rank and its move",
    check: lower_bounds,
}];

/// The natural sizes of a run.
struct Sizes {
    name: String,
    counted: Counted,
    points: f64,
    pairs: f64,
    member_pairs: f64,
    levels: f64,
    points_times_levels: f64,
    visitors: f64,
    ghosts: f64,
    cells: f64,
    tests: f64,
    degree: f64,
}

impl Sizes {
    fn of(&self, natural: Natural) -> f64 {
        match natural {
            Natural::One => 1.0,
            Natural::Points => self.points,
            Natural::PairsInLeaves => self.pairs,
            Natural::PairsWithMembers => self.member_pairs,
            Natural::Levels => self.levels,
            Natural::PointsTimesLevels => self.points_times_levels,
            Natural::PairsWithVisitors => self.visitors,
            Natural::Ghosts => self.ghosts,
            Natural::Cells => self.cells,
            Natural::CandidatesTimesFacets => self.tests,
            Natural::LargestDegree => self.degree,
        }
    }
}

fn lower_bounds(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let n = lab.size(6000, 30_000);
    let mut figures = Vec::new();
    for d in [2, 3] {
        let recursion = sizes(lab, Sample::new(Kind::WellSpaced, n, d), false)?;
        let lists = sizes(lab, Sample::new(Kind::Uniform, n, d), true)?;
        for floor in &FLOORS {
            figures.extend(checked(if floor.of_lists { &lists } else { &recursion }, floor, seed));
        }
    }
    Ok(figures)
}

fn checked(sizes: &Sizes, floor: &Floor, seed: u64) -> [Figure; 2] {
    let phase = sizes.counted.line.phase(floor.name);
    let (work, depth) = phase.map_or((f64::NAN, f64::NAN), |p| (p.work as f64, p.depth as f64));
    let figure = |what: &str, value: f64, Least { natural, operations }: Least| {
        let what = format!("{what} of {} over {}", floor.name, natural.name());
        Figure::at_least(what, &sizes.name, seed, value / sizes.of(natural), operations)
    };
    [figure("work", work, floor.work), figure("depth", depth, floor.depth)]
}

fn sizes(lab: &mut Lab, sample: Sample, lists: bool) -> Result<Sizes, ClaimError> {
    let seed = lab.seed();
    let specimen: Rc<Specimen> = lab.specimen(sample, seed)?;
    let run = lab.run(sample, seed, |config: Config| {
        config.with(|c| {
            c.machine.leaf = Some(LEAF);
            c.graph = if lists {
                Graph::Knn { k: Neighbours::Count(LIST) }
            } else {
                Graph::Density { alpha: Alpha::Value(DEFAULT_ALPHA) }
            };
        })
    })?;
    let counted = Counted::of_line(sample, seed, of_run(&run), &run.ledger);
    let points = specimen.points.len();
    let edges = if lists {
        pairs(&specimen.points, &kth_nearest2(&specimen.points, LIST as usize), nearest())
    } else {
        pairs(&specimen.points, &specimen.nearest2, density(DEFAULT_ALPHA))
    };
    let candidates = degrees(points, &edges);
    let stars = stars(points, run.cells(), sample.d);
    let tests: f64 = candidates.iter().zip(&stars).map(|(c, star)| *c as f64 * star.len() as f64).sum();
    let sum = |of: &dyn Fn(u64) -> f64| counted.leaves().map(|leaf| of(leaf.facts.population)).sum::<f64>();
    let member_pairs = counted.leaves().map(|leaf| (leaf.facts.population * leaf.facts.members) as f64).sum();
    Ok(Sizes {
        name: sample.name(),
        points: points as f64,
        pairs: sum(&|m| m as f64 * (m as f64 - 1.0)),
        member_pairs,
        levels: f64::from(counted.line.tree.levels),
        points_times_levels: counted.splits().map(|node| node.facts.population as f64).sum(),
        visitors: counted.leaves().map(|leaf| (leaf.facts.visits * leaf.facts.population) as f64).sum(),
        ghosts: counted
            .leaves()
            .map(|leaf| leaf.facts.members.saturating_sub(leaf.facts.population) as f64)
            .sum(),
        cells: run.cell_count() as f64,
        tests,
        degree: candidates.iter().copied().max().unwrap_or(0) as f64,
        counted,
    })
}
