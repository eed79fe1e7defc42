//! What stars tell each other in a round of exchange: proposals and objections, on their way and when they arrive.
//!
//! **Statement.** See [`crate::repair`]. All that stars were told in a step is considered together, whether it came
//! from this worker or from another: a star looks for each cell among its own once, however many proposed it, and
//! tests its link's points against those that it lacks.
//!
//! **Work and depth.** For a star with `l` facets that is told of `m` cells: a sort of those, `m` sweeps over the
//! link and over its points; O(m l + m log m) work, O(m) depth.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use septet_geometry::blocks::Blocks;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::hull::Witnesses;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message};

use crate::config::map_in;
use crate::links::{Sought, link_points};
use crate::query::Ball;
use crate::rows::{Objections, Rows, cell_of};
use crate::worker::Worker;

/// The state of the exchange, and of phases that only pass something on.
#[derive(Debug)]
pub(crate) struct Exchange<P: Point> {
    /// The k-nearest lists between their phases.
    pub(crate) knn: NearestLists,
    /// The home points of each leaf in blocks, while such lists are looked for.
    pub(crate) blocks: Vec<Blocks<P>>,
    /// Balls of the sampled stars, in the order of their points, until their outcome is sent; whether it is.
    pub(crate) samples: Vec<Ball>,
    pub(crate) sample_sent: bool,
    /// Points to add to home stars: star, point.
    pub(crate) additions: Vec<(u32, u32)>,
    /// What home stars were told and have not considered.
    proposed: Vec<Proposal<P>>,
    objected: Said<P>,
    /// Home points whose stars changed.
    pub(crate) repaired: BTreeSet<u32>,
    /// The last round of exchange in which this worker said something.
    pub(crate) rounds: u32,
    /// Results merged so far: those after a gathering are charged to the certificate, not to the paper.
    pub(crate) merges: u32,
    /// Home points whose stars disagreed at the last check.
    pub(crate) unresolved: BTreeSet<u32>,
}

impl<P: Point> Default for Exchange<P> {
    fn default() -> Self {
        Exchange {
            knn: NearestLists::default(),
            blocks: Vec::new(),
            samples: Vec::new(),
            sample_sent: false,
            additions: Vec::new(),
            proposed: Vec::new(),
            objected: Said::default(),
            repaired: BTreeSet::new(),
            rounds: 0,
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

    /// Are there stars to rebuild, or that were told something?
    pub(crate) fn is_pending(&self) -> bool {
        !(self.additions.is_empty() && self.proposed.is_empty() && self.objected.is_empty())
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
type Objection<P> = (u32, <P as Point>::Cell, u32, Range<usize>);

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

    /// Adds what others say.
    fn append(&mut self, other: Self) {
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

/// What some stars make of what they were told: points to add, what they answer, and what each's consideration cost.
struct Considered<P: Point> {
    additions: Vec<(u32, u32)>,
    answers: Said<P>,
    costs: Vec<(u32, Cost)>,
}

impl<P: Point> Default for Considered<P> {
    fn default() -> Self {
        Considered { additions: Vec::new(), answers: Said::default(), costs: Vec::new() }
    }
}

/// Stars that are looked at one after the other.
pub(crate) const GROUP: usize = 512;

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

    /// Stars that lack proposed cells take their vertices, and object with those of their own link points that
    /// conflict with them.
    pub(crate) fn answer_proposals(&mut self) {
        let mut proposed = std::mem::take(&mut self.exchange.proposed);
        if proposed.is_empty() {
            return;
        }
        proposed.sort_unstable();
        let stars: Vec<&[Proposal<P>]> = proposed.chunk_by(|a, b| a.0 == b.0).collect();
        let groups: Vec<&[&[Proposal<P>]]> = stars.chunks(GROUP).collect();
        let considered = map_in(&self.pool, &groups, |group| {
            let (mut seen, mut witnesses) = (Marks::new(self.table.positions.len()), Witnesses::default());
            let mut out = Considered::default();
            group.iter().for_each(|proposals| self.consider(proposals, &mut seen, &mut witnesses, &mut out));
            out
        });
        let answers = self.take_considered(considered);
        self.send_objections(&answers);
    }

    /// Notes what stars made of what they were told, and charges it as one vector step over those of each leaf; returns
    /// what they answer.
    fn take_considered(&mut self, considered: Vec<Considered<P>>) -> Said<P> {
        let mut answers = Said::default();
        self.charge_stars(considered.iter().flat_map(|group| group.costs.iter().copied()));
        for group in considered {
            self.exchange.additions.extend(&group.additions);
            answers.append(group.answers);
        }
        answers
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

    /// One star, and all that is proposed to it.
    fn consider(
        &self,
        proposals: &[Proposal<P>],
        seen: &mut Marks,
        witnesses: &mut Witnesses<P>,
        out: &mut Considered<P>,
    ) {
        let home = proposals[0].0;
        let link = self.stars.link(home);
        let (mut cost, mut looked, mut tests) = (Cost::ZERO, Sweep::default(), Sweep::default());
        let mut cells: Vec<P::Cell> = proposals.iter().map(|p| p.1).collect();
        cost.distinct_inside(&mut cells, Ord::cmp);
        let sought = Sought::<P>::of(link, home);
        cells.retain(|cell| !sought.has(cell, &mut looked));
        cost.swept_inside(looked);
        if !cells.is_empty() {
            let points = link_points::<P>(link, seen, &mut cost);
            witnesses.begin(&self.table.positions, home, &points, &mut tests);
            let mut against = Vec::new();
            for cell in &cells {
                // What stands in the link adds nothing.
                let new = cell.as_ref().iter().filter(|&&v| v != home && !seen.has_seen(v));
                out.additions.extend(new.map(|&v| (home, v)));
                against.clear();
                witnesses.against(&self.table.positions, cell, &mut against, &mut tests);
                if !against.is_empty() {
                    let first = proposals.partition_point(|p| p.1 < *cell);
                    let tellers = proposals[first..].iter().take_while(|p| p.1 == *cell).map(|p| p.2);
                    out.answers.add(tellers, cell, home, &against);
                }
            }
            cost.swept_inside(tests);
        }
        out.costs.push((home, cost));
    }

    /// Stars that hold cells which others object to take the points in their spheres.
    pub(crate) fn heed_objections(&mut self) {
        let mut said = std::mem::take(&mut self.exchange.objected);
        if said.is_empty() {
            return;
        }
        said.cells.sort_unstable_by_key(|objection| (objection.0, objection.1, objection.2));
        let stars: Vec<&[Objection<P>]> = said.cells.chunk_by(|a, b| a.0 == b.0).collect();
        let groups: Vec<&[&[Objection<P>]]> = stars.chunks(GROUP).collect();
        let considered = map_in(&self.pool, &groups, |group| {
            let mut out = Considered::default();
            group.iter().for_each(|objections| self.heed(objections, &said.points, &mut out));
            out
        });
        self.take_considered(considered);
    }

    /// One star, and all that is said against its cells.
    fn heed(&self, objections: &[Objection<P>], points: &[u32], out: &mut Considered<P>) {
        let home = objections[0].0;
        let sought = Sought::<P>::of(self.stars.link(home), home);
        let (mut cost, mut looked) = (Cost::ZERO, Sweep::default());
        let mut cells: Vec<P::Cell> = objections.iter().map(|o| o.1).collect();
        cost.distinct_inside(&mut cells, Ord::cmp);
        cells.retain(|cell| sought.has(cell, &mut looked));
        cost.swept_inside(looked);
        for (_, cell, _, range) in objections {
            if cells.binary_search(cell).is_ok() {
                out.additions.extend(points[range.clone()].iter().map(|&v| (home, v)));
            }
        }
        out.costs.push((home, cost));
    }

    /// The leaf of a home point.
    fn leaf_of(&self, home: u32) -> NodeId {
        let at = self.leaves.partition_point(|leaf| leaf.end <= home);
        self.leaves[at].id
    }
}
