//! `.su2`: the mesh of SU2, with indices from 0. Markers are boundaries. Regions have no place.

use std::io::Write;

use crate::write::elements::Elements;
use crate::write::error::WriteFault;
use crate::write::options::Order;
use crate::write::records::{WriteProgress, push_float, push_indices, push_integer, write_records};
use septet_core::model::MeshView;

/// Writes a mesh.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let elements = &Elements::of(mesh, Order::One)?;
    let axes = if mesh.heights.is_some() { 3 } else { mesh.dimension };
    let (cells, faces) = (&elements.cells, &elements.faces);
    // The types of VTK: line 3, triangle 5 and tetrahedron 10.
    let kind = |dimension: usize| [1, 3, 5, 10][dimension];
    writeln!(out, "NDIME= {axes}\nNELEM= {}", cells.len())?;
    write_records(out, cells.len(), progress, |buffer, i| {
        push_integer(buffer, kind(cells.dimension));
        push_indices(buffer, cells.row(i), 0);
        push_indices(buffer, &[i as u64], 0);
        buffer.push(b'\n');
    })?;
    writeln!(out, "NPOIN= {}", mesh.point_count())?;
    write_records(out, mesh.point_count(), progress, |buffer, i| {
        for c in &mesh.place(i)[..axes] {
            push_float(buffer, *c);
            buffer.push(b' ');
        }
        push_integer(buffer, i as u64);
        buffer.push(b'\n');
    })?;
    let groups = faces.rows_of_groups();
    writeln!(out, "NMARK= {}", groups.len())?;
    for (at, rows) in groups.iter().enumerate() {
        writeln!(out, "MARKER_TAG= {}\nMARKER_ELEMS= {}", faces.groups.name(at), rows.len())?;
        write_records(out, rows.len(), progress, |buffer, i| {
            push_integer(buffer, kind(faces.dimension));
            push_indices(buffer, faces.row(rows[i]), 0);
            buffer.push(b'\n');
        })?;
    }
    Ok(())
}
