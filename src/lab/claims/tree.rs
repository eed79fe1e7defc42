//! Theorem 4.4 and Lemma 4.5: the number of levels.

use super::counted::Counted;
use super::lab::Lab;
use super::sweeps::{recursions, trees};
use super::{Claim, ClaimError, Figure, Reading, Role};

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "levels",
    role: Role::Test,
    statistics: None,
    source: "Lemma 4.5, Theorem 4.4",
    statement: "the recursion has O(log n) levels",
    reading: Reading::AsPrinted,
    experiment: "Levels below the root minus 2, over log2(n/leaf); the maximum over all sizes and seeds",
    bound: "1.5: 1.05 to 1.3 measured; the split ratio proves 9.6",
    check: levels,
}];

fn levels(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let seed = lab.seed();
    let slope = |run: &Counted| {
        (f64::from(run.line.tree.levels) - 2.0) / (run.line.n as f64 / run.line.leaf as f64).log2()
    };
    let sweeps = [recursions(lab)?, trees(lab)?].concat();
    let figure = |sweep: super::sweeps::Sweep| {
        let what = "(levels - 2) / log2(n/leaf), largest of all runs";
        Figure::at_most(what, &sweep.name, seed, sweep.largest(slope), 1.5)
    };
    Ok(sweeps.into_iter().map(figure).collect())
}
