//! The canonical order of the cells of all processes: a sort by regular samples.
//!
//! Every process sorts its rows, and sends every `s`-th of them to all processes. The samples, of which there are about 1,024
//! for each process, are sorted and divided into equal ranges. Process k receives the rows of range k.
//!
//! **Statement.** Of n rows on p processes, a process receives at most about (1 + (p + 1) / 1024) n / p rows, however they
//! are distributed. **Proof.** Rows are unique, so a range has equally many samples, up to one. Between two samples that are
//! neighbours on a process, there are fewer than s of its rows. A range with m samples of a process therefore has at most
//! (m + 1) s of its rows, where s is about n / (1024 p).

use septet_protocol::codec::Bulk;
use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::cells::{Layout, ShareRows};
use super::counts::Counts;
use super::mesh::SharedMesh;
use super::words::{bytes_of, first_not_less, sort_rows, words_of};
use crate::write::cell_range::CellRange;

/// Number of samples for each process.
const SAMPLES: u64 = 1024;

/// The share of a process of the cells in canonical order.
#[derive(Clone, Debug)]
pub(super) struct SortedCells {
    /// The words of a cell.
    pub layout: Layout,
    /// The number of the first cell.
    first: u64,
    /// Number of cells of all processes.
    total: u64,
    words: Vec<u64>,
}

impl SortedCells {
    /// Returns the cells.
    pub fn range(&self) -> CellRange<'_> {
        let (first, total) = (self.first as usize, self.total as usize);
        let (corners, width) = (self.layout.corners, self.layout.width());
        CellRange { corners, first, total, width, words: &self.words }
    }
}

/// Sorts the cells of all processes as rows of this layout.
pub(super) fn sort(
    processes: &mut Processes<'_>,
    mesh: &SharedMesh<'_>,
    counts: &Counts,
    layout: Layout,
) -> Result<SortedCells, Ended> {
    let width = layout.width();
    let own = mesh.run.shares.iter().map(|share| share.cell_count() * width);
    let mut words = Vec::with_capacity(own.sum());
    for share in &mesh.run.shares {
        ShareRows::of(mesh, share, layout).append(&mut words);
    }
    let words = sort_words(processes, words, width, counts.cells)?;
    let before = processes.all_gather(&((words.len() / width) as u64))?;
    let first = before.iter().take(processes.process() as usize).sum();
    Ok(SortedCells { layout, first, total: counts.cells, words })
}

/// Sorts the rows of all processes, `total` in number. Returns the share of this process.
fn sort_words(
    processes: &mut Processes<'_>,
    mut words: Vec<u64>,
    width: usize,
    total: u64,
) -> Result<Vec<u64>, WireError> {
    sort_rows(&mut words, width);
    let splitters = splitters(processes, &words, width, total)?;
    let arrived = processes.scatter(cut(words, width, &splitters))?;
    join(arrived, width)
}

/// Returns the first row of each process except process 0, given sorted rows of this process. If there are no rows, returns
/// none.
fn splitters(
    processes: &mut Processes<'_>,
    words: &[u64],
    width: usize,
    total: u64,
) -> Result<Vec<u64>, WireError> {
    let count = u64::from(processes.processes());
    let stride = total.div_ceil(SAMPLES * count).max(1) as usize;
    let samples = words.chunks_exact(width).skip(stride - 1).step_by(stride).flatten().copied();
    let gathered = processes.all_gather(&Bulk(samples.collect::<Vec<u64>>()))?;
    let mut samples: Vec<u64> = gathered.into_iter().flat_map(|Bulk(samples)| samples).collect();
    if !samples.len().is_multiple_of(width) {
        let reason = "a sample of cells is not whole".to_string();
        return Err(WireError::Corrupt { process: 0, reason });
    }
    sort_rows(&mut samples, width);
    let sampled = (samples.len() / width) as u64;
    if sampled == 0 {
        return Ok(Vec::new());
    }
    let at = |process: u64| (process * sampled / count) as usize * width;
    Ok((1..count).flat_map(|process| &samples[at(process)..][..width]).copied().collect())
}

/// Cuts sorted rows into a parcel for each process.
fn cut(mut words: Vec<u64>, width: usize, splitters: &[u64]) -> Vec<Parcel> {
    let mut parcels = Vec::new();
    for (before, splitter) in splitters.chunks_exact(width).enumerate().rev() {
        let start = first_not_less(&words, width, splitter);
        parcels.push(Parcel { process: before as u32 + 1, bytes: bytes_of(&words[start..]) });
        words.truncate(start);
        words.shrink_to_fit();
    }
    parcels.push(Parcel { process: 0, bytes: bytes_of(&words) });
    parcels.reverse();
    parcels
}

/// Joins and sorts the rows that arrived.
fn join(arrived: Vec<Parcel>, width: usize) -> Result<Vec<u64>, WireError> {
    let bytes: usize = arrived.iter().map(|parcel| parcel.bytes.len()).sum();
    let mut words = Vec::with_capacity(bytes / 8);
    for Parcel { process, bytes } in arrived {
        if !bytes.len().is_multiple_of(8 * width) {
            let reason = "its cells are not whole".to_string();
            return Err(WireError::Corrupt { process, reason });
        }
        words.extend(words_of(&bytes));
    }
    sort_rows(&mut words, width);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::super::tests::on_each;
    use super::*;

    /// The shares are balanced if the rows of a process, the first words or both are concentrated.
    #[test]
    fn shares_are_balanced() {
        let count = 60_000;
        let spread: [fn(u64, u64) -> [u64; 3]; 3] = [
            |process, i| [0, process, i],
            |process, i| [i * 7919 % 60_000, process, 1],
            |process, i| [(i / 59_000) * process, i, process],
        ];
        for (lengths, row) in [[count; 3], [3 * count, 0, 0], [1, 10, count]].into_iter().zip(spread) {
            let total: u64 = lengths.iter().sum();
            let shares = on_each(&lengths, |processes, length| {
                let process = u64::from(processes.process());
                let words = (0..*length).rev().flat_map(|i| row(process, i)).collect();
                Ok(sort_words(processes, words, 3, total)?)
            });
            let shares: Vec<Vec<u64>> = shares.into_iter().map(Result::unwrap).collect();
            for share in &shares {
                let most = total as f64 / 3.0 * (1.0 + 4.0 / 1024.0) + 100.0;
                assert!((share.len() / 3) as f64 <= most, "{} of {total}", share.len() / 3);
            }
            let joined = shares.concat();
            assert_eq!(joined.len() as u64, 3 * total);
            assert!(joined.as_chunks::<3>().0.is_sorted());
        }
    }

    #[test]
    fn every_row_goes_to_its_range() {
        let rows: Vec<u64> = (0..20).flat_map(|i| [i, i + 1, i + 2]).collect();
        let parcels = cut(rows.clone(), 3, &[0, 0, 0, 5, 6, 7, 5, 6, 7, 50, 0, 0]);
        assert_eq!(parcels.iter().map(|parcel| parcel.process).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        let lengths: Vec<usize> = parcels.iter().map(|parcel| parcel.bytes.len() / 24).collect();
        assert_eq!(lengths, [0, 5, 0, 15, 0]);
        assert_eq!(join(parcels, 3).unwrap(), rows);
        assert!(join(vec![Parcel { process: 2, bytes: vec![0; 25] }], 3).is_err());
    }
}
