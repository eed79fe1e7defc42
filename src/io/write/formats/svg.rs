//! `.svg` files: a picture of a triangulation in the plane, with y upward.
//!
//! The longer side of the points is 1000 units long, and positions have three digits after the point. Edges are one path and
//! hull edges a second, thicker one. The triangles of a mesh of a domain are filled by region, and its segments take the place of
//! the hull. Colours are literal attributes, because not all programs know style sheets. Strokes are a twentieth of the mean
//! distance of points, and at most one unit. Up to 2000 points are drawn as dots.

use std::io::Write;
use std::ops::Range;

use septet_core::model::{Labels, MeshView};

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_integer, write_range, write_records};
use crate::write::topology;

/// Length of the longer side of the points.
const SIDE: f64 = 1000.0;

/// Distance between the points and the border.
const MARGIN: f64 = 10.0;

/// The largest number of points that are drawn as dots.
const MOST_DOTS: usize = 2000;

/// Colours of regions, in turn.
const REGIONS: [&str; 8] =
    ["#cfe3f6", "#fbe3bf", "#d5eccf", "#f5cfd2", "#e3d5f0", "#cdeceb", "#f3e9a9", "#e2e2de"];

/// Returns the number of records: cells for the edges, and again for the regions, and points.
pub fn records(mesh: &MeshView<'_>) -> u64 {
    let cells = mesh.cell_count() as u64;
    mesh.point_count() as u64 + if mesh.labels.is_some() { 2 * cells } else { cells }
}

/// Writes a picture.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    if mesh.dimension != 2 {
        return Err(WriteFault::OnlyPlane);
    }
    let frame = Frame::of(mesh);
    let [width, height] = frame.size.map(|side| side + 2.0 * MARGIN);
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">",
        text(width),
        text(height)
    )?;
    writeln!(out, "<title>{} points, {} triangles</title>", mesh.point_count(), mesh.cell_count())?;
    let stroke = stroke(mesh, frame.size);
    let thick = mesh.labels.map_or(1.5, |_| 2.5) * stroke;
    if let Some(labels) = mesh.labels {
        regions(out, (mesh, labels), &frame, progress)?;
    }
    let color = "fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\"";
    write!(out, "<path {color} stroke=\"#4a5560\" stroke-width=\"{}\" d=\"", text(stroke))?;
    let hull = topology::hull(2, mesh.point_count(), mesh.cells)?;
    edges(out, mesh, &frame, progress)?;
    // An edge of the hull belongs to one cell, which may have it in the other direction.
    let reverse = |edge: &[u64]| edge[0] > edge[1];
    let rest: Vec<u64> =
        hull.as_chunks::<2>().0.iter().filter(|edge| reverse(&edge[..])).flatten().copied().collect();
    pairs(out, &rest, &frame)?;
    writeln!(out, "\"/>")?;
    write!(out, "<path {color} stroke=\"#16202a\" stroke-width=\"{}\" d=\"", text(thick))?;
    pairs(out, mesh.labels.map_or(&hull, |labels| &labels.faces.vertices), &frame)?;
    writeln!(out, "\"/>")?;
    dots(out, mesh, &frame, (stroke, progress))?;
    writeln!(out, "</svg>")?;
    Ok(())
}

/// Fills the triangles of each region with its colour.
fn regions(
    out: &mut dyn Write,
    (mesh, labels): (&MeshView<'_>, &Labels),
    frame: &Frame<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let mut rows: Vec<usize> = (0..mesh.cell_count()).collect();
    rows.sort_by_key(|&row| labels.regions.get(row));
    let region = |row: &usize| labels.regions.get(*row).copied().unwrap_or_default();
    let mut start = 0;
    for group in rows.chunk_by(|a, b| region(a) == region(b)) {
        let number = group.first().map_or(0, region);
        let color = REGIONS[number.saturating_sub(1) as usize % REGIONS.len()];
        write!(out, "<path fill=\"{color}\" d=\"")?;
        let range: Range<usize> = start..start + group.len();
        write_range(out, range, progress, |buffer, i| {
            let row = &mesh.cells[3 * rows[i]..][..3];
            for (command, &vertex) in [b'M', b'L', b'L'].iter().zip(row) {
                frame.push(buffer, *command, vertex);
            }
            buffer.extend_from_slice(b"Z\n");
        })?;
        writeln!(out, "\"/>")?;
        start += group.len();
    }
    Ok(())
}

/// Writes each edge of a cell with ascending ends. An edge inside has one cell on each side, and is written once.
fn edges(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    frame: &Frame<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_records(out, mesh.cell_count(), progress, |buffer, cell| {
        let row = &mesh.cells[3 * cell..][..3];
        for (a, b) in [(row[0], row[1]), (row[1], row[2]), (row[2], row[0])] {
            if a < b {
                frame.push(buffer, b'M', a);
                frame.push(buffer, b'L', b);
                buffer.push(b'\n');
            }
        }
    })?;
    Ok(())
}

/// Writes edges, two vertices for each.
fn pairs(out: &mut dyn Write, vertices: &[u64], frame: &Frame<'_>) -> Result<(), WriteFault> {
    let mut buffer = Vec::new();
    for edge in vertices.as_chunks::<2>().0 {
        frame.push(&mut buffer, b'M', edge[0]);
        frame.push(&mut buffer, b'L', edge[1]);
        buffer.push(b'\n');
    }
    Ok(out.write_all(&buffer)?)
}

/// Draws points as dots, if there are few or if there are no cells.
fn dots(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    frame: &Frame<'_>,
    (stroke, progress): (f64, &mut WriteProgress<'_>),
) -> Result<(), WriteFault> {
    let points = mesh.point_count();
    if points > MOST_DOTS && mesh.cell_count() > 0 {
        progress.advance(points as u64);
        return Ok(());
    }
    let style = "fill=\"none\" stroke=\"#16202a\" stroke-linecap=\"round\"";
    write!(out, "<path {style} stroke-width=\"{}\" d=\"", text(4.0 * stroke))?;
    write_records(out, points, progress, |buffer, i| {
        if frame.has(i as u64) {
            frame.push(buffer, b'M', i as u64);
            buffer.extend_from_slice(b"h0\n");
        }
    })?;
    writeln!(out, "\"/>")?;
    Ok(())
}

/// Returns the width of a stroke: a twentieth of the mean distance of points, between a hundredth and one unit.
fn stroke(mesh: &MeshView<'_>, [width, height]: [f64; 2]) -> f64 {
    let cells = mesh.cell_count().max(1) as f64;
    (0.05 * (2.0 * width * height / cells).sqrt()).clamp(0.01, 1.0)
}

/// The map from points to the picture.
struct Frame<'a> {
    coordinates: &'a [f64],
    /// Half of the least x, and half of the largest y.
    corner: [f64; 2],
    /// Half of the longer side of the points.
    half: f64,
    /// The sides of the points in the picture.
    size: [f64; 2],
}

impl<'a> Frame<'a> {
    fn of(mesh: &MeshView<'a>) -> Self {
        let coordinates = mesh.coordinates;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in coordinates.as_chunks::<2>().0.iter().filter(|point| is_finite(&point[..])) {
            for axis in 0..2 {
                // Halves keep differences in range.
                low[axis] = low[axis].min(point[axis] / 2.0);
                high[axis] = high[axis].max(point[axis] / 2.0);
            }
        }
        let sides = [0, 1].map(|axis| (high[axis] - low[axis]).max(0.0));
        let half = sides[0].max(sides[1]);
        let half = if half > 0.0 { half } else { 1.0 };
        Frame { coordinates, corner: [low[0], high[1]], half, size: sides.map(|side| SIDE * (side / half)) }
    }

    /// Returns the coordinates of a point.
    fn point(&self, vertex: u64) -> &[f64] {
        &self.coordinates[2 * vertex as usize..][..2]
    }

    /// Whether a point has a place in the picture.
    fn has(&self, vertex: u64) -> bool {
        is_finite(self.point(vertex))
    }

    /// Appends a command of a path with the position of a point.
    fn push(&self, buffer: &mut Vec<u8>, command: u8, vertex: u64) {
        let point = self.point(vertex);
        let x = (point[0] / 2.0 - self.corner[0]) / self.half;
        let y = (self.corner[1] - point[1] / 2.0) / self.half;
        buffer.push(command);
        push_fixed(buffer, MARGIN + SIDE * x);
        buffer.push(b' ');
        push_fixed(buffer, MARGIN + SIDE * y);
    }
}

fn is_finite(point: &[f64]) -> bool {
    point.iter().all(|x| x.is_finite())
}

/// Appends a positive number with at most three digits after the point.
fn push_fixed(buffer: &mut Vec<u8>, value: f64) {
    let thousandths = (value * 1000.0).round().max(0.0) as u64;
    push_integer(buffer, thousandths / 1000);
    let rest = thousandths % 1000;
    if rest > 0 {
        buffer.push(b'.');
        let digits = [rest / 100, rest / 10 % 10, rest % 10];
        let used = digits.iter().rposition(|digit| *digit > 0).map_or(0, |last| last + 1);
        buffer.extend(digits[..used].iter().map(|digit| b'0' + *digit as u8));
    }
}

/// Returns a positive number as [`push_fixed`] writes it.
fn text(value: f64) -> String {
    let mut buffer = Vec::new();
    push_fixed(&mut buffer, value);
    String::from_utf8_lossy(&buffer).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(coordinates: &[f64], cells: &[u64], labels: Option<&Labels>) -> String {
        let mesh = MeshView {
            dimension: 2,
            coordinates,
            heights: None,
            cells,
            owner: None,
            owning_leaf: None,
            run: None,
            labels,
        };
        let mut out = Vec::new();
        let mut report = |done: u64, total: u64| assert!(done <= total);
        let mut progress = WriteProgress::new(records(&mesh), &mut report);
        write(&mut out, &mesh, &mut progress).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// Two triangles of a rectangle that is twice as wide as high.
    #[test]
    fn every_edge_is_drawn_once_with_y_upward() {
        let picture = written(&[0., 0., 2., 0., 2., 1., 0., 1.], &[0, 1, 2, 0, 2, 3], None);
        assert!(picture.contains("viewBox=\"0 0 1020 520\""), "{picture}");
        let paths: Vec<&str> = picture.split(" d=\"").skip(1).map(|p| p.split('"').next().unwrap()).collect();
        let [edges, hull, dots] = paths[..] else { panic!("{picture}") };
        let mut lines: Vec<&str> = edges.lines().collect();
        lines.sort_unstable();
        let expected =
            ["M10 10L10 510", "M10 510L1010 10", "M10 510L1010 510", "M1010 10L10 10", "M1010 510L1010 10"];
        let turned = |line: &str| {
            let (a, b) = line[1..].split_once('L').unwrap();
            if a < b { format!("M{a}L{b}") } else { format!("M{b}L{a}") }
        };
        let same = |lines: &[&str]| {
            let mut all: Vec<String> = lines.iter().map(|line| turned(line)).collect();
            all.sort_unstable();
            all
        };
        assert_eq!(same(&lines), same(&expected));
        assert_eq!((hull.lines().count(), dots.lines().count()), (4, 4));
    }

    #[test]
    fn few_points_and_points_on_a_line_are_dots() {
        assert!(written(&[], &[], None).contains("viewBox=\"0 0 20 20\""));
        let line = written(&[1e308, 0., -1e308, 0.], &[], None);
        assert!(line.contains("M1010 10h0") && line.contains("M10 10h0"), "{line}");
        assert!(written(&[5.0, 5.0], &[], None).contains("M10 10h0"));
        assert!(!written(&[f64::NAN, 0., 1., 1.], &[], None).contains("NaN"));
    }

    #[test]
    fn regions_have_colours_and_segments_are_thick() {
        let mut labels = Labels { regions: vec![2, 1], ..Labels::default() };
        labels.faces.vertices = vec![0, 2];
        let picture = written(&[0., 0., 1., 0., 1., 1., 0., 1.], &[0, 1, 2, 0, 2, 3], Some(&labels));
        let first = picture.find(REGIONS[0]).unwrap();
        assert!(first < picture.find(REGIONS[1]).unwrap());
        assert!(picture.contains("d=\"M10 1010L1010 10\n\"/>"), "{picture}");
    }

    #[test]
    fn numbers_have_three_digits() {
        for (value, expected) in [(0.0, "0"), (10.0, "10"), (0.05, "0.05"), (1.2346, "1.235"), (9.9999, "10")]
        {
            assert_eq!(text(value), expected);
        }
    }
}
