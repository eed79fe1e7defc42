//! The whole triangulation on the first process, for outputs that one process writes.

use std::path::Path;

use septet_core::model::MeshView;
use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::cells::{Layout, ShareRows};
use super::counts::Counts;
use super::fault::{SharedFault, describe, fits};
use super::mesh::SharedMesh;
use super::words::{append, sort_rows, words_of};
use crate::write::options::WriteOptions;
use crate::write::output;
use crate::write::staged::Staged;

/// A whole triangulation.
#[derive(Debug, Default)]
pub(super) struct Whole<'a> {
    dimension: usize,
    coordinates: Vec<f64>,
    heights: Option<&'a [f64]>,
    cells: Vec<u64>,
    /// The owner and the leaf of each cell, if they are written.
    labels: Option<(Vec<u32>, Vec<u64>)>,
    /// The row of the input of each point, if rows were dropped.
    source: Option<Vec<u64>>,
}

impl<'a> Whole<'a> {
    /// Sends the rows and cells of all processes to the first one. The others get an empty triangulation.
    pub fn gather(
        processes: &mut Processes<'_>,
        mesh: &SharedMesh<'a>,
        counts: &Counts,
    ) -> Result<Self, Ended> {
        let space = mesh.run.space;
        let layout = Layout { corners: space + 1, with_ratio: false, with_owner: counts.with_owner };
        let labels = counts.cells.saturating_mul(8 * (layout.width() - layout.corners) as u64);
        let bytes = bytes(counts.row_count() as u64, counts.cells, space).saturating_add(labels);
        processes.agree(fits(bytes), describe)?;
        let mut whole = Whole { dimension: space, heights: mesh.heights, ..Whole::default() };
        whole.coordinates = numbers_on_first(processes, mesh.coordinates)?;
        let mut words = Vec::new();
        for share in &mesh.run.shares {
            ShareRows::of(mesh, share, layout).append(&mut words);
        }
        let mut words = to_first(processes, words)?;
        sort_rows(&mut words, layout.width());
        whole.set_cells(words, layout, counts.rows.start);
        if mesh.dropped > 0 {
            let source = mesh.source_index.unwrap_or_default();
            whole.source = Some(to_first(processes, source.iter().copied())?);
        }
        Ok(whole)
    }

    /// Sets the cells and their labels, given sorted rows. `base` is the number of the first point.
    fn set_cells(&mut self, words: Vec<u64>, layout: Layout, base: u64) {
        let rows = || words.chunks_exact(layout.width());
        if layout.with_owner {
            let owner = rows().map(|row| row[layout.corners] as u32).collect();
            self.labels = Some((owner, rows().map(|row| row[layout.corners + 1]).collect()));
            self.cells = rows().flat_map(|row| &row[..layout.corners]).copied().collect();
        } else {
            self.cells = words;
        }
        self.cells.iter_mut().for_each(|vertex| *vertex -= base);
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
            let options = WriteOptions { source: self.source.as_deref(), ..*options };
            output::add(staged, path, &self.view(), &options, &mut |_, _| {}).map_err(SharedFault::from)
        } else {
            Ok(())
        };
        processes.agree(written, describe)
    }

    /// Returns the triangulation.
    fn view(&self) -> MeshView<'_> {
        let labels = self.labels.as_ref();
        MeshView {
            dimension: self.dimension,
            coordinates: &self.coordinates,
            heights: self.heights.filter(|_| !self.coordinates.is_empty()),
            cells: &self.cells,
            owner: labels.map(|(owner, _)| &owner[..]),
            owning_leaf: labels.map(|(_, leaf)| &leaf[..]),
            run: None,
            labels: None,
        }
    }
}

/// Returns the bytes of rows and cells without labels.
pub(super) fn bytes(rows: u64, cells: u64, space: usize) -> u64 {
    let rows = rows.saturating_mul(8 * space as u64 + 16);
    rows.saturating_add(cells.saturating_mul(8 * (space as u64 + 1)))
}

/// Sends numbers to the first process, which returns those of all processes in their order.
///
/// # Errors
/// Fails if the processes lose each other.
pub fn numbers_on_first(processes: &mut Processes<'_>, own: &[f64]) -> Result<Vec<f64>, Ended> {
    let words = to_first(processes, own.iter().map(|number| number.to_bits()))?;
    Ok(words.into_iter().map(f64::from_bits).collect())
}

/// Sends words to the first process, which returns those of all processes in their order.
///
/// # Errors
/// Fails if the processes lose each other.
pub fn to_first(
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
