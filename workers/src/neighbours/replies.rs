//! Replies to the queries of other ranks. A reply contains each point once for all balls of one leaf.
//!
//! **Statement.** Balls of one leaf travel together and find nearly the same points. For each leaf, a reply contains
//! the points in the lists of its balls, each point once, and the lists as positions among these points. It contains no
//! distances, because the receiver holds the centre and all ranks compute distances by the same expression. The content
//! of replies therefore depends on the leaves, not on their distribution over ranks.

use septet_geometry::complex::NONE;
use septet_geometry::lists::Lists;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::message::{QueryBatch, ReplyBatch};

use crate::state::table::Table;

/// The queries of one message. When the last list is complete, one message answers them all.
#[derive(Clone, Debug)]
pub(crate) struct ReceivedQueries {
    from: Rank,
    /// The number of queries whose lists are not complete.
    outstanding: u32,
    /// For each query, the sender's index.
    slots: Vec<u32>,
    /// The number of queries of each group.
    groups: Vec<u32>,
    /// The lists found on this rank, in the order of the queries, then the lists that were completed later.
    lists: Lists<u32>,
    /// For each query, the index of its list.
    list_of: Vec<u32>,
}

impl ReceivedQueries {
    /// Creates the record of a batch with the points found for each query. The complete lists of `outstanding` queries
    /// follow later.
    pub(crate) fn of<P>(from: Rank, batch: QueryBatch<P>, found: Lists<u32>, outstanding: u32) -> Self {
        let list_of = (0..batch.slots.len() as u32).collect();
        let (slots, groups) = (batch.slots.0, batch.groups.0);
        ReceivedQueries { from, outstanding, slots, groups, lists: found, list_of }
    }

    /// Returns the sender.
    pub(crate) fn from(&self) -> Rank {
        self.from
    }

    /// Stores the complete list of the outstanding query at position `query` of the batch.
    pub(crate) fn complete(&mut self, query: u32, list: impl IntoIterator<Item = u32>) {
        self.outstanding -= 1;
        self.list_of[query as usize] = self.lists.len() as u32;
        self.lists.push(list);
    }

    /// Returns `true` if all lists are complete and the reply has not been taken.
    pub(crate) fn is_complete(&self) -> bool {
        self.outstanding == 0 && !self.slots.is_empty()
    }

    /// Takes the reply. `marks` contains [`NONE`] for each point of the table, before and after the call.
    pub(crate) fn take<P: Point>(&mut self, table: &Table<P>, marks: &mut [u32]) -> ReplyBatch<P> {
        let lists = std::mem::take(&mut self.lists);
        let (groups, slots) = (std::mem::take(&mut self.groups), std::mem::take(&mut self.slots));
        let mut counts = Vec::with_capacity(slots.len());
        let mut sizes = Vec::with_capacity(groups.len());
        let mut places = Vec::with_capacity(lists.items());
        // The points of all groups.
        let (mut named, mut rest) = (Vec::new(), self.list_of.iter());
        for &queries in &groups {
            let begin = named.len();
            for &at in rest.by_ref().take(queries as usize) {
                let list = &lists[at as usize];
                counts.push(list.len() as u32);
                for &point in list {
                    let mark = &mut marks[point as usize];
                    if *mark == NONE {
                        *mark = (named.len() - begin) as u32;
                        named.push(point);
                    }
                    places.push(*mark);
                }
            }
            sizes.push((named.len() - begin) as u32);
            for &point in &named[begin..] {
                marks[point as usize] = NONE;
            }
        }
        ReplyBatch {
            slots: Bulk(slots),
            counts: Bulk(counts),
            groups: Bulk(groups),
            sizes: Bulk(sizes),
            places: Bulk(places),
            points: table.points(&named),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn a_reply_contains_a_point_once_for_each_group() {
        let positions: Vec<DVec2> = (0..4).map(|i| DVec2::new(f64::from(i), 0.0)).collect();
        let table = Table::of_owned(vec![100, 101, 102, 103], positions.clone(), 5);
        let batch = QueryBatch::<DVec2> {
            slots: Bulk(vec![7, 8, 9]),
            groups: Bulk(vec![2, 0, 1]),
            ..QueryBatch::default()
        };
        let found = [vec![0], vec![2, 3], vec![1, 0]].into_iter().collect();
        let mut received = ReceivedQueries::of(3, batch, found, 2);
        let mut marks = vec![NONE; 4];
        // The lists of the first two queries are completed in reverse order.
        received.complete(1, [1, 2, 3]);
        assert!(!received.is_complete());
        received.complete(0, [3, 1]);
        assert!(received.is_complete());
        let reply = received.take(&table, &mut marks);
        assert_eq!((reply.slots.0, reply.counts.0), (vec![7, 8, 9], vec![2, 3, 2]));
        assert_eq!((reply.groups.0, reply.sizes.0), (vec![2, 0, 1], vec![3, 0, 2]));
        assert_eq!(reply.places.0, [0, 1, 1, 2, 0, 0, 1]);
        let points = reply.points;
        assert_eq!(points.ids.0, [103, 101, 102, 101, 100]);
        assert!(points.positions.0.into_iter().eq([3, 1, 2, 1, 0].map(|i: usize| positions[i])));
        assert!(points.owners.0.iter().all(|&owner| owner == 5) && points.radii2.0 == [f64::INFINITY; 5]);
        assert!(marks.iter().all(|&mark| mark == NONE));
        // A reply is taken once.
        assert!(!received.is_complete());
    }
}
