//! Readers of domains: piecewise linear complexes and closed surfaces.
//!
//! What is read is what the file says; whether it is a domain, [`septet_meshing::check`] decides.

mod any;
mod poly;
mod surface;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::error::{InputError, Place};
use super::format::Format;
use super::load;
use super::points::Progress;
use super::text::Source;
pub use any::{AnyInput, DomainFile};

/// Endings of files of domains, for messages.
pub const DOMAINS: &str = ".poly .smesh .stl .off .ply .obj (each also with .gz)";

/// Reads a domain from a file, or from standard input if `path` is `-` (then it must be `.off`, `.ply` or
/// `.stl`). A `.poly` or `.smesh` file without points takes them from the `.node` file of the same name.
///
/// # Errors
/// [`InputError`], if the file is missing, of unknown format, or damaged, or names points that do not exist.
pub fn read_domain(path: &Path, progress: &mut Progress<'_>) -> Result<DomainFile, InputError> {
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
            let what = format!("a file of kind .{} as a domain", other.name());
            Err(source.unsupported(Place::Whole, what, "a domain is .poly, .smesh, .stl, .off, .ply or .obj"))
        }
        None => {
            let (path, advice) = (path.to_owned(), super::format::advice(path));
            Err(InputError::UnknownFormat { path, advice, known: DOMAINS })
        },
    }
}
