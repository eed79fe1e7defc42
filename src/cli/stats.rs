//! The lines of `--stats`: counts, hull, extent, and a table of degrees and of the quality of cells.

use septet_lab::report::StatsReport;
use septet_lab::report::mesh::histogram::{HistogramReport, PERCENTILES};

use super::summary::row;
use super::text::counted;

/// Width of a column of numbers.
const COLUMN: usize = 9;

/// Formats the numbers of a triangulation in a space of 2 or 3 dimensions.
pub fn lines(stats: &StatsReport, space: usize) -> Vec<String> {
    let cell = if space == 2 { "triangle" } else { "tetrahedron" };
    let facet = if space == 2 { "edge" } else { "triangle" };
    let mut counts = vec![counted(stats.points, "vertex"), counted(stats.edges, "edge")];
    if space == 3 {
        counts.push(counted(stats.facets, facet));
    }
    counts.extend([
        counted(stats.cells, cell),
        counted(stats.components, "component"),
        counted(stats.duplicates, "duplicate"),
    ]);
    let hull = &stats.hull;
    let mut of_hull = vec![counted(hull.facets, facet)];
    if space == 3 {
        of_hull.push(counted(hull.edges, "edge"));
    }
    of_hull.push(counted(hull.vertices, "vertex"));
    let measures = if space == 2 { ["area", "perimeter"] } else { ["volume", "area"] };
    let values = [hull.volume, hull.surface];
    of_hull.extend(measures.into_iter().zip(values).map(|(name, x)| format!("{name} {}", short(x))));
    let axis = |(axis, [low, high]): (&str, &[f64; 2])| format!("{axis} {low:?} to {high:?}");
    let axes: Vec<String> = ["x", "y", "z"].into_iter().zip(&stats.extent).map(axis).collect();
    let mut lines = vec![row("contents", counts.join(", ")), row("hull", of_hull.join(", "))];
    if !axes.is_empty() {
        lines.push(row("extent", axes.join(", ")));
    }
    if stats.cells > 0 {
        lines.extend(table(stats, space));
        lines.extend(slivers(stats, space));
    }
    lines
}

/// Formats the table of degrees and quality, with one column for each percentile.
fn table(stats: &StatsReport, space: usize) -> Vec<String> {
    let quality = &stats.quality;
    let angles = match space {
        2 => ["smallest angle", "largest angle"],
        _ => ["smallest dihedral", "largest dihedral"],
    };
    let rows = [
        ("edges at a vertex", &stats.degrees),
        ("radius-edge ratio", &quality.radius_edge),
        (angles[0], &quality.least_angles),
        (angles[1], &quality.largest_angles),
    ];
    let percent = PERCENTILES.map(|percent| format!("{percent} %"));
    let heads: Vec<String> = ["least", "mean"].map(str::to_owned).into_iter().chain(percent).collect();
    let mut lines = vec![line("", heads.into_iter().chain(["largest".to_owned()]))];
    for (label, histogram) in rows {
        lines.push(line(label, values(histogram).into_iter().map(short)));
    }
    lines
}

/// Returns the least value, the mean, the percentiles and the largest value.
fn values(histogram: &HistogramReport) -> Vec<Option<f64>> {
    let mut values = vec![histogram.least, histogram.mean];
    values.extend(histogram.percentiles.values());
    values.push(histogram.most);
    values
}

fn line(label: &str, cells: impl Iterator<Item = String>) -> String {
    let cells: Vec<String> = cells.map(|cell| format!("{cell:>COLUMN$}")).collect();
    format!("  {label:<17}{}", cells.concat())
}

/// Counts slivers with their definition. A triangle with a small ratio has no small angle.
fn slivers(stats: &StatsReport, space: usize) -> Option<String> {
    let slivers = &stats.quality.slivers;
    let first = slivers.first().filter(|_| space == 3)?;
    let count = |sliver: &septet_lab::report::mesh::SliverReport| {
        format!("{} below {} degrees", super::text::grouped(sliver.cells), sliver.angle)
    };
    let counts: Vec<String> = slivers.iter().map(count).collect();
    let definition = format!(
        "cells with a dihedral angle below the limit and a radius-edge ratio below {}",
        first.radius_edge
    );
    Some(row("slivers", format!("{}: {definition}", counts.join(", "))))
}

/// Formats a number with four digits.
fn short(x: Option<f64>) -> String {
    let Some(x) = x else { return "inf".to_owned() };
    let size = x.abs();
    if x == x.trunc() && size < 1e6 {
        return format!("{x}");
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{x:.3e}");
    }
    let before = size.log10().floor() as i32;
    format!("{x:.*}", (3 - before).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        for (x, expected) in [
            (0.0, "0"),
            (45.0, "45"),
            (0.123_456, "0.1235"),
            (12.345_6, "12.35"),
            (123_456.7, "123457"),
            (1e-9, "1.000e-9"),
            (2.5e300, "2.500e300"),
            (-0.5, "-0.5000"),
        ] {
            assert_eq!(short(Some(x)), expected);
        }
        assert_eq!(short(None), "inf");
    }
}
