//! `.off` files: the triangles of a [`Surface`]. Points in the plane get z = 0, and those of a
//! terrain their heights.

use std::io::Write;

use septet_core::model::{MeshView, Points};

use super::surface::Surface;
use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_indices, push_point, write_records};

/// Writes a surface.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let surface = Surface::of(mesh)?;
    write_head(out, surface.points(), surface.triangles.len() / 3)?;
    write_records(out, surface.points(), progress, |buffer, i| {
        push_point(buffer, &surface.point(i), b' ', true);
        buffer.push(b'\n');
    })?;
    write_records(out, surface.triangles.len() / 3, progress, |buffer, i| {
        buffer.push(b'3');
        push_indices(buffer, &surface.triangles[3 * i..3 * i + 3], 0);
        buffer.push(b'\n');
    })?;
    Ok(())
}

/// Writes points without faces.
pub fn write_points(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    write_head(out, points.len(), 0)?;
    write_records(out, points.len(), progress, |buffer, i| {
        push_point(buffer, &coordinates[i * dimension..(i + 1) * dimension], b' ', true);
        buffer.push(b'\n');
    })?;
    Ok(())
}

fn write_head(out: &mut dyn Write, points: usize, faces: usize) -> Result<(), WriteFault> {
    Ok(write!(out, "OFF\n{points} {faces} 0\n")?)
}
