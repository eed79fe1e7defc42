//! Several surfaces as one domain.

use std::path::{Path, PathBuf};

use glam::DVec3;
use septet_meshing::input::{DomainKind, Input, Solid};

use super::domain::{AnyInput, DomainFile};
use super::domain_file::read_domain;
use super::error::{InputError, Place};
use super::points::ReadProgress;

/// Reads the domain of one file, or of several closed surfaces, each of which is a solid ([`Input::solids`]). The points
/// and facets of the files are numbered one after another, from the first id of the first file.
///
/// # Errors
/// Returns [`InputError`] if a file cannot be read, or if one of several is not a surface.
pub fn read_domains(paths: &[PathBuf], progress: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    let Some((first, others)) = paths.split_first() else {
        return read_domain(Path::new(""), progress);
    };
    let DomainFile { input, notes, first_id } = read_domain(first, progress)?;
    if others.is_empty() {
        return Ok(DomainFile { input, notes, first_id });
    }
    let said = |path: &Path, notes: Vec<String>| -> Vec<String> {
        notes.into_iter().map(|note| format!("{}: {note}", path.display())).collect()
    };
    let mut joined = Input::new(DomainKind::Surface, Vec::new());
    let mut all = said(first, notes);
    append(&mut joined, input, first)?;
    for path in others {
        let [points, facets] = [joined.points.len(), joined.facets.len()].map(|n| n as u64 + first_id);
        let file = read_domain(path, progress)?;
        all.extend(said(path, file.notes));
        all.push(format!("{}: points count from {points}, facets from {facets}", path.display()));
        append(&mut joined, file.input, path)?;
    }
    Ok(DomainFile { input: AnyInput::Space(joined), notes: all, first_id })
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
