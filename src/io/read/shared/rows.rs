//! The rows of all files, as all processes know them.

use std::path::PathBuf;

use super::super::error::{InputError, Place};
use super::super::list::ListError;
use super::super::listed::ListedFile;
use super::super::points::{CoordinateType, ReadOptions};
use super::super::reading::{FileReading, OtherLines};
use super::cut::Counts;
use super::error::SharedError;
use super::facts::{PartFacts, counting_of};
use super::survey::{Cut, Form, Plan};
use super::tally::Tally;

/// A part of a file in which one process has counted rows, as the processes exchange it: the number of the file, lines, line
/// feeds, rows, rows that are not dropped, comments, and blank lines.
pub(super) type Part = [u64; 7];

/// Returns the parts of this process as they travel.
pub(super) fn parts(tallies: &[Tally]) -> Vec<Part> {
    let part = |Tally { file, counts, .. }: &Tally| {
        let Counts { lines, feeds, rows, kept, other } = *counts;
        [*file as u64, lines, feeds, rows, kept, other.comments, other.blank]
    };
    tallies.iter().map(part).collect()
}

/// A file that process 0 has read, as the processes exchange it: the numbers of [`WholeFile`], the numbers of lines that are
/// no rows, its notes, the names of its columns, and the names of those that are ignored.
pub(super) type WholeRow = ([u64; 5], [u64; 4], [Vec<String>; 3]);

/// The facts of a file that process 0 has read. All processes need them.
pub(super) struct WholeFile {
    pub rows: u64,
    pub kept: u64,
    pub dimension: usize,
    pub first_id: u64,
    pub kind: Option<CoordinateType>,
    pub notes: Vec<String>,
    pub reading: FileReading,
}

/// The types of coordinates, in the order of their numbers from 1.
const KINDS: [CoordinateType; 3] =
    [CoordinateType::Float32, CoordinateType::Float64, CoordinateType::Integer];

impl WholeFile {
    /// Returns the facts as they travel.
    pub fn row(&self) -> WholeRow {
        let kind = self.kind.and_then(|kind| KINDS.iter().position(|of| *of == kind)).map_or(0, |at| at + 1);
        let FileReading { columns, ignored, lines, .. } = &self.reading;
        let texts = [&self.notes, columns, ignored].map(Clone::clone);
        ([self.rows, self.kept, self.dimension as u64, self.first_id, kind as u64], lines.counts(), texts)
    }

    /// Returns the file that process 0 has sent.
    pub fn of((numbers, lines, [notes, columns, ignored]): WholeRow) -> Self {
        let [rows, kept, dimension, first_id, kind] = numbers;
        let reading = FileReading { rows, columns, ignored, lines: OtherLines::of_counts(lines) };
        let kind = kind.checked_sub(1).and_then(|at| KINDS.get(at as usize).copied());
        WholeFile { rows, kept, dimension: dimension as usize, first_id, kind, notes, reading }
    }
}

/// The rows of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct FileRows {
    /// The number of rows in the files before it.
    pub first_row: u64,
    /// The number of rows that are not dropped in the files before it.
    pub first_kept: u64,
    /// The lines and rows of the file.
    pub counts: Counts,
    /// The record of reading it.
    pub reading: FileReading,
    dimension: usize,
    kind: Option<CoordinateType>,
    first_id: u64,
}

/// A part of a file, its process, and the rows before it.
pub(super) struct Segment {
    /// The number of the file.
    pub file: usize,
    /// The process that has counted its rows.
    pub process: u32,
    /// The number of its rows that are not dropped.
    pub kept: u64,
    /// The number of rows that are not dropped before it, in all files.
    pub first: u64,
    /// The lines and rows of the file before it.
    pub before: Counts,
}

/// The rows of all files.
pub(super) struct AllRows {
    /// One entry per file.
    pub files: Vec<FileRows>,
    /// The parts of the files that are cut, in the order of the rows.
    pub segments: Vec<Segment>,
    /// The number of rows that are not dropped.
    pub kept: u64,
    /// The number of rows that are dropped.
    pub skipped: u64,
}

impl AllRows {
    /// Adds up the parts of all processes, and the files that process 0 has read, in their order.
    pub fn of(plans: &[Plan], parts: &[Vec<Part>], whole: &[WholeFile]) -> Self {
        let mut all = AllRows { files: Vec::new(), segments: Vec::new(), kept: 0, skipped: 0 };
        let mut of_files = vec![Vec::new(); plans.len()];
        for (process, parts) in parts.iter().enumerate() {
            for &part in parts {
                if let Some(parts) = of_files.get_mut(part[0] as usize) {
                    parts.push((process as u32, part));
                }
            }
        }
        let mut whole = whole.iter();
        let mut rows = 0;
        for (at, (plan, parts)) in plans.iter().zip(of_files).enumerate() {
            let mut file = FileRows { first_row: rows, first_kept: all.kept, ..FileRows::default() };
            match plan {
                Plan::Cut(cut) => {
                    (file.dimension, file.kind) = (cut.dimension, cut.coordinate_type());
                    all.add_parts(at, cut, parts, &mut file);
                }
                Plan::Whole(_) => {
                    if let Some(found) = whole.next() {
                        file.reading = found.reading.clone();
                        (file.counts.rows, file.counts.kept) = (found.rows, found.kept);
                        (file.dimension, file.kind) = (found.dimension, found.kind);
                        file.first_id = found.first_id;
                    }
                }
            }
            rows += file.counts.rows;
            all.kept += file.counts.kept;
            all.files.push(file);
        }
        all.skipped = rows - all.kept;
        all
    }

    /// Adds the parts of a file, each with its process.
    fn add_parts(&mut self, at: usize, cut: &Cut, parts: Vec<(u32, Part)>, file: &mut FileRows) {
        file.counts = Counts { lines: cut.lines, feeds: cut.feeds, ..Counts::default() };
        for (process, [_, lines, feeds, rows, kept, comments, blank]) in parts {
            let before = file.counts;
            let first = file.first_kept + before.kept;
            self.segments.push(Segment { file: at, process, kept, first, before });
            let other = OtherLines { comments, blank, ..OtherLines::default() };
            file.counts.add(Counts { lines, feeds, rows, kept, other });
        }
        file.reading = cut.reading(&file.counts);
    }

    /// Returns the first file with rows, or the first file if no file has rows.
    fn leader(&self) -> Option<&FileRows> {
        self.files.iter().find(|file| file.counts.rows > 0).or(self.files.first())
    }

    /// Returns the number of coordinates of the points.
    pub fn dimension(&self, options: &ReadOptions) -> usize {
        self.leader().map_or(options.dimension.unwrap_or(3), |file| file.dimension)
    }

    /// Returns the type of the coordinates of the first binary file.
    pub fn coordinate_type(&self) -> Option<CoordinateType> {
        match &self.files[..] {
            [file] => file.kind,
            files => files.iter().filter(|file| file.counts.rows > 0).find_map(|file| file.kind),
        }
    }

    /// Returns the id of the first point.
    pub fn first_id(&self) -> u64 {
        let ids = self.files.iter().filter(|file| file.counts.rows > 0).map(|file| file.first_id);
        ids.min().or(self.leader().map(|file| file.first_id)).unwrap_or(0)
    }

    /// Returns the files with their rows.
    pub fn listed(&self, paths: &[PathBuf]) -> Vec<ListedFile> {
        let of = |(file, path): (&FileRows, &PathBuf)| ListedFile {
            path: path.clone(),
            first_row: file.first_row,
            rows: file.counts.rows,
        };
        self.files.iter().zip(paths).map(of).collect()
    }

    /// Checks that all files with rows have the same dimension and type of coordinates.
    pub fn check(&self, paths: &[PathBuf]) -> Result<(), SharedError> {
        let mut kind = None;
        let mut dimension = None;
        for (file, path) in self.files.iter().zip(paths).filter(|(file, _)| file.counts.rows > 0) {
            if let Some(found) = file.kind {
                let (expected, first) = *kind.get_or_insert((found, path));
                if found != expected {
                    let (path, first) = (path.clone(), first.clone());
                    return Err(ListError::MixedTypes { path, found, first, expected }.into());
                }
            }
            let (expected, first) = *dimension.get_or_insert((file.dimension, path));
            if file.dimension != expected {
                let (path, found, first) = (path.clone(), file.dimension, first.clone());
                return Err(ListError::MixedDimension { path, found, first, expected }.into());
            }
        }
        Ok(())
    }

    /// Returns what was read of all files.
    pub fn reading(&self) -> FileReading {
        let mut all = FileReading::default();
        self.files.iter().for_each(|file| all.add(&file.reading));
        all
    }

    /// Refuses tables whose first column counts their rows. `facts` are those of the parts of all processes.
    pub fn check_ids(&self, plans: &[Plan], facts: &[Vec<PartFacts>]) -> Result<(), SharedError> {
        for (at, (file, plan)) in self.files.iter().zip(plans).enumerate() {
            if let (Plan::Cut(cut), Some(counting)) = (plan, counting_of(at, facts)) {
                let refused = cut.refuse_ids(counting, file.counts.rows);
                refused.map_err(|error| SharedError::of(error, plans.len(), file.first_row))?;
            }
        }
        Ok(())
    }

    /// Checks that each table has as many rows as it announces.
    pub fn check_announced(&self, plans: &[Plan]) -> Result<(), SharedError> {
        for (file, plan) in self.files.iter().zip(plans) {
            let Plan::Cut(Cut { path, form: Form::Table(head), .. }) = plan else { continue };
            if let Some(announced) = head.announced
                && file.counts.rows < announced.count
            {
                let error = InputError::Truncated {
                    path: path.clone(),
                    place: Place::Line(file.counts.feeds + 1),
                    expected: announced.count,
                    found: file.counts.rows,
                    what: "points",
                };
                return Err(SharedError::of(error, plans.len(), file.first_row));
            }
        }
        Ok(())
    }
}
