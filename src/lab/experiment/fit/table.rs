//! The result of a fit as text.

use std::fmt::Write;

use super::data::Key;
use super::equivalence::Equivalence;
use super::excluded::NotExcluded;
use super::growth::Growth;
use super::lack::rejects;
use super::ols::Interval;
use super::report::{FitReport, Series};
use super::speedup::SpeedupRow;

/// Formats a number with about four significant digits.
fn short(x: f64) -> String {
    match x.abs() {
        a if a == 0.0 || (1e-3..1e6).contains(&a) => {
            let digits = (3 - a.max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.3e}"),
    }
}

fn interval(i: &Interval) -> String {
    format!("{} [{}, {}]", short(i.value), short(i.low), short(i.high))
}

impl FitReport {
    /// Returns the result as tables and sentences. Every line ends with a line feed.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let phase = self.request.phase.as_ref().map_or_else(String::new, |p| format!(" of {p}"));
        for series in &self.series {
            let what = self.request.y.name();
            line(&mut out, &format!("{what}{phase}: {}, {} runs", series.name, series.runs));
            if let Some(growth) = &series.growth {
                growth.write(&mut out);
            }
            if let Some(test) = &series.levels {
                test.write(&mut out);
            }
            series.write_conclusion(&mut out);
            if self.request.phase.as_deref() == Some("paper") && self.request.y != Key::LevelDepth {
                line(
                    &mut out,
                    "  note: this fit is over all of the paper's phases; the constant of the local hulls can hide how the \
                     recursion grows, so fit its phases separately",
                );
            }
            out.push('\n');
        }
        out.pop();
        out
    }
}

impl Growth {
    fn write(&self, out: &mut String) {
        line(out, &format!("  {:>12} {:>12} {:>12} {:>12} {:>5}", "x", "mean", "least", "most", "runs"));
        for row in &self.table {
            let (x, mean, low, high) = (short(row.x), short(row.mean), short(row.low), short(row.high));
            line(out, &format!("  {x:>12} {mean:>12} {low:>12} {high:>12} {:>5}", row.runs));
        }
        line(
            out,
            "  y = a + b g, with 95 % intervals; behind: Akaike's criterion minus that of the best law (9.2: the best \
             is 100 times as likely)",
        );
        line(
            out,
            &format!("  {:<12} {:<34} {:<34} {:>8} {:>8} {:>9}", "g", "a", "b", "R^2", "behind", "fits, p"),
        );
        for fit in &self.laws {
            let (a, b) = (interval(&fit.constant), interval(&fit.slope));
            let name = fit.law.name();
            let (r, behind, p) = (fit.r_squared, fit.behind, p_value(fit.lack_of_fit));
            let out_of = if rejects(fit.lack_of_fit) { "  no" } else { "" };
            line(out, &format!("  {name:<12} {a:<34} {b:<34} {r:>8.5} {behind:>8.1} {p:>9}{out_of}"));
        }
        if let Some(exponent) = &self.exponent {
            line(out, &format!("  exponent of n without a constant: {}", interval(exponent)));
        }
        let (change, margin) = (&self.change, 100.0 * self.margin);
        line(
            out,
            &format!(
                "  change over these sizes: {:.1} % of the mean [{:.1}, {:.1}] (90 %); margin, stated in advance: \
                 {} %",
                100.0 * change.value,
                100.0 * change.low,
                100.0 * change.high,
                short(margin)
            ),
        );
        let c = &self.curvature;
        let bends = if c.bends { "it bends" } else { "no bend found" };
        line(
            out,
            &format!(
                "  quadratic term in log2 n: {}, p = {} ({bends} at 1 %); a term of {} would have been detected with \
                 a power of 95 %",
                interval(&c.quadratic),
                p_value(c.p),
                short(c.smallest_seen)
            ),
        );
        let hidden: Vec<String> = self
            .laws
            .iter()
            .filter(|fit| fit.power < 0.95 && fit.bend.abs() > 1e-12 * fit.slope.value.abs())
            .map(|fit| format!("{} ({:.0} %)", fit.law.name(), 100.0 * fit.power))
            .collect();
        if !c.bends && !hidden.is_empty() {
            line(out, &format!("  power too small to detect the bend of: {}", hidden.join(", ")));
        }
    }
}

/// Formats a p-value: with two decimals from 0.1 on, with three from 0.001 on, and with an exponent below.
fn p_value(p: f64) -> String {
    match p {
        p if p >= 0.1 => format!("{p:.2}"),
        p if p >= 0.001 => format!("{p:.3}"),
        p => format!("{p:.1e}"),
    }
}

impl Equivalence {
    fn write(&self, out: &mut String) {
        line(
            out,
            &format!(
                "  mean depth {}; slope per doubling of the size {} (90 %), over {} levels of {} runs",
                short(self.mean),
                interval(&self.slope),
                self.rows,
                self.runs
            ),
        );
        line(
            out,
            &format!(
                "  margin, stated in advance: {} % of the mean = {} per doubling; p = {}; smallest margin that would \
                 pass: {} %",
                short(100.0 * self.margin),
                short(self.margin_steps),
                p_value(self.p),
                short(100.0 * self.smallest_margin)
            ),
        );
    }
}

impl Series {
    fn write_conclusion(&self, out: &mut String) {
        if !self.not_excluded.is_empty() {
            let shares: Vec<String> = self.not_excluded.iter().map(NotExcluded::words).collect();
            line(
                out,
                &format!(
                    "  largest shares of faster laws that are not excluded, at the largest size: {}",
                    shares.join(", ")
                ),
            );
        }
        if let Some(power) = &self.power {
            line(out, &format!("  y = a + b n^e, e = 0 for log n: e = {}", power.words()));
        }
        line(out, &format!("  conclusion: {}", self.words));
        let Some(r) = &self.resampled else { return };
        let same = 100.0 * r.same_conclusion;
        let rest = if self.levels.is_some() {
            format!("flat in {:.1} %, sloped in {:.1} %", 100.0 * r.flat, 100.0 * r.bends)
        } else {
            format!("bends upwards in {:.1} %", 100.0 * r.bends)
        };
        line(out, &format!("  of {} resamplings: the same conclusion in {same:.1} %; {rest}", r.times));
    }
}

/// Returns the speed-up as a table.
pub fn speedup_table(rows: &[SpeedupRow]) -> String {
    let mut out = String::new();
    line(&mut out, "speed-up relative to the best serial run on the same points, medians over seeds");
    line(
        &mut out,
        &format!(
            "  {:<28} {:>10} {:>8} {:>8} {:>5} {:>10} {:>10} {:>9} {:>15} {:>10}",
            "set", "n", "workers", "threads", "runs", "seconds", "serial", "speed-up", "spread", "efficiency"
        ),
    );
    for row in rows {
        let spread = format!("{:.2} to {:.2}", row.spread.0, row.spread.1);
        line(
            &mut out,
            &format!(
                "  {:<28} {:>10} {:>8} {:>8} {:>5} {:>10.4} {:>10.4} {:>9.2} {spread:>15} {:>10.2}",
                row.set,
                row.n,
                row.workers,
                row.threads,
                row.runs,
                row.seconds,
                row.serial_seconds,
                row.speedup,
                row.efficiency
            ),
        );
    }
    out
}

fn line(out: &mut String, text: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{text}");
}
