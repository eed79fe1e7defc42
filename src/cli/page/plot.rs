//! A plot of marks and lines with two axes and a legend next to it.

use super::axes::{Axis, si};
use super::svg::Drawing;

/// A series of marks, lines, or both.
#[derive(Clone, Debug, Default)]
pub(super) struct PlotSeries {
    pub(super) name: String,
    /// Additional lines in the legend.
    pub(super) notes: Vec<String>,
    pub(super) marks: Vec<(f64, f64)>,
    /// Whether lines connect the marks in order.
    pub(super) joined: bool,
    /// The fitted law.
    pub(super) fit: Vec<(f64, f64)>,
    /// The proved law, dashed.
    pub(super) law: Vec<(f64, f64)>,
}

/// A plot.
#[derive(Clone, Debug)]
pub(super) struct Plot<'a> {
    pub(super) x: (&'a str, bool),
    pub(super) y: (&'a str, bool),
    pub(super) series: Vec<PlotSeries>,
}

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 560.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 346.0;

impl Plot<'_> {
    pub(super) fn draw(&self) -> Drawing {
        let all = || self.series.iter().flat_map(|s| &s.marks);
        let x = Axis::around(self.x.0, self.x.1, all().map(|p| p.0), (LEFT, RIGHT));
        let y = Axis::around(self.y.0, self.y.1, all().map(|p| p.1), (BOTTOM, TOP));
        let legend: f64 = self.series.iter().map(PlotSeries::height).sum();
        let mut out = Drawing::new(WIDTH, HEIGHT.max(legend + 60.0));
        frame(&mut out, &x, &y);
        out.raw(&format!(
            r#"<svg x="{LEFT}" y="{TOP}" width="{w}" height="{h}" viewBox="{LEFT} {TOP} {w} {h}">"#,
            w = RIGHT - LEFT,
            h = BOTTOM - TOP
        ));
        for (i, series) in self.series.iter().enumerate() {
            series.draw(i, &x, &y, &mut out);
        }
        out.raw("</svg>");
        let mut at = TOP + 12.0;
        for (i, series) in self.series.iter().enumerate() {
            series.legend(i, at, &mut out);
            at += series.height();
        }
        out
    }
}

/// Draws axes with ticks, grid and labels.
fn frame(out: &mut Drawing, x: &Axis, y: &Axis) {
    for tick in x.ticks() {
        let at = x.at(tick);
        out.line("grid", (at, TOP), (at, BOTTOM));
        out.text("tick", (at, BOTTOM + 17.0), "middle", &si(tick));
    }
    for tick in y.ticks() {
        let at = y.at(tick);
        out.line("grid", (LEFT, at), (RIGHT, at));
        out.text("tick", (LEFT - 8.0, at + 4.0), "end", &si(tick));
    }
    out.line("axis", (LEFT, BOTTOM), (RIGHT, BOTTOM));
    out.line("axis", (LEFT, TOP), (LEFT, BOTTOM));
    out.text("label", (f64::midpoint(LEFT, RIGHT), BOTTOM + 40.0), "middle", &x.label);
    out.upright("label", (18.0, f64::midpoint(TOP, BOTTOM)), "middle", &y.label);
}

impl PlotSeries {
    fn draw(&self, number: usize, x: &Axis, y: &Axis, out: &mut Drawing) {
        let place = |p: &(f64, f64)| (x.at(p.0), y.at(p.1));
        let drawn = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().filter(|p| !(y.log && p.1 <= 0.0)).map(place).collect()
        };
        let colour = number % 7;
        if !self.law.is_empty() {
            out.polyline(&format!("law c{colour}"), &drawn(&self.law));
        }
        if !self.fit.is_empty() {
            out.polyline(&format!("fit c{colour}"), &drawn(&self.fit));
        }
        if self.joined {
            out.polyline(&format!("fit c{colour}"), &drawn(&self.marks));
        }
        let radius = if self.marks.len() > 200 { 2.0 } else { 3.6 };
        let class = if self.marks.len() > 200 { "many" } else { "mark" };
        for at in drawn(&self.marks) {
            out.mark(&format!("{class} c{colour}"), number, at, radius);
        }
    }

    fn height(&self) -> f64 {
        26.0 + 16.0 * self.notes.len() as f64
    }

    fn legend(&self, number: usize, at: f64, out: &mut Drawing) {
        let left = RIGHT + 24.0;
        out.mark(&format!("mark c{}", number % 7), number, (left, at - 4.0), 4.5);
        out.text("legend", (left + 14.0, at), "start", &self.name);
        for (i, note) in self.notes.iter().enumerate() {
            out.text("note", (left + 14.0, at + 16.0 * (i + 1) as f64), "start", note);
        }
    }
}
