//! Joins the points of the files of a list.
//!
//! The files are read one after another, and the points of each are appended to one vector. At any time, only one file
//! is in memory besides the points so far.

use std::collections::TryReserveError;
use std::fs;
use std::path::{Path, PathBuf};

use septet_core::model::{HigherPoints, Points};

use super::super::dispatch::read;
use super::super::error::InputError;
use super::super::listed::ListedFile;
use super::super::points::{CoordinateType, PointFile, ReadOptions, ReadProgress};
use super::super::reading::FileReading;
use super::super::weight_file;
use super::columns;
use super::error::ListError;
use super::files::FileList;
use super::notes::Notes;

/// The points of all files of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct PointList {
    /// The points in the order of the files. The indices and [`PointFile::source_index`] count the points of all files.
    /// [`PointFile::first_id`] is 1 if all files with points number them from 1, otherwise 0.
    pub content: PointFile,
    /// The files in their order.
    pub files: Vec<ListedFile>,
}

impl PointList {
    /// Returns the file of a point, given by its zero-based row in the list. Dropped points count.
    pub fn file_of(&self, row: u64) -> Option<&ListedFile> {
        ListedFile::of_row(&self.files, row)
    }
}

/// The bytes of the files read so far, and of all files.
#[derive(Clone, Copy)]
struct Extent {
    done: u64,
    total: u64,
}

/// The points of the files read so far.
struct Joined<'o> {
    options: &'o ReadOptions,
    content: Option<PointFile>,
    files: Vec<ListedFile>,
    rows: u64,
    /// The first file with points.
    first: PathBuf,
    /// The first binary file with points.
    first_type: Option<(CoordinateType, PathBuf)>,
    notes: Notes,
    reading: FileReading,
}

/// Reads the points of all files of a list as one set. `progress` receives the bytes of all files.
///
/// Files may be empty, and text tables may have a header row without rows. The formats of the files may differ. All files
/// with points must have the same dimension, kept columns of the same names, and, if they are binary, coordinates of the
/// same type.
///
/// # Errors
/// Returns [`ListError`] if a file cannot be read, or does not agree with the files before it.
pub fn read_list(
    list: &FileList,
    options: &ReadOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<PointList, ListError> {
    let size = |path: &PathBuf| fs::metadata(path).map_or(0, |found| found.len());
    let sizes: Vec<u64> = list.files().iter().map(size).collect();
    let mut extent = Extent { done: 0, total: sizes.iter().sum() };
    let mut joined = Joined {
        options,
        content: None,
        files: Vec::new(),
        rows: 0,
        first: PathBuf::new(),
        first_type: None,
        notes: Notes::default(),
        reading: FileReading::default(),
    };
    let of_file = &*options.without_weight_file();
    for (path, size) in list.files().iter().zip(&sizes) {
        let mut step = |read: u64, _| progress(extent.done + read, Some(extent.total));
        let file = match read(path, of_file, &mut step) {
            // A part of a table may have no rows.
            Err(InputError::NoRows { .. }) => empty(options),
            file => file.map_err(|error| ListError::File { error: Box::new(error), before: joined.rows })?,
        };
        extent.done += size;
        joined.add(path, file, extent)?;
    }
    let PointList { content, files } = joined.finish();
    let content = weight_file::joined(content, options, progress);
    Ok(PointList { content: content.map_err(|error| ListError::Weights { error: Box::new(error) })?, files })
}

/// Returns a file without points.
pub(in super::super) fn empty(options: &ReadOptions) -> PointFile {
    let plane_or_space = if options.terrain { 2 } else { 3 };
    let points = Points::of(options.dimension.unwrap_or(plane_or_space), &[]);
    let weights = options.weight_column().map(|_| Vec::new());
    PointFile { heights: options.terrain.then(Vec::new), weights, ..PointFile::of_points(points) }
}

impl Joined<'_> {
    /// Appends the points of the next file.
    fn add(&mut self, path: &Path, mut file: PointFile, extent: Extent) -> Result<(), ListError> {
        let rows = (file.points.len() + file.skipped) as u64;
        self.files.push(ListedFile { path: path.to_owned(), first_row: self.rows, rows });
        self.notes.add(path, std::mem::take(&mut file.notes));
        self.reading.add(&file.reading);
        if rows > 0 {
            self.check_type(path, file.coordinate_type)?;
        }
        match &mut self.content {
            Some(content) if self.rows > 0 => {
                if rows > 0 {
                    append(content, file, (path, &self.first), (self.rows, extent))?;
                }
            }
            // Files without points do not determine the dimension of the others.
            content => {
                if rows > 0 || content.is_none() {
                    path.clone_into(&mut self.first);
                    *content = Some(file);
                }
            }
        }
        self.rows += rows;
        Ok(())
    }

    /// Compares the type of coordinates with the one of the first binary file.
    fn check_type(&mut self, path: &Path, found: Option<CoordinateType>) -> Result<(), ListError> {
        match (found, &self.first_type) {
            (Some(found), Some((expected, first))) if found != *expected => {
                let (path, first) = (path.to_owned(), first.clone());
                return Err(ListError::MixedTypes { path, found, first, expected: *expected });
            }
            (Some(found), None) => self.first_type = Some((found, path.to_owned())),
            _ => {}
        }
        Ok(())
    }

    fn finish(self) -> PointList {
        let mut content = self.content.unwrap_or_else(|| empty(self.options));
        content.notes = self.notes.lines();
        content.reading = self.reading;
        content.coordinate_type = self.first_type.map(|(kind, _)| kind);
        PointList { content, files: self.files }
    }
}

/// Appends the points of a file with `before` rows before it. `first` is the first file with points.
fn append(
    all: &mut PointFile,
    file: PointFile,
    (path, first): (&Path, &Path),
    (before, extent): (u64, Extent),
) -> Result<(), ListError> {
    let (known, added) = (all.points.len(), file.points.len());
    let (width, other) = (all.points.dimension(), file.points.dimension());
    let reserved = match (&mut all.points, file.points) {
        (Points::Plane(all), Points::Plane(more)) => extend(all, more, extent),
        (Points::Space(all), Points::Space(more)) => extend(all, more, extent),
        (Points::Higher(HigherPoints::Four(all)), Points::Higher(HigherPoints::Four(more))) => {
            extend(all, more, extent)
        }
        (Points::Higher(HigherPoints::Five(all)), Points::Higher(HigherPoints::Five(more))) => {
            extend(all, more, extent)
        }
        (Points::Higher(HigherPoints::Six(all)), Points::Higher(HigherPoints::Six(more))) => {
            extend(all, more, extent)
        }
        _ => {
            let (path, first) = (path.to_owned(), first.to_owned());
            return Err(ListError::MixedDimension { path, found: other, first, expected: width });
        }
    };
    reserved.map_err(|_| {
        let bytes = ((known + added) * 8 * width) as u64;
        let error = Box::new(InputError::OutOfMemory { path: path.to_owned(), bytes });
        ListError::File { error, before }
    })?;
    if let (Some(all), Some(more)) = (&mut all.heights, file.heights) {
        all.extend(more);
    }
    if let (Some(all), Some(more)) = (&mut all.weights, file.weights) {
        all.extend(more);
    }
    columns::append(&mut all.columns, file.columns, (path, first))?;
    if file.skipped > 0 && all.source_index.is_none() {
        all.source_index = Some((0..known as u64).collect());
    }
    if let Some(index) = &mut all.source_index {
        match file.source_index {
            Some(own) => index.extend(own.into_iter().map(|row| before + row)),
            None => index.extend(before..before + added as u64),
        }
    }
    all.rounded += file.rounded;
    all.skipped += file.skipped;
    all.first_id = all.first_id.min(file.first_id);
    Ok(())
}

/// Appends points. If the vector must grow, it reserves memory for the files that follow, which have about as many
/// points per byte as the files so far.
fn extend<P>(all: &mut Vec<P>, mut more: Vec<P>, extent: Extent) -> Result<(), TryReserveError> {
    if all.capacity() - all.len() < more.len() {
        let known = (all.len() + more.len()) as u128;
        let expected = known * u128::from(extent.total.max(extent.done)) / u128::from(extent.done.max(1));
        let expected = usize::try_from(expected).unwrap_or(usize::MAX).saturating_sub(all.len());
        all.try_reserve_exact(expected.max(more.len())).or_else(|_| all.try_reserve_exact(more.len()))?;
    }
    all.append(&mut more);
    Ok(())
}
