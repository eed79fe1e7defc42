//! Reading by several processes: each process reads the rows of its block.
//!
//! **Files that are cut.** Arrays (`.npy`) in C order, raw files and text tables (`.xyz`, `.txt`, `.csv`) are cut. A process
//! reads the header of an array and the bytes of its own rows. A table is read twice. First, the processes divide the bytes of
//! all tables into equal parts, which begin at lines, and count the rows. Then they exchange the offsets of the first rows
//! of all blocks, and each process parses its own rows. With `skip_invalid`, arrays and raw files are also read twice, because dropped
//! rows do not count.
//!
//! **Other files.** With [`ReadOptions::keep_columns`], process 0 reads all files and keeps the columns. Process 0 reads them as [`read`](super::read()) does, and sends each process its rows. These are
//! compressed files, arrays in Fortran order, chemical files, UTF-16 text, pipes, standard input and all other formats. Process 0 holds
//! the points of all these files until they are sent. A file of more than [`WHOLE_LIMIT`] bytes is refused.
//!
//! **Weights.** A column of weights is read with the rows. Each process reads its part of a `.npy` file of weights; process 0 reads other
//! files of weights and sends each process its part. With `skip_invalid` and a file of weights, process 0 reads all files, because rows
//! without a weight are dropped.
//!
//! **Terrain.** Each process reads its own points with their heights. Then all processes get the heights of all points.
//!
//! **Errors.** The error of a bad row ends all processes. It has the message that one process gives for this row. In a list with several
//! bad files, one process may find another file first. The number of rows of a `.npy` file of weights is checked before its numbers.

mod block;
mod chunks;
mod cut;
mod error;
mod facts;
mod rows;
mod survey;
mod tally;
#[cfg(test)]
mod tests;
mod weights;
mod whole;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use septet_core::model::Points;
use septet_protocol::codec::Bulk;
use septet_protocol::wire::{Ended, Processes, WireError};

use super::list;
use super::list::notes::Notes;
use super::listed::ListedFile;
use super::points::{Column, CoordinateType, PointFile, ReadOptions};
use super::reading::{Extent, FileReading};
use super::terrain;

use block::{Mark, Reading, Rows};
use error::{SharedError, agree};
use facts::PartFacts;
use rows::{AllRows, WholeFile};
use survey::{Form, Plan};
use tally::Tally;
use whole::Dealing;

/// The largest size in bytes of a file that process 0 reads for all processes. The size of a compressed file is the one
/// before decompression.
pub const WHOLE_LIMIT: u64 = 1 << 30;

/// The rows of an input that a process holds.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedPoints {
    /// The rows of the block of this process, in their order. Coordinates are finite and never -0.0.
    pub points: Points,
    /// The heights of the rows of all processes that are not dropped, as in [`PointFile::heights`]. All processes have the same.
    pub heights: Option<Vec<f64>>,
    /// The weights of the rows of the block, as in [`PointFile::weights`].
    pub weights: Option<Vec<f64>>,
    /// The number of the first row of the block. Dropped rows do not count.
    pub first: u64,
    /// The number of rows of all processes. Dropped rows do not count.
    pub rows: u64,
    /// The number of dropped rows of all processes.
    pub skipped: u64,
    /// The number in the input of each row of the block, or `None` if no process dropped a row. Dropped rows count.
    pub source_index: Option<Vec<u64>>,
    /// Notes for the user, as in [`PointFile::notes`]. All processes have the same notes.
    pub notes: Vec<String>,
    /// The files and their rows.
    pub files: Vec<ListedFile>,
    /// The id of the first point, as in [`PointFile::first_id`].
    pub first_id: u64,
    /// The type of the coordinates in binary files, as in [`PointFile::coordinate_type`].
    pub coordinate_type: Option<CoordinateType>,
    /// The columns of all rows that are not dropped, on process 0, as in [`PointFile::columns`]. Empty on the others.
    pub columns: Vec<Column>,
    /// The record of reading all files, as in [`PointFile::reading`]. All processes have the same. `None` if the rows do not come
    /// from a file.
    pub reading: Option<FileReading>,
    /// The extent of the rows of all processes, or `None` if there are no rows or the rows do not come from a file.
    pub extent: Option<Extent>,
}

impl SharedPoints {
    /// Creates the rows of a process that do not come from a file. `first` is the number of the first one, and `rows` the number
    /// of rows of all processes.
    pub fn of_block(points: Points, first: u64, rows: u64) -> Self {
        SharedPoints {
            points,
            heights: None,
            weights: None,
            first,
            rows,
            skipped: 0,
            source_index: None,
            notes: Vec::new(),
            files: Vec::new(),
            first_id: 0,
            coordinate_type: None,
            columns: Vec::new(),
            reading: None,
            extent: None,
        }
    }
}

/// The sizes of steps.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// The number of bytes that are read at a time.
    step: usize,
    /// The largest size of a file that process 0 reads.
    whole: u64,
    /// The number of rows that process 0 sends at a time.
    round: u64,
}

const LIMITS: Limits = Limits { step: 1 << 20, whole: WHOLE_LIMIT, round: 1 << 22 };

/// Reads files by all processes. Each process reads its own block of the rows.
///
/// The call is collective: all processes make it with equal `files` and `options`. `block` returns the rows that this
/// process must hold of an input with the given number of rows. The blocks of the processes are consecutive, may be empty,
/// and together have all rows. Rows that `skip_invalid` drops are not counted. The rows are those of
/// [`read`](super::read()) for one file, and those of [`read_list`](super::read_list) for several files.
///
/// # Errors
/// All processes return the same error. It has the message of `read` or `read_list`, and the exit code of the program. Also
/// fails if a file that process 0 must read has more than [`WHOLE_LIMIT`] bytes, if
/// the processes see different files, if the processes lose each other, or if `stop` returns `true` while process 0 reads a
/// file for all. Process 0 then leaves the thread that reads.
pub fn read_shared(
    processes: &mut Processes<'_>,
    files: &[PathBuf],
    options: &ReadOptions,
    block: &dyn Fn(u64) -> Range<u64>,
    stop: &dyn Fn() -> bool,
) -> Result<SharedPoints, Ended> {
    let first = files.first().map_or(Path::new(""), PathBuf::as_path);
    let wanted = agree(processes, terrain::in_space(first, options).map_err(SharedError::from))?;
    let read = Call { files, options: &wanted, limits: LIMITS, stop }.read(processes, block)?;
    if options.terrain { lowered(processes, read) } else { Ok(read) }
}

/// Divides the points in space into points in the plane and heights, and sends the heights to all processes.
fn lowered(processes: &mut Processes<'_>, read: SharedPoints) -> Result<SharedPoints, Ended> {
    let bytes = read.rows.saturating_mul(8);
    let fits =
        if bytes > WHOLE_LIMIT { Err(SharedError::Heights { bytes, limit: WHOLE_LIMIT }) } else { Ok(()) };
    agree(processes, fits)?;
    let (points, own) = terrain::plane_and_heights(read.points);
    let heights: Vec<f64> = processes.all_gather(&Bulk(own))?.into_iter().flat_map(|part| part.0).collect();
    Ok(SharedPoints { points, heights: Some(heights), ..read })
}

/// Sends each process its block of points that process 0 has, such as a generated set. `made` is `None` on the other processes.
///
/// # Errors
/// Fails on all processes if the blocks do not divide the points, or if the processes lose each other.
pub fn share_points(
    processes: &mut Processes<'_>,
    made: Option<Points>,
    block: &dyn Fn(u64) -> Range<u64>,
) -> Result<SharedPoints, Ended> {
    let content = made.map(PointFile::of_points);
    let sent: Option<rows::WholeRow> = content.as_ref().map(|file| whole::known(file).row());
    let first = processes.all_gather(&sent)?.swap_remove(0);
    let Some(known) = first.map(WholeFile::of) else {
        let reason = "it has no points".to_string();
        return Err(WireError::Corrupt { process: 0, reason }.into());
    };
    let blocks = blocks(processes, known.kept, block)?;
    let how = Dealing { round: LIMITS.round, has_index: false, has_weights: false };
    let rows = whole::deal(processes, content.as_ref(), &known, &blocks, how)?;
    let first = blocks[processes.process() as usize].start;
    Ok(SharedPoints::of_block(rows.points, first, known.kept))
}

/// The arguments of a call.
struct Call<'a> {
    files: &'a [PathBuf],
    options: &'a ReadOptions,
    limits: Limits,
    /// Returns whether to end the call on all processes.
    stop: &'a dyn Fn() -> bool,
}

/// The files that process 0 has read.
struct WholeFiles {
    /// The facts of them that all processes need.
    known: Vec<WholeFile>,
    /// Their content. Empty on the other processes.
    content: Vec<PointFile>,
}

impl Call<'_> {
    fn read(
        &self,
        processes: &mut Processes<'_>,
        block: &dyn Fn(u64) -> Range<u64>,
    ) -> Result<SharedPoints, Ended> {
        let (options, step) = (self.options, self.limits.step);
        let plans = survey::survey(processes, self.files, options, step)?;
        let who = (processes.process(), processes.processes());
        let own = tally::tally(&plans, options, who, step);
        let tallies = agree(processes, own)?;
        let parts = processes.all_gather(&rows::parts(&tallies))?;
        let whole = self.whole(processes, &plans, &parts)?;
        let all = AllRows::of(&plans, &parts, &whole.known);
        agree(processes, all.check(self.files))?;
        let blocks = blocks(processes, all.kept, block)?;
        let marks = self.marks(processes, (&plans, &tallies), &all, &blocks)?;
        let dealt = self.deal(processes, &plans, &all, &whole, &blocks)?;
        let columns = agree(processes, joined_columns(self.files, whole.content))?;
        let reading = Reading { plans: &plans, all: &all, options, step };
        let own = &blocks[processes.process() as usize];
        let read = reading.block(own, &marks, dealt);
        let (rows, facts) = agree(processes, read)?;
        agree(processes, all.check_announced(&plans))?;
        let facts = processes.all_gather(&facts)?;
        agree(processes, all.check_ids(&plans, &facts))?;
        let weights = self.weights(processes, rows.weights, (&blocks, all.kept))?;
        let extents = processes.all_gather(&Extent::of(&rows.points).map(|of| (of.low, of.high)))?;
        Ok(SharedPoints {
            points: rows.points,
            heights: None,
            weights,
            first: own.start,
            rows: all.kept,
            skipped: all.skipped,
            source_index: (all.skipped > 0).then_some(rows.index),
            notes: self.notes(&plans, &whole.known, &facts),
            files: all.listed(self.files),
            first_id: all.first_id(),
            coordinate_type: all.coordinate_type(),
            columns,
            reading: Some(all.reading()),
            extent: extents
                .into_iter()
                .flatten()
                .map(|(low, high)| Extent { low, high })
                .reduce(|a, b| a.and(&b)),
        })
    }

    /// Whether rows of points are read together with their weights.
    fn have_weights(&self) -> bool {
        self.options.weight_column().is_some() || self.options.drops_by_weight_file()
    }

    /// Returns the weights of the rows of this process, which are `own` if they were read with the points.
    fn weights(
        &self,
        processes: &mut Processes<'_>,
        own: Vec<f64>,
        (blocks, rows): (&[Range<u64>], u64),
    ) -> Result<Option<Vec<f64>>, Ended> {
        match &self.options.weights {
            None => Ok(None),
            Some(_) if self.have_weights() => Ok(Some(own)),
            Some(option) => {
                let file = weights::WeightFile {
                    option,
                    limits: self.limits,
                    stop: self.stop,
                    files: self.files.len(),
                };
                Ok(Some(file.read(processes, blocks, rows)?))
            }
        }
    }

    /// Reads the files that cannot be cut, on process 0, and announces their rows.
    fn whole(
        &self,
        processes: &mut Processes<'_>,
        plans: &[Plan],
        parts: &[Vec<rows::Part>],
    ) -> Result<WholeFiles, Ended> {
        if plans.iter().all(|plan| matches!(plan, Plan::Cut(_))) {
            return Ok(WholeFiles { known: Vec::new(), content: Vec::new() });
        }
        let read = match processes.process() {
            0 => whole::read(plans, self.options, parts, (self.limits.whole, self.stop)),
            _ => Ok(Vec::new()),
        };
        let content = agree(processes, read)?;
        let sent: Vec<rows::WholeRow> = content.iter().map(|file| whole::known(file).row()).collect();
        let mut gathered = processes.all_gather(&sent)?;
        let known = gathered.swap_remove(0).into_iter().map(WholeFile::of).collect();
        Ok(WholeFiles { known, content })
    }

    /// Finds the places of the first rows of all blocks.
    fn marks(
        &self,
        processes: &mut Processes<'_>,
        (plans, tallies): (&[Plan], &[Tally]),
        all: &AllRows,
        blocks: &[Range<u64>],
    ) -> Result<BTreeMap<u64, Mark>, Ended> {
        let who = (processes.process(), self.limits.step);
        let own = block::marks((plans, tallies), all, blocks, self.options, who);
        let own = agree(processes, own)?;
        let gathered = processes.all_gather(&own)?;
        Ok(gathered.into_iter().flatten().map(|mark| (mark[0], mark)).collect())
    }

    /// Sends the rows of the files that process 0 has read. Returns those of this process, per file.
    fn deal(
        &self,
        processes: &mut Processes<'_>,
        plans: &[Plan],
        all: &AllRows,
        whole: &WholeFiles,
        blocks: &[Range<u64>],
    ) -> Result<Vec<Rows>, Ended> {
        let files = plans.iter().zip(&all.files).filter(|(plan, _)| matches!(plan, Plan::Whole(_)));
        let mut dealt = Vec::new();
        for (at, (known, (_, file))) in whole.known.iter().zip(files).enumerate() {
            let within = |row: u64| row.saturating_sub(file.first_kept).min(known.kept);
            let wanted: Vec<_> = blocks.iter().map(|block| within(block.start)..within(block.end)).collect();
            let (round, has_index) = (self.limits.round, all.skipped > 0);
            let how = Dealing { round, has_index, has_weights: self.have_weights() };
            dealt.push(whole::deal(processes, whole.content.get(at), known, &wanted, how)?);
        }
        Ok(dealt)
    }

    /// Returns the notes on all files. `facts` are those of the parts of all processes.
    fn notes(&self, plans: &[Plan], whole: &[WholeFile], facts: &[Vec<PartFacts>]) -> Vec<String> {
        let mut sums = vec![0; plans.len()];
        for [file, count, _] in facts.iter().flatten() {
            if let Some(sum) = sums.get_mut(*file as usize) {
                *sum += count;
            }
        }
        let mut whole = whole.iter();
        let mut notes: Vec<Vec<String>> = Vec::new();
        for (at, plan) in plans.iter().enumerate() {
            notes.push(match plan {
                Plan::Whole(_) => whole.next().map(|file| file.notes.clone()).unwrap_or_default(),
                Plan::Cut(cut) => match &cut.form {
                    Form::Table(head) => head.notes(self.options),
                    Form::Array(layout) => layout.notes(sums[at]),
                },
            });
        }
        if let [notes] = &mut notes[..] {
            return std::mem::take(notes);
        }
        let mut listed = Notes::default();
        self.files.iter().zip(notes).for_each(|(path, notes)| listed.add(path, notes));
        listed.lines()
    }
}

/// Joins the kept columns of files, and drops their points.
fn joined_columns(paths: &[PathBuf], content: Vec<PointFile>) -> Result<Vec<Column>, SharedError> {
    let mut all: Option<(&PathBuf, Vec<Column>)> = None;
    for (path, file) in paths.iter().zip(content).filter(|(_, file)| !file.points.is_empty()) {
        match &mut all {
            None => all = Some((path, file.columns)),
            Some((first, columns)) => list::append_columns(columns, file.columns, (path, first))?,
        }
    }
    Ok(all.map(|(_, columns)| columns).unwrap_or_default())
}

/// Returns the blocks of all processes.
fn blocks(
    processes: &mut Processes<'_>,
    kept: u64,
    block: &dyn Fn(u64) -> Range<u64>,
) -> Result<Vec<Range<u64>>, Ended> {
    let own = block(kept);
    let gathered = processes.all_gather(&[own.start, own.end])?;
    let blocks: Vec<Range<u64>> = gathered.into_iter().map(|[start, end]| start..end).collect();
    let checked: Result<(), SharedError> = block::check(&blocks, kept);
    agree(processes, checked)?;
    Ok(blocks)
}
