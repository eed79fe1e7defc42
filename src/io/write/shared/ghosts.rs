//! The exchange of ghost cells: a cell with a vertex of another worker goes to the process of that worker.
//!
//! A parcel consists of blocks of words. A block has the cells of one subdomain for one other worker: the worker, the
//! numbers of points and of cells, the points and the cells. A point is its input index and the bits of its coordinates.
//! Points of the receiving worker are omitted. A cell is its canonical row, with its labels if they are written, and its
//! number in the whole triangulation.

use std::ops::Range;

use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::cells::{Layout, ShareRows, WIDEST};
use super::counts::Counts;
use super::mesh::SharedMesh;
use super::words::{append, first_not_less, sort_rows, words_of};

/// Number of words before the points of a block.
const HEAD: usize = 3;

/// The ghost cells of the workers of a process.
#[derive(Debug)]
pub(super) struct Ghosts {
    /// The words of a cell, which its number follows.
    pub layout: Layout,
    parcels: Vec<Parcel>,
    blocks: Vec<Block>,
}

/// The place of a block in the parcels.
#[derive(Clone, Debug)]
struct Block {
    worker: u32,
    parcel: usize,
    points: Range<usize>,
    cells: Range<usize>,
}

impl Ghosts {
    /// Sends the ghost cells of all workers to their processes.
    pub fn exchange(
        processes: &mut Processes<'_>,
        mesh: &SharedMesh<'_>,
        counts: &Counts,
    ) -> Result<Self, Ended> {
        let layout = Layout { corners: mesh.run.space + 1, with_ratio: false, with_owner: counts.with_owner };
        let mut sent: Vec<Vec<u8>> = vec![Vec::new(); processes.processes() as usize];
        for (share, &first) in mesh.run.shares.iter().zip(&counts.first_cells) {
            append_blocks(&ShareRows::of(mesh, share, layout), first, &mut sent);
        }
        let parcels = (0..).zip(sent).map(|(process, bytes)| Parcel { process, bytes });
        let parcels = processes.scatter(parcels.filter(|parcel| !parcel.bytes.is_empty()).collect())?;
        let mut blocks = Vec::new();
        for (at, parcel) in parcels.iter().enumerate() {
            find_blocks(at, parcel, layout, &mut blocks)?;
        }
        // The sort is stable, so the blocks of a worker stay in the order of their senders.
        blocks.sort_by_key(|block| block.worker);
        Ok(Ghosts { layout, parcels, blocks })
    }

    /// Returns the points of the ghost cells of a worker, without its own, in words. A point may occur several times.
    pub fn points(&self, worker: u32) -> impl Iterator<Item = u64> + '_ {
        self.words(worker, |block| block.points.clone())
    }

    /// Returns the ghost cells of a worker in words.
    pub fn cells(&self, worker: u32) -> impl Iterator<Item = u64> + '_ {
        self.words(worker, |block| block.cells.clone())
    }

    fn words<'a>(
        &'a self,
        worker: u32,
        range: impl Fn(&Block) -> Range<usize> + 'a,
    ) -> impl Iterator<Item = u64> + 'a {
        let from = self.blocks.partition_point(|block| block.worker < worker);
        let to = self.blocks.partition_point(|block| block.worker <= worker);
        self.blocks[from..to]
            .iter()
            .flat_map(move |block| words_of(&self.parcels[block.parcel].bytes[range(block)]))
    }
}

/// Appends the blocks of a share to the bytes for each process. The number of its first cell is given.
fn append_blocks(rows: &ShareRows<'_>, first: u64, sent: &mut [Vec<u8>]) {
    let (mesh, share, width) = (rows.mesh, rows.share, rows.layout.width());
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for cell in 0..share.cell_count() {
        let others = share.cell(cell).iter().filter(|&&vertex| vertex as usize >= share.owned);
        pairs.extend(others.map(|&vertex| (mesh.owner(share, vertex), cell as u32)));
    }
    if pairs.is_empty() {
        return;
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut sorted = Vec::new();
    rows.append(&mut sorted);
    sort_rows(&mut sorted, width);
    for cells in pairs.chunk_by(|a, b| a.0 == b.0) {
        let worker = cells[0].0;
        let mut points: Vec<u32> =
            cells.iter().flat_map(|&(_, cell)| share.cell(cell as usize)).copied().collect();
        points.retain(|&point| mesh.owner(share, point) != worker);
        points.sort_unstable();
        points.dedup();
        // Every owner has a process, because the counts were checked.
        let Some(bytes) = sent.get_mut(mesh.run.placement.process_of(worker) as usize) else { continue };
        append(bytes, [u64::from(worker), points.len() as u64, cells.len() as u64]);
        for point in points {
            append(bytes, [share.ids[point as usize]]);
            append(bytes, mesh.place(share, point).iter().map(|coordinate| coordinate.to_bits()));
        }
        for &(_, cell) in cells {
            let row = &mut [0; WIDEST][..width];
            rows.write(cell as usize, row);
            let before = first_not_less(&sorted, width, row) / width;
            append(bytes, row.iter().copied().chain([first + before as u64]));
        }
    }
}

/// Finds the blocks of a parcel.
fn find_blocks(at: usize, parcel: &Parcel, layout: Layout, blocks: &mut Vec<Block>) -> Result<(), WireError> {
    let mut start = 0;
    while start < parcel.bytes.len() {
        let Some(block) = block_at(&parcel.bytes, start, at, layout) else {
            let reason = "a block of ghost cells is not whole".to_string();
            return Err(WireError::Corrupt { process: parcel.process, reason });
        };
        start = block.cells.end;
        blocks.push(block);
    }
    Ok(())
}

/// Returns the block at a position. Returns `None` if it is not whole.
fn block_at(bytes: &[u8], start: usize, parcel: usize, layout: Layout) -> Option<Block> {
    let from = start + 8 * HEAD;
    let mut head = words_of(bytes.get(start..from)?);
    let worker = u32::try_from(head.next()?).ok()?;
    let mut end_after = |start: usize, width: usize| {
        let count = usize::try_from(head.next()?).ok()?;
        start.checked_add(count.checked_mul(8 * width)?).filter(|end| *end <= bytes.len())
    };
    let middle = end_after(from, layout.corners)?;
    let end = end_after(middle, layout.width() + 1)?;
    Some(Block { worker, parcel, points: from..middle, cells: middle..end })
}

#[cfg(test)]
mod tests {
    use super::super::words::bytes_of;
    use super::*;

    #[test]
    fn blocks_that_are_not_whole_are_refused() {
        let block: Vec<u64> = [5, 1, 2].into_iter().chain(0..3 + 8).collect();
        let mut parcel = Parcel { process: 0, bytes: bytes_of(&[&block[..], &block].concat()) };
        let layout = Layout { corners: 3, with_ratio: false, with_owner: false };
        let mut blocks = Vec::new();
        find_blocks(0, &parcel, layout, &mut blocks).unwrap();
        assert_eq!(blocks.len(), 2);
        let ghosts = Ghosts { layout, parcels: vec![parcel.clone()], blocks };
        assert_eq!(ghosts.points(5).collect::<Vec<_>>(), [0, 1, 2, 0, 1, 2]);
        assert_eq!(ghosts.cells(5).count(), 16);
        assert_eq!(ghosts.cells(4).count(), 0);
        parcel.bytes.truncate(8 * 14 * 2 - 8);
        assert!(find_blocks(0, &parcel, layout, &mut Vec::new()).is_err());
        parcel.bytes[8..16].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(find_blocks(0, &parcel, layout, &mut Vec::new()).is_err());
    }
}
