//! The sides of cells on which faces lie.

use super::Elements;

/// A side of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// The cell.
    pub cell: usize,
    /// The position of the corner of the cell that is opposite to the side.
    pub opposite: usize,
}

/// Returns the vertices of a face in ascending order. The third is missing in the plane.
fn key(vertices: impl Iterator<Item = u64>) -> [u64; 3] {
    let mut key = [u64::MAX; 3];
    key.iter_mut().zip(vertices).for_each(|(slot, v)| *slot = v);
    key.sort_unstable();
    key
}

impl Elements<'_> {
    /// Returns the rows of the faces, sorted by their vertices.
    fn sorted_faces(&self) -> Vec<([u64; 3], usize)> {
        let faces = (0..self.faces.len()).map(|row| (key(self.faces.corners(row).iter().copied()), row));
        let mut faces: Vec<_> = faces.collect();
        faces.sort_unstable();
        faces
    }

    /// Calls `visit` with each side of each cell that is a face, and the row of the face, in the order of the cells.
    pub fn each_side(&self, mut visit: impl FnMut(Side, usize)) {
        let faces = self.sorted_faces();
        for cell in 0..self.cells.len() {
            let corners = self.cells.corners(cell);
            for opposite in 0..corners.len() {
                let rest = corners.iter().enumerate().filter(|(i, _)| *i != opposite).map(|(_, v)| *v);
                let key = key(rest);
                if let Ok(at) = faces.binary_search_by(|(face, _)| face.cmp(&key)) {
                    visit(Side { cell, opposite }, faces[at].1);
                }
            }
        }
    }

    /// Returns the side of each face: that of its cell in the first component, or of the first of two cells in one
    /// component. A face out of which no cell is made has none.
    pub fn sides(&self) -> Vec<Option<Side>> {
        let component = |side: &Side| self.mesh.labels.map_or(0, |labels| labels.regions[side.cell]);
        let mut sides: Vec<Option<Side>> = vec![None; self.faces.len()];
        self.each_side(|side, face| {
            if sides[face].is_none_or(|known| component(&side) < component(&known)) {
                sides[face] = Some(side);
            }
        });
        sides
    }
}
