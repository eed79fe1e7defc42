//! `.obj` files: a comment with the counts, then the triangles of a [`Surface`]. Points in the plane get z = 0, and those of a
//! terrain their heights.

use std::io::Write;

use septet_core::model::MeshView;

use super::surface::Surface;
use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_indices, push_point, write_records};

/// Writes a surface. Points are numbered from 1.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let surface = Surface::of(mesh)?;
    writeln!(out, "# {} points, {} triangles", surface.points(), surface.triangles.len() / 3)?;
    write_records(out, surface.points(), progress, |buffer, i| {
        buffer.extend_from_slice(b"v ");
        push_point(buffer, &surface.point(i), b' ', true);
        buffer.push(b'\n');
    })?;
    write_records(out, surface.triangles.len() / 3, progress, |buffer, i| {
        buffer.push(b'f');
        push_indices(buffer, &surface.triangles[3 * i..3 * i + 3], 1);
        buffer.push(b'\n');
    })?;
    Ok(())
}
