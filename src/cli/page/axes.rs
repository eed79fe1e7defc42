//! Axes: the positions and labels of ticks.

/// Formats a number with an SI prefix or an exponent.
pub(super) fn si(x: f64) -> String {
    let size = x.abs();
    let (value, unit) = match size {
        s if s >= 1e12 => (x / 1e12, "T"),
        s if s >= 1e9 => (x / 1e9, "G"),
        s if s >= 1e6 => (x / 1e6, "M"),
        s if s >= 1e3 => (x / 1e3, "k"),
        s if s >= 1e-2 || s == 0.0 => (x, ""),
        _ => (x * 1e3, "m"),
    };
    let text = if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.2}") };
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if unit.is_empty() { text.to_owned() } else { format!("{text}\u{202f}{unit}") }
}

/// Formats a whole number with its digits in groups of three.
pub(super) fn grouped(x: f64) -> String {
    let digits = format!("{:.0}", x.abs());
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    if x < 0.0 { format!("−{out}") } else { out }
}

/// A linear or logarithmic axis, drawn between two pixel positions.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) log: bool,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) pixels: (f64, f64),
}

impl Axis {
    /// Returns an axis that contains all values with a small margin.
    pub(super) fn around(
        label: &str,
        log: bool,
        values: impl Iterator<Item = f64>,
        pixels: (f64, f64),
    ) -> Self {
        let fits = |v: &f64| v.is_finite() && (!log || *v > 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for v in values.filter(fits) {
            (low, high) = (low.min(v), high.max(v));
        }
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        if log {
            let room = (high / low).powf(0.06).max(1.3);
            (low, high) = (low / room, high * room);
        } else {
            low = low.min(0.0);
            high = if high > low { high + 0.06 * (high - low) } else { low + 1.0 };
        }
        Axis { label: label.to_owned(), log, low, high, pixels }
    }

    /// Returns the pixel position of a value.
    pub(super) fn at(&self, value: f64) -> f64 {
        let part = if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.pixels.0 + part * (self.pixels.1 - self.pixels.0)
    }

    /// Returns three to eight round values as ticks.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let logarithmic = if self.log { self.log_ticks() } else { Vec::new() };
        // A logarithmic axis over less than a factor of two has too few round values.
        if logarithmic.len() < 3 { self.linear_ticks() } else { logarithmic }
    }

    fn linear_ticks(&self) -> Vec<f64> {
        let rough = (self.high - self.low) / 5.0;
        let power = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(power);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    fn log_ticks(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let stride = (decades / 7.0).ceil().max(1.0) as i32;
        let within: &[f64] = if decades < 1.2 {
            &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0]
        } else if decades < 2.6 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let powers = (first..=last).filter(|e| e.rem_euclid(stride) == 0);
        let all = powers.flat_map(|e| within.iter().map(move |m| m * 10f64.powi(e)));
        all.filter(|v| *v >= self.low && *v <= self.high).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_inside() {
        for (low, high) in [(1.0, 9.0), (0.5, 3e9), (1000.0, 1100.0), (3.0, 700.0)] {
            for log in [true, false] {
                let axis = Axis::around("", log, [low, high].into_iter(), (0.0, 500.0));
                let ticks = axis.ticks();
                assert!((2..=12).contains(&ticks.len()), "{low} {high} {log}: {ticks:?}");
                assert!(ticks.iter().all(|&t| (0.0..=500.0).contains(&axis.at(t))));
            }
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [1.0, 1500.0, 2e6, 0.25, 123_456.0].map(si),
            ["1", "1.5\u{202f}k", "2\u{202f}M", "0.25", "123\u{202f}k"]
        );
        assert_eq!(grouped(1_234_567.0), "1\u{202f}234\u{202f}567");
    }
}
