//! Triangulations in periodic boxes: one cell of each class of translated cells.

use septet_core::result::periodic::PeriodicCells;
use septet_core::{Outcome, cores};
use septet_queries::NONE;

use crate::failure::Failure;

/// A vertex of a facet: the row, and the numbers of lengths to its image.
type Vertex = (u32, [i32; 3]);

/// Number of rows whose facets one core sorts in turn.
const BLOCK: usize = 1 << 12;

/// The cells of a triangulation in a periodic box.
#[derive(Clone, Debug)]
pub(crate) struct Folded {
    /// Number of coordinates.
    pub(crate) columns: usize,
    /// The rows of points.
    pub(crate) points: Vec<f64>,
    /// The rows of cells, in canonical order.
    pub(crate) cells: Vec<u32>,
    /// The cell across the facet opposite each vertex.
    pub(crate) neighbours: Vec<u32>,
    /// `columns` numbers of lengths for each vertex of a cell.
    pub(crate) offsets: Vec<i32>,
    /// Coincident points, and the first point at each place.
    pub(crate) duplicates: Vec<[u32; 2]>,
    /// Dimension of the affine hull of the points and their images.
    pub(crate) dimension: isize,
    /// Whether the cells are a simplicial complex.
    pub(crate) is_simplicial: bool,
    /// The smallest number of boxes along each axis whose triangulation is one.
    pub(crate) sheets: Vec<u32>,
}

impl Folded {
    /// Takes the cells of a run in a periodic box.
    ///
    /// # Errors
    /// Fails if the run has no box, or more cells than 32-bit indices can address.
    pub(crate) fn of(points: &[f64], columns: usize, run: &Outcome) -> Result<Self, Failure> {
        let Some(part) = &run.kept.periodic else {
            return Err(Failure::usage("the run has no periodic box"));
        };
        if run.cell_count() >= NONE as usize {
            return Err(Failure::new(
                septet_core::Code::Limit,
                format!("there are {} cells, but {} can be addressed", run.cell_count(), NONE - 1),
            ));
        }
        let cells: Vec<u32> = run.cells().iter().map(|&row| row as u32).collect();
        let offsets = PeriodicCells::offsets(part);
        let neighbours = neighbours((&cells, &offsets), columns, points.len() / columns);
        Ok(Folded {
            columns,
            points: points.to_vec(),
            neighbours,
            cells,
            offsets,
            duplicates: run.left_out.duplicates.iter().map(|&(own, of)| [own as u32, of as u32]).collect(),
            dimension: run.dimension,
            is_simplicial: part.is_simplicial,
            sheets: part.sheets.clone(),
        })
    }

    /// Returns the smallest cell of each point: that of its vertex for a duplicate, or [`NONE`].
    pub(crate) fn vertex_cells(&self) -> Vec<u32> {
        let mut first = vec![NONE; self.points.len() / self.columns];
        for (at, &v) in self.cells.iter().enumerate().rev() {
            first[v as usize] = (at / (self.columns + 1)) as u32;
        }
        for &[point, of] in &self.duplicates {
            first[point as usize] = first[of as usize];
        }
        first
    }

    /// Returns the area or volume of each cell, given the lengths of the box. Edges are rounded.
    pub(crate) fn volumes(&self, lengths: &[Option<f64>]) -> Vec<f64> {
        let d = self.columns;
        let cells = self.cells.chunks_exact(d + 1).zip(self.offsets.chunks_exact(d * (d + 1)));
        let one = |(cell, offsets): (&[u32], &[i32])| {
            let along = |corner: usize, axis: usize| {
                let [x, first] = [cell[corner], cell[0]].map(|v| self.points[v as usize * d + axis]);
                let steps = offsets[corner * d + axis] - offsets[axis];
                let length = lengths.get(axis).copied().flatten().unwrap_or(0.0);
                (x - first) + f64::from(steps) * length
            };
            let edge = |corner: usize| [0, 1, 2].map(|axis| if axis < d { along(corner, axis) } else { 0.0 });
            let [a, b] = [1, 2].map(edge);
            if d == 2 {
                return (a[0] * b[1] - a[1] * b[0]) / 2.0;
            }
            let c = edge(3);
            let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
            (a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)) / 6.0
        };
        cells.map(one).collect()
    }
}

/// Returns the cell across the facet opposite each vertex, or [`NONE`] on the hull. Facets are equal if a translation moves one to
/// the other: their vertices are sorted, which no translation changes, and then the first one has the offset 0. Facets are sorted by
/// buckets, one for each smallest row.
fn neighbours((cells, offsets): (&[u32], &[i32]), columns: usize, rows: usize) -> Vec<u32> {
    let corners = columns + 1;
    let smallest = |slot: usize| {
        let first = slot - slot % corners;
        let others = (first..first + corners).filter(|&at| at != slot);
        others.map(|at| cells[at] as usize).min().unwrap_or(0)
    };
    // `ends` holds the position of the next facet of each bucket, and finally the end of each bucket.
    let mut ends = vec![0; rows + 1];
    (0..cells.len()).for_each(|slot| ends[smallest(slot) + 1] += 1);
    (0..rows).for_each(|row| ends[row + 1] += ends[row]);
    let mut order = vec![0; cells.len()];
    for slot in 0..cells.len() {
        let end = &mut ends[smallest(slot)];
        order[*end] = slot;
        *end += 1;
    }
    let pairs = cores::map_blocks(rows, BLOCK, |block| {
        let (mut facets, mut pairs) = (Vec::new(), Vec::new());
        for row in block {
            let start = row.checked_sub(1).map_or(0, |before| ends[before]);
            facets.clear();
            facets.extend(
                order[start..ends[row]].iter().map(|&slot| (facet((cells, offsets), columns, slot), slot)),
            );
            facets.sort_unstable();
            let equal = facets.windows(2).filter(|pair| pair[0].0 == pair[1].0);
            pairs.extend(equal.map(|pair| [pair[0].1, pair[1].1]));
        }
        pairs
    });
    let mut across = vec![NONE; cells.len()];
    for [one, other] in pairs.into_iter().flatten() {
        across[one] = (other / corners) as u32;
        across[other] = (one / corners) as u32;
    }
    across
}

/// Returns the facet opposite a vertex of a cell, moved so that its first vertex has the offset 0. In the plane, the last entry is
/// unused.
fn facet((cells, offsets): (&[u32], &[i32]), columns: usize, slot: usize) -> [Vertex; 3] {
    let first = slot - slot % (columns + 1);
    let mut facet = [(NONE, [0; 3]); 3];
    for (to, at) in facet.iter_mut().zip((first..=first + columns).filter(|&at| at != slot)) {
        let steps = [0, 1, 2].map(|axis| if axis < columns { offsets[at * columns + axis] } else { 0 });
        *to = (cells[at], steps);
    }
    facet.sort_unstable();
    let base = facet[0].1;
    for (_, steps) in facet.iter_mut().filter(|vertex| vertex.0 != NONE) {
        *steps = [0, 1, 2].map(|axis| steps[axis] - base[axis]);
    }
    facet
}
