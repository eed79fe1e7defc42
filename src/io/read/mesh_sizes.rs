//! Sizes on a mesh: given at its points and linear in its cells.
//!
//! **Statement.** A size field is a list of sizes `h_i` at points `x_i`. The size function of a mesh to be made is the
//! largest function of slope L below all `h_i + L |x - x_i|`, so that a list needs points where sizes are small. Cells are
//! bisected at midpoints of edges, with the mean of the sizes at the ends, until no edge is longer than the smaller size
//! at its ends. Then the function exceeds the linear one by at most a factor of 1 + L.
//!
//! **Proof.** Let x be in a cell, with barycentric coordinates `c_i`. The function at x is at most the mean of
//! `h_i + L |x - x_i|` with the weights `c_i`. The distance `|x - x_i|` is at most the mean of `|x_j - x_i| <= h_j` with the
//! weights `c_j`, which is the linear function at x. A bisection halves an edge and leaves the linear function as it is,
//! so it ends.

use glam::DVec3;
use septet_core::mesh::field::SizeField;
use septet_core::model::Points;

use super::cells::CellOptions;
use super::error::{InputError, Place};
use super::mesh::FileMesh;
use super::size_rows;
use super::text::Source;

/// The largest number of points of a field.
const MOST: usize = 5_000_000;

/// A point with its size.
type Node = ([f64; 3], f64);

/// Returns the field of a mesh with these sizes at its points.
pub(super) fn field(source: Source<'_>, mesh: FileMesh<'_>, sizes: &[f64]) -> Result<SizeField, InputError> {
    let (points, cells) = mesh.into_both(&CellOptions::default())?;
    let places: Vec<[f64; 3]> = match &points.points {
        Points::Space(points) => points.iter().map(DVec3::to_array).collect(),
        Points::Plane(points) => points.iter().map(|p| [p.x, p.y, 0.0]).collect(),
        Points::Higher(_) => Vec::new(),
    };
    if sizes.len() != places.len() || places.is_empty() {
        let (expected, found) = (places.len().max(1) as u64, sizes.len() as u64);
        return Err(source.truncated(Place::Whole, "sizes at points", expected, found));
    }
    let is_plane = cells.dimension == 2 && places.iter().all(|p| p[2] == 0.0);
    let mut field = SizeField { dimension: if is_plane { 2 } else { 3 }, rows: Vec::new() };
    let width = field.dimension + 1;
    for (i, (place, size)) in places.iter().zip(sizes).enumerate() {
        let row = [place[0], place[1], if is_plane { *size } else { place[2] }, *size];
        size_rows::push(&mut field, &row[..width], |at, expected| {
            let what = format!("point {i} with {}", row[at]);
            source.unsupported(Place::Whole, what, format!("give {expected}"))
        })?;
    }
    for cell in cells.cells.chunks_exact(cells.dimension + 1) {
        let cell: Vec<Node> = cell.iter().map(|&v| (places[v as usize], sizes[v as usize])).collect();
        divide(cell, &mut field.rows);
        if field.rows.len() > MOST {
            field.rows = distinct(std::mem::take(&mut field.rows));
        }
        if field.rows.len() > MOST {
            let what = format!("a size field that needs more than {MOST} points");
            return Err(source.unsupported(
                Place::Whole,
                what,
                "give larger sizes, or a finer mesh where they are small",
            ));
        }
    }
    field.rows = distinct(field.rows);
    Ok(field)
}

/// Adds the midpoints of a cell that is bisected until no edge is longer than a size at its ends.
fn divide(cell: Vec<Node>, rows: &mut Vec<Node>) {
    let mut waiting = vec![cell];
    while let Some(cell) = waiting.pop() {
        let Some([i, j]) = longest(&cell) else { continue };
        let (a, b) = (cell[i], cell[j]);
        let middle = (std::array::from_fn(|k| a.0[k] / 2.0 + b.0[k] / 2.0), a.1 / 2.0 + b.1 / 2.0);
        rows.push(middle);
        if rows.len() > 2 * MOST {
            return;
        }
        for end in [i, j] {
            let mut half = cell.clone();
            half[end] = middle;
            waiting.push(half);
        }
    }
}

/// Returns the longest of the edges that are longer than the smaller size at their ends.
fn longest(cell: &[Node]) -> Option<[usize; 2]> {
    let mut found: Option<(f64, [usize; 2])> = None;
    for i in 0..cell.len() {
        for j in i + 1..cell.len() {
            let square: f64 = (0..3).map(|k| (cell[i].0[k] - cell[j].0[k]).powi(2)).sum();
            let size = cell[i].1.min(cell[j].1);
            if square > size * size && found.is_none_or(|(most, _)| square > most) {
                found = Some((square, [i, j]));
            }
        }
    }
    found.map(|(_, edge)| edge)
}

/// Sorts the rows, and keeps the smallest size of each point.
fn distinct(mut rows: Vec<Node>) -> Vec<Node> {
    let key = |row: &Node| [row.0[0], row.0[1], row.0[2], row.1];
    rows.sort_unstable_by(|a, b| {
        let pairs = key(a).into_iter().zip(key(b));
        pairs.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    rows.dedup_by(|later, first| later.0 == first.0);
    rows
}
