//! Geomview `.off` files: vertices, and triangles as two-dimensional cells.

use crate::read::cells::{CellFile, Indices};
use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::faces::{Faces, position};
use crate::read::points::{PointFile, ReadOptions};
use crate::read::signature::is_keyword;
use crate::read::text::{Line, Lines, NUMBER, Source, excerpt, number};

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
    if let Some(keyword) = word.filter(|w| is_keyword(w)) {
        if keyword.contains(&b'4') || keyword.contains(&b'n') {
            let what = format!("{}, points of homogeneous or free dimension,", excerpt(keyword));
            return Err(source.unsupported(line.place(), what, "save as plain OFF"));
        }
        word = words.next();
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

/// Reads the vertices.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    let size = (header.vertices, lines.rest().len(), 6);
    let mut points = Collector::new(source, options, (header.line.place(), 3), size)?;
    let mut extra = false;
    while points.met < header.vertices {
        let Some(line) = lines.next_data() else { break };
        let mut words = line.words();
        points.push_words(&line, &mut words)?;
        extra |= words.next().is_some() && points.dimension() == 3;
    }
    points.complete(Place::Line(lines.number()), header.vertices)?;
    if header.faces == 0
        && let Some(line) = lines.next_data()
    {
        return Err(source.surplus(line.place(), "points", header.vertices));
    }
    if extra {
        points.notes.push("colours or normals after the coordinates are ignored".to_owned());
    }
    points.note_if_flat();
    Ok(points.finish())
}

/// Skips the vertices.
fn skip_vertices<'a>(source: Source<'a>, lines: &mut Lines<'a>, vertices: u64) -> Result<(), InputError> {
    for found in 0..vertices {
        let Some(line) = lines.next_data() else {
            return Err(source.truncated(Place::Line(lines.number()), "points", vertices, found));
        };
        if line.words().next().and_then(number).is_none() {
            return Err(source.bad_line(&line, NUMBER));
        }
    }
    Ok(())
}

/// Reads faces with any number of corners.
pub fn read_faces(source: Source<'_>) -> Result<Faces, InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    skip_vertices(source, &mut lines, header.vertices)?;
    let mut faces = Faces::new();
    while (faces.len() as u64) < header.faces {
        let Some(line) = lines.next_data() else {
            let found = faces.len() as u64;
            return Err(source.truncated(Place::Line(lines.number()), "faces", header.faces, found));
        };
        let mut words = line.words();
        let corners = source.count(&line, words.next(), "a face `corners id id …`")?;
        faces.push((0..corners).map(|_| position(source, &line, words.next())).collect::<Result<_, _>>()?);
    }
    Ok(faces)
}

/// Reads the faces as cells. They must be triangles.
pub fn read_cells(source: Source<'_>) -> Result<CellFile, InputError> {
    let mut lines = Lines::new(source.data);
    let header = header(source, &mut lines)?;
    skip_vertices(source, &mut lines, header.vertices)?;
    let mut cells = Indices::new(source, 3, 0, Some(header.vertices));
    while cells.rows() < header.faces {
        let Some(line) = lines.next_data() else {
            return Err(source.truncated(Place::Line(lines.number()), "faces", header.faces, cells.rows()));
        };
        let mut words = line.words();
        if words.next() != Some(b"3".as_slice()) {
            return Err(source.bad_line(&line, "a triangle `3 a b c` (only triangles are cells)"));
        }
        cells.push_words(&line, &mut words)?;
    }
    Ok(cells.finish(Vec::new()))
}
