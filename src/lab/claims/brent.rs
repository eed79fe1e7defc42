//! Theorem 4.4 with its two halves: time with n processors, and work.
//!
//! **Statement.** Let a phase have work `W` and depth `D` at level l. By Brent's principle, n processors run all levels
//! in `T_n = sum over phases and levels of ceil((W - D) / n) + D` steps. `T_n` of a run is
//! `machine.total.brent` of its report. Theorem 4.4 states that `T_n` is `O(log n)`, and hence
//! that the work is `O(n log n)`.

use super::bounds::{PHASES, T_N};
use super::lab::Lab;
use super::sweeps::{Sweep, lists, recursions};
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "brent",
    role: Role::Test,
    statistics: None,
    source: "Theorem 4.4",
    statement: "DT(P) takes O(log n) time with n processors, hence O(n log n) work",
    reading: Reading::AsPrinted,
    experiment: "Leaves of 60 points, well-spaced sets from 512 points up, and lists of 12 neighbours of uniform sets: the \
                 largest T_n = machine.total.brent over log2 n; for each phase, the largest work over \
                 n log2 n and the largest depth over log2 n",
    bound: "1.15 times the largest value over the seeds 1 to 3, measured once before the run: counts vary by a few percent \
            between seeds, and a second pass of a phase adds 100 %; for the work of a probe, a tenth of the bound of the \
            descent that follows, because a probe processes few balls",
    check: brent,
}];

fn brent(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for sweep in recursions(lab)? {
        figures.push(time(&sweep, lab.seed()));
        figures.extend(phases(&sweep, lab.seed(), false));
    }
    for sweep in lists(lab)? {
        figures.extend(phases(&sweep, lab.seed(), true));
    }
    Ok(figures)
}

fn time(sweep: &Sweep, seed: u64) -> Figure {
    let largest = sweep.largest(|run| run.brent() as f64 / run.log());
    let bound = T_N.of(sweep.dimension());
    Figure::at_most("T_n over log2 n", &sweep.name, seed, largest, bound)
}

/// Returns the figures of the phases with a bound. If `lists` is set, these are the phases of nearest-neighbour lists.
/// Otherwise, they are all other phases. A phase that must occur has no value without a charge, so its figures fail.
fn phases(sweep: &Sweep, seed: u64, lists: bool) -> Vec<Figure> {
    let mut figures = Vec::new();
    let d = sweep.dimension();
    for phase in PHASES.iter().filter(|phase| phase.of_lists == lists) {
        let work =
            sweep.largest(|run| sweep.count(run, phase.name, |p| p.work) / (run.line.n as f64 * run.log()));
        let what = format!("work of {} over n log2 n", phase.name);
        figures.push(Figure::at_most(what, &sweep.name, seed, work, phase.work.of(d)));
        let depth = sweep.largest(|run| sweep.count(run, phase.name, |p| p.depth) / run.log());
        let what = format!("depth of {} over log2 n", phase.name);
        figures.push(Figure::at_most(what, &sweep.name, seed, depth, phase.depth.of(d)));
    }
    figures
}
