//! `.off` files. In space, they hold the hull, oriented outward, and its points in the order of their indices. In the
//! plane, they hold all points and triangles, with z = 0.

use std::io::Write;

use septet_core::cores::{each_chunk_mut, sort_rows};

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_indices, push_point, write_records};
use crate::write::topology;
use septet_core::model::{MeshView, Points};

/// Vertices for each unit of parallel work.
const BLOCK: usize = 4096;

/// Writes a surface.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    if mesh.dimension == 2 {
        write_head(out, mesh.point_count(), mesh.cell_count())?;
        write_vertices(out, 2, mesh.coordinates, progress)?;
        return write_triangles(out, mesh.cells, progress);
    }
    let mut hull = topology::hull(3, mesh.point_count(), mesh.cells)?;
    let mut used = hull.clone();
    sort_rows(&mut used, 1);
    used.dedup();
    each_chunk_mut(&mut hull, BLOCK, |_, vertices| {
        for vertex in vertices {
            // The search always succeeds, because the list has all vertices of the hull.
            *vertex = used.binary_search(vertex).map_or(0, |position| position as u64);
        }
    });
    write_head(out, used.len(), hull.len() / 3)?;
    write_records(out, used.len(), progress, |buffer, i| {
        let start = used[i] as usize * 3;
        push_point(buffer, &mesh.coordinates[start..start + 3], b' ', true);
        buffer.push(b'\n');
    })?;
    write_triangles(out, &hull, progress)
}

/// Writes points without faces.
pub fn write_points(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_head(out, points.len(), 0)?;
    write_vertices(out, points.dimension(), points.coordinates(), progress)
}

fn write_head(out: &mut dyn Write, points: usize, faces: usize) -> Result<(), WriteFault> {
    Ok(write!(out, "OFF\n{points} {faces} 0\n")?)
}

fn write_vertices(
    out: &mut dyn Write,
    dimension: usize,
    coordinates: &[f64],
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_records(out, coordinates.len() / dimension, progress, |buffer, i| {
        push_point(buffer, &coordinates[i * dimension..(i + 1) * dimension], b' ', true);
        buffer.push(b'\n');
    })?;
    Ok(())
}

fn write_triangles(
    out: &mut dyn Write,
    triangles: &[u64],
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_records(out, triangles.len() / 3, progress, |buffer, i| {
        buffer.push(b'3');
        push_indices(buffer, &triangles[3 * i..3 * i + 3], 0);
        buffer.push(b'\n');
    })?;
    Ok(())
}
