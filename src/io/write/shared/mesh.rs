//! The share of a process.

use std::ops::Range;

use septet_core::{Outcome, WorkerShare};

/// A triangulation that several processes hold: the share of one process.
#[derive(Clone, Copy, Debug)]
pub struct SharedMesh<'a> {
    /// The outcome of this process.
    pub run: &'a Outcome,
    /// The coordinates of the input rows that this process read, in their order. Rows of all processes are points, duplicates
    /// included.
    pub coordinates: &'a [f64],
    /// The heights of the rows of all processes, if the points are a terrain.
    pub heights: Option<&'a [f64]>,
    /// The number of the first of these rows. The rows of a process follow those of the process before it. The first process can
    /// begin with any number.
    pub first: u64,
    /// The row of the input of each point that this process read, if rows were dropped.
    pub source_index: Option<&'a [u64]>,
    /// Number of dropped rows of all processes.
    pub dropped: u64,
}

impl SharedMesh<'_> {
    /// Returns `true` if the points do not span the space, so that there are no cells.
    pub(super) fn is_flat(&self) -> bool {
        self.run.is_flat()
    }

    /// Returns the number of rows that this process read.
    pub(super) fn row_count(&self) -> usize {
        self.coordinates.len() / self.run.space
    }

    /// Returns the coordinates of a point of a share. A process that has all rows takes them from there.
    pub(super) fn place<'b>(&'b self, share: &'b WorkerShare, point: u32) -> &'b [f64] {
        let (space, point) = (self.run.space, point as usize);
        let at = |position: usize| position * space..(position + 1) * space;
        match share.coordinates.get(at(point)) {
            Some(place) => place,
            None => &self.coordinates[at((share.ids[point] - self.first) as usize)],
        }
    }

    /// Returns the owner of a point of a share. A process that has all shares finds it there. Returns 0 if there is none.
    pub(super) fn owner(&self, share: &WorkerShare, point: u32) -> u32 {
        let point = point as usize;
        let of_run = || self.run.point_owner()?.get(share.ids[point] as usize).copied();
        if point < share.owned {
            return share.rank;
        }
        share.owners.get(point).copied().or_else(of_run).unwrap_or_default()
    }

    /// Returns the rows of this process that are neither duplicates nor refused, each with its coordinates.
    pub(super) fn vertices(&self) -> impl Iterator<Item = (u64, &[f64])> {
        let points = &self.run.left_out;
        let mut unused: Vec<u64> = points.duplicates.iter().map(|(row, _)| *row).collect();
        unused.extend(&points.refused);
        unused.sort_unstable();
        let rows = (self.first..).zip(self.coordinates.chunks_exact(self.run.space));
        rows.filter(move |(row, _)| unused.binary_search(row).is_err())
    }

    /// Checks that the arrays of this process are consistent, given the numbers of the rows of all processes.
    ///
    /// # Errors
    /// Returns the contradiction.
    pub(super) fn check(&self, rows: &Range<u64>) -> Result<(), String> {
        let (space, found) = (self.run.space, self.coordinates.len());
        if !found.is_multiple_of(space) {
            return Err(format!("{found} coordinates for points with {space}"));
        }
        let count = (rows.end - rows.start) as usize;
        if let Some(heights) = self.heights.filter(|heights| heights.len() != count || space != 2) {
            return Err(format!("{} heights of {count} points with {space} coordinates", heights.len()));
        }
        if self.source_index.map_or(0, <[u64]>::len) != if self.dropped > 0 { self.row_count() } else { 0 } {
            return Err("the input rows of the points are missing".to_string());
        }
        for share in &self.run.shares {
            let (rank, points) = (share.rank, share.ids.len());
            let lengths = [share.owners.len(), share.coordinates.len() / space];
            let has_places = lengths == [points; 2] || (self.run.is_whole() && lengths == [0; 2]);
            if !has_places || share.owned > points {
                return Err(format!("the arrays of worker {rank} have different lengths"));
            }
            if let Some(id) = share.ids.iter().find(|id| !rows.contains(id)) {
                return Err(format!("worker {rank} has point {id} of points {} to {}", rows.start, rows.end));
            }
            let is_own = |(at, owner): (usize, &u32)| (*owner == rank) == (at < share.owned);
            let has_owner = |&point: &u32| self.run.placement.has_worker(self.owner(share, point));
            for cell in (0..share.cell_count()).map(|cell| share.cell(cell)) {
                if cell.iter().any(|&vertex| vertex as usize >= points) {
                    return Err(format!("a cell of worker {rank} has a vertex that is not a point"));
                }
                if !cell.iter().all(has_owner) {
                    return Err(format!("a cell of worker {rank} has a vertex without an owner"));
                }
            }
            if !share.owners.iter().enumerate().all(is_own) {
                return Err(format!("the points of worker {rank} have other owners"));
            }
        }
        Ok(())
    }
}
