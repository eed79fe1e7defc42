//! Edges of a supergraph: counted once, at their lexicographically smaller end, and hashed.
//!
//! **Work.** O(1) an edge and end. Which end is the smaller one no processor foresees, so both are hashed and one counts.

use septet_geometry::hash::finalise;
use septet_geometry::point::{Point, is_lex_smaller};
use septet_protocol::ids::NodeId;
use septet_protocol::ledger::LedgerPart;

use crate::state::table::Table;

/// What some home points' edges come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Edges {
    /// Of those whose smaller end is among them.
    pub(crate) count: u64,
    /// Of those: a sum that their order does not matter to.
    pub(crate) hash: u64,
    /// Most neighbours of one point.
    pub(crate) max_degree: u64,
}

impl Edges {
    /// Takes in a home point with its neighbours.
    #[inline]
    pub(crate) fn take<P: Point>(&mut self, table: &Table<P>, owned: u32, neighbours: &[u32]) {
        self.max_degree = self.max_degree.max(neighbours.len() as u64);
        for (pair, is_counted) in edges_of(table, owned, neighbours) {
            // At most as many as there are items in the lists.
            self.count = self.count.wrapping_add(u64::from(is_counted));
            let all_or_none = u64::from(is_counted).wrapping_neg();
            self.hash = self.hash.wrapping_add(hash_of(pair) & all_or_none);
        }
    }

    /// Enters those of a leaf into the ledger.
    pub(crate) fn enter(&self, leaf: NodeId, ledger: &mut LedgerPart) {
        let facts = ledger.facts(leaf);
        facts.edges += self.count;
        facts.max_degree = facts.max_degree.max(self.max_degree);
        ledger.edge_hash = ledger.edge_hash.wrapping_add(self.hash);
    }
}

/// The edges of a home point: the ids of their ends, and whether they are counted here.
#[inline]
pub(crate) fn edges_of<P: Point>(
    table: &Table<P>,
    owned: u32,
    neighbours: &[u32],
) -> impl Iterator<Item = ([u64; 2], bool)> {
    let positions = table.positions.as_slice();
    let ids = &table.ids[..positions.len()];
    let (x, own) = (positions[owned as usize], ids[owned as usize]);
    neighbours.iter().map(move |&j| {
        let (y, other) = (positions[j as usize], ids[j as usize]);
        ([own, other], is_lex_smaller(&x, &y))
    })
}

/// An order-free hash of an edge.
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
        // The second and third are told by their last coordinates.
        let positions =
            vec![DVec2::new(2.0, 0.0), DVec2::new(1.0, 5.0), DVec2::new(1.0, 4.0), DVec2::new(3.0, 0.0)];
        let table = Table::of_owned(vec![10, 11, 12, 13], positions, 0);
        let lists: [&[u32]; 4] = [&[1, 2, 3], &[0, 2], &[0, 1], &[0]];
        let (mut all, mut pairs) = (Edges::default(), Vec::new());
        for (owned, list) in (0..).zip(lists) {
            all.take(&table, owned, list);
            pairs.extend(edges_of(&table, owned, list).filter(|edge| edge.1).map(|edge| edge.0));
        }
        assert_eq!(pairs, [[10, 13], [11, 10], [12, 10], [12, 11]]);
        let hash = pairs.iter().fold(0u64, |sum, &[a, b]| sum.wrapping_add(hash_of([b, a])));
        assert_eq!(all, Edges { count: 4, hash, max_degree: 3 });
    }
}
