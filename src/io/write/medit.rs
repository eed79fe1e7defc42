//! `.mesh` of Medit: numbered from one, a reference behind every entity (0 for vertices, 1 for
//! cells and hull facets).

use std::io::Write;

use super::error::Fault;
use super::records::{Progress, push_integer, push_point, write_records};
use super::topology;
use crate::model::MeshView;

/// Writes a triangulation and its hull.
pub(super) fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut Progress<'_>,
) -> Result<(), Fault> {
    let (dimension, points) = (mesh.dimension, mesh.point_count());
    let hull = topology::hull(dimension, points, mesh.cells)?;
    let (facet, cell) = if dimension == 3 { ("Triangles", "Tetrahedra") } else { ("Edges", "Triangles") };
    write!(out, "MeshVersionFormatted 2\nDimension {dimension}\nVertices\n{points}\n")?;
    write_records(out, points, progress, |buffer, i| {
        push_point(buffer, &mesh.coordinates[i * dimension..(i + 1) * dimension], b' ', false);
        buffer.extend_from_slice(b" 0\n");
    })?;
    let mut silent = |_, _| {};
    let mut uncounted = Progress::new(0, &mut silent);
    write_entities(out, facet, &hull, dimension, &mut uncounted)?;
    write_entities(out, cell, mesh.cells, dimension + 1, progress)?;
    writeln!(out, "End")?;
    Ok(())
}

fn write_entities(
    out: &mut dyn Write,
    name: &str,
    indices: &[u64],
    width: usize,
    progress: &mut Progress<'_>,
) -> Result<(), Fault> {
    let count = indices.len() / width;
    write!(out, "{name}\n{count}\n")?;
    write_records(out, count, progress, |buffer, row| {
        for &index in &indices[row * width..(row + 1) * width] {
            push_integer(buffer, index + 1);
            buffer.push(b' ');
        }
        buffer.extend_from_slice(b"1\n");
    })?;
    Ok(())
}
