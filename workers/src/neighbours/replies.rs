//! Answers to balls that came from elsewhere: lists of points, each point once for all balls of one leaf.
//!
//! **Statement.** Balls of one leaf travel together and find much the same points. An answer has the points that the
//! lists of one leaf's balls name, each once, and the lists as places among them. Distances are not sent: whoever
//! asked has the centre, and there is one expression for them. So what is sent depends on leaves, and not on how
//! many of them a worker has.

use septet_geometry::complex::NONE;
use septet_geometry::lists::Lists;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Rank;
use septet_protocol::message::{QueryBatch, ReplyBatch};

use crate::state::table::Table;

/// Queries that came in one message: answered in one message, when the last of them is.
#[derive(Clone, Debug)]
pub(crate) struct Asked {
    from: Rank,
    outstanding: u32,
    /// The sender's names of the queries; how many each group has.
    slots: Vec<u32>,
    groups: Vec<u32>,
    /// What was found at once, and the lists that were completed later; which of them is a query's.
    lists: Lists<u32>,
    places: Vec<u32>,
}

impl Asked {
    /// Those of a batch, in their order, with what was found for each: the answer, but for `outstanding` of them that
    /// are answered later.
    pub(crate) fn of<P>(from: Rank, batch: QueryBatch<P>, found: Lists<u32>, outstanding: u32) -> Self {
        let places = (0..batch.slots.len() as u32).collect();
        Asked { from, outstanding, slots: batch.slots.0, groups: batch.groups.0, lists: found, places }
    }

    /// Who asked.
    pub(crate) fn from(&self) -> Rank {
        self.from
    }

    /// Enters the list of a query that was outstanding, by its position in the batch.
    pub(crate) fn answer(&mut self, query: u32, list: impl IntoIterator<Item = u32>) {
        self.outstanding -= 1;
        self.places[query as usize] = self.lists.len() as u32;
        self.lists.push(list);
    }

    /// Is it to be sent?
    pub(crate) fn is_complete(&self) -> bool {
        self.outstanding == 0 && !self.slots.is_empty()
    }

    /// The answer, once; `marks` has a [`NONE`] for every point of the table, before and after.
    pub(crate) fn take<P: Point>(&mut self, table: &Table<P>, marks: &mut [u32]) -> ReplyBatch<P> {
        let lists = std::mem::take(&mut self.lists);
        let (groups, slots) = (std::mem::take(&mut self.groups), std::mem::take(&mut self.slots));
        let mut counts = Vec::with_capacity(slots.len());
        let mut sizes = Vec::with_capacity(groups.len());
        let mut places = Vec::with_capacity(lists.items());
        // The points of all groups.
        let (mut named, mut rest) = (Vec::new(), self.places.iter());
        for &queries in &groups {
            let begin = named.len();
            for &place in rest.by_ref().take(queries as usize) {
                let list = &lists[place as usize];
                counts.push(list.len() as u32);
                for &number in list {
                    let mark = &mut marks[number as usize];
                    if *mark == NONE {
                        *mark = (named.len() - begin) as u32;
                        named.push(number);
                    }
                    places.push(*mark);
                }
            }
            sizes.push((named.len() - begin) as u32);
            for &number in &named[begin..] {
                marks[number as usize] = NONE;
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
    fn a_point_goes_once_for_each_group() {
        let positions: Vec<DVec2> = (0..4).map(|i| DVec2::new(f64::from(i), 0.0)).collect();
        let table = Table::of_owned(vec![100, 101, 102, 103], positions.clone(), 5);
        let batch = QueryBatch::<DVec2> {
            slots: Bulk(vec![7, 8, 9]),
            groups: Bulk(vec![2, 0, 1]),
            ..QueryBatch::default()
        };
        let found = [vec![0], vec![2, 3], vec![1, 0]].into_iter().collect();
        let mut asked = Asked::of(3, batch, found, 2);
        let mut marks = vec![NONE; 4];
        // In the order in which they are done: the last one was at once.
        asked.answer(1, [1, 2, 3]);
        assert!(!asked.is_complete());
        asked.answer(0, [3, 1]);
        assert!(asked.is_complete());
        let answer = asked.take(&table, &mut marks);
        assert_eq!((answer.slots.0, answer.counts.0), (vec![7, 8, 9], vec![2, 3, 2]));
        assert_eq!((answer.groups.0, answer.sizes.0), (vec![2, 0, 1], vec![3, 0, 2]));
        assert_eq!(answer.places.0, [0, 1, 1, 2, 0, 0, 1]);
        let points = answer.points;
        assert_eq!(points.ids.0, [103, 101, 102, 101, 100]);
        assert!(points.positions.0.into_iter().eq([3, 1, 2, 1, 0].map(|i: usize| positions[i])));
        assert!(points.owners.0.iter().all(|&owner| owner == 5) && points.radii2.0 == [f64::INFINITY; 5]);
        assert!(marks.iter().all(|&mark| mark == NONE));
        // Nothing is sent twice.
        assert!(!asked.is_complete());
    }
}
