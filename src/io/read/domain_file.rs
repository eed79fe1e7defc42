//! Reads a file of a domain by the reader of its format.

use std::path::Path;

use super::columns::is_of_points;
use super::domain::DomainFile;
use super::error::{InputError, Place};
use super::formats::{described, of_content, reader};
use super::load::{self, Packing};
use super::points::ReadProgress;
use super::text::Source;
use crate::format::{Format, Role};

/// Reads a domain from a file, or from standard input if `path` is `-`. Standard input must be `.off`, `.ply` or
/// `.stl`. If a `.poly` or `.smesh` file has no points, they are read from the `.node` file of the same name.
///
/// # Errors
/// Returns [`InputError`] if the file is missing, of unknown format or damaged, or names points that do not exist.
pub fn read_domain(path: &Path, progress: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    let data = load::load(path, Packing::of(path), progress)?;
    let source = Source { path, data: &data };
    let is_points = || is_of_points(&data);
    let domain = of_format(source, Format::of_path(path).or_else(|| of_content(&data)), progress);
    domain.map_err(|error| if is_points() { refused(source, "a table of points", None) } else { error })
}

fn of_format(
    source: Source<'_>,
    format: Option<Format>,
    progress: &mut ReadProgress<'_>,
) -> Result<DomainFile, InputError> {
    let Some(format) = format else {
        let (path, role) = (source.path.to_owned(), Role::Domain);
        return Err(InputError::UnknownFormat { path, advice: role.advice(source.path), role });
    };
    match reader(format).domain {
        Some(read) => read(source, progress),
        None => Err(refused(source, &described(format), format.instead(Role::Domain))),
    }
}

/// Returns the error for a file without a domain. Without advice, it advises to triangulate the points.
fn refused(source: Source<'_>, what: &str, advice: Option<&str>) -> InputError {
    let advice = advice.unwrap_or("triangulate its points with `septet triangulate`");
    let advice = format!("{advice}, or give one of {}", Role::Domain.extensions(|_| true));
    source.unsupported(Place::Whole, format!("{what} as a domain"), advice)
}
