//! Histograms of the quality of a mesh.

use std::fmt::Write;

use serde_json::json;

use septet_lab::report::mesh::histogram::HistogramReport;

use super::DataTable;
use super::axes::{Axis, grouped, si};
use super::svg::Drawing;

/// A histogram with its labels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bars<'a> {
    /// The heading.
    pub(crate) title: &'a str,
    /// Name and unit of the abscissa.
    pub(crate) label: &'a str,
    /// Name of the counted items, such as cells.
    pub(crate) of: &'a str,
    /// The counts by interval.
    pub(crate) histogram: &'a HistogramReport,
    /// A bound that the histogram marks.
    pub(crate) bound: Option<f64>,
}

const LEFT: f64 = 76.0;
const RIGHT: f64 = 796.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 274.0;

/// A quantity of a mesh that has a histogram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drawn {
    RadiusEdge,
    Angles,
    LeastAngles,
    LargestAngles,
    Lengths,
    Sizes,
    Degrees,
}

impl Drawn {
    /// Returns the file name without extension.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Drawn::RadiusEdge => "radius-edge",
            Drawn::Angles => "angles",
            Drawn::LeastAngles => "least-angles",
            Drawn::LargestAngles => "largest-angles",
            Drawn::Lengths => "lengths",
            Drawn::Sizes => "sizes",
            Drawn::Degrees => "degrees",
        }
    }

    /// Returns the histogram with its labels. `bound` is the bound on radius-edge ratios.
    pub(crate) fn bars(self, histogram: &HistogramReport, bound: f64) -> Bars<'_> {
        let cells = "cells";
        let of = |title, label, of, bound| Bars { title, label, of, histogram, bound };
        match self {
            Drawn::RadiusEdge => {
                of("Radius-edge ratios", "circumradius over shortest edge", cells, Some(bound))
            }
            Drawn::Angles => of("Angles", "angle [degrees]", "angles", None),
            Drawn::LeastAngles => of("Smallest angles", "smallest angle [degrees]", cells, None),
            Drawn::LargestAngles => of("Largest angles", "largest angle [degrees]", cells, None),
            Drawn::Lengths => {
                of("Edges over size", "length over the smaller size at the ends", "edges", None)
            }
            Drawn::Degrees => of("Degrees", "edges at a vertex", "vertices", None),
            Drawn::Sizes => {
                of("Size over local feature size", "size over local feature size", "points", None)
            }
        }
    }
}

/// Returns the counts as a table.
pub(super) fn table(bars: &Bars<'_>) -> DataTable {
    let h = bars.histogram;
    let mut table = DataTable::new(&["from", "to", bars.of]);
    let ends = [(None, Some(h.from), h.below), (Some(h.to), None, h.above)];
    let [below, above] = ends.map(|(from, to, count)| vec![json!(from), json!(to), json!(count)]);
    table.rows.extend((h.below > 0).then_some(below));
    for (i, count) in h.counts.iter().enumerate() {
        let [from, to] = h.bin(i);
        table.rows.push(vec![json!(from), json!(to), json!(count)]);
    }
    table.rows.extend((h.above > 0).then_some(above));
    table
}

/// Returns the histogram as an SVG file.
pub(crate) fn svg(bars: &Bars<'_>) -> String {
    draw(bars).alone(bars.title)
}

pub(super) fn draw(bars: &Bars<'_>) -> Drawing {
    let h = bars.histogram;
    let mut out = Drawing::new(820.0, 330.0);
    let most = h.counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let across = Axis { label: String::new(), log: false, low: h.from, high: h.to, pixels: (LEFT, RIGHT) };
    let up = Axis::around(bars.of, false, [0.0, most].into_iter(), (BOTTOM, TOP));
    out.rect("plot", (LEFT, TOP), (RIGHT - LEFT, BOTTOM - TOP));
    for tick in up.ticks() {
        out.line("grid", (LEFT, up.at(tick)), (RIGHT, up.at(tick)));
        out.text("tick", (LEFT - 8.0, up.at(tick) + 4.0), "end", &si(tick));
    }
    for tick in across.ticks() {
        out.line("grid", (across.at(tick), TOP), (across.at(tick), BOTTOM));
        out.text("tick", (across.at(tick), BOTTOM + 17.0), "middle", &si(tick));
    }
    for (i, &count) in h.counts.iter().enumerate().filter(|c| *c.1 > 0) {
        let [a, b] = h.bin(i).map(|x| across.at(x));
        let y = up.at(count as f64);
        out.rect("bar c0", (a + 0.5, y), ((b - a - 1.0).max(0.5), BOTTOM - y));
    }
    out.line("axis", (LEFT, BOTTOM), (RIGHT, BOTTOM));
    if let Some(bound) = bars.bound.filter(|b| (h.from..=h.to).contains(b)) {
        let x = across.at(bound);
        out.line("law c2", (x, TOP), (x, BOTTOM));
        out.text("note", (x + 6.0, TOP + 14.0), "start", &format!("bound {bound:.4}"));
    }
    out.text("label", (f64::midpoint(LEFT, RIGHT), BOTTOM + 42.0), "middle", bars.label);
    out.upright("label", (20.0, f64::midpoint(TOP, BOTTOM)), "middle", bars.of);
    let mut total = format!("{} {}", grouped(h.total() as f64), bars.of);
    if let (Some(least), Some(most)) = (h.least, h.most) {
        let _ = write!(total, ", from {} to {}", si(least), si(most));
    }
    out.text("note", (LEFT, TOP - 12.0), "start", &total);
    for (count, x, anchor, word) in [(h.below, LEFT, "start", "below"), (h.above, RIGHT, "end", "above")] {
        if count > 0 {
            let text = format!("{} {word}", grouped(count as f64));
            out.text("note", (x, BOTTOM + 42.0), anchor, &text);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use septet_meshing::quality::histogram::Histogram;

    use super::*;

    #[test]
    fn every_bin_with_counts_has_a_bar() {
        let mut histogram = Histogram::new(0.0, 10.0, 10);
        for x in [0.5, 0.6, 3.5, 9.99, 12.0] {
            histogram.add(x);
        }
        let histogram = HistogramReport::from(&histogram);
        let bars = Bars { title: "A < B", label: "x", of: "cells", histogram: &histogram, bound: Some(4.0) };
        let text = svg(&bars);
        assert_eq!(text.matches("bar c0").count(), 3);
        assert!(text.contains("A &lt; B") && text.contains("bound 4.0000") && text.contains("1 above"));
        assert!(!text.contains(" below") && !text.contains("NaN"));
        let rows = table(&bars).rows;
        assert_eq!(rows.len(), 11);
        assert_eq!(rows.iter().map(|r| r[2].as_u64().unwrap()).sum::<u64>(), 5);
        let beyond = Bars { bound: Some(40.0), ..bars };
        assert!(!svg(&beyond).contains("bound"));
    }
}
