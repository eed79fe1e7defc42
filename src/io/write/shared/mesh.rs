//! The share of a process.

use std::ops::Range;

use septet_core::Outcome;
use septet_core::model::Points;

/// A triangulation that several processes hold: the share of one process.
#[derive(Clone, Copy, Debug)]
pub struct SharedMesh<'a> {
    /// The outcome of this process.
    pub run: &'a Outcome,
    /// The input rows that this process read, in their order. Rows of all processes are points, duplicates included.
    pub rows: &'a Points,
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

    /// Returns the rows of this process that are neither duplicates nor refused, each with its coordinates.
    pub(super) fn vertices(&self) -> impl Iterator<Item = (u64, &[f64])> {
        let points = &self.run.left_out;
        let mut unused: Vec<u64> = points.duplicates.iter().map(|(row, _)| *row).collect();
        unused.extend(&points.refused);
        unused.sort_unstable();
        let rows = (self.first..).zip(self.rows.coordinates().chunks_exact(self.run.space));
        rows.filter(move |(row, _)| unused.binary_search(row).is_err())
    }

    /// Checks that the arrays of this process are consistent, given the numbers of the rows of all processes.
    ///
    /// # Errors
    /// Returns the contradiction.
    pub(super) fn check(&self, rows: &Range<u64>) -> Result<(), String> {
        let (space, found) = (self.run.space, self.rows.dimension());
        if space != found {
            return Err(format!("rows of {found} coordinates for a triangulation with {space}"));
        }
        if self.source_index.map_or(0, <[u64]>::len) != if self.dropped > 0 { self.rows.len() } else { 0 } {
            return Err("the input rows of the points are missing".to_string());
        }
        for subdomain in &self.run.shares {
            let (rank, points) = (subdomain.rank, subdomain.ids.len());
            let lengths = [subdomain.owners.len(), subdomain.coordinates.len() / space];
            if lengths != [points; 2] || subdomain.owned > points {
                return Err(format!("the arrays of worker {rank} have different lengths"));
            }
            if let Some(id) = subdomain.ids.iter().find(|id| !rows.contains(id)) {
                return Err(format!("worker {rank} has point {id} of points {} to {}", rows.start, rows.end));
            }
            let (own, others) = subdomain.owners.split_at(subdomain.owned);
            let is_other = |owner: &u32| *owner != rank && self.run.placement.has_worker(*owner);
            if !own.iter().all(|owner| *owner == rank) || !others.iter().all(is_other) {
                return Err(format!("the points of worker {rank} have other owners"));
            }
            let mut cells = 0..subdomain.cell_count();
            if cells.any(|cell| subdomain.cell(cell).iter().any(|&vertex| vertex as usize >= points)) {
                return Err(format!("a cell of worker {rank} has a vertex that is not a point"));
            }
        }
        Ok(())
    }
}
