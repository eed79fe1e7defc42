//! Wavefront `.obj` files: the `v` lines.

use crate::read::collect::Collector;
use crate::read::error::{InputError, Place};
use crate::read::faces::Faces;
use crate::read::points::{PointFile, ReadOptions};
use crate::read::text::{Lines, Source, integer};

/// Reads the lines `v x y z …`. Colours and weights on them are ignored, as are all other lines.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
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
    let mut lines = Lines::new(source.data);
    let faces = std::iter::from_fn(|| lines.next_data());
    let line = faces.filter(|line| line.words().next() == Some(b"f".as_slice())).nth(at);
    line.map_or(Place::Whole, |line| line.place())
}
