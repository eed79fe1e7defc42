//! The whole triangulation on the first process, for outputs that one process writes.

use std::path::Path;

use septet_core::model::{MeshView, Shares};
use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::cells::append_rows;
use super::counts::Counts;
use super::fault::{SharedFault, describe};
use super::flat::FLAT_WORKER;
use super::mesh::SharedMesh;
use super::words::{append, sort_rows, words_of};
use crate::format::Role;
use crate::write::options::{KeptRows, WriteOptions};
use crate::write::output;
use crate::write::staged::Staged;

/// The largest size in bytes of a triangulation that several processes gather on the first one: coordinates, cells, and 16
/// bytes for each point.
pub const GATHER_LIMIT: u64 = 1 << 30;

/// A whole triangulation.
#[derive(Debug, Default)]
pub(super) struct Whole {
    dimension: usize,
    coordinates: Vec<f64>,
    cells: Vec<u64>,
    workers: u32,
    point_owner: Vec<u32>,
    /// The row of the input of each point, if rows were dropped.
    source: Vec<u64>,
    dropped: u64,
}

impl Whole {
    /// Sends the rows and cells of all processes to the first one. The others get an empty triangulation.
    pub fn gather(
        processes: &mut Processes<'_>,
        mesh: &SharedMesh<'_>,
        counts: &Counts,
    ) -> Result<Self, Ended> {
        let space = mesh.run.space;
        let rows = counts.row_count() as u64;
        let bytes = rows.saturating_mul(8 * space as u64 + 16);
        let bytes = bytes.saturating_add(counts.cells.saturating_mul(8 * (space as u64 + 1)));
        processes.agree(fits(bytes), describe)?;
        let mut whole =
            Whole { dimension: space, workers: counts.workers, dropped: mesh.dropped, ..Whole::default() };
        let coordinates = mesh.rows.coordinates().iter().map(|coordinate| coordinate.to_bits());
        let arrived = to_first(processes, coordinates)?;
        whole.coordinates = arrived.into_iter().map(f64::from_bits).collect();
        let base = counts.rows.start;
        let mut cells = Vec::new();
        for subdomain in &mesh.run.shares {
            append_rows(subdomain, space, false, &mut cells);
        }
        let mut cells = to_first(processes, cells.into_iter().map(|row| row - base))?;
        sort_rows(&mut cells, space + 1);
        whole.cells = cells;
        let owned = owned(mesh, base);
        whole.set_owners(&to_first(processes, owned)?)?;
        let source = mesh.source_index.unwrap_or_default();
        whole.source = to_first(processes, source.iter().copied())?;
        Ok(whole)
    }

    /// Sets the worker of each point, given the pairs of point and worker.
    fn set_owners(&mut self, pairs: &[u64]) -> Result<(), WireError> {
        self.point_owner = vec![0; self.coordinates.len() / self.dimension];
        for [point, worker] in pairs.as_chunks::<2>().0 {
            let Some(owner) = self.point_owner.get_mut(*point as usize) else {
                return Err(WireError::Corrupt {
                    process: 0,
                    reason: "a worker has a point that is no row".to_string(),
                });
            };
            *owner = *worker as u32;
        }
        Ok(())
    }

    /// Writes an output on the first process, as one process does.
    pub fn write(
        &self,
        processes: &mut Processes<'_>,
        staged: &mut Staged,
        path: &Path,
        options: &WriteOptions<'_>,
    ) -> Result<(), Ended> {
        let written = if processes.process() == 0 {
            let options = WriteOptions { kept: self.kept(), ..*options };
            output::add(staged, path, &self.view(), &options, &mut |_, _| {}).map_err(SharedFault::from)
        } else {
            Ok(())
        };
        processes.agree(written, describe)
    }

    /// Returns the triangulation.
    fn view(&self) -> MeshView<'_> {
        MeshView {
            dimension: self.dimension,
            coordinates: &self.coordinates,
            cells: &self.cells,
            owner: None,
            owning_leaf: None,
            shares: Some(Shares { workers: self.workers, point_owner: &self.point_owner }),
            labels: None,
        }
    }

    /// Returns the rows of the input that are points, if rows were dropped.
    fn kept(&self) -> Option<KeptRows<'_>> {
        (self.dropped > 0).then_some(KeptRows { rows: &self.source, dropped: self.dropped })
    }
}

/// Checks the size of a triangulation.
fn fits(bytes: u64) -> Result<(), SharedFault> {
    let divided = || Role::Triangulation.extensions(|row| row.is_divided(Role::Triangulation));
    let too_large = || SharedFault::TooLarge { bytes, limit: GATHER_LIMIT, divided: divided() };
    if bytes > GATHER_LIMIT { Err(too_large()) } else { Ok(()) }
}

/// Returns the pairs of point and worker of this process.
fn owned(mesh: &SharedMesh<'_>, base: u64) -> Vec<u64> {
    if mesh.is_flat() {
        // All vertices belong to one worker, and no subdomain has them.
        let rows = mesh.vertices().map(|(row, _)| row - base);
        return rows.flat_map(|row| [row, u64::from(FLAT_WORKER)]).collect();
    }
    let pairs = mesh.run.shares.iter().flat_map(|subdomain| {
        subdomain.ids[..subdomain.owned].iter().flat_map(move |id| [id - base, u64::from(subdomain.rank)])
    });
    pairs.collect()
}

/// Sends words to the first process, which returns those of all processes in their order.
fn to_first(
    processes: &mut Processes<'_>,
    words: impl IntoIterator<Item = u64>,
) -> Result<Vec<u64>, WireError> {
    let words = words.into_iter();
    let mut bytes = Vec::with_capacity(8 * (words.size_hint().0 + 1));
    append(&mut bytes, words);
    let arrived = processes.scatter(vec![Parcel { process: 0, bytes }])?;
    let count = arrived.iter().map(|parcel| parcel.bytes.len() / 8).sum();
    let mut all = Vec::with_capacity(count);
    for parcel in arrived {
        if !parcel.bytes.len().is_multiple_of(8) {
            let reason = "its words are not whole".to_string();
            return Err(WireError::Corrupt { process: parcel.process, reason });
        }
        all.extend(words_of(&parcel.bytes));
    }
    Ok(all)
}
