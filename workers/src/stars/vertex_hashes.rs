//! Hashes of points, from which the hashes of cells are made.

use septet_geometry::point::Point;

use crate::stars::fingerprint_sums::{mix, point_hash};
use crate::state::cells::smallest_vertex;
use crate::state::table::Table;

/// For each point of a table, its hash and its first coordinate. [`VertexHashes::extend`] adds the new points of the
/// table.
#[derive(Debug, Default)]
pub(crate) struct VertexHashes {
    hashes: Vec<u128>,
    firsts: Vec<f64>,
}

impl VertexHashes {
    /// Hashes the points that were added to the table since the last call.
    pub(super) fn extend<P: Point>(&mut self, table: &Table<P>) {
        let known = self.hashes.len();
        let new = table.ids()[known..].iter().zip(&table.positions()[known..]);
        self.hashes.extend(new.map(|(&id, &x)| point_hash(id, x)));
        self.firsts.extend(table.positions()[known..].iter().map(|x| x.coord(0)));
    }

    /// Returns the hash of a cell.
    pub(super) fn cell_hash(&self, vertices: &[u32]) -> u128 {
        mix(vertices.iter().fold(0u128, |sum, &v| sum.wrapping_add(self.hashes[v as usize])))
    }

    /// Returns the key of a pair in lists of fingerprints. Both hashes are mixed, so their difference is as well
    /// distributed as the hashes themselves.
    pub(super) fn list_key(&self, cell_hash: u128, other: u32) -> u64 {
        (cell_hash ^ self.hashes[other as usize]) as u64
    }

    /// Returns the lexicographically smallest vertex of a finite cell.
    #[inline]
    pub(super) fn smallest<P: Point>(&self, table: &Table<P>, cell: &P::Cell) -> u32 {
        smallest_vertex(table.positions(), cell.as_ref(), |v| self.firsts[v as usize])
    }

    /// Returns the hashes of all points, and their first coordinates.
    #[inline]
    pub(super) fn columns(&self) -> (&[u128], &[f64]) {
        (&self.hashes, &self.firsts)
    }
}
