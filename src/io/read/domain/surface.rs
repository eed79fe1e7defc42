//! Closed surfaces in space: the faces of `.off`, `.ply`, `.obj` and `.stl` files.

use septet_meshing::input::Input;

use super::super::error::{InputError, Place};
use super::super::faces::Faces;
use super::super::format::Format;
use super::super::points::ReadOptions;
use super::super::text::{Lines, Source, integer};
use super::super::{obj, off, ply, stl};
use super::any::{AnyInput, DomainFile};
use septet_core::model::Points;

/// Reads the points and the faces.
pub fn read(source: Source<'_>, format: Format) -> Result<DomainFile, InputError> {
    let options = ReadOptions::default();
    let (file, faces, first_id) = match format {
        Format::Off => (off::read(source, &options)?, off::read_faces(source)?, 0),
        Format::Ply => (ply::read(source, &options)?, ply::read_faces(source)?, 0),
        Format::Obj => (obj::read(source, &options)?, read_obj(source)?, 1),
        _ => {
            let (file, faces) = stl::read_faces(source, &options)?;
            (file, faces, 0)
        }
    };
    let Points::Space(points) = file.points else {
        return Err(source.unsupported(
            Place::Whole,
            "a surface in the plane",
            "use a .poly file for a domain in the plane",
        ));
    };
    let limit = points.len() as u64;
    if let Some((cell, &value)) =
        faces.iter().enumerate().find_map(|(i, f)| Some((i, f.iter().find(|&&v| u64::from(v) >= limit)?)))
    {
        let (path, value, limit) = (source.path.to_owned(), i128::from(value) + first_id, Some(limit));
        let (place, cell, first) = (Place::Whole, cell as u64, first_id as u64);
        return Err(InputError::OutOfRangeIndex { path, place, cell, value, first, limit });
    }
    let input = AnyInput::Space(Input::surface(points, faces));
    let notes = file.notes.into_iter().filter(|n| !n.contains("-d 2")).collect();
    Ok(DomainFile { input, notes, first_id: first_id as u64 })
}

/// Reads the lines `f a b c …`. Each corner is `v`, `v/t`, `v//n` or `v/t/n`. Negative ids count back from the last
/// point.
fn read_obj(source: Source<'_>) -> Result<Faces, InputError> {
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
