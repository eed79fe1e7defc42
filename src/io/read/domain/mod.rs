//! Readers of domains: piecewise linear complexes and closed surfaces.
//!
//! The readers return the content of the file. [`septet_meshing::check`] decides whether it is a domain.

mod any;
mod poly;
mod surface;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::error::{InputError, Place};
use super::format::Format;
use super::load;
use super::points::ReadProgress;
use super::text::Source;
pub use any::{AnyInput, DomainFile};

/// The file name extensions of domains, for messages.
pub const DOMAINS: &str = ".poly .smesh .stl .off .ply .obj (each also with .gz)";

/// Reads a domain from a file, or from standard input if `path` is `-`. Standard input must be `.off`, `.ply` or
/// `.stl`. If a `.poly` or `.smesh` file has no points, they are read from the `.node` file of the same name.
///
/// # Errors
/// Returns [`InputError`] if the file is missing, of unknown format or damaged, or names points that do not exist.
pub fn read_domain(path: &Path, progress: &mut ReadProgress<'_>) -> Result<DomainFile, InputError> {
    let (format, zipped) = Format::of_path(path);
    let data = load::load(path, zipped, progress)?;
    let source = Source { path, data: &data };
    let name = path.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    let facets = match Path::new(stem).extension().and_then(|e| e.to_str()) {
        Some("smesh") => Some(poly::Facets::Simple),
        Some("poly") => Some(poly::Facets::Polygons),
        _ => None,
    };
    if let Some(facets) = facets {
        let mut node = None;
        if poly::wants_node(source)? {
            let beside = path.to_string_lossy();
            let beside = beside.strip_suffix(".gz").unwrap_or(&beside);
            let beside = Path::new(beside).with_extension("node");
            node = Some((load::load(&beside, false, progress)?, beside));
        }
        let node = node.as_ref().map(|(data, path)| Source { path, data });
        return poly::read(source, node, facets);
    }
    match format.or_else(|| Format::of_content(&data)) {
        Some(format @ (Format::Off | Format::Ply | Format::Stl | Format::Obj)) => {
            surface::read(source, format)
        }
        Some(other) => {
            let what = format!("a .{} file as a domain", other.name());
            Err(source.unsupported(Place::Whole, what, "give a .poly, .smesh, .stl, .off, .ply or .obj file"))
        }
        None => {
            let (path, advice) = (path.to_owned(), String::new());
            Err(InputError::UnknownFormat { path, advice, known: DOMAINS })
        }
    }
}
