//! Lists of cells: rows of point ids, which are checked and converted to zero-based indices.

use super::error::{InputError, Place};
use super::listed::ListedFile;
use super::text::{Line, Lines, Source, integer};
use crate::format::Format;

/// The options for reading a file of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellOptions {
    /// The format. By default, the file name determines it, or the content if the name does not.
    pub format: Option<Format>,
    /// The id of the first point in an `.ele` file: 0 or 1, as in the `.node` file (`PointFile::first_id`). By default,
    /// it is the id of the first cell. Other formats fix this id.
    pub base: Option<u64>,
    /// The number of points, which bounds the indices. By default, it is the number of points in the file. If the file
    /// has no points, indices are not checked.
    pub point_count: Option<u64>,
    /// The dimension of the cells to read: 2 for triangles, 3 for tetrahedra. By default, tetrahedra are read if there
    /// are any, otherwise triangles. From a mesh (`.vtu`, `.vtk`, `.msh`, `.mesh`), only cells of this dimension are
    /// read. A plain list of cells of the other dimension is an error.
    pub dimension: Option<usize>,
}

/// The cells of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellFile {
    /// The dimension of the cells: 2 for triangles, 3 for tetrahedra.
    pub dimension: usize,
    /// The cells in file order, each of `dimension + 1` zero-based point indices.
    pub cells: Vec<u64>,
    /// The id of point 0 in the file.
    pub first_id: u64,
    /// Notes for the user, one line each.
    pub notes: Vec<String>,
    /// The files of the pieces of a `.pvtu` file with their cells, in their order. Empty for other formats.
    pub pieces: Vec<ListedFile>,
}

impl CellFile {
    /// Returns the number of cells.
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
    /// The number of points, if it is known.
    limit: Option<u64>,
    pub flat: Vec<u64>,
}

impl<'a> Indices<'a> {
    pub fn new(source: Source<'a>, width: usize, first: u64, limit: Option<u64>) -> Self {
        Indices { source, width, first, limit, flat: Vec::new() }
    }

    /// Returns the number of complete rows.
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

    /// Returns the error for an id that no point has.
    pub fn out_of_range(&self, place: Place, value: i128) -> InputError {
        let (path, cell) = (self.source.path.to_owned(), self.rows());
        InputError::OutOfRangeIndex { path, place, cell, value, first: self.first, limit: self.limit }
    }

    /// Adds one row from the next words of a line. Later words are not read.
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

    /// Returns the cells together with `notes`.
    pub fn finish(self, notes: Vec<String>) -> CellFile {
        CellFile {
            dimension: self.width - 1,
            cells: self.flat,
            first_id: self.first,
            notes,
            pieces: Vec::new(),
        }
    }
}

/// Parses one of the point ids of a cell with `width` points.
pub(super) fn index(
    source: Source<'_>,
    line: &Line<'_>,
    word: Option<&[u8]>,
    width: usize,
) -> Result<i64, InputError> {
    let word = word.ok_or_else(|| source.bad_line(line, format!("{width} point ids")))?;
    integer(word).ok_or_else(|| source.bad_word(line, word, "a point id"))
}

/// Reads an `.ele` file of `TetGen` or Triangle: `cells corners attributes`, then `id a b c [d] …`.
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
        let expected_id = first + cells.rows();
        if id != Some(expected_id) {
            return Err(source.bad_word(
                &line,
                word,
                format!("the cell id {expected_id}, ids consecutive from 0 or 1"),
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
