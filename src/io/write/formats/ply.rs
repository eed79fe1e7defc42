//! `.ply` files: points, or the triangles of a [`Surface`]. Binary, little-endian, doubles. Points in the plane get z = 0, and those of a
//! terrain their heights.

use std::io::Write;

use septet_core::model::{MeshView, Points};

use super::surface::Surface;
use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, write_records};

/// Writes points.
pub fn write(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    write_head(out, points.len(), "")?;
    write_records(out, points.len(), progress, |buffer, i| {
        push_vertex(buffer, &coordinates[i * dimension..(i + 1) * dimension]);
    })?;
    Ok(())
}

/// Writes a surface.
pub fn write_surface(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let surface = Surface::of(mesh)?;
    let faces = surface.triangles.len() / 3;
    if u32::try_from(surface.points()).is_err() {
        return Err(WriteFault::TooLarge(surface.points() as u64));
    }
    write_head(
        out,
        surface.points(),
        &format!("element face {faces}\nproperty list uchar uint vertex_indices\n"),
    )?;
    write_records(out, surface.points(), progress, |buffer, i| push_vertex(buffer, &surface.point(i)))?;
    write_records(out, faces, progress, |buffer, i| {
        buffer.push(3);
        for corner in &surface.triangles[3 * i..3 * i + 3] {
            buffer.extend_from_slice(&(*corner as u32).to_le_bytes());
        }
    })?;
    Ok(())
}

/// Writes the header. `faces` are its lines on faces.
fn write_head(out: &mut dyn Write, points: usize, faces: &str) -> Result<(), WriteFault> {
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {points}\n")?;
    out.write_all(b"property double x\nproperty double y\nproperty double z\n")?;
    Ok(writeln!(out, "{faces}end_header")?)
}

fn push_vertex(buffer: &mut Vec<u8>, point: &[f64]) {
    for axis in 0..3 {
        buffer.extend_from_slice(&point.get(axis).copied().unwrap_or(0.0).to_le_bytes());
    }
}
