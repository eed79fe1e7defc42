//! Medit `.mesh`, ASCII.

use crate::read::cells::index;
use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::mesh::{CellKind, FileMesh};
use crate::read::points::ReadOptions;
use crate::read::text::{Line, Lines, Source, Words, excerpt, number};

/// The words of the file with their lines. The format ignores line breaks.
struct Tokens<'a> {
    source: Source<'a>,
    lines: Lines<'a>,
    line: Line<'a>,
    words: Words<'a>,
}

impl<'a> Tokens<'a> {
    fn new(source: Source<'a>) -> Self {
        let line = Line { number: 0, text: b"" };
        Tokens { source, lines: Lines::new(source.data), line, words: line.words() }
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            self.line = self.lines.next_data()?;
            self.words = self.line.words();
        }
    }

    /// Returns the next word, or `None` if it begins a section.
    fn value(&mut self) -> Option<&'a [u8]> {
        let before = (self.line, self.words.clone(), self.lines.clone());
        let word = self.next()?;
        if is_keyword(word) {
            (self.line, self.words, self.lines) = before;
            return None;
        }
        Some(word)
    }

    fn count(&mut self, what: &'static str) -> Result<u64, InputError> {
        let word = self.next();
        self.source.count(&self.line, word, what)
    }

    /// Returns the words of a row. Its last word is a reference number, which the caller ignores.
    fn row(&mut self, width: usize) -> Option<[&'a [u8]; 4]> {
        let mut row = [b"".as_slice(); 4];
        for slot in &mut row[..width] {
            *slot = self.value()?;
        }
        self.value()?;
        Some(row)
    }
}

/// Returns `true` for a keyword, and `false` for a number such as `NaN`.
fn is_keyword(word: &[u8]) -> bool {
    word.first().is_some_and(u8::is_ascii_uppercase) && number(word).is_none()
}

/// Reads the mesh.
pub fn parse<'a>(source: Source<'a>, options: &ReadOptions) -> Result<FileMesh<'a>, InputError> {
    let options = &ReadOptions { dimension: None, ..options.clone() };
    let mut tokens = Tokens::new(source);
    if tokens.next() != Some(b"MeshVersionFormatted".as_slice()) {
        return Err(source.bad_line(&tokens.line, "the keyword MeshVersionFormatted (ASCII Medit)"));
    }
    tokens.count("the version of the format")?;
    let mut dimension = 3;
    let mut mesh: Option<FileMesh<'a>> = None;
    while let Some(word) = tokens.next() {
        match (word, &mut mesh) {
            (b"Dimension", None) => {
                dimension = tokens.count("the dimension")?;
                if !(2..=3).contains(&dimension) {
                    let (path, place) = (source.path.to_owned(), tokens.line.place());
                    return Err(InputError::UnsupportedDimension { path, place, found: dimension });
                }
            }
            (b"Vertices", None) => {
                let points = read_vertices(&mut tokens, options, dimension as usize)?;
                mesh = Some(FileMesh::new(source, points, 1));
            }
            (b"Triangles", Some(mesh)) => read_cells(&mut tokens, mesh, CellKind::Triangle)?,
            (b"Tetrahedra", Some(mesh)) => read_cells(&mut tokens, mesh, CellKind::Tetrahedron)?,
            (b"Dimension" | b"Vertices" | b"Triangles" | b"Tetrahedra", _) => {
                return Err(source.bad_word(
                    &tokens.line,
                    word,
                    "one Dimension, then one list of Vertices, then cells",
                ));
            }
            (b"End", _) => break,
            _ if is_keyword(word) => {
                let place = tokens.line.place();
                let first = tokens.value();
                let solid = matches!(word, b"Quadrilaterals" | b"Hexahedra" | b"Prisms" | b"Pyramids");
                if let (true, Some(mesh)) = (solid && first != Some(b"0"), &mut mesh) {
                    mesh.other.get_or_insert_with(|| (place, format!("the section {}", excerpt(word))));
                }
                while tokens.value().is_some() {}
            }
            _ => return Err(source.bad_word(&tokens.line, word, "a keyword such as Vertices")),
        }
    }
    mesh.ok_or_else(|| source.truncated(Place::Line(tokens.lines.number()), "section Vertices", 1, 0))
}

fn read_vertices<'a>(
    tokens: &mut Tokens<'a>,
    options: &ReadOptions,
    dimension: usize,
) -> Result<Collector<'a>, InputError> {
    let announced = tokens.count("the number of vertices")?;
    let size = (announced, tokens.lines.rest().len(), 2 * dimension + 2);
    let mut points = Collector::new(tokens.source, options, (tokens.line.place(), dimension), size)?;
    while points.met < announced {
        let Some(row) = tokens.row(dimension) else {
            return Err(tokens.source.truncated(tokens.line.place(), "vertices", announced, points.met));
        };
        points.push_words(&tokens.line, &mut row.into_iter())?;
    }
    if tokens.value().is_some() {
        return Err(tokens.source.surplus(tokens.line.place(), "vertices", announced));
    }
    Ok(points)
}

fn read_cells(tokens: &mut Tokens<'_>, mesh: &mut FileMesh<'_>, kind: CellKind) -> Result<(), InputError> {
    let announced = tokens.count("the number of cells")?;
    let width = if kind == CellKind::Triangle { 3 } else { 4 };
    let Some(list) = mesh.list(kind) else {
        return Ok(());
    };
    for found in 0..announced {
        let Some(row) = tokens.row(width) else {
            return Err(tokens.source.truncated(tokens.line.place(), "cells", announced, found));
        };
        for word in &row[..width] {
            let value = index(tokens.source, &tokens.line, Some(word), width)?;
            list.push(tokens.line.place(), i128::from(value))?;
        }
    }
    if tokens.value().is_some() {
        return Err(tokens.source.surplus(tokens.line.place(), "cells", announced));
    }
    Ok(())
}
