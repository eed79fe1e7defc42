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
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::hull::StarBuilder;
use septet_geometry::neighbourhood::Found;
use septet_geometry::point::{Point, Simplex, lex_cmp};
use septet_geometry::predicates::{Sign, in_sphere, orientation};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::check::Disagreement;
use crate::config::map_in;
use crate::schedule::Outcome;
use crate::worker::{Worker, finite_cell};

/// The state of the exchange, and of phases that only pass something on.
#[derive(Debug)]
pub(crate) struct Exchange<P> {
    /// The k-nearest lists between their phases.
    pub(crate) knn: Vec<Vec<Found>>,
    /// Number of sampled stars, and whether their outcome is sent.
    pub(crate) samples: usize,
    pub(crate) sample_sent: bool,
    /// Points to add to home stars.
    additions: BTreeMap<u32, Vec<u32>>,
    /// Home points whose stars changed.
    pub(crate) repaired: BTreeSet<u32>,
    /// Rounds of exchange so far.
    pub(crate) rounds: u32,
    /// Home points whose stars disagreed at the last check.
    unresolved: BTreeSet<u32>,
    marker: std::marker::PhantomData<P>,
}

impl<P> Default for Exchange<P> {
    fn default() -> Self {
        Exchange {
            knn: Vec::new(),
            samples: 0,
            sample_sent: false,
            additions: BTreeMap::new(),
            repaired: BTreeSet::new(),
            rounds: 0,
            unresolved: BTreeSet::new(),
            marker: std::marker::PhantomData,
        }
    }
}

impl<P> Exchange<P> {
    /// Are there stars to rebuild?
    pub(crate) fn is_pending(&self) -> bool {
        !self.additions.is_empty()
    }
}

/// A cell to propose: the home vertex, the receiver's vertex, the others.
type Proposal<P> = (u32, u32, <P as Point>::Cell);

/// Points in conflict with a cell, for the star of another vertex.
type Objection = (u32, Vec<u32>);

/// A star that was rebuilt.
struct Rebuilt<P: Point> {
    home: u32,
    link: Option<Vec<P::Facet>>,
    proposals: Vec<Proposal<P>>,
    objections: Vec<Objection>,
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
            self.exchange.rounds += 1;
        }
        self.send_proposals(&proposals);
    }

    fn cap(&self) -> u32 {
        let default = 4 * (64 - self.population.max(2).leading_zeros());
        self.config.exchange_cap.unwrap_or(default)
    }

    /// Odd steps answer proposals, even ones rebuild.
    pub(crate) fn on_repair(&mut self, inbox: &mut Vec<Message<P>>) {
        self.take_conflicts(inbox);
        self.take_proposals(inbox);
        if self.step.is_multiple_of(2) {
            self.rebuild();
        }
    }

    /// Sends cells to the homes of the vertices that may lack them.
    fn send_proposals(&mut self, proposals: &[Proposal<P>]) {
        let mut batches: BTreeMap<Rank, (PointBatch<P>, Vec<u32>, BTreeMap<u32, u32>)> = BTreeMap::new();
        for (from, to, cell) in proposals {
            let rank = self.table.owners[*to as usize];
            let (points, cells, places) = batches.entry(rank).or_default();
            let others = cell.as_ref().iter().filter(|v| *v != from && *v != to);
            for &v in [from, to].into_iter().chain(others) {
                let next = points.len() as u32;
                let place = *places.entry(v).or_insert(next);
                if place == next {
                    self.table.export(v, points);
                }
                cells.push(place);
            }
        }
        for (rank, (points, cells, _)) in batches {
            let body = Body::Propose { points, cells: Bulk(cells) };
            self.out.send(rank, NodeId::ROOT, self.exchange.rounds, body);
        }
    }

    fn send_objections(&mut self, objections: Vec<Objection>) {
        let mut batches: BTreeMap<Rank, (Vec<u64>, Vec<u32>, PointBatch<P>)> = BTreeMap::new();
        for (vertex, added) in objections {
            let rank = self.table.owners[vertex as usize];
            let (vertices, counts, points) = batches.entry(rank).or_default();
            vertices.push(self.table.ids[vertex as usize]);
            counts.push(added.len() as u32);
            for point in added {
                self.table.export(point, points);
            }
        }
        for (rank, (vertices, counts, points)) in batches {
            let body = Body::Conflict { vertices: Bulk(vertices), counts: Bulk(counts), points };
            self.out.send(rank, NodeId::ROOT, self.exchange.rounds, body);
        }
    }

    fn take_conflicts(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Conflict { vertices, counts, points } | Body::Region { vertices, counts, points } => {
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
                    self.exchange.additions.entry(home).or_default().extend(&numbers[at..end]);
                }
                at = end;
            }
        }
    }

    /// Answers proposals: a star that lacks the cell takes its vertices, and names its own link points
    /// that conflict with it.
    fn take_proposals(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Propose { points, cells } => {
                received.push((std::mem::take(points), std::mem::take(&mut cells.0)));
                false
            }
            _ => true,
        });
        if received.is_empty() {
            return;
        }
        let mut objections = Vec::new();
        let mut sweeps: BTreeMap<NodeId, Sweep> = BTreeMap::new();
        for (points, cells) in received {
            let numbers = self.table.intern_all(&points);
            for row in cells.chunks_exact(P::DIM + 1) {
                let mut cell = P::Cell::splat(0);
                for (v, &place) in cell.as_mut().iter_mut().zip(row) {
                    *v = numbers[place as usize];
                }
                let (from, to) = (cell.as_ref()[0], cell.as_ref()[1]);
                if !self.table.is_home(to) {
                    continue;
                }
                let leaf = self.leaf_of(to);
                let sweep = sweeps.entry(leaf).or_default();
                sweep.each(self.stars.link(to), |_| {});
                if self.position_in(to, &cell).is_some() {
                    continue;
                }
                let others = cell.as_ref().iter().copied().filter(|&v| v != to);
                self.exchange.additions.entry(to).or_default().extend(others);
                let conflicts = self.conflicts_with(to, &cell);
                if !conflicts.is_empty() {
                    objections.push((from, conflicts));
                }
            }
        }
        self.charge_repair(sweeps);
        self.send_objections(objections);
    }

    fn charge_repair(&mut self, sweeps: BTreeMap<NodeId, Sweep>) {
        for (leaf, sweep) in sweeps {
            let mut cost = Cost::ZERO;
            let items = sweep.items();
            cost.swept(sweep);
            self.ledger.charge(Phase::Repair, leaf, cost, items);
        }
    }

    fn leaf_of(&self, home: u32) -> NodeId {
        let at = self.leaves.partition_point(|leaf| leaf.end <= home);
        self.leaves[at].id
    }

    /// Link points of a home vertex that conflict with a cell.
    fn conflicts_with(&self, home: u32, cell: &P::Cell) -> Vec<u32> {
        conflicts(&self.table.positions, self.stars.link(home), cell)
    }

    /// Rebuilds every star that got points; proposes what is new, objects to what is gone.
    fn rebuild(&mut self) {
        let additions: Vec<(u32, Vec<u32>)> =
            std::mem::take(&mut self.exchange.additions).into_iter().collect();
        if additions.is_empty() {
            return;
        }
        self.extend_hashes();
        let groups: Vec<&[(u32, Vec<u32>)]> = additions.chunks(256).collect();
        let rebuilt = map_in(&self.pool, &groups, |group| {
            let mut builder = StarBuilder::default();
            let one = |(home, added): &(u32, Vec<u32>)| self.rebuild_star(*home, added, &mut builder);
            group.iter().map(one).collect::<Vec<_>>()
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
        if proposals.is_empty() && objections.is_empty() {
            return;
        }
        if self.exchange.rounds >= self.cap() {
            return;
        }
        self.exchange.rounds += 1;
        self.send_proposals(&proposals);
        self.send_objections(objections);
    }

    fn rebuild_star(&self, home: u32, added: &[u32], builder: &mut StarBuilder<P>) -> Rebuilt<P> {
        let old = self.stars.link(home);
        let mut candidates: Vec<u32> =
            old.iter().flat_map(|f| f.as_ref()).copied().filter(|&v| v != INFINITE).collect();
        candidates.extend_from_slice(added);
        // One canonical order, whatever the numbering here.
        let positions = &self.table.positions;
        candidates.sort_unstable_by(|&a, &b| lex_cmp(&positions[a as usize], &positions[b as usize]));
        candidates.dedup();
        let mut cost = Cost::ZERO;
        let built = builder.build(positions, home, &candidates, &mut cost);
        let mut star = Rebuilt { home, link: None, proposals: Vec::new(), objections: Vec::new(), cost };
        let mut link = Vec::new();
        builder.facets(&mut link);
        if !built || same_links::<P>(old, &link) {
            return star;
        }
        self.compare(home, old, &link, &mut star);
        star.link = Some(link);
        star
    }

    /// New cells to propose, and objections to those that are gone.
    fn compare(&self, home: u32, old: &[P::Facet], new: &[P::Facet], star: &mut Rebuilt<P>) {
        let cells = |link: &[P::Facet]| -> BTreeSet<P::Cell> {
            link.iter().filter_map(|f| finite_cell::<P>(home, f)).map(|c| sorted::<P>(&c)).collect()
        };
        let (before, after) = (cells(old), cells(new));
        for cell in after.difference(&before) {
            let others = cell.as_ref().iter().filter(|&&v| v != home);
            star.proposals.extend(others.map(|&v| (home, v, *cell)));
        }
        for cell in before.difference(&after) {
            let points = conflicts(&self.table.positions, new, cell);
            let others = cell.as_ref().iter().filter(|&&v| v != home);
            star.objections.extend(others.map(|&v| (v, points.clone())));
        }
        // The canonical order again: sets of local numbers are not in it.
        let rank = |v: u32| &self.table.positions[v as usize];
        star.objections.sort_by(|a, b| lex_cmp(rank(a.0), rank(b.0)));
    }

    /// Gathers what the last check found unresolved, or everything.
    pub(crate) fn begin_fallback(&mut self) {
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
            links.extend(self.stars.link(home).iter().flat_map(|f| f.as_ref()).copied());
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
        self.take_conflicts(inbox);
    }
}

/// Are two links the same set of facets?
fn same_links<P: Point>(a: &[P::Facet], b: &[P::Facet]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let canonical = |link: &[P::Facet]| {
        let mut all: Vec<P::Facet> = link
            .iter()
            .map(|f| {
                let mut s = *f;
                s.as_mut().sort_unstable();
                s
            })
            .collect();
        all.sort_unstable();
        all
    };
    canonical(a) == canonical(b)
}

/// Finite link points that lie in the (perturbed) circumsphere of a cell.
fn conflicts<P: Point>(positions: &[P], link: &[P::Facet], cell: &P::Cell) -> Vec<u32> {
    let mut corners: Vec<P> = cell.as_ref().iter().map(|&v| positions[v as usize]).collect();
    match orientation(&corners) {
        Sign::Zero => return Vec::new(),
        Sign::Negative => corners.swap(0, 1),
        Sign::Positive => {}
    }
    let mut points: Vec<u32> = link.iter().flat_map(|f| f.as_ref()).copied().collect();
    points.sort_unstable();
    points.dedup();
    points.retain(|&v| {
        v != INFINITE && !cell.as_ref().contains(&v) && in_sphere(&corners, positions[v as usize])
    });
    points
}
