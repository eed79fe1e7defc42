//! The triangles that formats of surfaces hold. In the plane, they are the cells. In space, they are the hull, oriented
//! outward, and its points are numbered in the order of their indices.

use std::borrow::Cow;

use septet_core::cores::{each_chunk_mut, sort_rows};
use septet_core::model::MeshView;

use crate::write::error::WriteFault;
use crate::write::topology;

/// Vertices for each unit of parallel work.
const BLOCK: usize = 4096;

/// The triangles of a surface and their points.
pub struct Surface<'a> {
    mesh: MeshView<'a>,
    /// The points of the mesh that belong to the surface, or `None` for all.
    used: Option<Vec<u64>>,
    /// The numbers of the corners, three for each triangle.
    pub triangles: Cow<'a, [u64]>,
}

impl<'a> Surface<'a> {
    /// Finds the surface of a mesh.
    pub fn of(mesh: &MeshView<'a>) -> Result<Self, WriteFault> {
        if mesh.dimension == 2 {
            return Ok(Surface { mesh: *mesh, used: None, triangles: Cow::Borrowed(mesh.cells) });
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
        Ok(Surface { mesh: *mesh, used: Some(used), triangles: Cow::Owned(hull) })
    }

    /// Returns the number of points.
    pub fn points(&self) -> usize {
        self.used.as_ref().map_or(self.mesh.point_count(), Vec::len)
    }

    /// Returns the place of a point in space.
    pub fn point(&self, i: usize) -> [f64; 3] {
        self.mesh.place(self.used.as_ref().map_or(i, |used| used[i] as usize))
    }
}
