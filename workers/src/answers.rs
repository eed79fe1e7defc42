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
use septet_protocol::message::{AnswerBatch, QueryBatch};

use crate::table::Table;

/// Queries that came in one message: answered in one message, when the last of them is.
#[derive(Clone, Debug)]
pub(crate) struct Asked {
    from: Rank,
    outstanding: u32,
    /// The sender's names of the queries; how many each group has.
    slots: Vec<u32>,
    groups: Vec<u32>,
    /// The lists that are complete, and which of them is a query's.
    lists: Lists<u32>,
    places: Vec<u32>,
}

impl Asked {
    /// Those of a batch, of which none is answered, with room for so many items in their lists.
    pub(crate) fn of<P>(from: Rank, batch: &QueryBatch<P>, items: usize) -> Self {
        let queries = batch.slots.len();
        Asked {
            from,
            outstanding: queries as u32,
            slots: batch.slots.0.clone(),
            groups: batch.groups.0.clone(),
            lists: Lists::with_capacity(queries, items),
            places: vec![NONE; queries],
        }
    }

    /// Who asked.
    pub(crate) fn from(&self) -> Rank {
        self.from
    }

    /// Enters the list of a query, by its position in the batch.
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
    pub(crate) fn take<P: Point>(&mut self, table: &Table<P>, marks: &mut [u32]) -> AnswerBatch<P> {
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
        AnswerBatch {
            slots: Bulk(slots),
            counts: Bulk(counts),
            groups: Bulk(groups),
            sizes: Bulk(sizes),
            places: Bulk(places),
            points: table.points(&named),
        }
    }
}
