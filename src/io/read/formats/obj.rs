//! Wavefront `.obj` files: the `v` lines.

use std::borrow::Cow;

use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::faces::Faces;
use crate::read::points::{PointFile, ReadOptions};
use crate::read::text::{Lines, Source, integer};

/// Joins lines that end in a backslash with the next ones. The line ends move behind the joined line, so that later lines
/// keep their numbers.
fn joined(data: &[u8]) -> Cow<'_, [u8]> {
    let is_end = |b: &u8| matches!(b, b'\n' | b'\r');
    if !data.windows(2).any(|w| w[0] == b'\\' && is_end(&w[1])) {
        return Cow::Borrowed(data);
    }
    let (mut text, mut ends, mut at) = (Vec::with_capacity(data.len()), Vec::new(), 0);
    while at < data.len() {
        let end = if data[at..].starts_with(b"\r\n") { 2 } else { usize::from(is_end(&data[at])) };
        let next = data[at + 1..].first();
        if data[at] == b'\\' && next.is_some_and(is_end) {
            let length = if data[at + 1..].starts_with(b"\r\n") { 2 } else { 1 };
            text.push(b' ');
            ends.extend_from_slice(&data[at + 1..at + 1 + length]);
            at += 1 + length;
        } else if end > 0 {
            text.append(&mut ends);
            text.extend_from_slice(&data[at..at + end]);
            at += end;
        } else {
            text.push(data[at]);
            at += 1;
        }
    }
    Cow::Owned(text)
}

/// Reads the lines `v x y z …`. Colours and weights on them are ignored, as are all other lines.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let text = joined(source.data);
    let source = Source { path: source.path, data: &text };
    let mut points = Collector::new(source, options, (Place::Whole, 3), (0, 0, 1))?;
    let mut lines = Lines::new(source.data);
    let mut extra = false;
    while let Some(line) = lines.next_data() {
        let mut words = line.words();
        if words.next() != Some(b"v".as_slice()) {
            continue;
        }
        points.push_words(&line, &mut words)?;
        extra |= words.next().is_some() && points.dimension() == 3;
    }
    if points.met == 0 {
        let advice = "export it with vertices (lines `v x y z`)";
        return Err(source.unsupported(Place::Whole, "an .obj file without vertices", advice));
    }
    if extra {
        points.notes.push("colours or weights after the coordinates are ignored".to_owned());
    }
    points.note_if_flat();
    Ok(points.finish())
}

/// Reads the lines `f a b c …`. Each corner is `v`, `v/t`, `v//n` or `v/t/n`. Negative ids count back from the last
/// point.
pub fn read_faces(source: Source<'_>) -> Result<Faces, InputError> {
    let text = joined(source.data);
    let source = Source { path: source.path, data: &text };
    let mut lines = Lines::new(source.data);
    let (mut points, mut faces) = (0i64, Vec::new());
    while let Some(line) = lines.next_data() {
        let mut words = line.words();
        match words.next() {
            Some(b"v") => points += 1,
            Some(b"f") => {
                let corner = |word: &[u8]| {
                    let id = word.split(|b| *b == b'/').next().and_then(integer);
                    let from_zero = id.map(|id| if id < 0 { points + id } else { id - 1 });
                    let position = from_zero.and_then(|id| u32::try_from(id).ok());
                    position
                        .ok_or_else(|| source.bad_word(&line, word, "a corner `v`, `v/t`, `v//n` or `v/t/n`"))
                };
                faces.push(words.map(corner).collect::<Result<_, _>>()?);
            }
            _ => {}
        }
    }
    Ok(faces)
}

/// Returns the line of a face, given by its position.
pub fn place_of_face(source: Source<'_>, at: usize) -> Place {
    let text = joined(source.data);
    let mut lines = Lines::new(&text);
    let faces = std::iter::from_fn(|| lines.next_data());
    let line = faces.filter(|line| line.words().next() == Some(b"f".as_slice())).nth(at);
    line.map_or(Place::Whole, |line| line.place())
}
