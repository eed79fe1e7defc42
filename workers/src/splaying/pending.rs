//! What stars tell each other in a round of exchange: proposals and objections, on their way and when they arrive.
//!
//! **Statement.** See [`crate::splaying::splay`]. Stars consider all that they hear in a step together,
//! whether it came from this rank or from another.
//!
//! **Work and depth.** Stars pay for their own in [`crate::splaying::step`]. Here the machine sorts once what all stars of
//! a rank heard.

use std::collections::BTreeMap;
use std::ops::Range;

use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::machine::context::Context;
use crate::machine::tasks::Recorder;
use crate::stars::owned::Stars;
use crate::stars::rows::{Objections, Rows, cell_of};
use crate::state::cells::in_order;
use crate::state::table::Table;
use crate::state::tree::{Leaf, leaf_number};

/// A cell that a star may lack: the receiver, the cell in order, the sender; both are vertices of it.
pub(crate) type Proposal<P> = (u32, <P as Point>::Cell, u32);

/// Cells that are not Delaunay, as seen from one vertex, for the stars of others; points that show it.
#[derive(Clone, Debug)]
pub(crate) struct Announced<P: Point> {
    cells: Vec<Objection<P>>,
    points: Vec<u32>,
}

/// The receiver, the cell in order, the sender, the places of the points against the cell.
pub(crate) type Objection<P> = (u32, <P as Point>::Cell, u32, Range<usize>);

impl<P: Point> Default for Announced<P> {
    fn default() -> Self {
        Announced { cells: Vec::new(), points: Vec::new() }
    }
}

impl<P: Point> Announced<P> {
    /// Whether nothing is said.
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Puts the objections in the order of receivers, cells and senders.
    pub(crate) fn sort(&mut self) {
        self.cells.sort_unstable_by_key(|objection| (objection.0, objection.1, objection.2));
    }

    /// The objections.
    pub(crate) fn cells(&self) -> &[Objection<P>] {
        &self.cells
    }

    /// The points that they name.
    pub(crate) fn points(&self) -> &[u32] {
        &self.points
    }

    /// Adds what others say.
    pub(crate) fn append(&mut self, other: Self) {
        let offset = self.points.len();
        let moved = |range: Range<usize>| range.start + offset..range.end + offset;
        self.cells
            .extend(other.cells.into_iter().map(|(to, cell, from, range)| (to, cell, from, moved(range))));
        self.points.extend(other.points);
    }

    /// Adds one cell for several vertices.
    pub(crate) fn add(&mut self, to: impl Iterator<Item = u32>, cell: &P::Cell, from: u32, points: &[u32]) {
        let start = self.points.len();
        self.points.extend_from_slice(points);
        let range = start..self.points.len();
        self.cells.extend(to.map(|to| (to, *cell, from, range.clone())));
    }
}

/// What one star heard in a step, each list in order.
pub(crate) struct StarNews<'a, P: Point> {
    pub(crate) owned: u32,
    pub(crate) proposed: &'a [Proposal<P>],
    pub(crate) objected: &'a [Objection<P>],
    pub(crate) gathered: &'a [(u32, u32)],
}

/// What stars heard, star by star; each list is in the order of the stars.
pub(crate) fn star_by_star<'a, P: Point>(
    proposed: &'a [Proposal<P>],
    objected: &'a [Objection<P>],
    gathered: &'a [(u32, u32)],
) -> Vec<StarNews<'a, P>> {
    let mut proposed = proposed.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut objected = objected.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut gathered = gathered.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut stars = Vec::new();
    loop {
        let heads = [
            proposed.peek().map(|news| news[0].0),
            objected.peek().map(|news| news[0].0),
            gathered.peek().map(|news| news[0].0),
        ];
        let Some(owned) = heads.into_iter().flatten().min() else { return stars };
        stars.push(StarNews {
            owned,
            proposed: proposed.next_if(|news| news[0].0 == owned).unwrap_or_default(),
            objected: objected.next_if(|news| news[0].0 == owned).unwrap_or_default(),
            gathered: gathered.next_if(|news| news[0].0 == owned).unwrap_or_default(),
        });
    }
}

/// A point that a gathering brought for a home star: the star, the point.
pub(crate) type Gathered = (u32, u32);

/// What home stars heard and have not considered.
#[derive(Debug)]
pub(crate) struct Received<P: Point> {
    pub(crate) proposed: Vec<Proposal<P>>,
    pub(crate) objected: Announced<P>,
    pub(crate) gathered: Vec<Gathered>,
}

impl<P: Point> Received<P> {
    /// What a gathering brought.
    pub(crate) fn of(gathered: Vec<Gathered>) -> Self {
        Received { proposed: Vec::new(), objected: Announced::default(), gathered }
    }

    /// Whether some star heard something.
    pub(crate) fn is_pending(&self) -> bool {
        !(self.gathered.is_empty() && self.proposed.is_empty() && self.objected.is_empty())
    }

    /// Puts all lists in the order of the receivers.
    pub(crate) fn sort(&mut self) {
        self.proposed.sort_unstable();
        self.gathered.sort_unstable();
        self.objected.sort();
    }

    /// What stars heard, star by star, once all lists are in order.
    pub(crate) fn star_by_star(&self) -> Vec<StarNews<'_, P>> {
        star_by_star::<P>(&self.proposed, self.objected.cells(), &self.gathered)
    }

    /// Takes what stars of other ranks say.
    pub(crate) fn take(&mut self, cx: &mut Context<P>, table: &mut Table<P>, stars: &mut Stars<P>) {
        let proposals = take_proposals(cx);
        let objections = take_objections(cx);
        if !(proposals.is_empty() && objections.is_empty()) {
            stars.write_out(table);
        }
        for (points, cells) in proposals {
            let numbers = table.intern_all(&points);
            for row in cells.chunks_exact(P::DIM + 1) {
                let cell = cell_of::<P>(row, &numbers);
                let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
                if table.is_owned(to) {
                    self.proposed.push((to, in_order::<P>(&cell), from));
                }
            }
        }
        for Against { points, cells, counts, conflicts } in objections {
            let numbers = table.intern_all(&points);
            let mut at = 0;
            for (row, count) in cells.chunks_exact(P::DIM + 1).zip(counts) {
                let end = at + count as usize;
                let cell = cell_of::<P>(row, &numbers);
                let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
                let against: Vec<u32> = conflicts[at..end].iter().map(|&i| numbers[i as usize]).collect();
                if table.is_owned(to) {
                    self.objected.add([to].into_iter(), &in_order::<P>(&cell), from, &against);
                }
                at = end;
            }
        }
    }
}

/// A message of proposals: points, and cells of them.
type Proposed<P> = (PointBatch<P>, Vec<u32>);

fn take_proposals<P: Point>(cx: &mut Context<P>) -> Vec<Proposed<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Propose { points, cells } => Some((std::mem::take(points), std::mem::take(&mut cells.0))),
        _ => None,
    })
}

/// A message of objections: points, cells of them, how many points are against each cell, and which.
struct Against<P> {
    points: PointBatch<P>,
    cells: Vec<u32>,
    counts: Vec<u32>,
    conflicts: Vec<u32>,
}

fn take_objections<P: Point>(cx: &mut Context<P>) -> Vec<Against<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Object { points, cells, counts, conflicts } => Some(Against {
            points: std::mem::take(points),
            cells: std::mem::take(&mut cells.0),
            counts: std::mem::take(&mut counts.0),
            conflicts: std::mem::take(&mut conflicts.0),
        }),
        _ => None,
    })
}

/// What the stars of a rank say in a round.
pub(crate) struct Announcements<P: Point> {
    pub(crate) proposals: Vec<Proposal<P>>,
    pub(crate) objections: Announced<P>,
    /// The round of exchange.
    pub(crate) round: u32,
}

impl<P: Point> Announcements<P> {
    /// Whether nothing is said.
    pub(crate) fn is_empty(&self) -> bool {
        self.proposals.is_empty() && self.objections.is_empty()
    }

    /// Tells the stars of this rank, and sends the rest to the homes of the others.
    pub(crate) fn tell(
        &self,
        cx: &mut Context<P>,
        leaves: &[Leaf<P>],
        table: &Table<P>,
        heard: &mut Received<P>,
    ) {
        if let Some(recorder) = &mut cx.recorder {
            self.record(recorder, leaves, table);
        }
        self.propose(cx, table, heard);
        self.object(cx, table, heard);
    }

    /// Cells to the vertices that may lack them.
    fn propose(&self, cx: &mut Context<P>, table: &Table<P>, heard: &mut Received<P>) {
        let mut batches: BTreeMap<Rank, Rows<P>> = BTreeMap::new();
        for &(to, cell, from) in &self.proposals {
            if table.is_owned(to) {
                heard.proposed.push((to, cell, from));
            } else {
                let rows = batches.entry(table.owners()[to as usize]).or_default();
                rows.cell(table, from, to, &cell);
            }
        }
        for (rank, rows) in batches {
            let body = Body::Propose { points: rows.points, cells: Bulk(rows.cells) };
            cx.send(rank, NodeId::ROOT, self.round, body);
        }
    }

    /// Cells, and what is against them, to the vertices that may hold them.
    fn object(&self, cx: &mut Context<P>, table: &Table<P>, heard: &mut Received<P>) {
        let mut batches: BTreeMap<Rank, Objections<P>> = BTreeMap::new();
        for (to, cell, from, range) in &self.objections.cells {
            let points = &self.objections.points[range.clone()];
            if table.is_owned(*to) {
                heard.objected.add([*to].into_iter(), cell, *from, points);
                continue;
            }
            let batch = batches.entry(table.owners()[*to as usize]).or_default();
            batch.rows.cell(table, *from, *to, cell);
            batch.counts.push(points.len() as u32);
            batch.conflicts.extend(points.iter().map(|&v| batch.rows.place(table, v)));
        }
        for (rank, Objections { rows, counts, conflicts }) in batches {
            let body = Body::Object {
                points: rows.points,
                cells: Bulk(rows.cells),
                counts: Bulk(counts),
                conflicts: Bulk(conflicts),
            };
            cx.send(rank, NodeId::ROOT, self.round, body);
        }
    }

    /// Records what stars of one leaf tell stars of another, if that is asked for.
    fn record(&self, recorder: &mut Recorder, leaves: &[Leaf<P>], table: &Table<P>) {
        let mut said = |objection: bool, (from, to): (u32, u32), cell: &P::Cell, conflicts: &[u32]| {
            let between = (leaf_number(leaves, from), leaf_number(leaves, to));
            let named = cell.as_ref().iter().chain(conflicts).map(|&v| table.ids()[v as usize]);
            recorder.said((self.round - 1, objection), between, named, conflicts.len() as u64);
        };
        for (to, cell, from) in &self.proposals {
            said(false, (*from, *to), cell, &[]);
        }
        for (to, cell, from, range) in &self.objections.cells {
            said(true, (*from, *to), cell, &self.objections.points[range.clone()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn every_star_hears_each_thing_once() {
        let proposed: Vec<Proposal<DVec2>> =
            vec![(1, [1, 5, 6], 5), (1, [1, 5, 6], 6), (1, [1, 7, 8], 7), (4, [2, 4, 9], 2)];
        let mut said = Announced::<DVec2>::default();
        said.add([7].into_iter(), &[3, 7, 8], 3, &[40]);
        said.add([4, 1].into_iter(), &[1, 4, 9], 9, &[50, 51]);
        said.sort();
        let (objected, points) = (said.cells(), said.points());
        let gathered = vec![(0, 9), (4, 10), (4, 11)];
        let stars = star_by_star::<DVec2>(&proposed, objected, &gathered);
        let counts: Vec<_> =
            stars.iter().map(|s| (s.owned, s.proposed.len(), s.objected.len(), s.gathered.len())).collect();
        assert_eq!(counts, [(0, 0, 0, 1), (1, 3, 1, 0), (4, 1, 1, 2), (7, 0, 1, 0)]);
        assert_eq!(points[stars[1].objected[0].3.clone()], [50, 51]);
        assert_eq!(points[stars[3].objected[0].3.clone()], [40]);
        assert!(star_by_star::<DVec2>(&[], &[], &[]).is_empty());
    }
}
