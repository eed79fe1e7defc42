//! Stars that disagree exchange what they miss (star splaying).
//!
//! **Statement** (Shewchuk 2005; termination in ARCHITECTURE.md). If a cell `t` of `star(v)` is missing from
//! `star(a)`, `a` receives `t`'s vertices, and answers with the points of its own link that conflict with `t`;
//! both rebuild. A star that changed proposes its new cells, and to the vertices of a cell it dropped it sends
//! the points that took its place. Each exchange with any disagreement enlarges some candidate set, so it
//! ends; and if every vertex but the smallest has a smaller candidate, it ends in the triangulation.
//!
//! **Departure.** All stars move in lockstep, those of one worker like those of two: what is exchanged in a
//! round does not depend on where a star is at home, so work and depth do not depend on the number of
//! workers. A round of exchange is two rounds of messages: proposals, and answers.
//!
//! **Rounds.** None where the paper's hypothesis holds; about `0.4 log2 n` on uniform sets (measured).

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::hull::StarBuilder;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::Found;
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::check::Disagreement;
use crate::config::map_in;
use crate::links::{conflicts, difference, link_points};
use crate::rows::{Objections, Rows, cell_of};
use crate::schedule::Outcome;
use crate::worker::{Worker, finite_cell};

/// The state of the exchange, and of phases that only pass something on.
#[derive(Debug)]
pub(crate) struct Exchange<P> {
    /// The k-nearest lists between their phases.
    pub(crate) knn: Lists<Found>,
    /// Number of sampled stars, and whether their outcome is sent.
    pub(crate) samples: usize,
    pub(crate) sample_sent: bool,
    /// Points of the table that a step has seen.
    seen: Marks,
    /// Points to add to home stars: star, point.
    additions: Vec<(u32, u32)>,
    /// Link facets looked at since the last rebuilding, and what became of those that lack a cell: one vector
    /// step of each leaf.
    considered: BTreeMap<NodeId, (Sweep, Cost)>,
    /// Home points whose stars changed.
    pub(crate) repaired: BTreeSet<u32>,
    /// The last round of exchange in which this worker said something.
    pub(crate) rounds: u32,
    /// Results merged so far: those after a gathering are charged to the certificate, not to the paper.
    pub(crate) merges: u32,
    /// Home points whose stars disagreed at the last check.
    unresolved: BTreeSet<u32>,
    marker: std::marker::PhantomData<P>,
}

impl<P> Default for Exchange<P> {
    fn default() -> Self {
        Exchange {
            knn: Lists::default(),
            samples: 0,
            sample_sent: false,
            seen: Marks::default(),
            additions: Vec::new(),
            considered: BTreeMap::new(),
            repaired: BTreeSet::new(),
            rounds: 0,
            merges: 0,
            unresolved: BTreeSet::new(),
            marker: std::marker::PhantomData,
        }
    }
}

impl<P> Exchange<P> {
    /// The phase that the next merging is charged to.
    pub(crate) fn merge_phase(&self) -> Phase {
        if self.merges > 0 { Phase::Certificate } else { Phase::Merge }
    }

    /// Are there stars to rebuild?
    pub(crate) fn is_pending(&self) -> bool {
        !self.additions.is_empty()
    }
}

/// A cell to propose: the home vertex, the receiver's vertex, the cell.
type Proposal<P> = (u32, u32, <P as Point>::Cell);

/// A cell that is not Delaunay, as seen from a home vertex, for the star of another; points that show it.
type Objection<P> = (u32, u32, <P as Point>::Cell, Vec<u32>);

/// A star that was rebuilt.
struct Rebuilt<P: Point> {
    home: u32,
    link: Option<Vec<P::Facet>>,
    proposals: Vec<Proposal<P>>,
    objections: Vec<Objection<P>>,
    cost: Cost,
}

/// The cell as a sorted list, for comparison.
fn sorted<P: Point>(cell: &P::Cell) -> P::Cell {
    let mut s = *cell;
    s.as_mut().sort_unstable();
    s
}

impl<P: Point> Worker<P> {
    pub(crate) fn begin_repair(&mut self) {
        let disagreements = self.finish_check();
        if self.exchange.is_pending() || !disagreements.is_empty() {
            self.write_out();
        }
        if self.exchange.is_pending() {
            // After a gathering the stars get its points first.
            self.rebuild();
            return;
        }
        let propose = |d: &Disagreement| {
            let facet = self.stars.link(d.home)[(d.facet - self.stars.start(d.home)) as usize];
            finite_cell::<P>(d.home, &facet).map(|cell| (d.home, d.other, cell))
        };
        let proposals: Vec<Proposal<P>> = disagreements.iter().filter_map(propose).collect();
        if !proposals.is_empty() {
            self.exchange.rounds = 1;
        }
        self.send_proposals(proposals);
    }

    fn cap(&self) -> u32 {
        let default = 4 * (64 - self.population.max(2).leading_zeros());
        self.config.exchange_cap.unwrap_or(default)
    }

    /// Odd steps answer proposals, even ones rebuild. What concerns two stars of this worker needs no
    /// message and is settled when it is said; it takes effect in the same step as if it had been sent.
    pub(crate) fn on_repair(&mut self, inbox: &mut Vec<Message<P>>) {
        if !inbox.is_empty() {
            self.write_out();
        }
        self.take_objections(inbox);
        self.take_proposals(inbox);
        if self.step.is_multiple_of(2) {
            self.charge_considered();
            self.rebuild();
        }
    }

    /// Sends cells to the homes of the vertices that may lack them.
    fn send_proposals(&mut self, proposals: Vec<Proposal<P>>) {
        let mut batches: BTreeMap<Rank, Rows<P>> = BTreeMap::new();
        let mut answers = Vec::new();
        for (from, to, cell) in proposals {
            self.record_said(self.step, false, (from, to), &cell, &[]);
            if self.table.is_home(to) {
                let answer = self.consider(from, to, &cell);
                if let Some((from, to, cell, points)) = &answer {
                    self.record_said(self.step + 1, true, (*from, *to), cell, points);
                }
                answers.extend(answer);
            } else {
                let rows = batches.entry(self.table.owners[to as usize]).or_default();
                rows.cell(&self.table, from, to, &cell);
            }
        }
        for (rank, rows) in batches {
            let body = Body::Propose { points: rows.points, cells: Bulk(rows.cells) };
            self.out.send(rank, NodeId::ROOT, self.exchange.rounds, body);
        }
        self.send_objections(answers);
    }

    fn send_objections(&mut self, objections: Vec<Objection<P>>) {
        let mut batches: BTreeMap<Rank, Objections<P>> = BTreeMap::new();
        for (from, to, cell, points) in objections {
            if self.table.is_home(to) {
                self.heed(to, &cell, &points);
                continue;
            }
            let rank = self.table.owners[to as usize];
            let (rows, counts, conflicts) = batches.entry(rank).or_default();
            rows.cell(&self.table, from, to, &cell);
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

    /// Records what a star of one leaf tells a star of another. An answer to a proposal is due a step later.
    fn record_said(
        &mut self,
        step: u32,
        objection: bool,
        (from, to): (u32, u32),
        cell: &P::Cell,
        conflicts: &[u32],
    ) {
        if self.recorder.is_none() {
            return;
        }
        let leaves = (self.leaf_number(from), self.leaf_number(to));
        let named = cell.as_ref().iter().chain(conflicts).map(|&v| self.table.ids[v as usize]);
        if let Some(recorder) = &mut self.recorder {
            recorder.said((step, objection), leaves, named, conflicts.len() as u64);
        }
    }

    /// A star that holds the cell takes the points that are in its sphere.
    fn heed(&mut self, to: u32, cell: &P::Cell, points: &[u32]) {
        if self.holds(to, cell) {
            self.exchange.additions.extend(points.iter().map(|&v| (to, v)));
        }
    }

    /// A star that lacks a proposed cell takes its vertices, and objects with those of its own link points
    /// that conflict with it.
    fn consider(&mut self, from: u32, to: u32, cell: &P::Cell) -> Option<Objection<P>> {
        if self.holds(to, cell) {
            return None;
        }
        let others = cell.as_ref().iter().copied().filter(|&v| v != to);
        self.exchange.additions.extend(others.map(|v| (to, v)));
        let mut cost = Cost::ZERO;
        let seen = &mut self.exchange.seen;
        seen.make_room(self.table.positions.len());
        let points = link_points::<P>(self.stars.link(to), seen, &mut cost);
        let mut tests = Sweep::default();
        let conflicts = conflicts(&self.table.positions, &points, cell, &mut tests);
        cost.swept_inside(tests);
        self.exchange.considered.entry(self.leaf_of(to)).or_default().1.beside(cost);
        (!conflicts.is_empty()).then_some((to, from, *cell, conflicts))
    }

    /// Has the star the cell? Looks at every facet of its link.
    fn holds(&mut self, home: u32, cell: &P::Cell) -> bool {
        let mut known = false;
        let sweep = &mut self.exchange.considered.entry(self.leaf_of(home)).or_default().0;
        sweep.each(self.stars.link(home), |facet| {
            known |= facet.as_ref().iter().all(|v| cell.as_ref().contains(v));
        });
        known
    }

    fn take_objections(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Object { points, cells, counts, conflicts } => {
                let lists = (std::mem::take(&mut counts.0), std::mem::take(&mut conflicts.0));
                received.push((std::mem::take(points), std::mem::take(&mut cells.0), lists));
                false
            }
            _ => true,
        });
        for (points, cells, (counts, conflicts)) in received {
            let numbers = self.table.intern_all(&points);
            let mut at = 0;
            for (row, count) in cells.chunks_exact(P::DIM + 1).zip(counts) {
                let end = at + count as usize;
                let cell = cell_of::<P>(row, &numbers);
                let to = cell.as_ref()[1];
                let added: Vec<u32> = conflicts[at..end].iter().map(|&i| numbers[i as usize]).collect();
                if self.table.is_home(to) {
                    self.heed(to, &cell, &added);
                }
                at = end;
            }
        }
    }

    fn take_proposals(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Propose { points, cells } => {
                received.push((std::mem::take(points), std::mem::take(&mut cells.0)));
                false
            }
            _ => true,
        });
        let mut objections = Vec::new();
        for (points, cells) in received {
            let numbers = self.table.intern_all(&points);
            for row in cells.chunks_exact(P::DIM + 1) {
                let cell = cell_of::<P>(row, &numbers);
                let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
                if self.table.is_home(to) {
                    objections.extend(self.consider(from, to, &cell));
                }
            }
        }
        self.send_objections(objections);
    }

    /// Charges the step of considering what was said in a round.
    pub(crate) fn charge_considered(&mut self) {
        for (leaf, (sweep, objected)) in std::mem::take(&mut self.exchange.considered) {
            let mut cost = Cost::ZERO;
            let items = sweep.items();
            cost.swept(sweep);
            cost.then(objected);
            self.ledger.charge(Phase::Repair, leaf, cost, items);
        }
    }

    fn leaf_of(&self, home: u32) -> NodeId {
        let at = self.leaves.partition_point(|leaf| leaf.end <= home);
        self.leaves[at].id
    }

    /// Rebuilds every star that got points; proposes what is new, objects to what is gone.
    fn rebuild(&mut self) {
        let mut pairs = std::mem::take(&mut self.exchange.additions);
        if pairs.is_empty() {
            return;
        }
        // Delivery to the stars; what a star was told twice it drops itself.
        pairs.sort_unstable();
        let additions: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
        self.extend_hashes();
        let groups: Vec<&[&[(u32, u32)]]> = additions.chunks(256).collect();
        let rebuilt = map_in(&self.pool, &groups, |group| {
            let (mut builder, mut seen) = (StarBuilder::default(), Marks::new(self.table.positions.len()));
            group.iter().map(|added| self.rebuild_star(added, &mut builder, &mut seen)).collect::<Vec<_>>()
        });
        let (mut proposals, mut objections) = (Vec::new(), Vec::new());
        let mut costs: BTreeMap<NodeId, (Cost, u64)> = BTreeMap::new();
        for star in rebuilt.into_iter().flatten() {
            let entry = costs.entry(self.leaf_of(star.home)).or_default();
            entry.0.beside(star.cost);
            entry.1 += 1;
            if let Some(link) = star.link {
                let old = self.stars.link(star.home).to_vec();
                self.recount_star(star.home, &old, &link);
                self.stars.replace(star.home, &link);
                self.exchange.repaired.insert(star.home);
                proposals.extend(star.proposals);
                objections.extend(star.objections);
            }
        }
        for (leaf, (cost, items)) in costs {
            self.ledger.charge(Phase::Repair, leaf, cost, items);
        }
        // All ranks step together, so the number of the round is the same on each.
        let round = self.step / 2 + 1;
        if (proposals.is_empty() && objections.is_empty()) || round > self.cap() {
            return;
        }
        self.exchange.rounds = round;
        self.send_proposals(proposals);
        for (from, to, cell, points) in &objections {
            self.record_said(self.step, true, (*from, *to), cell, points);
        }
        self.send_objections(objections);
    }

    fn rebuild_star(
        &self,
        added: &[(u32, u32)],
        builder: &mut StarBuilder<P>,
        seen: &mut Marks,
    ) -> Rebuilt<P> {
        let home = added[0].0;
        let old = self.stars.link(home);
        let mut candidates: Vec<u32> =
            old.iter().flat_map(std::convert::AsRef::as_ref).copied().filter(|&v| v != INFINITE).collect();
        candidates.extend(added.iter().map(|a| a.1));
        let mut cost = Cost::ZERO;
        cost.distinct_numbers(&mut candidates, seen);
        let built = builder.build(&self.table.positions, home, &candidates, &mut cost);
        let mut link = Vec::new();
        builder.facets(&mut link);
        let mut star = Rebuilt { home, link: None, proposals: Vec::new(), objections: Vec::new(), cost };
        if built && self.compare(old, &link, &mut star, seen) {
            star.link = Some(link);
        }
        star
    }

    /// New cells to propose, and objections to those that are gone. Has the link changed at all?
    fn compare(&self, old: &[P::Facet], new: &[P::Facet], star: &mut Rebuilt<P>, seen: &mut Marks) -> bool {
        let (fresh, gone) = difference::<P>(old, new, &mut star.cost);
        let home = star.home;
        let cells = |facets: &[P::Facet]| -> Vec<P::Cell> {
            let finite = facets.iter().filter_map(|f| finite_cell::<P>(home, f));
            finite.map(|c| sorted::<P>(&c)).collect()
        };
        for cell in cells(&fresh) {
            let others = cell.as_ref().iter().filter(|&&v| v != home);
            star.proposals.extend(others.map(|&v| (home, v, cell)));
        }
        let gone_cells = cells(&gone);
        if !gone_cells.is_empty() {
            let points = link_points::<P>(new, seen, &mut star.cost);
            let mut tests = Sweep::default();
            for cell in gone_cells {
                let against = conflicts(&self.table.positions, &points, &cell, &mut tests);
                let others = cell.as_ref().iter().filter(|&&v| v != home);
                star.objections.extend(others.map(|&v| (home, v, cell, against.clone())));
            }
            star.cost.swept_inside(tests);
        }
        !(fresh.is_empty() && gone.is_empty())
    }

    /// Gathers what the last check found unresolved, or everything.
    pub(crate) fn begin_fallback(&mut self) {
        self.write_out();
        let all = self.known.outcome == Outcome::GatherAll;
        let disagreements = self.finish_check();
        self.exchange.unresolved = if all {
            (0..self.table.home).collect()
        } else {
            let other_home = |d: &Disagreement| Some(d.other).filter(|&o| self.table.is_home(o));
            disagreements.iter().flat_map(|d| [Some(d.home), other_home(d)]).flatten().collect()
        };
        self.exchange.rounds = 0;
        let mut batch = PointBatch::default();
        let mut links = BTreeSet::new();
        for &home in &self.exchange.unresolved {
            let i = home as usize;
            // A radius of 1 marks a vertex whose star is wanted.
            batch.push(self.table.ids[i], self.table.positions[i], self.rank, 1.0);
            links.extend(self.stars.link(home).iter().flat_map(std::convert::AsRef::as_ref).copied());
        }
        links.remove(&INFINITE);
        for v in links.difference(&self.exchange.unresolved) {
            let i = *v as usize;
            batch.push(self.table.ids[i], self.table.positions[i], self.table.owners[i], 0.0);
        }
        self.out.send(COORDINATOR, NodeId::ROOT, 0, Body::Gather(batch));
    }

    /// Takes the gathered region's neighbours; they are used when the exchange goes on.
    pub(crate) fn on_fallback(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Region { vertices, counts, points } => {
                let taken = (std::mem::take(&mut vertices.0), std::mem::take(&mut counts.0));
                received.push((taken, std::mem::take(points)));
                false
            }
            _ => true,
        });
        for ((vertices, counts), points) in received {
            let numbers = self.table.intern_all(&points);
            let mut at = 0;
            for (id, count) in vertices.into_iter().zip(counts) {
                let end = (at + count as usize).min(numbers.len());
                if let Some(home) = self.table.find(id).filter(|&h| self.table.is_home(h)) {
                    self.exchange.additions.extend(numbers[at..end].iter().map(|&v| (home, v)));
                }
                at = end;
            }
        }
    }
}
