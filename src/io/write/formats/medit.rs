//! `.mesh` files of Medit, with ids from 1. Every entity ends with a reference number.
//!
//! The triangles of a terrain have three coordinates. In a triangulation, references are 0 for vertices and 1 for cells and hull facets. In a mesh of a domain, points,
//! triangles on facets and edges on segments carry their markers. Cells carry the attribute of their region if it is
//! an integer, otherwise the number of their component.

use std::io::Write;

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_integer, push_point, push_signed, write_records};
use crate::write::topology;
use septet_core::model::MeshView;

/// Writes a triangulation and its hull.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, points) = (mesh.dimension, mesh.point_count());
    let markers = mesh.labels.map(|l| l.point_markers.as_slice());
    let (facet, cell) = if dimension == 3 { ("Triangles", "Tetrahedra") } else { ("Edges", "Triangles") };
    let axes = if mesh.heights.is_some() { 3 } else { dimension };
    write!(out, "MeshVersionFormatted 2\nDimension {axes}\nVertices\n{points}\n")?;
    write_records(out, points, progress, |buffer, i| {
        push_point(buffer, &mesh.place(i)[..axes], b' ', false);
        push_signed(buffer, markers.map_or(0, |m| m[i]));
        buffer.push(b'\n');
    })?;
    let mut silent = |_, _| {};
    let mut uncounted = WriteProgress::new(0, &mut silent);
    if let Some(labels) = mesh.labels {
        let (faces, edges) = (&labels.faces, &labels.edges);
        let marker = |i: usize| faces.markers[i];
        write_entities(out, facet, (&faces.vertices, dimension), marker, &mut uncounted)?;
        if dimension == 3 {
            write_entities(out, "Edges", (&edges.vertices, 2), |i| edges.markers[i], &mut uncounted)?;
        }
        let whole = |x: &f64| x.fract() == 0.0 && x.abs() < f64::from(i32::MAX);
        let named = labels.attributes.iter().all(whole);
        let region = |i: usize| {
            if named { labels.attributes[i] as i64 } else { i64::from(labels.regions[i]) }
        };
        write_entities(out, cell, (mesh.cells, dimension + 1), region, progress)?;
    } else {
        let hull = topology::hull(dimension, points, mesh.cells)?;
        write_entities(out, facet, (&hull, dimension), |_| 1, &mut uncounted)?;
        write_entities(out, cell, (mesh.cells, dimension + 1), |_| 1, progress)?;
    }
    writeln!(out, "End")?;
    Ok(())
}

fn write_entities(
    out: &mut dyn Write,
    name: &str,
    (indices, width): (&[u64], usize),
    reference: impl Fn(usize) -> i64 + Sync,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let count = indices.len() / width;
    write!(out, "{name}\n{count}\n")?;
    write_records(out, count, progress, |buffer, row| {
        for &index in &indices[row * width..(row + 1) * width] {
            push_integer(buffer, index + 1);
            buffer.push(b' ');
        }
        buffer.pop();
        push_signed(buffer, reference(row));
        buffer.push(b'\n');
    })?;
    Ok(())
}
