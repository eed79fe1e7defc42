//! Neighbours, hull facets and edges of a list of cells.
//!
//! Facets and edges are sorted into one bucket per smallest vertex. This takes little more memory than one index per
//! facet or edge of each cell, and buckets are processed in parallel. Results depend on the cells, but not on the
//! number of threads.

use septet_core::cores::{map_blocks, sort_rows};

use super::buckets::{Buckets, Item};

/// Cells for each unit of parallel work.
const BLOCK: usize = 4096;

/// The value of `neighbours` for a facet on the hull.
pub const OUTSIDE: u64 = u64::MAX;

/// A reason why cells do not form a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TopologyError {
    /// The dimension is not between 2 and 6, or facets are requested above 3.
    #[error("dimension {dimension} is not supported")]
    Dimension {
        /// The dimension.
        dimension: usize,
    },
    /// The number of indices is not a multiple of the number of vertices per cell.
    #[error("{length} indices do not form whole cells")]
    PartialCell {
        /// The number of indices.
        length: usize,
    },
    /// A cell refers to a point that does not exist.
    #[error("cell {cell} has vertex {vertex}, but there are only {points} points")]
    VertexOutOfRange {
        /// The index of the cell.
        cell: u64,
        /// The index.
        vertex: u64,
        /// The number of points.
        points: u64,
    },
    /// A cell has the same vertex twice.
    #[error("cell {cell} has vertex {vertex} twice")]
    RepeatedVertex {
        /// The index of the cell.
        cell: u64,
        /// The vertex.
        vertex: u64,
    },
    /// A facet belongs to more than two cells.
    #[error("the facet {vertices:?} belongs to {count} cells")]
    CrowdedFacet {
        /// The sorted vertices of the facet.
        vertices: Vec<u64>,
        /// The number of its cells.
        count: usize,
    },
    /// Two cells lie on the same side of a common facet.
    #[error("cells {first} and {second} lie on the same side of the facet {vertices:?}")]
    SameSide {
        /// The index of one cell.
        first: u64,
        /// The index of the other cell.
        second: u64,
        /// The sorted vertices of the facet.
        vertices: Vec<u64>,
    },
}

/// The facets of a triangulation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// For each vertex `i` of each cell, the index of the cell across the facet opposite `i`, or [`OUTSIDE`]. Empty if
    /// only the hull was requested.
    pub neighbours: Vec<u64>,
    /// The facets that belong to one cell only, `dimension` vertices each, ordered by their sorted vertices.
    /// Triangles are oriented outward and begin with their smallest vertex. In the plane, edges are directed with the
    /// interior on their left.
    pub hull: Vec<u64>,
}

/// Returns the neighbours of all cells and the hull.
///
/// # Errors
/// Returns a [`TopologyError`] if cells are malformed, a facet belongs to more than two cells, or two cells lie on
/// the same side of a facet.
pub fn adjacency(dimension: usize, point_count: usize, cells: &[u64]) -> Result<Adjacency, TopologyError> {
    facets(dimension, point_count, cells, true)
}

/// Returns the hull facets, as in [`Adjacency::hull`].
///
/// # Errors
/// See [`adjacency`].
pub fn hull(dimension: usize, point_count: usize, cells: &[u64]) -> Result<Vec<u64>, TopologyError> {
    Ok(facets(dimension, point_count, cells, false)?.hull)
}

/// Returns all edges, sorted, smaller vertex first.
///
/// # Errors
/// Returns a [`TopologyError`] if the cells are malformed.
pub fn edges(dimension: usize, point_count: usize, cells: &[u64]) -> Result<Vec<[u64; 2]>, TopologyError> {
    check_cells(dimension, point_count, cells)?;
    if u32::try_from(point_count).is_ok() {
        Ok(edges_with::<u32>(dimension, point_count, cells))
    } else {
        Ok(edges_with::<u64>(dimension, point_count, cells))
    }
}

/// Returns the edges of hull facets, sorted, smaller vertex first.
pub fn hull_edges(dimension: usize, hull: &[u64]) -> Vec<[u64; 2]> {
    let mut edges = Vec::with_capacity(hull.len());
    for facet in hull.chunks_exact(dimension) {
        for (i, &a) in facet.iter().enumerate() {
            edges.extend(facet[i + 1..].iter().map(|&b| [a.min(b), a.max(b)]));
        }
    }
    sort_rows(edges.as_flattened_mut(), 2);
    edges.dedup();
    edges
}

/// Checks that all indices are in range and that the vertices of each cell are distinct.
pub(super) fn check_cells(dimension: usize, point_count: usize, cells: &[u64]) -> Result<(), TopologyError> {
    check(dimension, point_count, cells, false)
}

/// Checks that all indices of periodic cells are in range. Several vertices of a cell may be images of one point.
pub(super) fn check_periodic_cells(
    dimension: usize,
    point_count: usize,
    cells: &[u64],
) -> Result<(), TopologyError> {
    check(dimension, point_count, cells, true)
}

fn check(dimension: usize, point_count: usize, cells: &[u64], may_repeat: bool) -> Result<(), TopologyError> {
    if !(2..=6).contains(&dimension) {
        return Err(TopologyError::Dimension { dimension });
    }
    if !cells.len().is_multiple_of(dimension + 1) {
        return Err(TopologyError::PartialCell { length: cells.len() });
    }
    let points = point_count as u64;
    let corners = dimension + 1;
    let fault = |row: usize| {
        let cell = &cells[row * corners..][..corners];
        if let Some(&vertex) = cell.iter().find(|&&vertex| vertex >= points) {
            return Some(TopologyError::VertexOutOfRange { cell: row as u64, vertex, points });
        }
        let repeated = (1..corners).find(|&i| !may_repeat && cell[..i].contains(&cell[i]));
        repeated.map(|i| TopologyError::RepeatedVertex { cell: row as u64, vertex: cell[i] })
    };
    let faults = map_blocks(cells.len() / corners, BLOCK, |mut rows| rows.find_map(fault));
    faults.into_iter().flatten().next().map_or(Ok(()), Err)
}

/// Returns the facet opposite vertex `i` of a positively oriented cell, oriented outward. In the plane, the facet is
/// an edge and is padded with [`OUTSIDE`].
fn facet(cell: &[u64], i: usize) -> [u64; 3] {
    if cell.len() == 3 {
        return [cell[(i + 1) % 3], cell[(i + 2) % 3], OUTSIDE];
    }
    let [a, b, c] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]][i];
    [cell[a], cell[b], cell[c]]
}

/// Returns the vertices in increasing order, and whether the permutation is odd.
fn sorted([mut a, mut b, mut c]: [u64; 3]) -> ([u64; 3], bool) {
    let mut odd = false;
    let mut order = |x: &mut u64, y: &mut u64| {
        if x > y {
            std::mem::swap(x, y);
            odd = !odd;
        }
    };
    order(&mut a, &mut b);
    order(&mut b, &mut c);
    order(&mut a, &mut b);
    ([a, b, c], odd)
}

fn facets(
    dimension: usize,
    point_count: usize,
    cells: &[u64],
    with_neighbours: bool,
) -> Result<Adjacency, TopologyError> {
    if dimension > 3 {
        return Err(TopologyError::Dimension { dimension });
    }
    check_cells(dimension, point_count, cells)?;
    if u32::try_from(cells.len()).is_ok() {
        facets_with::<u32>(dimension, point_count, cells, with_neighbours)
    } else {
        facets_with::<u64>(dimension, point_count, cells, with_neighbours)
    }
}

/// Pairs the facets of all cells. A facet is identified by the position in `cells` of the vertex opposite it.
fn facets_with<T: Item>(
    dimension: usize,
    point_count: usize,
    cells: &[u64],
    with_neighbours: bool,
) -> Result<Adjacency, TopologyError> {
    let corners = dimension + 1;
    let facet_of = |entry: usize| {
        let row = entry / corners * corners;
        facet(&cells[row..row + corners], entry % corners)
    };
    let buckets = Buckets::<T>::fill(point_count, |visit| {
        for entry in 0..cells.len() {
            visit(sorted(facet_of(entry)).0[0] as usize, entry as u64);
        }
    });
    let mut result = Adjacency::default();
    if with_neighbours {
        result.neighbours = vec![OUTSIDE; cells.len()];
    }
    buckets.for_each_batch(
        |entries, pairs| pair_up(dimension, entries, &facet_of, pairs),
        |pairs| {
            for [first, second] in pairs {
                if second == OUTSIDE {
                    push_hull_facet(&mut result.hull, dimension, facet_of(first as usize));
                } else if with_neighbours {
                    result.neighbours[first as usize] = second / corners as u64;
                    result.neighbours[second as usize] = first / corners as u64;
                }
            }
        },
    )?;
    Ok(result)
}

/// Appends the pairs of entries in a bucket that denote the same facet. A hull facet is paired with [`OUTSIDE`].
fn pair_up<T: Item>(
    dimension: usize,
    entries: &[T],
    facet_of: &impl Fn(usize) -> [u64; 3],
    pairs: &mut Vec<[u64; 2]>,
) -> Result<(), TopologyError> {
    let mut keyed: Vec<([u64; 3], u64, bool)> = entries
        .iter()
        .map(|&entry| {
            let (key, odd) = sorted(facet_of(entry.wide() as usize));
            (key, entry.wide(), odd)
        })
        .collect();
    keyed.sort_unstable();
    for group in keyed.chunk_by(|a, b| a.0 == b.0) {
        let vertices = || group[0].0[..dimension].to_vec();
        match *group {
            [(_, entry, _)] => pairs.push([entry, OUTSIDE]),
            [(_, first, a), (_, second, b)] if a != b => pairs.push([first, second]),
            [(_, first, _), (_, second, _)] => {
                let corners = dimension as u64 + 1;
                let (first, second) = (first / corners, second / corners);
                return Err(TopologyError::SameSide { first, second, vertices: vertices() });
            }
            _ => {
                let count = group.len();
                return Err(TopologyError::CrowdedFacet { vertices: vertices(), count });
            }
        }
    }
    Ok(())
}

fn push_hull_facet(hull: &mut Vec<u64>, dimension: usize, mut facet: [u64; 3]) {
    if dimension == 3 {
        let smallest = (0..3).min_by_key(|&i| facet[i]).unwrap_or(0);
        facet.rotate_left(smallest);
    }
    hull.extend_from_slice(&facet[..dimension]);
}

fn edges_with<T: Item>(dimension: usize, point_count: usize, cells: &[u64]) -> Vec<[u64; 2]> {
    let mut buckets = Buckets::<T>::fill(point_count, |visit| {
        for cell in cells.chunks_exact(dimension + 1) {
            for (i, &a) in cell.iter().enumerate() {
                for &b in &cell[i + 1..] {
                    visit(a.min(b) as usize, a.max(b));
                }
            }
        }
    });
    buckets.sort_each();
    let mut edges = Vec::new();
    for (smaller, larger) in buckets.iter().enumerate() {
        for run in larger.chunk_by(|a, b| a == b) {
            edges.push([smaller as u64, run[0].wide()]);
        }
    }
    edges
}

#[cfg(test)]
#[path = "topology_tests.rs"]
mod tests;
