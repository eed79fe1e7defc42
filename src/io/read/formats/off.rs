//! Geomview `.off` files: vertices, and triangles as two-dimensional cells.
//!
//! OFF is a stream of numbers, but most writers put each vertex and each face on a line of its own, and some add colours to
//! the line. A file without such lines is read as a stream, in which each vertex has three numbers.

use crate::read::cells::{CellFile, Indices};
use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::faces::{Faces, position};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::signature::off_keyword;
use crate::read::text::{Line, Lines, Source, Words, excerpt, number};

/// The line with the counts, and the numbers of vertices and faces.
struct Header<'a> {
    line: Line<'a>,
    vertices: u64,
    faces: u64,
}

fn header<'a>(source: Source<'a>, lines: &mut Lines<'a>) -> Result<Header<'a>, InputError> {
    const COUNTS: &str = "the counts of vertices, faces and edges";
    let missing = || source.truncated(Place::Line(1), "header line", 1, 0);
    let mut line = lines.next_data().ok_or_else(missing)?;
    let mut words = line.words();
    let mut word = words.next();
    if let Some((whole, keyword)) = word.and_then(|word| Some((word, off_keyword(word)?))) {
        if keyword.contains(&b'4') || keyword.contains(&b'n') {
            let what = format!("{}, points of homogeneous or free dimension,", excerpt(keyword));
            return Err(source.unsupported(line.place(), what, "save as plain OFF"));
        }
        let glued = Some(&whole[keyword.len()..]).filter(|count| !count.is_empty());
        word = glued.or_else(|| words.next());
        if word == Some(b"BINARY".as_slice()) {
            return Err(source.unsupported(line.place(), "binary OFF", "save as ASCII OFF, or as PLY"));
        }
        if word.is_none() {
            line = lines
                .next_data()
                .ok_or_else(|| source.truncated(Place::Line(lines.number()), "header line", 1, 0))?;
            words = line.words();
            word = words.next();
        }
    } else if word.and_then(number).is_none() {
        return Err(source.bad_line(&line, "the keyword OFF"));
    }
    let vertices = source.count(&line, word, COUNTS)?;
    let faces = source.count(&line, words.next(), COUNTS)?;
    Ok(Header { line, vertices, faces })
}

/// The words of a file, each with its line.
struct Stream<'a> {
    lines: Lines<'a>,
    line: Line<'a>,
    words: Words<'a>,
}

impl<'a> Stream<'a> {
    /// Returns the words after the header if vertices and faces are not on lines of their own, but the file has enough
    /// words.
    fn of(header: &Header<'a>, lines: &Lines<'a>) -> Option<Self> {
        let wanted = header.vertices.saturating_add(header.faces);
        let (mut rest, mut found, mut is_by_lines) = (lines.clone(), 0, true);
        while is_by_lines && found < wanted {
            let line = rest.next_data();
            is_by_lines = line.is_some_and(|line| found >= header.vertices || line.words().nth(2).is_some());
            found += 1;
        }
        let line = Line { number: header.line.number, text: b"" };
        let stream = || Stream { lines: lines.clone(), line, words: line.words() };
        let least = header.vertices.saturating_mul(3).saturating_add(header.faces.saturating_mul(4));
        (!is_by_lines && stream().take(usize::try_from(least).ok()?).count() as u64 == least).then(stream)
    }

    /// Returns the next words, and the line of the first.
    fn several(&mut self, count: usize) -> Option<(Line<'a>, Vec<&'a [u8]>)> {
        let (line, first) = self.next()?;
        let mut words = vec![first];
        words.extend(self.take(count - 1).map(|(_, word)| word));
        (words.len() == count).then_some((line, words))
    }
}

impl<'a> Iterator for Stream<'a> {
    type Item = (Line<'a>, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(word) = self.words.next() {
                return Some((self.line, word));
            }
            self.line = self.lines.next_data()?;
            self.words = self.line.words();
        }
    }
}

/// The vertices on lines of their own.
struct Vertices<'a> {
    points: Collector<'a>,
    /// The lines after the vertices.
    lines: Lines<'a>,
    /// Whether the file has a line for each vertex, with at least three words.
    is_complete: bool,
    /// Whether a line has more words than coordinates.
    has_more: bool,
}

impl<'a> Vertices<'a> {
    /// Reads one vertex per line, as far as there are lines.
    fn read(mut points: Collector<'a>, mut lines: Lines<'a>, count: u64) -> Result<Self, InputError> {
        let (mut is_complete, mut has_more) = (true, false);
        let in_space = points.dimension() == 3;
        while points.met < count {
            let Some(line) = lines.next_data() else {
                is_complete = false;
                break;
            };
            let mut words = line.words();
            points.push_words(&line, &mut words)?;
            let more = words.next().is_some();
            is_complete &= more || in_space;
            has_more |= more && in_space;
        }
        Ok(Vertices { points, lines, is_complete, has_more })
    }

    /// Reads the vertices from a stream.
    fn of_stream(mut points: Collector<'a>, mut stream: Stream<'a>, count: u64) -> Result<Self, InputError> {
        while points.met < count {
            let Some((line, words)) = stream.several(3) else { break };
            points.push_words(&line, &mut words.into_iter())?;
        }
        let note = "read as a stream of numbers, because vertices have no lines of their own";
        points.notes.push(note.to_owned());
        Vertices::read(points, stream.lines, count)
    }
}

/// Reads the vertices.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    let size = (header.vertices, lines.rest().len(), 6);
    let points = || Collector::new(source, options, (header.line.place(), 3), size);
    let mut read = Vertices::read(points()?, lines.clone(), header.vertices);
    // Only a file without a line for each vertex and each face can be a stream.
    let is_by_lines = |of: &Vertices<'_>| of.is_complete && has_lines(of.lines.clone(), header.faces);
    if !read.as_ref().is_ok_and(is_by_lines)
        && let Some(stream) = Stream::of(&header, &lines)
    {
        read = Vertices::of_stream(points()?, stream, header.vertices);
    }
    let Vertices { mut points, mut lines, has_more, .. } = read?;
    points.complete(Place::Line(lines.number()), header.vertices)?;
    if header.faces == 0
        && let Some(line) = lines.next_data()
    {
        return Err(source.surplus(line.place(), "points", header.vertices));
    }
    if has_more {
        points.notes.push("colours or normals after the coordinates are ignored".to_owned());
    }
    points.note_if_flat();
    Ok(points.finish())
}

/// Returns `true` if there are at least `count` lines with data.
fn has_lines(mut lines: Lines<'_>, count: u64) -> bool {
    (0..count).all(|_| lines.next_data().is_some())
}

/// A face: the line on which it begins, and its words: a count, the ids of its corners, and colours.
type Face<'a> = (Line<'a>, Vec<&'a [u8]>);

/// Returns the faces, and the header.
fn faces(source: Source<'_>) -> Result<(Header<'_>, Vec<Face<'_>>), InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    let stream = Stream::of(&header, &lines);
    let mut all: Vec<Face<'_>> = Vec::new();
    let Some(mut stream) = stream else {
        skip_vertices(source, &mut lines, header.vertices)?;
        while (all.len() as u64) < header.faces {
            let Some(line) = lines.next_data() else {
                let (place, found) = (Place::Line(lines.number()), all.len() as u64);
                return Err(source.truncated(place, "faces", header.faces, found));
            };
            all.push((line, line.words().collect()));
        }
        return Ok((header, all));
    };
    stream.nth(usize::try_from(header.vertices * 3).unwrap_or(usize::MAX).saturating_sub(1));
    while (all.len() as u64) < header.faces {
        let face = stream.next().and_then(|(line, word)| {
            let corners = usize::try_from(source.count(&line, Some(word), FACE).ok()?).ok()?;
            let mut words = vec![word];
            words.extend(stream.by_ref().take(corners).map(|(_, word)| word));
            (words.len() == corners + 1).then_some((line, words))
        });
        let cut =
            || source.truncated(Place::Line(stream.line.number), "faces", header.faces, all.len() as u64);
        all.push(face.ok_or_else(cut)?);
    }
    Ok((header, all))
}

/// The description of a face in messages.
const FACE: &str = "a face `corners id id …`";

/// Skips the vertices.
fn skip_vertices<'a>(source: Source<'a>, lines: &mut Lines<'a>, vertices: u64) -> Result<(), InputError> {
    for found in 0..vertices {
        let Some(line) = lines.next_data() else {
            return Err(source.truncated(Place::Line(lines.number()), "points", vertices, found));
        };
        let word = line.words().next().unwrap_or_default();
        if number(word).is_none() {
            return Err(source.bad_number(&line, word));
        }
    }
    Ok(())
}

/// Reads faces with any number of corners.
pub fn read_faces(source: Source<'_>) -> Result<Faces, InputError> {
    let of = |(line, words): Face<'_>| {
        let mut words = words.into_iter();
        let corners = source.count(&line, words.next(), FACE)?;
        (0..corners).map(|_| position(source, &line, words.next())).collect::<Result<_, _>>()
    };
    faces(source)?.1.into_iter().map(of).collect()
}

/// Reads the faces as cells. They must be triangles.
pub fn read_cells(source: Source<'_>) -> Result<CellFile, InputError> {
    let (header, faces) = faces(source)?;
    let mut cells = Indices::new(source, 3, 0, Some(header.vertices));
    for (line, words) in faces {
        let mut words = words.into_iter();
        if words.next() != Some(b"3".as_slice()) {
            return Err(source.bad_line(&line, "a triangle `3 a b c` (only triangles are cells)"));
        }
        cells.push_words(&line, &mut words)?;
    }
    Ok(cells.finish(Vec::new()))
}
