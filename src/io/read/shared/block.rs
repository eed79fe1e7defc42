//! The rows of one process: where they begin and end in the files, and their content.

use std::collections::BTreeMap;
use std::ops::Range;

use septet_core::model::{HigherPoints, Points};

use super::super::error::InputError;
use super::super::points::ReadOptions;
use super::chunks::OpenFile;
use super::cut::Chunk;
use super::error::SharedError;
use super::facts::{PartFacts, part_facts};
use super::rows::AllRows;
use super::survey::{Cut, Plan};
use super::tally::Tally;

/// The place of a row, as the processes exchange it: the number of the row, the number of its file, its offset, and the
/// lines and rows before it in the file.
pub(super) type Mark = [u64; 5];

/// Checks that the blocks of all processes are consecutive, and together have all rows.
pub(super) fn check(blocks: &[Range<u64>], rows: u64) -> Result<(), SharedError> {
    let mut end = 0;
    for block in blocks {
        if block.start != end || block.end < end {
            return Err(SharedError::Blocks { rows });
        }
        end = block.end;
    }
    if end == rows { Ok(()) } else { Err(SharedError::Blocks { rows }) }
}

/// Finds the places of the first rows of all blocks that are in the parts of this process.
pub(super) fn marks(
    (plans, tallies): (&[Plan], &[Tally]),
    all: &AllRows,
    blocks: &[Range<u64>],
    options: &ReadOptions,
    (process, step): (u32, usize),
) -> Result<Vec<Mark>, SharedError> {
    let mut marks = Vec::new();
    let mut segments =
        all.segments.iter().filter(|segment| segment.process == process).zip(tallies).peekable();
    let mut last = None;
    for row in blocks.iter().map(|block| block.start) {
        while segments.next_if(|(segment, _)| segment.first + segment.kept <= row).is_some() {}
        let Some((segment, tally)) = segments.peek() else { break };
        if row < segment.first || last == Some(row) {
            continue;
        }
        last = Some(row);
        if let Plan::Cut(cut) = &plans[segment.file] {
            let (offset, mut before) = tally.locate(cut, options, row - segment.first, step)?;
            before.add(segment.before);
            marks.push([row, segment.file as u64, offset, before.lines, before.rows]);
        }
    }
    Ok(marks)
}

/// Rows that a process holds.
pub(super) struct Rows {
    /// The points.
    pub points: Points,
    /// The weight of each point. Empty if the points have no weights, or their file has not been read.
    pub weights: Vec<f64>,
    /// The number of each row in its file, and later in the input. Empty if no row of the input was dropped.
    pub index: Vec<u64>,
}

impl Rows {
    /// Creates an empty set.
    pub fn new(dimension: usize) -> Self {
        Rows { points: Points::of(dimension, &[]), weights: Vec::new(), index: Vec::new() }
    }

    /// Appends rows of the same dimension.
    pub fn add(&mut self, mut more: Rows) {
        self.index.append(&mut more.index);
        append(&mut self.weights, more.weights);
        match (&mut self.points, more.points) {
            (Points::Plane(all), Points::Plane(more)) => append(all, more),
            (Points::Space(all), Points::Space(more)) => append(all, more),
            (Points::Higher(HigherPoints::Four(all)), Points::Higher(HigherPoints::Four(more))) => {
                append(all, more);
            }
            (Points::Higher(HigherPoints::Five(all)), Points::Higher(HigherPoints::Five(more))) => {
                append(all, more);
            }
            (Points::Higher(HigherPoints::Six(all)), Points::Higher(HigherPoints::Six(more))) => {
                append(all, more)
            }
            _ => {}
        }
    }
}

/// Appends values, without a copy if there are none before.
fn append<P>(all: &mut Vec<P>, mut more: Vec<P>) {
    if all.is_empty() { *all = more } else { all.append(&mut more) }
}

/// The files that a process reads, and the options.
pub(super) struct Reading<'a> {
    /// The plans of the files.
    pub plans: &'a [Plan],
    /// The rows of the files.
    pub all: &'a AllRows,
    /// The options.
    pub options: &'a ReadOptions,
    /// The number of bytes to read at a time.
    pub step: usize,
}

impl Reading<'_> {
    /// Reads the rows of a block. `marks` are the places of the first rows of all blocks, and `whole` are the rows that
    /// process 0 has sent, per file. Also returns what is known of the part of each file.
    pub fn block(
        &self,
        own: &Range<u64>,
        marks: &BTreeMap<u64, Mark>,
        whole: Vec<Rows>,
    ) -> Result<(Rows, Vec<PartFacts>), SharedError> {
        let mut block = Rows::new(self.all.dimension(self.options));
        let (mut facts, mut whole) = (Vec::new(), whole.into_iter());
        for (at, (plan, file)) in self.plans.iter().zip(&self.all.files).enumerate() {
            let mut rows = match plan {
                Plan::Whole(_) => whole.next(),
                Plan::Cut(cut) => {
                    let end = file.first_kept + file.counts.kept;
                    let window = own.start.max(file.first_kept)..own.end.min(end);
                    if window.is_empty() {
                        continue;
                    }
                    let (rows, of_part) = self.part(cut, at, window, marks)?;
                    facts.push(of_part);
                    Some(rows)
                }
            };
            for rows in rows.iter_mut().filter(|rows| !rows.points.is_empty()) {
                rows.index.iter_mut().for_each(|row| *row += file.first_row);
            }
            // A file without rows may have another dimension.
            if let Some(rows) = rows.filter(|rows| !rows.points.is_empty()) {
                block.add(rows);
            }
        }
        Ok((block, facts))
    }

    /// Reads rows of a file, which are given by their numbers among all rows that are not dropped.
    fn part(
        &self,
        cut: &Cut,
        at: usize,
        window: Range<u64>,
        marks: &BTreeMap<u64, Mark>,
    ) -> Result<(Rows, PartFacts), SharedError> {
        let file = &self.all.files[at];
        let mark = |row: u64| {
            let mark = marks.get(&row).filter(|mark| mark[1] == at as u64);
            mark.copied().ok_or_else(|| SharedError::Changed { path: cut.path.clone() })
        };
        let [_, _, start, mut lines, before] = if window.start == file.first_kept {
            [window.start, at as u64, cut.rows.start, cut.lines, 0]
        } else {
            mark(window.start)?
        };
        let end = if window.end == file.first_kept + file.counts.kept {
            cut.rows.end
        } else {
            mark(window.end)?[2]
        };
        let refused =
            |error: InputError| SharedError::of(cut.refused(error), self.plans.len(), file.first_row);
        let collector = cut.collector(self.options, window.end - window.start, before);
        let (mut points, mut rounded) = (collector.map_err(refused)?, 0);
        OpenFile::of(&cut.path, self.step)?.chunks(start..end, cut.unit(), &mut |offset, bytes| {
            let chunk = Chunk { offset, lines, bytes };
            let of_chunk = cut.add(self.options, &chunk, &mut points).map_err(refused)?;
            rounded += of_chunk.rounded;
            lines += of_chunk.lines;
            Ok(())
        })?;
        let met = points.met;
        let found = points.finish();
        let facts = part_facts(at, rounded, cut.counting(&found, before));
        let index = match found.source_index {
            _ if self.all.skipped == 0 => Vec::new(),
            Some(index) => index,
            None => (before..met).collect(),
        };
        let weights = found.weights.unwrap_or_default();
        Ok((Rows { points: found.points, weights, index }, facts))
    }
}
