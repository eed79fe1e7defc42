//! `.stl` files as text. Coordinates are read back exactly, and equal corners stay equal. In space, the files hold
//! the boundary, oriented outward. In the plane, they hold all triangles, with z = 0 or the heights of a terrain.

use std::io::Write;

use crate::write::error::WriteFault;
use crate::write::records::{WriteProgress, push_float, push_point, write_records};
use crate::write::topology;
use septet_core::model::MeshView;

/// Writes a surface.
pub fn write(
    out: &mut dyn Write,
    mesh: &MeshView<'_>,
    progress: &mut WriteProgress<'_>,
) -> Result<(), WriteFault> {
    let hull;
    let triangles = if mesh.dimension == 3 {
        hull = topology::hull(3, mesh.point_count(), mesh.cells)?;
        hull.as_slice()
    } else {
        mesh.cells
    };
    writeln!(out, "solid septet")?;
    write_records(out, triangles.len() / 3, progress, |buffer, i| {
        let corners = [0, 1, 2].map(|k| mesh.place(triangles[3 * i + k] as usize));
        buffer.extend_from_slice(b"facet normal");
        for c in normal(corners) {
            buffer.push(b' ');
            push_float(buffer, c);
        }
        buffer.extend_from_slice(b"\nouter loop\n");
        for corner in corners {
            buffer.extend_from_slice(b"vertex ");
            push_point(buffer, &corner, b' ', true);
            buffer.push(b'\n');
        }
        buffer.extend_from_slice(b"endloop\nendfacet\n");
    })?;
    writeln!(out, "endsolid septet")?;
    Ok(())
}

/// Returns the unit normal, or zero for a degenerate triangle. It is rounded to single precision, as readers store
/// it.
fn normal(corners: [[f64; 3]; 3]) -> [f64; 3] {
    let minus = |i: usize| [0, 1, 2].map(|k| corners[i][k] - corners[0][k]);
    let (u, v) = (minus(1), minus(2));
    // Without scaling, the normals of tiny triangles would underflow.
    let unit = |u: [f64; 3]| {
        let size = u.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        u.map(|c| c / size)
    };
    let (u, v) = (unit(u), unit(v));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { n.map(|c| f64::from((c / length) as f32)) } else { [0.0; 3] }
}
