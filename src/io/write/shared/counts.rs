//! The numbers of rows, cells and workers of all processes.

use std::ops::Range;

use septet_protocol::wire::{Ended, Processes};

use super::fault::{SharedFault, describe};
use super::mesh::SharedMesh;

/// The numbers that determine the places of the shares in the outputs.
#[derive(Clone, Debug)]
pub(super) struct Counts {
    /// The numbers of the rows of all processes.
    pub rows: Range<u64>,
    /// Whether the rows of each process follow those of the process before it.
    is_consecutive: bool,
    /// Number of cells of all processes.
    pub cells: u64,
    /// Number of workers of all processes.
    pub workers: u32,
    /// For each worker of this process the number of its first cell. Cells are numbered worker by worker.
    pub first_cells: Vec<u64>,
    /// Whether outputs have the owner and the leaf of each cell.
    pub with_owner: bool,
}

impl Counts {
    /// Collects the numbers, and checks that the shares fit together. `with_owner` states whether the owner and the leaf of
    /// each cell are requested, which are written if a run keeps them.
    pub fn gather(
        processes: &mut Processes<'_>,
        mesh: &SharedMesh<'_>,
        with_owner: bool,
    ) -> Result<Self, Ended> {
        let counts = Self::collect(processes, mesh, with_owner)?;
        let own = counts.check(mesh, processes.process()).map_err(SharedFault::inconsistent);
        processes.agree(own, describe)?;
        Ok(counts)
    }

    /// Collects the numbers.
    pub fn collect(
        processes: &mut Processes<'_>,
        mesh: &SharedMesh<'_>,
        with_owner: bool,
    ) -> Result<Self, Ended> {
        let cells: Vec<u64> = mesh.run.shares.iter().map(|own| own.cell_count() as u64).collect();
        let has_owners = with_owner && mesh.run.has_owners();
        let all = processes.all_gather(&(mesh.first, mesh.row_count() as u64, cells, has_owners))?;
        let process = processes.process();
        // There is at least one process, this one.
        let base = all.first().map_or(0, |(first, ..)| *first);
        let mut counts = Counts {
            rows: base..base,
            is_consecutive: true,
            cells: 0,
            workers: 0,
            first_cells: Vec::new(),
            with_owner: all.iter().any(|(.., has_owners)| *has_owners),
        };
        for (of, (first, rows, cells, _)) in (0..).zip(&all) {
            counts.is_consecutive &= *first == counts.rows.end;
            counts.rows.end = counts.rows.end.saturating_add(*rows);
            counts.workers += cells.len() as u32;
            for worker in cells {
                if of == process {
                    counts.first_cells.push(counts.cells);
                }
                counts.cells = counts.cells.saturating_add(*worker);
            }
        }
        Ok(counts)
    }

    /// Returns the number of rows of all processes.
    pub fn row_count(&self) -> usize {
        (self.rows.end - self.rows.start) as usize
    }

    /// Checks that the share of a process fits to the others.
    pub fn check(&self, mesh: &SharedMesh<'_>, process: u32) -> Result<(), String> {
        let run = mesh.run;
        if !self.is_consecutive {
            return Err("the rows of the processes are not consecutive".to_string());
        }
        let ranks = run.shares.iter().map(|own| own.rank);
        let is_placed = run.placement.has_worker(self.workers) && !run.placement.has_worker(self.workers + 1);
        if !is_placed || !ranks.eq(run.placement.workers_of(process)) {
            return Err(format!("process {process} has the subdomains of other workers"));
        }
        if self.cells != run.cells || (mesh.is_flat() && self.cells > 0) {
            return Err(format!("the processes hold {} of {} cells", self.cells, run.cells));
        }
        mesh.check(&self.rows)
    }
}
