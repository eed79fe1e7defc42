//! A triangulation taken apart into what is kept of it: rows of vertices and neighbours.

use super::Incremental;
use crate::point::Point;

impl<P: Point> Incremental<P> {
    /// Turns the storage into rows of `2 (DIM + 1)` numbers, one for each cell whose entry in `numbers` (by slot)
    /// is less than `bound`; these must be counted up from 0 in the order of slots. A row holds what `vertex`
    /// makes of the cell's vertices, then for each of them the entry of the cell across the opposite facet.
    ///
    /// **Work.** O(cells).
    pub fn into_rows(self, numbers: &[u32], bound: u32, vertex: impl Fn(u32) -> u32) -> Vec<u32> {
        let rows = numbers.iter().filter(|&&number| number < bound).count();
        let mut out = Vec::with_capacity(rows * 2 * (P::DIM + 1));
        for (slot, vertices, neighbours) in self.cells.entries() {
            if numbers[slot as usize] < bound {
                out.extend(vertices.as_ref().iter().map(|&v| vertex(v)));
                out.extend(neighbours.as_ref().iter().map(|&code| numbers[(code >> 2) as usize]));
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::Incremental;
    use glam::DVec2;

    #[test]
    fn rows_keep_order_and_adjacency() {
        let points: Vec<DVec2> =
            (0..40u32).map(|i| DVec2::new(f64::from(i * 37 % 41), f64::from(i * i % 43))).collect();
        let delaunay = Incremental::new(points).unwrap();
        let complex = delaunay.complex();
        let mut count = 0;
        let mut numbers = vec![u32::MAX; complex.slots() as usize];
        let mut expected = Vec::new();
        for (slot, vertices, _) in complex.entries() {
            if !complex.is_infinite(slot) {
                numbers[slot as usize] = count;
                count += 1;
                expected.push(vertices.map(|v| v + 100));
            }
        }
        let rows = delaunay.clone().into_rows(&numbers, u32::MAX, |v| v + 100);
        assert_eq!(rows.len(), 6 * expected.len());
        for (row, vertices) in rows.chunks_exact(6).zip(&expected) {
            assert_eq!(row[..3], vertices[..]);
        }
        for (at, row) in (0u32..).zip(rows.chunks_exact(6)) {
            for &next in row[3..].iter().filter(|&&n| n != u32::MAX) {
                let back = &rows[next as usize * 6..][..6];
                assert!(back[3..].contains(&at));
                assert_eq!(row[..3].iter().filter(|v| back[..3].contains(v)).count(), 2);
            }
        }
    }
}
