//! A grid of coloured cells. The colour scale, with nine steps, is drawn next to it.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::axes::si;
use super::svg::{Drawing, short};

/// Steps of the colour scale.
const STEPS: usize = 9;

/// Values by row and column, and their logarithmic scale.
#[derive(Debug)]
pub(super) struct Cells {
    values: BTreeMap<(u32, u32), f64>,
    low: f64,
    high: f64,
}

impl Cells {
    /// Creates a grid of the cells that have a value.
    pub(super) fn new(values: BTreeMap<(u32, u32), f64>) -> Self {
        let positive = || values.values().copied().filter(|v| *v > 0.0);
        let low = positive().fold(f64::INFINITY, f64::min);
        let high = positive().fold(0.0, f64::max);
        Cells { values, low, high }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.high <= 0.0
    }

    fn step(&self, value: f64) -> usize {
        if self.high <= self.low {
            return STEPS - 1;
        }
        let part = (value / self.low).ln() / (self.high / self.low).ln();
        ((part * STEPS as f64) as usize).min(STEPS - 1)
    }

    /// Draws the cells from `corner`, each of the given size. Each step of the scale is one path, and adjacent cells
    /// in a row are merged.
    pub(super) fn draw(&self, out: &mut Drawing, corner: (f64, f64), size: (f64, f64)) {
        let mut paths = vec![String::new(); STEPS];
        let mut runs: Vec<(u32, u32, u32, usize)> = Vec::new();
        for (&(row, column), &value) in self.values.iter().filter(|(_, v)| **v > 0.0) {
            let step = self.step(value);
            match runs.last_mut() {
                Some(r) if r.0 == row && r.2 == column && r.3 == step => r.2 += 1,
                _ => runs.push((row, column, column + 1, step)),
            }
        }
        for (row, from, to, step) in runs {
            let _ = write!(paths[step], "M{from} {row}h{w}v1h-{w}z", w = to - from);
        }
        let [x, y, w, h] = [corner.0, corner.1, size.0, size.1].map(|v| format!("{v:.4}"));
        out.raw(&format!(
            r#"<g transform="translate({x} {y}) scale({w} {h})" shape-rendering="crispEdges">"#
        ));
        for (step, path) in paths.iter().enumerate().filter(|(_, p)| !p.is_empty()) {
            out.raw(&format!(r#"<path class="s{step}" d="{path}"/>"#));
        }
        out.raw("</g>");
    }

    /// Draws the scale upwards: nine steps, with the values between them.
    pub(super) fn scale(&self, out: &mut Drawing, at: (f64, f64), label: &str) {
        let (step, ratio) = (18.0, self.high / self.low);
        out.text("legend", (at.0, at.1), "start", label);
        let top = at.1 + 14.0;
        for i in 0..STEPS {
            let y = top + step * (STEPS - 1 - i) as f64;
            out.rect(&format!("s{i}"), (at.0, y), (20.0, step));
        }
        for i in 0..=STEPS {
            let value = self.low * ratio.powf(i as f64 / STEPS as f64);
            let y = top + step * (STEPS - i) as f64 + 4.0;
            if i % 3 == 0 {
                out.text("tick", (at.0 + 27.0, y), "start", &si(value));
            }
        }
        let y = short(top);
        let h = short(step * STEPS as f64);
        out.raw(&format!(
            r#"<rect class="outline" x="{x}" y="{y}" width="20" height="{h}"/>"#,
            x = short(at.0)
        ));
    }
}
