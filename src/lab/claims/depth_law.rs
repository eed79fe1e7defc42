//! Theorem 4.4: the depth of every phase grows like log n.
//!
//! **Statement.** Let L be log2 of n over the smallest n, and let h be the number of levels. The fit is
//! `depth = a + b L + c L^2 + e h`, and `c L^2` at the largest n is bounded. The number of levels is a sawtooth in L,
//! so it has its own column; the claim `levels` bounds it.
//!
//! **Phases within leaves.** They have no levels, so their depth must not grow at all. Their fit is `depth = a + b L`,
//! and the growth `b L` has the bound of the quadratic term. The hulls are an exception. Their depth is that of the
//! largest star, and the largest of n stars grows slowly towards the bound on all stars. So the growth of the hulls has
//! a larger bound. A quadratic term of the hulls would have an error of 5 % of their depth.
//!
//! **Probes.** A run probes only if a ball is large. The probes are therefore not part of these fits. `brent` and
//! `level-depth` bound their depth.

use crate::experiment::fit::{ClusterRow, Estimate, clustered};

use super::claim::LEVEL;
use super::counted::Counted;
use super::lab::Lab;
use super::sweeps::{Sweep, lists, recursions};
use super::{Claim, ClaimError, Figure, Reading, Role, Statistics};

/// Largest quadratic term, and largest growth of a phase within leaves, as a share of the depth at the largest size.
const SHARE: f64 = 0.1;

/// Largest growth of the depth of the hulls, as a share of the depth at the largest size.
const SHARE_OF_HULLS: f64 = 0.2;

/// The phases within leaves.
pub(super) const LOCAL: [&str; 5] = ["radii", "graph", "hulls", "check", "knn-radii"];

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "depth-law",
    role: Role::Test,
    statistics: Some(Statistics {
        level: LEVEL,
        fault: "slow:hulls:root3",
        caught: 20,
        of: 20,
        smallest: "slow:hulls:root3:0.6, at 6 of 6 seeds",
    }),
    source: "Theorem 4.4, Lemma 4.5",
    statement: "DT(P) takes O(log n) depth on an EREW PRAM with unit-time scans",
    reading: Reading::AsPrinted,
    experiment: "Fit of depth = a + b L + c L^2 + e h over eight sizes per octave, L = log2 of n over the smallest n, \
                 which has 8 leaves, h the levels. The upper end of the one-sided 95 % interval of c L^2 at the \
                 largest n over the depth there, for each phase and the sum; for phases within leaves, the growth \
                 b L of a + b L",
    bound: "10 %: with a larger share, a depth is not distinguished from log^2 n; 20 % for the growth of the hulls: \
            the largest star grows towards the bound on all stars by 8 % in space, a depth like n^(1/3) by 30 %",
    check: law,
}];

fn law(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let mut figures = Vec::new();
    for sweep in recursions(lab)? {
        figures.push(bend(&sweep, "all phases but the probe", seed, sum));
        figures.extend(sweep.phases.iter().map(|phase| of_phase(&sweep, phase, seed)));
    }
    for sweep in lists(lab)? {
        figures.extend(["knn-radii", "knn"].map(|phase| of_phase(&sweep, phase, seed)));
    }
    Ok(figures)
}

/// Returns the figure of a phase that every run must charge. It has no value if a run does not charge the phase.
pub(super) fn of_phase(sweep: &Sweep, phase: &str, seed: u64) -> Figure {
    bend(sweep, phase, seed, |run| sweep.count(run, phase, |total| total.depth))
}

/// Returns the depth of all groups of phases, without the steps of the probe on the longest chain.
fn sum(run: &Counted) -> f64 {
    let depths = run.line.totals.each().into_iter().filter_map(|(_, row)| *row).map(|row| row.total.depth);
    let probe = run.line.phase("probe").map_or(0, |phase| phase.total.critical_depth);
    depths.sum::<u64>().saturating_sub(probe) as f64
}

/// Returns the figure of a phase. It has no value if the depth of a run is undefined.
fn bend(sweep: &Sweep, phase: &str, seed: u64, depth: impl Fn(&Counted) -> f64) -> Figure {
    let local = LOCAL.contains(&phase);
    let runs: Vec<(&Counted, f64)> = sweep.runs.iter().map(|run| (run, depth(run))).collect();
    let asked = || runs.iter().map(|(run, _)| run.line.asked);
    let (least, most) = (asked().min().unwrap_or(1), asked().max().unwrap_or(1));
    let above = |n: u64| (n as f64 / least as f64).log2();
    let row = |(run, y): &(&Counted, f64)| {
        let log = above(run.line.n);
        let bent = vec![log, log * log, f64::from(run.line.tree.levels)];
        ClusterRow { cluster: run.line.asked, columns: if local { vec![log] } else { bent }, y: *y }
    };
    let rows: Vec<ClusterRow> = runs.iter().map(row).collect();
    let last: Vec<f64> = runs.iter().filter(|(run, _)| run.line.asked == most).map(|(_, y)| *y).collect();
    let mean = last.iter().sum::<f64>() / last.len().max(1) as f64;
    let (what, column, scale) =
        if local { ("growth", 1, above(most)) } else { ("quadratic share", 2, above(most) * above(most)) };
    let defined = runs.iter().all(|(_, y)| y.is_finite());
    let share = defined.then(|| clustered(&rows, column)).flatten();
    let share = share.map(|term: Estimate| term.times(scale / mean.max(1.0)));
    let estimate = share.map_or(f64::NAN, |share| share.value);
    let what = format!(
        "{what} of the depth of {phase}, {mean:.0} at the largest n, estimated {:.2} %",
        100.0 * estimate
    );
    let bound = if phase == "hulls" { SHARE_OF_HULLS } else { SHARE };
    let figure =
        Figure::at_most(what, &sweep.name, seed, share.map_or(f64::NAN, |share| share.upper()), bound);
    figure.with_p(share.map_or(f64::NAN, |share| share.p_below(bound)))
}
