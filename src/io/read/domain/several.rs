//! Several surfaces as one domain.

use std::path::{Path, PathBuf};

use glam::DVec3;
use septet_meshing::input::{DomainKind, Input, Solid};

use super::super::domain_file::read_domain;
use super::super::error::{InputError, Place};
use super::super::points::ReadProgress;
use super::any::{AnyInput, DomainFile};

/// Reads the domain of one file, or of several closed surfaces, each of which is a solid ([`Input::solids`]). The points
/// and facets of the files are numbered one after another, from the first id of the first file.
///
/// # Errors
/// Returns [`InputError`] if a file cannot be read, or if one of several is no surface.
pub fn read_domains(paths: &[PathBuf], progress: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    let Some((first, others)) = paths.split_first() else {
        return read_domain(Path::new(""), progress);
    };
    let mut all = read_domain(first, progress)?;
    if others.is_empty() {
        return Ok(all);
    }
    let mut joined = Input::new(DomainKind::Surface, Vec::new());
    let mut notes = Vec::new();
    for (path, file) in std::iter::once((first, Ok(None)))
        .chain(others.iter().map(|path| (path, read_domain(path, progress).map(Some))))
    {
        let file = file?;
        let (input, said) = match file {
            None => (
                std::mem::replace(&mut all.input, AnyInput::Space(Input::new(DomainKind::Surface, vec![]))),
                std::mem::take(&mut all.notes),
            ),
            Some(file) => (file.input, file.notes),
        };
        notes.extend(said.into_iter().map(|note| format!("{}: {note}", path.display())));
        let from = (joined.points.len() as u64 + all.first_id, joined.facets.len() as u64 + all.first_id);
        append(&mut joined, input, path)?;
        if from.1 > all.first_id {
            notes.push(format!("{}: points count from {}, facets from {}", path.display(), from.0, from.1));
        }
    }
    Ok(DomainFile { input: AnyInput::Space(joined), notes, first_id: all.first_id })
}

/// Appends a surface. A file of several solids keeps them.
fn append(all: &mut Input<DVec3>, input: AnyInput, path: &Path) -> Result<(), InputError> {
    let AnyInput::Space(mut input) = input else { return Err(refused(path)) };
    if input.kind != DomainKind::Surface {
        return Err(refused(path));
    }
    let (points, facets) = (all.points.len() as u32, all.facets.len() as u32);
    if input.solids.is_empty() {
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        input.solids.push(Solid { name, end: input.facets.len() as u32 });
    }
    all.points.append(&mut input.points);
    for mut facet in input.facets {
        facet.polygons.iter_mut().flatten().for_each(|v| *v += points);
        all.facets.push(facet);
    }
    all.solids.extend(input.solids.into_iter().map(|s| Solid { end: s.end + facets, ..s }));
    Ok(())
}

fn refused(path: &Path) -> InputError {
    let (what, advice) =
        ("a complex as one of several surfaces", "give closed surfaces, or one complex alone");
    let (path, what, advice) = (path.to_owned(), what.to_owned(), advice.to_owned());
    InputError::Unsupported { path, place: Place::Whole, what, advice }
}
