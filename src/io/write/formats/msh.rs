//! `.msh` files of Gmsh, text, versions 4.1 and 2.2. A triangulation is one entity of the dimension of the mesh, with
//! tag 1 and physical group 1. `msh_elements` writes meshes of domains and quadratic triangulations.

use std::io::Write;

use super::msh_elements;
use crate::write::elements::Elements;
use crate::write::error::WriteFault;
use crate::write::options::{MshVersion, Order};
use crate::write::records::{
    WriteProgress, push_float, push_indices, push_integer, push_point, write_records,
};
use septet_core::model::MeshView;

/// Writes a triangulation.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    (version, order): (MshVersion, Order),
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    if mesh.labels.is_some() || order == Order::Two {
        return msh_elements::write(out, &Elements::of(mesh, order)?, version, progress);
    }
    match version {
        MshVersion::V41 => write_41(out, mesh, progress),
        MshVersion::V22 => write_22(out, mesh, progress),
    }
}

/// The element types of Gmsh: triangle 2, tetrahedron 4.
fn element_type(dimension: usize) -> usize {
    if dimension == 3 { 4 } else { 2 }
}

fn write_22(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, corners) = (mesh.dimension, mesh.dimension + 1);
    let (points, cells) = (mesh.point_count(), mesh.cell_count());
    write!(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{points}\n")?;
    write_records(out, points, progress, |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        buffer.push(b' ');
        push_point(buffer, &mesh.place(i), b' ', true);
        buffer.push(b'\n');
    })?;
    writeln!(out, "$EndNodes")?;
    write!(out, "$Elements\n{cells}\n")?;
    let tags = format!(" {} 2 1 1", element_type(dimension));
    write_records(out, cells, progress, |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        buffer.extend_from_slice(tags.as_bytes());
        push_indices(buffer, &mesh.cells[i * corners..(i + 1) * corners], 1);
        buffer.push(b'\n');
    })?;
    writeln!(out, "$EndElements")?;
    Ok(())
}

fn write_41(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, corners) = (mesh.dimension, mesh.dimension + 1);
    let (points, cells) = (mesh.point_count(), mesh.cell_count());
    writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
    let counts = if dimension == 3 { "0 0 0 1" } else { "0 0 1 0" };
    writeln!(out, "$Entities\n{counts}\n1 {} 1 1 0\n$EndEntities", bounding_box(mesh))?;
    writeln!(out, "$Nodes")?;
    // A mesh without points gets no block, because some programs refuse a block with the tags 1 to 0.
    if points > 0 {
        write!(out, "1 {points} 1 {points}\n{dimension} 1 0 {points}\n")?;
    } else {
        writeln!(out, "0 0 0 0")?;
    }
    let mut silent = |_, _| {};
    write_records(out, points, &mut WriteProgress::new(points as u64, &mut silent), |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        buffer.push(b'\n');
    })?;
    write_records(out, points, progress, |buffer, i| {
        push_point(buffer, &mesh.place(i), b' ', true);
        buffer.push(b'\n');
    })?;
    writeln!(out, "$EndNodes")?;
    writeln!(out, "$Elements")?;
    if cells > 0 {
        let kind = element_type(dimension);
        write!(out, "1 {cells} 1 {cells}\n{dimension} 1 {kind} {cells}\n")?;
    } else {
        writeln!(out, "0 0 0 0")?;
    }
    write_records(out, cells, progress, |buffer, i| {
        push_integer(buffer, i as u64 + 1);
        push_indices(buffer, &mesh.cells[i * corners..(i + 1) * corners], 1);
        buffer.push(b'\n');
    })?;
    writeln!(out, "$EndElements")?;
    Ok(())
}

/// Returns the three smallest and then the three largest coordinates, or zeros if there are no points.
fn bounding_box(mesh: &MeshView<'_>) -> String {
    let all = msh_elements::bounding_box((0..mesh.point_count()).map(|point| mesh.place(point)));
    let mut text = Vec::new();
    for (i, c) in all.into_iter().enumerate() {
        if i > 0 {
            text.push(b' ');
        }
        push_float(&mut text, c);
    }
    String::from_utf8_lossy(&text).into_owned()
}
