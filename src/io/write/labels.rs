//! Checks that the labels of a mesh fit its cells and points.

use septet_core::model::{Labels, MeshView, Patches};

/// Returns an error that describes the first mismatch, if there is one.
pub(super) fn check(mesh: &MeshView<'_>, labels: &Labels) -> Result<(), String> {
    let (points, cells) = (mesh.point_count(), mesh.cell_count());
    let lengths = [
        ("regions", labels.regions.len(), cells),
        ("attributes", labels.attributes.len(), cells),
        ("markers of points", labels.point_markers.len(), points),
        ("sizes", labels.sizes.len(), points),
        ("carriers", labels.carriers.len(), points),
        ("sides of faces", labels.sides.len(), labels.faces.len()),
    ];
    for (what, found, expected) in lengths {
        if found != expected {
            return Err(format!("{found} {what} instead of {expected}"));
        }
    }
    patches("face", &labels.faces, mesh.dimension, points)?;
    patches("edge", &labels.edges, 2, points)
}

fn patches(what: &str, patches: &Patches, width: usize, points: usize) -> Result<(), String> {
    let rows = patches.len();
    if patches.markers.len() != rows || patches.vertices.len() != rows * width {
        return Err(format!("the arrays of {what}s have different lengths"));
    }
    match patches.vertices.iter().position(|&v| v >= points as u64) {
        Some(at) => Err(format!("{what} {} has vertex {}", at / width, patches.vertices[at])),
        None => Ok(()),
    }
}
