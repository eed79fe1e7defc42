//! What can be said of how a count grows: laws with intervals, curvature, flatness, and a verdict in words.
//!
//! **Statement.** For a count y of runs over sets of x points (or x = n / leaf):
//! 1. each law g of [`Law`] is fitted as `y = a + b g(x)` by weighted least squares, with Student's intervals;
//! 2. *nested test*: `y = a + b L + c L^2`, L = log2 x, against c = 0, two-sided, size 1 %; with the smallest |c|
//!    that would have been found in 95 % of repetitions, and the c that a pure `log^2` law through the same data has;
//! 3. *equivalence*: for depth level by level, `depth = a + s log2 m` over levels of mean size m; flat if the
//!    90 % interval of s lies within plus or minus the margin (two one-sided tests of 5 %, Schuirmann 1987). The margin is
//!    part of the question, never of the answer: 5 % of the mean depth per doubling unless asked otherwise;
//! 4. *lack of fit*: each law against its own change of steepness and against a cubic in log x, 1 % for both: what
//!    does not fit is named no law, and if none is left the verdict is "none of these" with the exponent;
//! 5. *flatness*: a count does not grow if the 90 % interval of its change over the range of sizes, by the fit of
//!    log n, lies within the margin, here a share of the mean (two one-sided tests again); a slope that is not found
//!    is no finding: then the verdict is that one cannot tell;
//! 6. a [`Verdict`], which can be that these sizes do not tell laws apart.
//!
//! **Departures from the textbook, and why.** Seeds at one size share its place on the saw-tooth that a floor of
//! leaves makes, so they are no independent witnesses of curvature: the fit is over the means at each size, and the
//! error is what remains between sizes. Levels of one run share its points: the error of s is that of clusters
//! (one a run, CR1). Counts that grow like a power of n (work, messages, bytes, seconds) are weighted by 1 / y^2.
//!
//! What must not be mixed is refused: a count of the whole run holds repair and the machine's own phases, so it has
//! no fit; phases are fitted apart ([`FitError::Mixes`]).

mod data;
mod design;
mod distribution;
mod equivalence;
mod growth;
mod lack;
mod nested;
mod ols;
mod qr;
mod report;
mod resample;
mod speedup;
mod table;
mod verdict;

pub use data::{Abscissa, FitError, Key, MARGIN, Request};
pub use design::Law;
pub use equivalence::Equivalence;
pub use growth::{Growth, LawFit};
pub use nested::Curvature;
pub use ols::{Fit, Interval, Observation, least_squares};
pub use report::{FitReport, SCHEMA, Series, fit};
pub use resample::Resampled;
pub use speedup::{SpeedupRow, speedup};
pub use table::speedup_table;
pub use verdict::Verdict;
