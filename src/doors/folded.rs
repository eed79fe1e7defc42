//! Triangulations in periodic boxes: one cell of each class of translated cells.

use septet_core::result::periodic::PeriodicCells;
use septet_core::{Outcome, cores};
use septet_queries::{NONE, volumes_in_box};

use crate::failure::Failure;
use crate::rows::Rows;

/// A vertex of a facet: the row, and the numbers of lengths to its image.
type Vertex = (u32, [i32; 3]);

/// Number of rows whose facets one core sorts in turn, and of items of a serial loop between two looks at the flag of the call.
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
        // The run does not keep these rows.
        let cells = cores::map(&part.rows(), |&row| row as u32);
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

    /// Returns the area or volume of each cell, given the lengths of the box, with a relative error below 1e-15.
    ///
    /// # Errors
    /// Fails if there are not 2 or 3 columns.
    pub(crate) fn volumes(&self, lengths: &[Option<f64>]) -> Result<Vec<f64>, Failure> {
        let cells = (&self.cells[..], &self.offsets[..]);
        Ok(match Rows::of(&self.points, self.columns)? {
            Rows::Plane(points) => volumes_in_box(points, cells, lengths),
            Rows::Space(points) => volumes_in_box(points, cells, lengths),
        })
    }
}

/// Calls `f` with the numbers below `count` in order. Ends the call between blocks if its flag is set.
fn in_order(count: usize, mut f: impl FnMut(usize)) {
    for first in (0..count).step_by(BLOCK) {
        // Before each item, a loop looks at the flag.
        cores::each(1, &|_| {});
        (first..count.min(first + BLOCK)).for_each(&mut f);
    }
}

/// Two facets that a translation moves to each other: their cells, and the positions of the vertices opposite to them.
type Pair = [(u32, u8); 2];

/// Returns the cell across the facet opposite each vertex, or [`NONE`] on the hull. Facets are equal if a translation moves one to
/// the other: their vertices are sorted, which no translation changes, and then the first one has the offset 0. Facets are sorted by
/// buckets, one for each smallest row. A bucket lists the cells that have such facets, each once.
fn neighbours((cells, offsets): (&[u32], &[i32]), columns: usize, rows: usize) -> Vec<u32> {
    let corners = columns + 1;
    let smallest = |cell: usize, opposite: usize| {
        let others = (0..corners).filter(|&corner| corner != opposite);
        others.map(|corner| cells[cell * corners + corner]).min().unwrap_or(0)
    };
    // The first vertex is the smallest one, so that only the facet opposite to it may have another bucket.
    let buckets = |cell: usize| {
        let [first, second] = [smallest(cell, 1), smallest(cell, 0)];
        std::iter::once(first).chain((first != second).then_some(second))
    };
    let count = cells.len() / corners;
    // `ends` holds the position of the next cell of each bucket, and finally the end of each bucket.
    let mut ends = vec![0; rows + 1];
    in_order(count, |cell| buckets(cell).for_each(|row| ends[row as usize + 1] += 1));
    in_order(rows, |row| ends[row + 1] += ends[row]);
    let mut order = vec![0u32; ends[rows]];
    in_order(count, |cell| {
        for row in buckets(cell) {
            let end = &mut ends[row as usize];
            order[*end] = cell as u32;
            *end += 1;
        }
    });
    let pairs = cores::map_blocks(rows, BLOCK, |block| {
        let (mut facets, mut pairs): (_, Vec<Pair>) = (Vec::new(), Vec::new());
        for row in block {
            let start = row.checked_sub(1).map_or(0, |before| ends[before]);
            facets.clear();
            for &cell in &order[start..ends[row]] {
                let own = (0..corners).filter(|&corner| smallest(cell as usize, corner) as usize == row);
                facets.extend(own.map(|corner| {
                    let slot = cell as usize * corners + corner;
                    (facet((cells, offsets), columns, slot), (cell, corner as u8))
                }));
            }
            facets.sort_unstable();
            let equal = facets.windows(2).filter(|pair| pair[0].0 == pair[1].0);
            pairs.extend(equal.map(|pair| [pair[0].1, pair[1].1]));
        }
        pairs
    });
    let mut across = vec![NONE; cells.len()];
    for pairs in pairs {
        in_order(pairs.len(), |at| {
            let [one, other] = pairs[at];
            for ((cell, corner), next) in [(one, other.0), (other, one.0)] {
                across[cell as usize * corners + usize::from(corner)] = next;
            }
        });
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
