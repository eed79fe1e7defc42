//! The part of a triangulation that one worker holds, with its ghost cells: a piece of a `.pvtu` file.
//!
//! A point belongs to the worker that holds it after the partition. A cell belongs to the worker of its
//! lexicographically smallest vertex. The *ghost cells* of a worker contain one of its points and belong to other
//! workers. Every point of a worker therefore has all its cells in the worker's part. The points of a part are those of
//! the worker and the other vertices of its cells, the *ghost points*.

use rayon::prelude::*;

use crate::model::{MeshView, Shares};

/// The part of a triangulation that one worker holds. It is complete in itself: a process can write it alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// 2 or 3.
    pub dimension: usize,
    /// Number of points that the worker holds. They come first.
    pub owned_points: usize,
    /// Number of cells that belong to the worker. They come first.
    pub owned_cells: usize,
    /// The input index of each point: first those of the worker, ascending, then those of ghost points, ascending.
    pub point_ids: Vec<u64>,
    /// `dimension` coordinates per point.
    pub coordinates: Vec<f64>,
    /// `dimension + 1` vertices per cell, as positions in `point_ids`. The cells of the worker and the ghost cells are in
    /// canonical order, and so are the vertices of a cell.
    pub cells: Vec<u64>,
    /// The number of each cell in the whole triangulation. Cells are numbered worker by worker, in canonical order.
    pub cell_ids: Vec<u64>,
    /// The worker of each cell, if the triangulation has them.
    pub owner: Option<Vec<u32>>,
    /// The leaf of the partition tree of each cell, if the triangulation has them.
    pub owning_leaf: Option<Vec<u64>>,
}

/// A reason why a triangulation cannot be divided among workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DivisionError {
    /// The triangulation does not state the worker of each point.
    #[error("the triangulation does not state the worker of each point")]
    NoShares,
    /// The workers of points are more or fewer than the points.
    #[error("{owners} workers of {points} points")]
    Length {
        /// Number of entries.
        owners: usize,
        /// Number of points.
        points: usize,
    },
    /// The worker of a point does not exist.
    #[error("point {point} belongs to worker {owner}, but there are {workers} workers")]
    Worker {
        /// The point.
        point: usize,
        /// Its worker.
        owner: u32,
        /// Number of workers.
        workers: u32,
    },
    /// The owners or the leaves of cells are more or fewer than the cells.
    #[error("{labels} owners or leaves of {cells} cells")]
    Labels {
        /// Number of owners or leaves.
        labels: usize,
        /// Number of cells.
        cells: usize,
    },
    /// A vertex of a cell is not a point, or belongs to no worker.
    #[error("point {point} belongs to no worker, but it is a vertex of a cell")]
    NoWorker {
        /// The point.
        point: u64,
    },
}

/// A triangulation divided among its workers. It takes 8 bytes for each cell, 12 for each point and 16 for each ghost
/// cell.
#[derive(Debug)]
pub struct Division<'a> {
    mesh: MeshView<'a>,
    shares: Shares<'a>,
    /// The points of each worker.
    points: Groups,
    /// The position of each point among the points of its worker.
    place: Vec<u32>,
    /// The cells of each worker.
    cells: Groups,
    /// Pairs of a worker and one of its ghost cells, sorted.
    ghosts: Vec<(u32, u64)>,
}

/// Items by group, ascending within each group.
#[derive(Debug)]
struct Groups {
    /// The position of the first item of each group, then the number of items.
    starts: Vec<usize>,
    items: Vec<u64>,
}

impl Groups {
    /// Groups the items 0, 1, 2, ... by their keys, which are at most `last`.
    fn of(keys: &[u32], last: u32) -> Self {
        let mut starts = vec![0; last as usize + 2];
        for &key in keys {
            starts[key as usize + 1] += 1;
        }
        for group in 0..=last as usize {
            starts[group + 1] += starts[group];
        }
        let (mut next, mut items) = (starts.clone(), vec![0; keys.len()]);
        for (item, &key) in (0..).zip(keys) {
            let next = &mut next[key as usize];
            items[*next] = item;
            *next += 1;
        }
        Groups { starts, items }
    }

    fn get(&self, group: u32) -> &[u64] {
        &self.items[self.starts[group as usize]..self.starts[group as usize + 1]]
    }
}

impl<'a> Division<'a> {
    /// Divides a triangulation. Its cells are in canonical order.
    ///
    /// # Errors
    /// Fails if [`MeshView::shares`] is missing or contradicts the points or the cells.
    pub fn new(mesh: MeshView<'a>) -> Result<Self, DivisionError> {
        let shares = mesh.shares.ok_or(DivisionError::NoShares)?;
        check(&mesh, shares)?;
        let points = Groups::of(shares.point_owner, shares.workers);
        let mut place = vec![0; mesh.point_count()];
        for worker in 1..=shares.workers {
            for (at, &point) in (0..).zip(points.get(worker)) {
                place[point as usize] = at;
            }
        }
        let rows = || mesh.cells.par_chunks_exact(mesh.dimension + 1);
        let owners: Vec<u32> = rows().map(|cell| owner(&mesh, shares, cell)).collect();
        let of_others = |(cell, row): (usize, &[u64])| {
            let mut others = [0; 4];
            for (other, &vertex) in others.iter_mut().zip(row) {
                *other = shares.point_owner[vertex as usize];
            }
            others.sort_unstable();
            let own = owners[cell];
            let is_new = move |at: usize| others[at] != 0 && (at == 0 || others[at] != others[at - 1]);
            let new = (0..4).filter(move |&at| is_new(at)).map(move |at| others[at]);
            new.filter(move |&other| other != own).map(move |other| (other, cell as u64))
        };
        let is_shared = |(cell, row): &(usize, &[u64])| {
            row.iter().any(|&vertex| shares.point_owner[vertex as usize] != owners[*cell])
        };
        let mut ghosts: Vec<(u32, u64)> =
            rows().enumerate().filter(is_shared).flat_map_iter(of_others).collect();
        ghosts.par_sort_unstable();
        let cells = Groups::of(&owners, shares.workers);
        Ok(Division { mesh, shares, points, place, cells, ghosts })
    }

    /// Returns the number of workers. Their ranks are 1 to this number.
    pub fn workers(&self) -> u32 {
        self.shares.workers
    }

    /// Returns the part of a worker.
    ///
    /// # Panics
    /// Panics if there is no worker of this rank.
    pub fn part(&self, worker: u32) -> Part {
        let (dimension, corners) = (self.mesh.dimension, self.mesh.dimension + 1);
        let own = self.cells.get(worker);
        let cells: Vec<u64> = own.iter().copied().chain(self.ghosts(worker)).collect();
        let row = |&cell: &u64| &self.mesh.cells[cell as usize * corners..][..corners];
        let is_ghost = |vertex: &u64| self.shares.point_owner[*vertex as usize] != worker;
        let mut ghost_points: Vec<u64> =
            cells.par_iter().flat_map_iter(|cell| row(cell).iter().copied().filter(is_ghost)).collect();
        ghost_points.par_sort_unstable();
        ghost_points.dedup();
        let owned = self.points.get(worker);
        let local = |vertex: &u64| {
            if is_ghost(vertex) {
                // The search succeeds, because the list has all ghost points of the cells.
                owned.len() as u64 + ghost_points.binary_search(vertex).unwrap_or_default() as u64
            } else {
                u64::from(self.place[*vertex as usize])
            }
        };
        let mut rows = vec![0; cells.len() * corners];
        rows.par_chunks_exact_mut(corners).zip(&cells).for_each(|(to, cell)| {
            to.iter_mut().zip(row(cell)).for_each(|(to, vertex)| *to = local(vertex));
        });
        let point_ids = [owned, &ghost_points].concat();
        let mut coordinates = Vec::with_capacity(point_ids.len() * dimension);
        for &point in &point_ids {
            coordinates.extend_from_slice(&self.mesh.coordinates[point as usize * dimension..][..dimension]);
        }
        let first = self.cells.starts[worker as usize] as u64;
        let numbers =
            (first..).take(own.len()).chain(cells[own.len()..].iter().map(|&cell| self.number(cell)));
        Part {
            dimension,
            owned_points: owned.len(),
            owned_cells: own.len(),
            coordinates,
            point_ids,
            cells: rows,
            cell_ids: numbers.collect(),
            owner: self.mesh.owner.map(|of| cells.iter().map(|&cell| of[cell as usize]).collect()),
            owning_leaf: self
                .mesh
                .owning_leaf
                .map(|of| cells.iter().map(|&cell| of[cell as usize]).collect()),
        }
    }

    /// Returns the ghost cells of a worker.
    fn ghosts(&self, worker: u32) -> impl Iterator<Item = u64> {
        let from = self.ghosts.partition_point(|&(of, _)| of < worker);
        let to = self.ghosts.partition_point(|&(of, _)| of <= worker);
        self.ghosts[from..to].iter().map(|&(_, cell)| cell)
    }

    /// Returns the number of a cell if cells are numbered worker by worker.
    fn number(&self, cell: u64) -> u64 {
        let corners = self.mesh.dimension + 1;
        let owner = owner(&self.mesh, self.shares, &self.mesh.cells[cell as usize * corners..][..corners]);
        let before = self.cells.get(owner).partition_point(|&other| other < cell);
        (self.cells.starts[owner as usize] + before) as u64
    }
}

/// Returns the worker of the lexicographically smallest vertex of a cell.
fn owner(mesh: &MeshView<'_>, shares: Shares<'_>, cell: &[u64]) -> u32 {
    let position = |vertex: u64| &mesh.coordinates[vertex as usize * mesh.dimension..][..mesh.dimension];
    let smaller = |a: u64, b: u64| if position(b) < position(a) { b } else { a };
    cell.iter().copied().reduce(smaller).map_or(0, |vertex| shares.point_owner[vertex as usize])
}

/// Checks that every vertex has a worker.
fn check(mesh: &MeshView<'_>, shares: Shares<'_>) -> Result<(), DivisionError> {
    let Shares { workers, point_owner } = shares;
    let (owners, points) = (point_owner.len(), mesh.point_count());
    if owners != points {
        return Err(DivisionError::Length { owners, points });
    }
    if let Some(point) = point_owner.iter().position(|&owner| owner > workers) {
        return Err(DivisionError::Worker { point, owner: point_owner[point], workers });
    }
    let cells = mesh.cell_count();
    let labels = [mesh.owner.map(<[u32]>::len), mesh.owning_leaf.map(<[u64]>::len)];
    if let Some(labels) = labels.into_iter().flatten().find(|&labels| labels != cells) {
        return Err(DivisionError::Labels { labels, cells });
    }
    // A vertex that is not a point has no worker either.
    let has_none = |vertex: &&u64| point_owner.get(**vertex as usize).is_none_or(|&owner| owner == 0);
    mesh.cells.par_iter().find_first(has_none).map_or(Ok(()), |&point| Err(DivisionError::NoWorker { point }))
}

#[cfg(test)]
mod tests;
