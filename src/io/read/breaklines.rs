//! Reads the break lines of a terrain.

use std::path::Path;

use septet_meshing::input::Input;
use septet_meshing::plane::Shapes;

use super::domain::{AnyInput, poly};
use super::error::{InputError, Place};
use super::formats::{described, geojson, of_content, wkt};
use super::load::{self, Packing};
use super::points::ReadProgress;
use super::text::Source;
use crate::format::Format;

/// Reads lines and rings of polygons from a `.geojson`, `.wkt` or `.poly` file, and notes for the user. Positions in
/// space have heights. In a `.poly` file in space, the lines are the edges of all polygons.
///
/// # Errors
/// Returns [`InputError`] if the file is missing, of another format or damaged.
pub fn read_breaklines(
    path: &Path,
    progress: &mut ReadProgress<'_>,
) -> Result<(Shapes, Vec<String>), InputError> {
    let data = load::load(path, Packing::of(path), progress)?;
    let source = Source { path, data: &data };
    let map = match Format::of_path(path).or_else(|| of_content(&data)) {
        Some(Format::GeoJson) => geojson::read(source)?,
        Some(Format::Wkt) => wkt::read(source)?,
        Some(Format::Poly) => {
            let file = poly::read_polygons(source, progress)?;
            let shapes = match &file.input {
                AnyInput::Plane(input) => lines_of(input, |p| (*p, None)),
                AnyInput::Space(input) => lines_of(input, |p| (p.truncate(), Some(p.z))),
            };
            return Ok((shapes, file.notes));
        }
        other => {
            let what = other.map_or_else(|| "a file of unknown format".to_owned(), described);
            let advice = "give lines in a .geojson, .wkt or .poly file";
            return Err(source.unsupported(Place::Whole, format!("{what} as break lines"), advice));
        }
    };
    let notes = map.notes();
    Ok((map.shapes, notes))
}

/// Returns the segments and the loops of a domain as lines.
fn lines_of<P>(input: &Input<P>, place: impl Fn(&P) -> (glam::DVec2, Option<f64>)) -> Shapes {
    let mut shapes = Shapes { features: 1, ..Shapes::default() };
    for point in &input.points {
        let (at, height) = place(point);
        shapes.push(at, height);
    }
    shapes.lines.extend(input.segments.iter().map(|segment| (1, segment.ends.to_vec())));
    for polygon in input.facets.iter().flat_map(|facet| &facet.polygons) {
        let closed = polygon.iter().chain(polygon.first()).copied().collect();
        shapes.lines.push((1, closed));
    }
    shapes
}
