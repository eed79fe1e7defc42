//! Points as lines of text: `.xyz`, `.csv` and the `v` lines of `.obj`.

use std::io::Write;

use septet_core::model::Points;

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_point, write_records};

/// Writes one point per line.
pub fn write(
    out: &mut dyn Write,
    points: &Points,
    separator: u8,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_lines(out, points, (b"", separator, false), progress)
}

/// Writes the `v` lines of an `.obj` file. Points in the plane get z = 0.
pub fn write_obj(
    out: &mut dyn Write,
    points: &Points,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    write_lines(out, points, (b"v ", b' ', true), progress)
}

fn write_lines(
    out: &mut dyn Write,
    points: &Points,
    (prefix, separator, in_space): (&[u8], u8, bool),
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let (dimension, coordinates) = (points.dimension(), points.coordinates());
    write_records(out, points.len(), progress, |buffer, i| {
        buffer.extend_from_slice(prefix);
        let point = &coordinates[i * dimension..(i + 1) * dimension];
        push_point(buffer, point, separator, in_space);
        buffer.push(b'\n');
    })?;
    Ok(())
}
