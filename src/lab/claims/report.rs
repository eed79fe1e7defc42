//! The report of checked claims, as data and as text.

use std::fmt::Write;

use septet_core::spec::Fault;
use serde::Serialize;

use super::claim::{LEVEL, Statistics};
use super::figure::worse;
use super::holm::adjusted;
use super::lab::Lab;
use super::{Claim, ClaimError, Extent, Figure, Reading, Relation, Role};

/// Name and version of the schema of [`ClaimReport`].
pub const SCHEMA: &str = "septet-claims/2";

/// A checked claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CheckedClaim {
    /// The name of the claim.
    pub name: &'static str,
    /// The role: test or illustration.
    pub role: Role,
    /// The error probabilities of a statistical claim. `None` if the figures have no statistical error.
    pub statistics: Option<Statistics>,
    /// The section or theorem of the paper.
    pub source: &'static str,
    /// The statement.
    pub statement: &'static str,
    /// The form of the statement that was checked.
    pub reading: Reading,
    /// The runs and measurements.
    pub experiment: &'static str,
    /// The bound and its reason.
    pub bound: &'static str,
    /// Whether there is a figure of the checked form and every such figure satisfies its bound. In a report, the
    /// adjusted p-value of a statistical claim must also be at most the level.
    pub passed: bool,
    /// The largest p-value of the figures. `None` if they have no statistical error.
    pub p: Option<f64>,
    /// The p-value after Holm's adjustment over the statistical claims of the report. `None` before the adjustment.
    pub adjusted_p: Option<f64>,
    /// Whether every figure of the printed form satisfies its bound. `None` if no figure belongs to the printed form
    /// ([`Figure::as_printed`]).
    pub holds_as_printed: Option<bool>,
    /// All figures.
    pub figures: Vec<Figure>,
}

/// All checked claims.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ClaimReport {
    /// Name and version of this schema.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    pub schema: &'static str,
    /// Version of septet.
    pub version: &'static str,
    /// The extent of the experiments.
    pub extent: Extent,
    /// The first seed.
    pub seed: u64,
    /// The fault that every machine had; absent if none was planted.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub fault: Option<Fault>,
    /// Whether there are claims, all tests passed, and all illustrations satisfy their bounds.
    pub passed: bool,
    /// Number of tests that passed.
    pub tests_passed: usize,
    /// Number of tests.
    pub tests: usize,
    /// The claims, in the paper's order.
    pub claims: Vec<CheckedClaim>,
}

impl Claim {
    /// Runs the experiment. In a laboratory with a planted fault, a claim fails if its experiment ends with an error.
    ///
    /// # Errors
    /// See [`ClaimError`].
    pub fn check(&self, lab: &mut Lab) -> Result<CheckedClaim, ClaimError> {
        let figures = match (self.check)(lab) {
            Err(error) if lab.options.fault.is_some() && !error.is_interruption() => {
                vec![Figure::at_most(error.to_string(), "no result", lab.options.seed, f64::NAN, 0.0)]
            }
            figures => figures?,
        };
        Ok(CheckedClaim::of(self, figures))
    }
}

impl CheckedClaim {
    pub(super) fn of(claim: &Claim, figures: Vec<Figure>) -> CheckedClaim {
        let (printed, checked): (Vec<&Figure>, Vec<&Figure>) = figures.iter().partition(|f| f.as_printed);
        let passed = !checked.is_empty() && checked.iter().all(|f| f.holds());
        let holds_as_printed = (!printed.is_empty()).then(|| printed.iter().all(|f| f.holds()));
        let p = checked.iter().filter_map(|f| f.p).reduce(worse);
        let Claim { name, role, statistics, source, statement, reading, experiment, bound, .. } = *claim;
        CheckedClaim {
            name,
            role,
            statistics,
            source,
            statement,
            reading,
            experiment,
            bound,
            passed,
            p,
            adjusted_p: None,
            holds_as_printed,
            figures,
        }
    }

    /// Returns `true` if the figures have p-values, so that the result depends on Holm's adjustment.
    pub fn is_statistical(&self) -> bool {
        self.p.is_some()
    }

    /// Returns the decisive figure of the printed form if `as_printed` is set, and otherwise of the checked form. It is
    /// the figure farthest beyond its bound, or the figure nearest to its bound if none is beyond.
    pub fn telling(&self, as_printed: bool) -> Option<&Figure> {
        let of = self.figures.iter().filter(|f| f.as_printed == as_printed);
        of.max_by(|a, b| a.strain().total_cmp(&b.strain()))
    }

    /// Returns the rows of the claim: one for the checked form, one for the printed form if it has figures, and one for
    /// an adjusted p-value above the level.
    pub fn rows(&self) -> String {
        let mut out = String::new();
        let result = match (self.passed, self.role) {
            (false, _) => "FAIL",
            (true, Role::Test) => "PASS",
            (true, Role::Illustration) => "shown",
        };
        row(&mut out, result, self.name, self.telling(false));
        if let Some(holds) = self.holds_as_printed {
            let says = if holds { "  as printed: holds" } else { "  as printed: does not hold" };
            row(&mut out, "", says, self.telling(true));
        }
        if let Some(p) = self.adjusted_p.filter(|&p| p > LEVEL) {
            let (mark, name, p) = ("    x", "    adjusted p", short(p));
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "{mark:<5} {name:<28} {p:>9} <= {LEVEL:<8} {:>4}  adjusted p = {p} > {LEVEL} (Holm, over the \
                 statistical claims of this call)",
                ""
            );
        }
        out
    }

    /// Returns the rows of all figures. If `beyond` is set, returns only the rows of figures of the checked form that
    /// are beyond their bounds.
    pub fn details(&self, beyond: bool) -> String {
        let mut out = String::new();
        for figure in self.figures.iter().filter(|f| !(beyond && (f.holds() || f.as_printed))) {
            let name = if figure.as_printed { "    as printed" } else { "" };
            let mark = if figure.holds() { "" } else { "    x" };
            row(&mut out, mark, name, Some(figure));
        }
        out
    }
}

fn row(out: &mut String, result: &str, name: &str, figure: Option<&Figure>) {
    let Some(figure) = figure else {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{result:<5} {name:<28} nothing was measured");
        return;
    };
    let relation = match figure.relation {
        Relation::AtMost => "<=",
        Relation::AtLeast => ">=",
    };
    let Figure { what, on, seed, .. } = figure;
    let (value, bound) = (short(figure.value), short(figure.bound));
    let _ = writeln!(out, "{result:<5} {name:<28} {value:>9} {relation} {bound:<8} {seed:>4}  {what}; {on}");
}

/// Formats a number with about four significant digits.
fn short(x: f64) -> String {
    let size = x.abs();
    if x == x.trunc() && size < 1e7 {
        format!("{x:.0}")
    } else if (1e-3..1e7).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.2e}")
    }
}

impl ClaimReport {
    /// Returns the report of checked claims, which must be in the paper's order. Adjusts the p-values of the
    /// statistical claims.
    pub fn of(extent: Extent, seed: u64, mut claims: Vec<CheckedClaim>) -> ClaimReport {
        let mut statistical: Vec<&mut CheckedClaim> = claims.iter_mut().filter(|c| c.p.is_some()).collect();
        let all: Vec<f64> = statistical.iter().map(|claim| claim.p.unwrap_or(f64::NAN)).collect();
        for (claim, p) in statistical.iter_mut().zip(adjusted(&all)) {
            claim.adjusted_p = Some(p);
            claim.passed &= p <= LEVEL;
        }
        let tests: Vec<&CheckedClaim> = claims.iter().filter(|claim| claim.role == Role::Test).collect();
        let (tests_passed, tests) = (tests.iter().filter(|claim| claim.passed).count(), tests.len());
        let passed = !claims.is_empty() && claims.iter().all(|claim| claim.passed);
        ClaimReport {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            extent,
            seed,
            fault: None,
            passed,
            tests_passed,
            tests,
            claims,
        }
    }

    /// Returns the report with the fault that was planted in every machine.
    #[must_use]
    pub fn with_fault(self, fault: Option<Fault>) -> ClaimReport {
        ClaimReport { fault, ..self }
    }

    /// Returns the header of the table.
    pub fn head() -> String {
        let (result, claim, figure, bound, seed) = ("", "claim", "figure", "bound", "seed");
        format!("{result:<5} {claim:<28} {figure:>9}    {bound:<8} {seed:>4}  what; on which points\n")
    }

    /// Returns a summary in one sentence.
    pub fn summary(&self) -> String {
        let ClaimReport { tests_passed, tests, .. } = self;
        let illustrations = self.claims.len() - tests;
        let failed = self.claims.iter().filter(|claim| !claim.passed).count();
        let otherwise = self.claims.iter().filter(|claim| claim.holds_as_printed == Some(false)).count();
        let planted = self.fault.map_or_else(String::new, |fault| format!("fault {fault}: "));
        format!(
            "{planted}{tests_passed} of {tests} tests pass, {failed} claims fail; {illustrations} illustrations; \
             {otherwise} claims hold as read but not as printed"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::registry;
    use super::*;

    fn checked(name: &str, p: Option<f64>) -> CheckedClaim {
        let claim = registry().find(|claim| claim.name == name).unwrap();
        let figure = Figure::at_most("depth", "some points", 1, 0.4, 0.5);
        CheckedClaim::of(claim, vec![Figure { p, ..figure }])
    }

    /// Alone, each of the p-values is below the level. Over three claims, the adjusted values are 0.003, 0.06 and 0.06.
    #[test]
    fn a_claim_that_passes_alone_may_fail_in_a_report() {
        let claims = vec![
            checked("level-depth", Some(0.001)),
            checked("depth-law", Some(0.04)),
            checked("replication", Some(0.03)),
            checked("levels", None),
        ];
        assert!(claims.iter().all(|claim| claim.passed && claim.adjusted_p.is_none()));
        let report = ClaimReport::of(Extent::Quick, 1, claims);
        let passed: Vec<bool> = report.claims.iter().map(|claim| claim.passed).collect();
        assert_eq!(passed, [true, false, false, true]);
        assert_eq!((report.tests_passed, report.tests, report.passed), (2, 4, false));
        for (claim, expected) in report.claims.iter().zip([Some(0.003), Some(0.06), Some(0.06), None]) {
            let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert_eq!(claim.is_statistical(), expected.is_some());
            assert!(claim.adjusted_p.zip(expected).is_none_or(|(p, q)| close(p, q)), "{}", claim.name);
            let rows = claim.rows();
            assert_eq!(rows.contains("adjusted p = 0.06000 > 0.05"), !claim.passed, "{rows}");
            assert_eq!(rows.starts_with("FAIL"), !claim.passed, "{rows}");
        }
        let alone = ClaimReport::of(Extent::Quick, 1, vec![checked("depth-law", Some(0.04))]);
        assert!(alone.passed && !alone.claims[0].rows().contains("adjusted"));
    }

    /// A missing p-value of one figure makes the p-value of the claim undefined, so the claim fails.
    #[test]
    fn an_undefined_p_value_fails() {
        let report = ClaimReport::of(Extent::Quick, 1, vec![checked("depth-law", Some(f64::NAN))]);
        assert!(!report.passed && report.claims[0].adjusted_p == Some(1.0));
    }
}
