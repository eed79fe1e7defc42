//! Cell lists: rows of point indices, checked and made zero-based.

use super::error::{InputError, Place};
use super::format::Format;
use super::text::{Line, Lines, Source, integer};

/// How to read a file of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellOptions {
    /// The format; by default the file's name or content tells.
    pub format: Option<Format>,
    /// The id of the first point in an `.ele` file, 0 or 1, best taken from the `.node` file
    /// (`PointFile::first_id`); by default the id of the first cell. Other formats know theirs.
    pub base: Option<u64>,
    /// The number of points there are, so that indices can be checked; by default the number in
    /// the file itself, if it holds points, else unchecked.
    pub point_count: Option<u64>,
    /// 2: take the triangles, 3: take the tetrahedra of a mesh; by default tetrahedra if there are
    /// any. A list of the other kind is refused.
    pub dimension: Option<usize>,
}

/// The cells of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellFile {
    /// 2 (triangles) or 3 (tetrahedra).
    pub dimension: usize,
    /// `dimension + 1` zero-based point indices per cell, cell after cell, in file order.
    pub cells: Vec<u64>,
    /// The id the file gave to point 0.
    pub first_id: u64,
    /// Remarks for the user, one line each.
    pub notes: Vec<String>,
}

impl CellFile {
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / (self.dimension + 1)
    }
}

/// The rows read so far.
pub(super) struct Indices<'a> {
    source: Source<'a>,
    width: usize,
    /// The id of point 0.
    first: u64,
    /// Number of points, where known.
    limit: Option<u64>,
    pub flat: Vec<u64>,
}

impl<'a> Indices<'a> {
    pub fn new(source: Source<'a>, width: usize, first: u64, limit: Option<u64>) -> Self {
        Indices { source, width, first, limit, flat: Vec::new() }
    }

    /// Complete rows.
    pub fn rows(&self) -> u64 {
        (self.flat.len() / self.width) as u64
    }

    /// Adds one id.
    pub fn push(&mut self, place: Place, value: i128) -> Result<(), InputError> {
        let index = u64::try_from(value - i128::from(self.first)).ok();
        match index.filter(|i| self.limit.is_none_or(|limit| *i < limit)) {
            Some(index) => self.flat.push(index),
            None => return Err(self.out_of_range(place, value)),
        }
        Ok(())
    }

    /// An id that is no point's.
    pub fn out_of_range(&self, place: Place, value: i128) -> InputError {
        let (path, cell) = (self.source.path.to_owned(), self.rows());
        InputError::OutOfRangeIndex { path, place, cell, value, first: self.first, limit: self.limit }
    }

    /// Adds one row from the next words; what follows them is left alone.
    pub fn push_words(
        &mut self,
        line: &Line<'_>,
        words: &mut dyn Iterator<Item = &[u8]>,
    ) -> Result<(), InputError> {
        for _ in 0..self.width {
            let value = index(self.source, line, words.next(), self.width)?;
            self.push(line.place(), i128::from(value))?;
        }
        Ok(())
    }

    /// The result.
    pub fn finish(self, notes: Vec<String>) -> CellFile {
        CellFile { dimension: self.width - 1, cells: self.flat, first_id: self.first, notes }
    }
}

/// One point id of a cell of `width` points.
pub(super) fn index(
    source: Source<'_>,
    line: &Line<'_>,
    word: Option<&[u8]>,
    width: usize,
) -> Result<i64, InputError> {
    let word = word.ok_or_else(|| source.bad_line(line, format!("{width} point ids")))?;
    integer(word).ok_or_else(|| source.bad_word(line, word, "a point id"))
}

/// TetGen and Triangle `.ele`: `cells corners attributes`, then `id a b c [d] …`.
pub(super) fn read_ele(source: Source<'_>, options: &CellOptions) -> Result<CellFile, InputError> {
    const HEADER: &str = "the header `cells corners attributes`";
    let mut lines = Lines::new(source.data);
    let header = lines.next_data().ok_or_else(|| source.truncated(Place::Line(1), "header line", 1, 0))?;
    let mut words = header.words();
    let announced = source.count(&header, words.next(), HEADER)?;
    let corners = source.count(&header, words.next(), HEADER)?;
    let width = match corners {
        3 | 6 => 3,
        4 | 10 => 4,
        _ => {
            return Err(source.bad_line(&header, "3 or 6 corners (triangles), 4 or 10 (tetrahedra)"));
        }
    };
    let mut cells = Indices::new(source, width, options.base.unwrap_or(0), options.point_count);
    let mut first = 0;
    while let Some(line) = lines.next_data() {
        if cells.rows() == announced {
            return Err(source.surplus(line.place(), "cells", announced));
        }
        let mut words = line.words();
        let word = words.next().unwrap_or_default();
        let id = integer(word).and_then(|id| u64::try_from(id).ok());
        if cells.rows() == 0 && matches!(id, Some(0 | 1)) {
            first = id.unwrap_or(0);
            cells.first = options.base.unwrap_or(first);
        }
        let due = first + cells.rows();
        if id != Some(due) {
            return Err(source.bad_word(
                &line,
                word,
                format!("the cell id {due}, ids rising by one from 0 or 1"),
            ));
        }
        cells.push_words(&line, &mut words)?;
    }
    if cells.rows() < announced {
        return Err(source.truncated(Place::Line(lines.number()), "cells", announced, cells.rows()));
    }
    let quadratic = corners as usize > width;
    Ok(cells.finish(
        quadratic.then(|| "nodes on the edges of cells are ignored".to_owned()).into_iter().collect(),
    ))
}
