//! Counts and reads the rows of a part of a file.

use super::super::collect::Collector;
use super::super::dispatch::a_domain;
use super::super::error::InputError;
use super::super::ids::Counting;
use super::super::points::PointFile;
use super::super::points::{CoordinateType, ReadOptions};
use super::super::reading::{FileReading, OtherLines};
use super::super::text::{Lines, Source, line_feeds};
use super::chunks::{OpenFile, Unit};
use super::error::SharedError;
use super::survey::{Cut, Form};

/// Whole rows of a file.
#[derive(Clone, Copy)]
pub(super) struct Chunk<'a> {
    /// The offset of the bytes in the file.
    pub offset: u64,
    /// The number of lines before the rows. Counts may use other numbers, which are all above the first row.
    pub lines: u64,
    /// The bytes.
    pub bytes: &'a [u8],
}

/// The lines and rows of a part of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// The number of lines.
    pub lines: u64,
    /// The number of line feeds, if the table announces its rows.
    pub feeds: u64,
    /// The number of rows.
    pub rows: u64,
    /// The number of rows that are not dropped.
    pub kept: u64,
    /// The comments, blank lines and header lines.
    pub other: OtherLines,
}

/// The content of a chunk that was added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Added {
    /// The number of lines.
    pub lines: u64,
    /// The number of integers that were rounded.
    pub rounded: u64,
}

impl Counts {
    /// Adds the counts of the part that follows.
    pub fn add(&mut self, next: Counts) {
        self.lines += next.lines;
        self.feeds += next.feeds;
        self.rows += next.rows;
        self.kept += next.kept;
        self.other.add(next.other);
    }
}

impl Cut {
    /// Returns where the file can be cut.
    pub fn unit(&self) -> Unit {
        match &self.form {
            Form::Table(_) => Unit::Lines,
            Form::Array(layout) => Unit::Bytes(layout.row_size()),
        }
    }

    /// Returns the type of the coordinates in a binary file.
    pub fn coordinate_type(&self) -> Option<CoordinateType> {
        match &self.form {
            Form::Table(_) => None,
            Form::Array(layout) => Some(layout.coordinate_type()),
        }
    }

    /// Returns the first beginning of a row at or after a position.
    pub fn boundary(&self, file: &mut OpenFile<'_>, at: u64) -> Result<u64, SharedError> {
        if at <= self.rows.start || at >= self.rows.end {
            return Ok(at.clamp(self.rows.start, self.rows.end));
        }
        match self.unit() {
            Unit::Lines => file.line_from(at..self.rows.end, self.rows.start),
            Unit::Bytes(size) => {
                let rows = (at - self.rows.start).div_ceil(size.max(1));
                Ok(self.rows.start + rows * size)
            }
        }
    }

    fn source(&self) -> Source<'_> {
        Source { path: &self.path, data: &[] }
    }

    /// Returns what was read of a file with these counts.
    pub fn reading(&self, counts: &Counts) -> FileReading {
        match &self.form {
            Form::Table(head) => head.reading(counts.rows, counts.other),
            Form::Array(_) => FileReading::of_rows(counts.rows),
        }
    }

    /// Looks at the first coordinates of points, which follow `before` points of the file, if the first column may count the
    /// rows.
    pub fn counting(&self, points: &PointFile, before: u64) -> Option<Counting> {
        let Form::Table(head) = &self.form else { return None };
        let row = |i: usize| points.source_index.as_ref().map_or(before + i as u64, |index| index[i]);
        Some(Counting::of(&points.points, head.counts_from? as f64, row))
    }

    /// Refuses a table of `rows` rows whose first column counts them.
    pub fn refuse_ids(&self, counting: Counting, rows: u64) -> Result<(), InputError> {
        match &self.form {
            Form::Table(head) => head.refuse_ids(self.source(), counting, rows),
            Form::Array(_) => Ok(()),
        }
    }

    /// Returns the error for a domain, if the file is one.
    pub fn refused(&self, error: InputError) -> InputError {
        if self.is_domain { a_domain(self.source(), "points") } else { error }
    }

    /// Creates a collector of `rows` points, which follow `before` points of the file.
    pub fn collector(
        &self,
        options: &ReadOptions,
        rows: u64,
        before: u64,
    ) -> Result<Collector<'_>, InputError> {
        let points = match &self.form {
            Form::Table(head) => {
                let bytes = usize::try_from(rows).unwrap_or(usize::MAX);
                head.collector(self.source(), options, (rows, bytes, 1))
            }
            Form::Array(layout) => layout.collector(self.source(), options, rows),
        };
        Ok(points?.after(before))
    }

    /// Adds the points of a chunk.
    pub fn add(
        &self,
        options: &ReadOptions,
        chunk: &Chunk<'_>,
        points: &mut Collector<'_>,
    ) -> Result<Added, InputError> {
        match &self.form {
            Form::Table(head) => {
                let (mut head, mut lines) = (head.clone(), Lines::after(chunk.bytes, chunk.lines));
                head.rows(self.source(), options, &mut lines, points)?;
                Ok(Added { lines: lines.number() - chunk.lines, rounded: 0 })
            }
            Form::Array(layout) => {
                let rounded = layout.rows_at(chunk.offset, chunk.bytes, points)?;
                Ok(Added { lines: 0, rounded })
            }
        }
    }

    /// Counts the lines and rows of a chunk.
    pub fn count(&self, options: &ReadOptions, chunk: &Chunk<'_>) -> Counts {
        let mut counts = Counts::default();
        match &self.form {
            Form::Table(head) => {
                let mut lines = Lines::after(chunk.bytes, chunk.lines);
                let found = head.count(&mut lines);
                (counts.rows, counts.other) = (found.rows, found.other);
                counts.lines = lines.number() - chunk.lines;
                if head.announced.is_some() {
                    counts.feeds = line_feeds(chunk.bytes);
                }
            }
            Form::Array(layout) => counts.rows = chunk.bytes.len() as u64 / layout.row_size().max(1),
        }
        counts.kept = if options.skip_invalid { self.kept(options, chunk, counts.rows) } else { counts.rows };
        counts
    }

    /// Counts the rows of a chunk that are not dropped. If a row is an error, all rows count, so that the process that
    /// reads this row reports it.
    fn kept(&self, options: &ReadOptions, chunk: &Chunk<'_>, rows: u64) -> u64 {
        let kept = self.collector(options, 0, 0).and_then(|mut points| {
            self.add(options, chunk, &mut points)?;
            Ok(points.len() as u64)
        });
        kept.unwrap_or(rows)
    }

    /// Returns the bytes and the counts before a row of a chunk, which is given by its number among the kept rows.
    pub fn locate(&self, options: &ReadOptions, chunk: &Chunk<'_>, kept: u64) -> (u64, Counts) {
        let (mut rest, mut before) = (chunk.bytes, Counts::default());
        while !rest.is_empty() {
            let length = match self.unit() {
                Unit::Lines => rest.len() - after_line(rest).len(),
                Unit::Bytes(size) => rest.len().min(size as usize),
            };
            let (row, after) = rest.split_at(length);
            let offset = chunk.offset + (chunk.bytes.len() - rest.len()) as u64;
            let row = Chunk { offset, lines: chunk.lines + before.lines, bytes: row };
            let counts = self.count(options, &row);
            if before.kept + counts.kept > kept {
                break;
            }
            before.add(counts);
            rest = after;
        }
        ((chunk.bytes.len() - rest.len()) as u64, before)
    }
}

/// Returns the bytes after the first line.
fn after_line(data: &[u8]) -> &[u8] {
    let mut lines = Lines::after(data, 0);
    let _ = lines.next();
    lines.rest()
}
