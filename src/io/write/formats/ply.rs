//! Points as `.ply` files: binary, little-endian, doubles. Points in the plane get z = 0.

use std::io::Write;

use septet_core::model::Points;

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, write_records};

/// Writes points.
pub fn write(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    write!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.len())?;
    out.write_all(b"property double x\nproperty double y\nproperty double z\nend_header\n")?;
    write_records(out, points.len(), progress, |buffer, i| {
        for coordinate in &coordinates[i * dimension..(i + 1) * dimension] {
            buffer.extend_from_slice(&coordinate.to_le_bytes());
        }
        if dimension == 2 {
            buffer.extend_from_slice(&0.0f64.to_le_bytes());
        }
    })?;
    Ok(())
}
