//! Readers of domains: piecewise linear complexes and closed surfaces.
//!
//! The readers return the content of the file. [`septet_meshing::check`] decides whether it is a domain.

mod any;
mod poly;
mod surface;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::ending::{extension, without_gz};

use super::columns::is_of_points;
use super::error::{InputError, Place};
use super::format::Format;
use super::load::{self, Packing};
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
    let format = Format::of_path(path);
    let data = load::load(path, Packing::of(path), progress)?;
    let source = Source { path, data: &data };
    let facets = match extension(path).as_str() {
        "smesh" => Some(poly::Facets::Simple),
        "poly" => Some(poly::Facets::Polygons),
        _ => None,
    };
    let domain = match facets {
        Some(facets) => with_facets(source, facets, progress),
        None => of_format(source, format),
    };
    domain.map_err(
        |error| if is_of_points(&data) { source.unsupported(Place::Whole, POINTS, ADVICE) } else { error },
    )
}

/// The name of a table of points in messages.
const POINTS: &str = "a table of points as a domain";

/// The remedy for files that are not domains.
const ADVICE: &str = "triangulate its points with `septet triangulate`, or give a .poly, .smesh, .stl, .off, .ply or .obj file";

/// Reads a `.poly` or `.smesh` file, and the `.node` file next to it if it has no points.
fn with_facets(
    source: Source<'_>,
    facets: poly::Facets,
    progress: &mut ReadProgress<'_>,
) -> Result<DomainFile, InputError> {
    let mut node = None;
    if poly::wants_node(source)? {
        let beside = without_gz(source.path).0.with_extension("node");
        node = Some((load::load(&beside, Packing::of(&beside), progress)?, beside));
    }
    let node = node.as_ref().map(|(data, path)| Source { path, data });
    poly::read(source, node, facets)
}

/// Reads a surface whose format is known by its name or by its content.
fn of_format(source: Source<'_>, format: Option<Format>) -> Result<DomainFile, InputError> {
    match format.or_else(|| Format::of_content(source.data)) {
        Some(format @ (Format::Off | Format::Ply | Format::Stl | Format::Obj)) => {
            surface::read(source, format)
        }
        Some(Format::Ele) => Err(source.unsupported(
            Place::Whole,
            "a list of cells (.ele) as a domain",
            "check the cells with `septet verify POINTS CELLS`, or give a .poly, .smesh, .stl, .off, .ply or .obj file",
        )),
        Some(other) => {
            let what = format!("a .{} file as a domain", other.name());
            Err(source.unsupported(Place::Whole, what, ADVICE))
        }
        None => {
            let (path, advice) = (source.path.to_owned(), String::new());
            Err(InputError::UnknownFormat { path, advice, known: DOMAINS })
        }
    }
}
