//! The part of the files in which a process counts rows.

use std::ops::Range;

use super::super::points::ReadOptions;
use super::chunks::{OpenFile, Unit};
use super::cut::{Chunk, Counts};
use super::error::SharedError;
use super::survey::{Cut, Form, Plan};

/// The rows of a part of a file.
pub(super) struct Tally {
    /// The number of the file.
    pub file: usize,
    /// The bytes of the part.
    pub range: Range<u64>,
    /// The lines and rows.
    pub counts: Counts,
    /// Offsets in the part, each with the counts before it.
    marks: Vec<(u64, Counts)>,
}

/// Counts the rows in the part of a process. All processes divide the bytes of the files into parts of equal size.
pub(super) fn tally(
    plans: &[Plan],
    options: &ReadOptions,
    (process, processes): (u32, u32),
    step: usize,
) -> Result<Vec<Tally>, SharedError> {
    let size = |plan: &Plan| match plan {
        Plan::Cut(cut) => cut.rows.end - cut.rows.start,
        Plan::Whole(_) => 0,
    };
    let total: u64 = plans.iter().map(size).sum();
    let cut = |process: u32| (u128::from(total) * u128::from(process) / u128::from(processes)) as u64;
    let part = cut(process)..cut(process + 1);
    let (mut tallies, mut before) = (Vec::new(), 0);
    for (file, plan) in plans.iter().enumerate() {
        let size = size(plan);
        let [from, to] = [part.start, part.end].map(|at| at.saturating_sub(before).min(size));
        before += size;
        if let Plan::Cut(cut) = plan
            && from < to
        {
            let range = cut.rows.start + from..cut.rows.start + to;
            tallies.extend(of_range(cut, options, file, range, step)?);
        }
    }
    Ok(tallies)
}

/// Counts the rows that begin in a range of a file. Returns `None` if there are none.
fn of_range(
    cut: &Cut,
    options: &ReadOptions,
    file: usize,
    range: Range<u64>,
    step: usize,
) -> Result<Option<Tally>, SharedError> {
    let mut open = OpenFile::of(&cut.path, step)?;
    let (start, end) = (cut.boundary(&mut open, range.start)?, cut.boundary(&mut open, range.end)?);
    if start >= end {
        return Ok(None);
    }
    let mut tally = Tally { file, range: start..end, counts: Counts::default(), marks: Vec::new() };
    if let (Unit::Bytes(size), false) = (cut.unit(), options.skip_invalid) {
        let rows = (end - start) / size.max(1);
        tally.counts = Counts { rows, kept: rows, ..Counts::default() };
        return Ok(Some(tally));
    }
    let base = tally.lines_before(cut);
    open.chunks(start..end, cut.unit(), &mut |offset, bytes| {
        let chunk = Chunk { offset, lines: base + tally.counts.lines, bytes };
        let counts = cut.count(options, &chunk);
        tally.marks.push((offset, tally.counts));
        tally.counts.add(counts);
        Ok(())
    })?;
    Ok(Some(tally))
}

impl Tally {
    /// Returns the number of lines before the part, or a larger one if it is unknown.
    fn lines_before(&self, cut: &Cut) -> u64 {
        match &cut.form {
            Form::Table(head) if self.range.start != cut.rows.start => head.line,
            _ => cut.lines,
        }
    }

    /// Returns the offset of a row, and the counts before it. The row is given by its number among the kept rows of the
    /// part.
    pub fn locate(
        &self,
        cut: &Cut,
        options: &ReadOptions,
        kept: u64,
        step: usize,
    ) -> Result<(u64, Counts), SharedError> {
        if let (Unit::Bytes(size), false) = (cut.unit(), options.skip_invalid) {
            let before = Counts { rows: kept, kept, ..Counts::default() };
            return Ok((self.range.start + kept * size, before));
        }
        let next = self.marks.partition_point(|(_, before)| before.kept <= kept);
        let Some(&(offset, mut before)) = next.checked_sub(1).and_then(|at| self.marks.get(at)) else {
            return Ok((self.range.start, Counts::default()));
        };
        let end = self.marks.get(next).map_or(self.range.end, |(offset, _)| *offset);
        let mut bytes = Vec::new();
        OpenFile::of(&cut.path, step)?.read(offset..end, &mut bytes)?;
        let chunk = Chunk { offset, lines: self.lines_before(cut) + before.lines, bytes: &bytes };
        let (length, within) = cut.locate(options, &chunk, kept - before.kept);
        before.add(within);
        Ok((offset + length, before))
    }
}
