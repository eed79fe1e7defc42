//! The processes of a periodic run, and what they send each other outside of the machine.
//!
//! A process alone is a team of one: its collective calls return at once, and it sends nothing. All calls are collective. They
//! are no part of the machine and are not counted.

use std::ops::Range;

use bytemuck::Pod;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::transport::{Placement, TransportError};
use septet_protocol::wire::{Parcel, Processes, WireError};

use crate::error::Error;
use crate::run::processes::rows_of;

/// The processes of a run.
pub(super) struct Team<'a, 'w> {
    pub(super) processes: &'a mut Processes<'w>,
    /// The processes of the ranks; `None` for a process alone.
    pub(super) placement: Option<Placement>,
}

impl Team<'_, '_> {
    /// Returns the words of all processes, in their order.
    ///
    /// # Errors
    /// Fails if a process is gone.
    pub(super) fn all(&mut self, own: Vec<u64>) -> Result<Vec<Vec<u64>>, Error> {
        if self.placement.is_none() {
            return Ok(vec![own]);
        }
        let to_each = (0..self.processes.processes()).map(|_| own.clone()).collect();
        self.scatter(to_each)
    }

    /// Returns the words of all processes on the first one, and nothing on the others.
    ///
    /// # Errors
    /// Fails if a process is gone.
    pub(super) fn on_first(&mut self, own: Vec<u64>) -> Result<Vec<u64>, Error> {
        if self.placement.is_none() {
            return Ok(own);
        }
        let mut to_each = vec![Vec::new(); self.processes.processes() as usize];
        to_each[0] = own;
        Ok(self.scatter(to_each)?.concat())
    }

    /// Sends items to each process. Returns the items to this process, one list for each process.
    ///
    /// # Errors
    /// Fails if a process is gone, or if the items do not fit.
    pub(super) fn scatter<T: Pod>(&mut self, to_each: Vec<Vec<T>>) -> Result<Vec<Vec<T>>, Error> {
        if self.placement.is_none() {
            return Ok(to_each);
        }
        let parcel = |(process, items): (u32, Vec<T>)| {
            let bytes = bytemuck::cast_slice(&items).to_vec();
            Parcel { process, bytes }
        };
        let arrived =
            self.processes.scatter((0..).zip(to_each).map(parcel).collect()).map_err(|error| lost(&error))?;
        let items = |Parcel { process, bytes }: Parcel| {
            let is_whole = bytes.len().is_multiple_of(size_of::<T>());
            let reason = || WireError::Corrupt { process, reason: "its rows are not whole".to_owned() };
            if is_whole { Ok(bytemuck::pod_collect_to_vec(&bytes)) } else { Err(lost(&reason())) }
        };
        arrived.into_iter().map(items).collect()
    }

    /// Returns the numbers of the `rows` that each process holds if the ranks read them.
    pub(super) fn blocks(&self, rows: u64) -> Vec<Range<u64>> {
        match self.placement {
            Some(placement) => {
                let block = |process| {
                    if process < placement.processes() {
                        rows_of(placement, process, rows)
                    } else {
                        rows..rows
                    }
                };
                (0..self.processes.processes()).map(block).collect()
            }
            None => vec![Range { start: 0, end: rows }],
        }
    }

    /// Moves items to the processes of these blocks. `first` is the number of the first item of this process. Returns the
    /// items of this process, in the order of their numbers.
    ///
    /// # Errors
    /// See [`Team::scatter`].
    pub(super) fn moved<T: Pod>(
        &mut self,
        items: &[T],
        first: u64,
        blocks: &[Range<u64>],
    ) -> Result<Vec<T>, Error> {
        if self.placement.is_none() {
            return Ok(items.to_vec());
        }
        let at = |number: u64| (number.saturating_sub(first) as usize).min(items.len());
        let part = |block: &Range<u64>| items[at(block.start)..at(block.end).max(at(block.start))].to_vec();
        Ok(self.scatter(blocks.iter().map(part).collect())?.concat())
    }
}

/// Returns the error of a run whose processes lost each other.
fn lost(error: &WireError) -> Error {
    let (WireError::Lost { process, .. } | WireError::Corrupt { process, .. }) = *error;
    let rank = COORDINATOR.saturating_add(process);
    TransportError::WorkerFailed { rank, reason: error.to_string() }.into()
}
