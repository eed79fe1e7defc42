//! What stars tell each other in a round of exchange: proposals and objections, on their way and when they arrive.
//!
//! **Statement.** See [`crate::splaying::repair`]. All that stars were told in a step is considered together, whether it came
//! from this worker or from another.
//!
//! **Work and depth.** A star's own are charged in [`crate::splaying::react`]; what is done here is the machine's: one sort of
//! what all stars of a worker were told.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use septet_geometry::blocks::Blocks;
use septet_geometry::cost::Cost;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message};

use crate::neighbours::query::Ball;
use crate::stars::rows::{Objections, Rows, cell_of};
use crate::worker::Worker;

/// The state of the exchange, and of phases that only pass something on.
#[derive(Debug)]
pub(crate) struct Exchange<P: Point> {
    /// The k-nearest lists of each leaf among its own points, between their phases.
    pub(crate) knn: Vec<NearestLists>,
    /// The home points of each leaf in blocks, while such lists are looked for.
    pub(crate) blocks: Vec<Blocks<P>>,
    /// Balls of the sampled stars, in the order of their points, until their outcome is sent; whether it is.
    pub(crate) samples: Vec<Ball>,
    pub(crate) sample_sent: bool,
    /// Points that a gathering brought for home stars: star, point.
    pub(crate) gathered: Vec<(u32, u32)>,
    /// What home stars were told and have not considered.
    pub(crate) proposed: Vec<Proposal<P>>,
    pub(crate) objected: Said<P>,
    /// Home points whose stars changed.
    pub(crate) repaired: BTreeSet<u32>,
    /// The last round of exchange in which this worker said something.
    pub(crate) rounds: u32,
    /// Results merged so far: those after a gathering are charged to the certificate, not to the paper.
    pub(crate) merges: u32,
    /// Cells that belong to this worker, by its last merging; and for each home point a bit for each of its first 64
    /// facets, set where the cell belongs to it.
    pub(crate) cells: u64,
    pub(crate) owned: Vec<u64>,
    /// Home points of which the last check found a cell that another star lacks, or all that are gathered.
    pub(crate) unresolved: BTreeSet<u32>,
}

impl<P: Point> Default for Exchange<P> {
    fn default() -> Self {
        Exchange {
            knn: Vec::new(),
            blocks: Vec::new(),
            samples: Vec::new(),
            sample_sent: false,
            gathered: Vec::new(),
            proposed: Vec::new(),
            objected: Said::default(),
            repaired: BTreeSet::new(),
            rounds: 0,
            cells: 0,
            owned: Vec::new(),
            merges: 0,
            unresolved: BTreeSet::new(),
        }
    }
}

impl<P: Point> Exchange<P> {
    /// The phase that the next merging is charged to.
    pub(crate) fn merge_phase(&self) -> Phase {
        if self.merges > 0 { Phase::Certificate } else { Phase::Merge }
    }

    /// Are there stars that were told something?
    pub(crate) fn is_pending(&self) -> bool {
        !(self.gathered.is_empty() && self.proposed.is_empty() && self.objected.is_empty())
    }
}

/// A cell that a star may lack: the vertex that is told, the cell in order, the vertex that tells.
pub(crate) type Proposal<P> = (u32, <P as Point>::Cell, u32);

/// Cells that are not Delaunay, as seen from one vertex, for the stars of others; points that show it.
#[derive(Clone, Debug)]
pub(crate) struct Said<P: Point> {
    cells: Vec<Objection<P>>,
    points: Vec<u32>,
}

/// The vertex that is told, the cell in order, the vertex that tells, the places of the points against the cell.
pub(crate) type Objection<P> = (u32, <P as Point>::Cell, u32, Range<usize>);

impl<P: Point> Default for Said<P> {
    fn default() -> Self {
        Said { cells: Vec::new(), points: Vec::new() }
    }
}

impl<P: Point> Said<P> {
    /// Is nothing said?
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// What is said in the order of those that are told, of the cells and of those that tell; and the points.
    pub(crate) fn sorted(&mut self) -> (&[Objection<P>], &[u32]) {
        self.cells.sort_unstable_by_key(|objection| (objection.0, objection.1, objection.2));
        (&self.cells, &self.points)
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

/// What one star was told in a step, each list in order.
pub(crate) struct Told<'a, P: Point> {
    pub(crate) home: u32,
    pub(crate) proposed: &'a [Proposal<P>],
    pub(crate) objected: &'a [Objection<P>],
    pub(crate) gathered: &'a [(u32, u32)],
}

/// What was told, star by star; each list is in the order of the stars.
pub(crate) fn star_by_star<'a, P: Point>(
    proposed: &'a [Proposal<P>],
    objected: &'a [Objection<P>],
    gathered: &'a [(u32, u32)],
) -> Vec<Told<'a, P>> {
    let mut proposed = proposed.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut objected = objected.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut gathered = gathered.chunk_by(|a, b| a.0 == b.0).peekable();
    let mut stars = Vec::new();
    loop {
        let heads = [
            proposed.peek().map(|told| told[0].0),
            objected.peek().map(|told| told[0].0),
            gathered.peek().map(|told| told[0].0),
        ];
        let Some(home) = heads.into_iter().flatten().min() else { return stars };
        stars.push(Told {
            home,
            proposed: proposed.next_if(|told| told[0].0 == home).unwrap_or_default(),
            objected: objected.next_if(|told| told[0].0 == home).unwrap_or_default(),
            gathered: gathered.next_if(|told| told[0].0 == home).unwrap_or_default(),
        });
    }
}

/// The cell with its vertices in order, for comparison.
pub(crate) fn in_order<P: Point>(cell: &P::Cell) -> P::Cell {
    let mut ordered = *cell;
    ordered.as_mut().sort_unstable();
    ordered
}

impl<P: Point> Worker<P> {
    /// Sends cells to the homes of the vertices that may lack them.
    pub(crate) fn send_proposals(&mut self, proposals: Vec<Proposal<P>>) {
        let mut batches: BTreeMap<Rank, Rows<P>> = BTreeMap::new();
        for (to, cell, from) in proposals {
            self.record_said(false, (from, to), &cell, &[]);
            if self.table.is_home(to) {
                self.exchange.proposed.push((to, cell, from));
            } else {
                let rows = batches.entry(self.table.owners[to as usize]).or_default();
                rows.cell(&self.table, from, to, &cell);
            }
        }
        for (rank, rows) in batches {
            let body = Body::Propose { points: rows.points, cells: Bulk(rows.cells) };
            self.out.send(rank, NodeId::ROOT, self.exchange.rounds, body);
        }
    }

    /// Sends cells, and what is against them, to the homes of vertices that may hold them.
    pub(crate) fn send_objections(&mut self, said: &Said<P>) {
        let mut batches: BTreeMap<Rank, Objections<P>> = BTreeMap::new();
        for (to, cell, from, range) in &said.cells {
            let points = &said.points[range.clone()];
            self.record_said(true, (*from, *to), cell, points);
            if self.table.is_home(*to) {
                self.exchange.objected.add([*to].into_iter(), cell, *from, points);
                continue;
            }
            let rank = self.table.owners[*to as usize];
            let (rows, counts, conflicts) = batches.entry(rank).or_default();
            rows.cell(&self.table, *from, *to, cell);
            counts.push(points.len() as u32);
            conflicts.extend(points.iter().map(|&v| rows.place(&self.table, v)));
        }
        for (rank, (rows, counts, conflicts)) in batches {
            let body = Body::Object {
                points: rows.points,
                cells: Bulk(rows.cells),
                counts: Bulk(counts),
                conflicts: Bulk(conflicts),
            };
            self.out.send(rank, NodeId::ROOT, self.exchange.rounds, body);
        }
    }

    /// Records what a star of one leaf tells a star of another.
    fn record_said(&mut self, objection: bool, (from, to): (u32, u32), cell: &P::Cell, conflicts: &[u32]) {
        if self.recorder.is_none() {
            return;
        }
        let leaves = (self.leaf_number(from), self.leaf_number(to));
        let named = cell.as_ref().iter().chain(conflicts).map(|&v| self.table.ids[v as usize]);
        if let Some(recorder) = &mut self.recorder {
            recorder.said((self.step, objection), leaves, named, conflicts.len() as u64);
        }
    }

    /// Takes what other workers' stars tell.
    pub(crate) fn take_said(&mut self, inbox: &mut Vec<Message<P>>) {
        let (mut proposals, mut objections) = (Vec::new(), Vec::new());
        inbox.retain_mut(|m| match &mut m.body {
            Body::Propose { points, cells } => {
                proposals.push((std::mem::take(points), std::mem::take(&mut cells.0)));
                false
            }
            Body::Object { points, cells, counts, conflicts } => {
                let lists = (std::mem::take(&mut counts.0), std::mem::take(&mut conflicts.0));
                objections.push((std::mem::take(points), std::mem::take(&mut cells.0), lists));
                false
            }
            _ => true,
        });
        for (points, cells) in proposals {
            let numbers = self.table.intern_all(&points);
            for row in cells.chunks_exact(P::DIM + 1) {
                let cell = cell_of::<P>(row, &numbers);
                let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
                if self.table.is_home(to) {
                    self.exchange.proposed.push((to, in_order::<P>(&cell), from));
                }
            }
        }
        for (points, cells, (counts, conflicts)) in objections {
            let numbers = self.table.intern_all(&points);
            let mut at = 0;
            for (row, count) in cells.chunks_exact(P::DIM + 1).zip(counts) {
                let end = at + count as usize;
                let cell = cell_of::<P>(row, &numbers);
                let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
                let against: Vec<u32> = conflicts[at..end].iter().map(|&i| numbers[i as usize]).collect();
                if self.table.is_home(to) {
                    self.exchange.objected.add([to].into_iter(), &in_order::<P>(&cell), from, &against);
                }
                at = end;
            }
        }
    }

    /// Charges one vector step over stars, leaf by leaf.
    pub(crate) fn charge_stars(&mut self, costs: impl Iterator<Item = (u32, Cost)>) {
        let mut leaves: BTreeMap<NodeId, (Cost, u64)> = BTreeMap::new();
        for (home, cost) in costs {
            let entry = leaves.entry(self.leaf_of(home)).or_default();
            entry.0.beside(cost);
            entry.1 += 1;
        }
        for (leaf, (cost, items)) in leaves {
            self.ledger.charge(Phase::Repair, leaf, cost, items);
        }
    }

    /// The leaf of a home point.
    fn leaf_of(&self, home: u32) -> NodeId {
        let at = self.subdomain.leaves.partition_point(|leaf| leaf.end <= home);
        self.subdomain.leaves[at].id
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn every_star_hears_all_that_it_was_told_once() {
        let proposed: Vec<Proposal<DVec2>> =
            vec![(1, [1, 5, 6], 5), (1, [1, 5, 6], 6), (1, [1, 7, 8], 7), (4, [2, 4, 9], 2)];
        let mut said = Said::<DVec2>::default();
        said.add([7].into_iter(), &[3, 7, 8], 3, &[40]);
        said.add([4, 1].into_iter(), &[1, 4, 9], 9, &[50, 51]);
        let (objected, points) = said.sorted();
        let gathered = vec![(0, 9), (4, 10), (4, 11)];
        let stars = star_by_star::<DVec2>(&proposed, objected, &gathered);
        let counts: Vec<_> =
            stars.iter().map(|s| (s.home, s.proposed.len(), s.objected.len(), s.gathered.len())).collect();
        assert_eq!(counts, [(0, 0, 0, 1), (1, 3, 1, 0), (4, 1, 1, 2), (7, 0, 1, 0)]);
        assert_eq!(points[stars[1].objected[0].3.clone()], [50, 51]);
        assert_eq!(points[stars[3].objected[0].3.clone()], [40]);
        assert!(star_by_star::<DVec2>(&[], &[], &[]).is_empty());
    }
}
