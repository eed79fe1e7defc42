//! The faces of a mesh of a domain as a second `.vtu` file: triangles on facets, or edges on segments in the plane.
//! Each face has its marker, the facet or segment that it is part of, and the components on its two sides. Component
//! 0 is the exterior.

use std::io::Write;

use super::vtu::{Record, Section, cell_array, offsets_and_types, points, write_whole};
use crate::write::error::WriteFault;
use crate::write::records::WriteProgress;
use septet_core::model::{Labels, MeshView};

/// Cell types of VTK.
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;

/// Writes the faces and their points.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    labels: &Labels,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, faces) = (mesh.dimension, &labels.faces);
    let mut used = faces.vertices.clone();
    used.sort_unstable();
    used.dedup();
    let coordinates: Vec<f64> = used
        .iter()
        .flat_map(|&v| &mesh.coordinates[v as usize * dimension..][..dimension])
        .copied()
        .collect();
    let count = faces.len();
    // The search always succeeds, because the list has all vertices of the faces.
    let position = |v: &u64| used.binary_search(v).map_or(0, |at| at as u64);
    let global: Record<'_> = Box::new(|buffer, i| buffer.extend_from_slice(&used[i].to_le_bytes()));
    let marker: Record<'_> = Box::new(|buffer, i| buffer.extend_from_slice(&faces.markers[i].to_le_bytes()));
    let of: Record<'_> = Box::new(|buffer, i| buffer.extend_from_slice(&faces.of[i].to_le_bytes()));
    let side = |k: usize| -> Record<'_> {
        Box::new(move |buffer, i| buffer.extend_from_slice(&labels.sides[i][k].to_le_bytes()))
    };
    let connectivity: Record<'_> = Box::new(|buffer, i| {
        for v in &faces.vertices[i * dimension..(i + 1) * dimension] {
            buffer.extend_from_slice(&position(v).to_le_bytes());
        }
    });
    let piece = if dimension == 3 { "facet" } else { "segment" };
    let mut arrays = vec![
        cell_array(Section::PointData, "point", "Int64", (used.len(), 8), global),
        cell_array(Section::CellData, "marker", "Int64", (count, 8), marker),
        cell_array(Section::CellData, piece, "UInt32", (count, 4), of),
        cell_array(Section::CellData, "inner_region", "UInt32", (count, 4), side(0)),
        cell_array(Section::CellData, "outer_region", "UInt32", (count, 4), side(1)),
        points(dimension, (&coordinates, None)),
        cell_array(Section::Cells, "connectivity", "Int64", (count, 8 * dimension), connectivity),
    ];
    let kind = if dimension == 3 { TRIANGLE } else { LINE };
    arrays.extend(offsets_and_types(count, dimension, kind));
    let data = ["PointData", "CellData Scalars=\"marker\""];
    Ok(write_whole(out, data, &arrays, progress)?)
}
