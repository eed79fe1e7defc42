//! Closed surfaces in space: the faces of a file of points and faces.

use septet_meshing::input::{Input, Solid};

use super::super::error::{InputError, Place};
use super::super::faces::Faces;
use super::super::points::PointFile;
use super::super::text::Source;
use super::any::{AnyInput, DomainFile};
use septet_core::model::Points;

/// Returns the surface of points and faces. `first` is the id of the first point in the file.
pub fn of(source: Source<'_>, file: PointFile, faces: Faces, first: u64) -> Result<DomainFile, InputError> {
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
        let (path, value, limit) =
            (source.path.to_owned(), i128::from(u64::from(value) + first), Some(limit));
        let (place, cell) = (Place::Whole, cell as u64);
        return Err(InputError::OutOfRangeIndex { path, place, cell, value, first, limit });
    }
    let input = AnyInput::Space(Input::surface(points, faces));
    let notes = file.notes.into_iter().filter(|n| !n.contains("dimension 2")).collect();
    Ok(DomainFile { input, notes, first_id: first })
}

/// Adds the names of the solids, given with the number of facets up to the end of each.
pub fn with_solids(mut file: DomainFile, solids: Vec<(String, u32)>) -> DomainFile {
    if let (AnyInput::Space(input), true) = (&mut file.input, solids.len() > 1) {
        input.solids = solids.into_iter().map(|(name, end)| Solid { name, end }).collect();
    }
    file
}
