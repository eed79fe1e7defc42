//! The number and the hash of a supergraph's edges. Each edge counts once, at its lexicographically smaller end.
//!
//! **Work.** O(1) for each end of an edge. A processor cannot predict which end is smaller. The code therefore hashes
//! an edge at both ends without a branch, and masks one of the hashes.

use septet_geometry::hash::finalise;
use septet_geometry::point::{Point, is_lex_smaller};
use septet_protocol::ids::NodeId;

use crate::machine::context::Context;
use crate::state::table::Table;

/// The sums over the edges of some owned points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Edges {
    /// The number of edges whose smaller end is among the points.
    pub(crate) count: u64,
    /// The sum of the hashes of these edges, independent of their order.
    pub(crate) hash: u64,
    /// The largest number of neighbours of one of the points.
    pub(crate) max_degree: u64,
}

impl Edges {
    /// Adds an owned point with its neighbours.
    #[inline]
    pub(crate) fn add<P: Point>(&mut self, table: &Table<P>, point: u32, neighbours: &[u32]) {
        self.max_degree = self.max_degree.max(neighbours.len() as u64);
        for (pair, is_counted) in edges_of(table, point, neighbours) {
            // No overflow: the count is at most the number of items in the lists.
            self.count = self.count.wrapping_add(u64::from(is_counted));
            let all_or_none = u64::from(is_counted).wrapping_neg();
            self.hash = self.hash.wrapping_add(hash_of(pair) & all_or_none);
        }
    }

    /// Adds the edges of a leaf to the ledger.
    pub(crate) fn enter<P: Point>(&self, leaf: NodeId, cx: &mut Context<P>) {
        let facts = cx.facts(leaf);
        facts.edges += self.count;
        facts.max_degree = facts.max_degree.max(self.max_degree);
        cx.add_edge_hash(self.hash);
    }
}

/// Returns the edges of an owned point: the ids of their ends, and whether they count at this end.
#[inline]
pub(crate) fn edges_of<P: Point>(
    table: &Table<P>,
    point: u32,
    neighbours: &[u32],
) -> impl Iterator<Item = ([u64; 2], bool)> {
    let positions = table.positions();
    let ids = &table.ids()[..positions.len()];
    let (x, own) = (positions[point as usize], ids[point as usize]);
    neighbours.iter().map(move |&j| {
        let (y, other) = (positions[j as usize], ids[j as usize]);
        ([own, other], is_lex_smaller(&x, &y))
    })
}

/// Hashes an edge, independently of the order of its ends.
#[inline]
fn hash_of(pair: [u64; 2]) -> u64 {
    let (a, b) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
    finalise(a.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ b.rotate_left(32))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn each_edge_counts_at_its_smaller_end() {
        // The second and the third point differ only in their last coordinates.
        let positions =
            vec![DVec2::new(2.0, 0.0), DVec2::new(1.0, 5.0), DVec2::new(1.0, 4.0), DVec2::new(3.0, 0.0)];
        let table = Table::of_owned(vec![10, 11, 12, 13], positions, 0);
        let lists: [&[u32]; 4] = [&[1, 2, 3], &[0, 2], &[0, 1], &[0]];
        let (mut all, mut pairs) = (Edges::default(), Vec::new());
        for (point, list) in (0..).zip(lists) {
            all.add(&table, point, list);
            pairs.extend(edges_of(&table, point, list).filter(|edge| edge.1).map(|edge| edge.0));
        }
        assert_eq!(pairs, [[10, 13], [11, 10], [12, 10], [12, 11]]);
        let hash = pairs.iter().fold(0u64, |sum, &[a, b]| sum.wrapping_add(hash_of([b, a])));
        assert_eq!(all, Edges { count: 4, hash, max_degree: 3 });
    }
}
