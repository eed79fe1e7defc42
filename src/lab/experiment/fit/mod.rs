//! The growth of counts: growth laws with intervals, tests of curvature and flatness, and a conclusion in words.
//!
//! **Statement.** Let y be a count of a run, and x the number n of its points (or n / leaf).
//! - (1) *Laws.* Each law g of [`Law`] is fitted as `y = a + b g(x)` by weighted least squares, with Student's
//!   intervals.
//! - (2) *Nested test.* `y = a + b L + c L^2` with L = log2 x is tested against c = 0, two-sided, at 1 %. The result
//!   states the smallest |c| that would be detected in 95 % of repetitions, and the c of a pure `log^2` law through
//!   the same data.
//! - (3) *Equivalence.* For depth by level, `depth = a + s log2 m` is fitted over levels of mean size m. The depth is
//!   flat if the 90 % interval of s lies within plus or minus the margin (two one-sided tests at 5 %, Schuirmann
//!   1987). The margin is part of the request and is never derived from the data. The default is 5 % of the mean
//!   depth per doubling.
//! - (4) *Lack of fit.* Each law is tested at 1 % against two more flexible curves jointly: the law with another
//!   steepness, and a cubic in log x. A law that does not fit is excluded. If no law remains, the conclusion is "none
//!   of these", with the exponent.
//! - (5) *Flatness.* A count does not grow if the 90 % interval of its change over the range of sizes, according to the
//!   fit of log n, lies within the margin. Here, the margin is a fraction of the mean, and there are again two
//!   one-sided tests. A slope that is not significant does not show flatness. If neither growth nor flatness is shown,
//!   the conclusion is that growth is unclear.
//! - (6) *Conclusion.* A [`Conclusion`] summarises the tests. A possible conclusion is that the sizes do not
//!   distinguish the laws.
//! - (7) *Shares.* A [`NotExcluded`] states the largest share of a faster-growing law that the data do not exclude, at
//!   2.5 % one-sided. This share bounds the error of the conclusion "it grows like log n".
//! - (8) *Power.* The fit of `y = a + b x^e` with free e gives a 95 % profile interval for e ([`Power`]).
//!
//! **Departures.** The leaf size makes counts a sawtooth in n. All seeds at one size have the same position on this
//! sawtooth, so they are not independent observations of curvature. The fit is therefore over the means at each size,
//! and its error is computed from the residuals of these means. The levels of a run share its points, so the error of s
//! is clustered by run (CR1). Counts that grow like a power of n (work, messages, bytes, seconds) are weighted by
//! `1 / y^2`.
//!
//! A count of a whole run includes repair and the phases of the machine, so it is not fitted. Phases are fitted
//! separately ([`FitError::Mixes`]).

mod cluster;
mod conclusion;
mod data;
mod design;
mod distribution;
mod equivalence;
mod excluded;
mod growth;
mod lack;
mod nested;
mod ols;
mod power;
mod qr;
mod report;
mod resample;
mod speedup;
mod table;

pub use cluster::{ClusterRow, Estimate, clustered};
pub use conclusion::Conclusion;
pub use data::{Abscissa, FitError, FitRequest, Key, MARGIN};
pub use design::Law;
pub use equivalence::Equivalence;
pub use excluded::NotExcluded;
pub use growth::{Growth, LawFit};
pub use nested::Curvature;
pub use ols::{Fit, Interval, Observation, least_squares};
pub use power::Power;
pub use report::{FitReport, SCHEMA, Series, fit};
pub use resample::Resampled;
pub use speedup::{SpeedupRow, speedup};
pub use table::speedup_table;
