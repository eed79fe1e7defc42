//! Balls that look for points: the descent of neighbourhood balls through the partition tree.
//!
//! **Statement** (paper, Section 4.3, after Frieze, Miller and Teng 1993). Every ball starts with what its
//! own leaf gave it. All balls go down from the root together; a ball that meets a separator goes to both
//! sides; a leaf answers with its points inside the ball; the answers of a ball's replicas are combined on
//! the way back up. With the levels that built the tree: three passes, `3 h` levels.
//!
//! **Departures.** (1) Frieze, Miller and Teng correct bottom-up, level by level; the descent of all balls
//! together needs no recursion on heights (the naive correction is O(log^2 n)). (2) The punt: a ball much
//! larger than its leaf's median first *probes*: at every node on its way home it looks at the one leaf
//! beyond the separator in which its centre would lie. It shrinks, and only then descends. (3) A child is
//! pruned by the separator and by the box of its home points.
//!
//! **Rounds.** A replica takes one message for each group it enters on its way down and one on its way
//! back: at most twice the number of shared levels.
//!
//! **Work and depth.** At each node one vector step over its balls down and one over its replicated balls
//! up; at a leaf one vector step over (ball, point) pairs and one segmented scan.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use septet_geometry::complex::NONE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::found::FoundList;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::{Point, dist2};
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{AnswerBatch, Body, Message, QueryBatch};
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::neighbours::answers::Asked;
use crate::neighbours::chains::{Chain, Chains};
use crate::neighbours::done::{Done, Part};
use crate::neighbours::forwards::Forwards;
use crate::neighbours::walk::{Counts, Probe};
use crate::worker::Worker;

/// What the balls of a phase ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Ask {
    /// How many nearest points, ties included.
    pub(crate) wanted: u32,
    /// The punt: one leaf beyond each separator of the way home.
    pub(crate) probe: bool,
    /// Does the ball's own leaf answer too?
    pub(crate) own_leaf: bool,
}

/// A way out of the shared nodes: position on the path, and side.
pub(crate) type Way = (usize, usize);

/// A charge at a node: cost and items.
pub(crate) type Charged = (NodeId, Cost, u64);

/// A ball of a home point.
#[derive(Clone, Debug)]
pub(crate) struct Ball {
    pub(crate) home: u32,
    pub(crate) leaf: usize,
    pub(crate) radius2: f64,
}

#[derive(Clone, Debug)]
struct Pending<P> {
    /// The batch it came in, and its position there; none for an own ball.
    origin: Option<(u32, u32)>,
    home: u32,
    outstanding: u32,
    centre: P,
    radius2: f64,
    /// What was found so far, none of it farther than the radius.
    list: Chain,
}

/// Queries under way.
#[derive(Clone, Debug)]
pub(crate) struct Engine<P> {
    ask: Ask,
    pending: Vec<Pending<P>>,
    /// What pending balls found so far.
    chains: Chains,
    asked: Vec<Asked>,
    /// For each point of the table [`NONE`], between answers.
    marks: Vec<u32>,
    /// Home points whose lists are complete.
    pub(crate) done: Done,
    down: BTreeMap<NodeId, Sweep>,
    up: BTreeMap<NodeId, Sweep>,
    pairs: BTreeMap<NodeId, Sweep>,
    scratch: FoundList,
}

impl<P> Engine<P> {
    /// What the balls of this phase ask for.
    pub(crate) fn ask(&self) -> Ask {
        self.ask
    }

    /// A ball is looked at by a shared node, and goes to both of its sides or not.
    pub(crate) fn visit(&mut self, node: NodeId, both: bool) {
        self.down.entry(node).or_default().visit();
        if both {
            self.up.entry(node).or_default().visit();
        }
    }

    /// Keeps a home point's ball until its one answer comes.
    pub(crate) fn await_answer(&mut self, home: u32, centre: P, radius2: f64) {
        let list = Chain::EMPTY;
        self.pending.push(Pending { origin: None, home, outstanding: 1, centre, radius2, list });
    }

    /// The name of the query that is kept next.
    pub(crate) fn next_slot(&self) -> u32 {
        self.pending.len() as u32
    }
}

impl<P> Default for Engine<P> {
    fn default() -> Self {
        Engine {
            ask: Ask::default(),
            pending: Vec::new(),
            chains: Chains::default(),
            asked: Vec::new(),
            marks: Vec::new(),
            done: Done::default(),
            down: BTreeMap::new(),
            up: BTreeMap::new(),
            pairs: BTreeMap::new(),
            scratch: FoundList::default(),
        }
    }
}

/// Balls that were looked at, with what they found and their ways out.
#[derive(Default)]
struct LookedAt {
    balls: Vec<u32>,
    found: Lists<u32>,
    ways: Lists<Way>,
}

impl LookedAt {
    fn push(&mut self, ball: usize, found: impl IntoIterator<Item = u32>, ways: &[Way]) {
        self.balls.push(ball as u32);
        self.found.push(found);
        self.ways.push(ways.iter().copied());
    }

    /// Position, what was found, ways.
    fn iter(&self) -> impl Iterator<Item = (usize, &[u32], &[Way])> {
        let lists = self.found.iter().zip(self.ways.iter());
        self.balls.iter().zip(lists).map(|(&ball, (found, ways))| (ball as usize, found, ways))
    }
}

/// Of a group of balls: those that stay with what they found, those that leave, and what was counted.
type Walked = (Part, LookedAt, Counts);

impl<P: Point> Worker<P> {
    /// Sends the balls of home points on their way; `known` has what each leaf holds for its own, if it was asked.
    pub(crate) fn launch(&mut self, ask: Ask, balls: &[Ball], known: Option<&[NearestLists]>) {
        self.ask_afresh(ask);
        let groups: Vec<&[Ball]> = balls.chunks(2048).collect();
        let largest2 = self.largest_balls(balls);
        let walked = map_in(&self.pool, &groups, |group| self.walk_balls(ask, group, known, &largest2));
        // Room for other workers' balls, too.
        let leaving: usize = walked.iter().map(|(_, leaving, _)| leaving.balls.len()).sum();
        self.engine.pending.reserve(2 * leaving);
        self.engine.chains.reserve(4 * leaving);
        let mut forwards = Forwards::new(ask);
        for ((done, leaving, counts), group) in walked.into_iter().zip(groups) {
            self.engine.done.parts.push(done);
            self.count_walk(&counts);
            if let (Some(recorder), Some(reached)) = (&mut self.recorder, counts.reach.reached) {
                recorder.reached(self.phase, reached);
            }
            let (block, mut begin) = (self.engine.chains.next_block(), 0);
            for (at, found, ways) in leaving.iter() {
                let ball = &group[at];
                let centre = self.table.positions[ball.home as usize];
                forwards.add(self, ways, centre, ball.radius2, ball.leaf as u64);
                let mut list = Chain::EMPTY;
                self.engine.chains.add(&mut list, block, begin..begin + found.len());
                begin += found.len();
                self.engine.pending.push(Pending {
                    origin: None,
                    home: ball.home,
                    outstanding: ways.len() as u32,
                    centre,
                    radius2: ball.radius2,
                    list,
                });
            }
            self.engine.chains.take_block(leaving.found.into_items());
        }
        // The lists of the balls that left, as they are complete.
        self.engine.done.parts.push(Part::with_capacity(leaving, leaving * ask.wanted as usize));
        forwards.send(self);
    }

    /// The largest squared radius of the balls of each leaf.
    fn largest_balls(&self, balls: &[Ball]) -> Vec<f64> {
        let mut largest2 = vec![0.0; self.subdomain.leaves.len()];
        for ball in balls {
            let most: &mut f64 = &mut largest2[ball.leaf];
            *most = most.max(ball.radius2);
        }
        largest2
    }

    /// Balls of home points on their way through what this worker knows.
    fn walk_balls(
        &self,
        ask: Ask,
        group: &[Ball],
        known: Option<&[NearestLists]>,
        largest2: &[f64],
    ) -> Walked {
        let mut walk = self.walk();
        let mut done = Part::with_capacity(group.len(), group.len() * ask.wanted as usize);
        let mut leaving = LookedAt::default();
        let (mut found, mut ways) = (FoundList::default(), Vec::new());
        let mut leaf = None;
        for (at, ball) in group.iter().enumerate() {
            if leaf != Some(ball.leaf) {
                leaf = Some(ball.leaf);
                walk.start(ball.leaf, largest2[ball.leaf]);
            }
            let start = Probe {
                centre: self.table.positions[ball.home as usize],
                radius2: ball.radius2,
                home: Some(self.subdomain.leaves[ball.leaf].id),
            };
            found.clear();
            ways.clear();
            if walk.along_path(0, &start, &mut ways)
                && let Some((_, tree)) = &self.subdomain.tree
            {
                walk.down(tree, &start, &mut found);
            }
            let own =
                known.map(|leaves| leaves[ball.leaf].of(ball.home - self.subdomain.leaves[ball.leaf].start));
            if let Some((kth2, list)) = own
                && found.is_empty()
                && ways.is_empty()
                && kth2 <= ball.radius2
            {
                // What its own leaf gave is all there is.
                done.push(ball.home, kth2, list.iter().copied());
                continue;
            }
            let distance2 = |j: u32| dist2(self.table.positions[j as usize], start.centre);
            found.extend(own.map_or(&[], |own| own.1), distance2);
            let kth2 = found.keep_nearest(ask.wanted as usize, ball.radius2);
            let list = found.numbers().iter().copied();
            if ways.is_empty() {
                done.push(ball.home, kth2, list);
            } else {
                leaving.push(at, list, &ways);
            }
        }
        (done, leaving, walk.into_counts())
    }

    /// Adds what a walk counted.
    pub(crate) fn count_walk(&mut self, counts: &Counts) {
        let Counts { shared, local, at_leaf, .. } = counts;
        let ids: Vec<NodeId> = self.subdomain.path.iter().map(|s| s.id).collect();
        for (ids, sweeps) in [(&ids, shared), (&self.subdomain.inner_ids, local)] {
            for (&id, (down, up)) in ids.iter().zip(sweeps) {
                if down.items() > 0 {
                    self.engine.down.entry(id).or_default().join(down);
                    self.engine.up.entry(id).or_default().join(up);
                }
            }
        }
        for (leaf, (pairs, visits)) in self.subdomain.leaves.iter().zip(at_leaf) {
            if *visits > 0 {
                self.engine.pairs.entry(leaf.id).or_default().join(pairs);
                self.ledger.facts(leaf.id).visits += visits;
            }
        }
    }

    /// Queries from other workers, and answers to own ones; those whose arrays do not fit together stay in the inbox.
    ///
    /// # Errors
    /// If something is answered that was not asked.
    pub(crate) fn on_queries(&mut self, inbox: &mut Vec<Message<P>>) -> Result<(), TransportError> {
        let mut queries = Vec::new();
        let mut lists = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Query(batch) if batch.is_consistent() => {
                queries.push((m.from, m.node, std::mem::take(batch)));
                false
            }
            Body::Answer(batch) if batch.is_consistent() => {
                lists.push((m.from, std::mem::take(batch)));
                false
            }
            _ => true,
        });
        let mut forwards = Forwards::new(self.engine.ask);
        for (from, node, batch) in queries {
            self.on_query(from, node, batch, &mut forwards);
        }
        forwards.send(self);
        for (from, batch) in lists {
            let unasked =
                || TransportError::BadMessage { from, reason: "it answers what was not asked".into() };
            self.on_answer(batch).ok_or_else(unasked)?;
        }
        self.answer_batches();
        Ok(())
    }

    /// Answers every batch whose last query is done: as many answers as there were questions.
    fn answer_batches(&mut self) {
        let Engine { asked, marks, .. } = &mut self.engine;
        marks.resize(self.table.ids.len().max(marks.len()), NONE);
        for asked in asked.iter_mut().filter(|asked| asked.is_complete()) {
            let answer = asked.take(&self.table, marks);
            self.out.send(asked.from(), NodeId::ROOT, 0, Body::Answer(answer));
        }
    }

    /// Keeps account of a batch of queries and of what was found for them, so many of which are answered later; returns
    /// its number.
    fn ask_for(&mut self, from: Rank, batch: QueryBatch<P>, found: Lists<u32>, outstanding: u32) -> u32 {
        self.engine.asked.push(Asked::of(from, batch, found, outstanding));
        self.engine.asked.len() as u32 - 1
    }

    fn on_query(&mut self, from: Rank, node: NodeId, batch: QueryBatch<P>, forwards: &mut Forwards<P>) {
        self.engine.ask.wanted = batch.wanted;
        self.engine.ask.probe = batch.probe;
        if let Some((at, holder)) = self.subdomain.relay
            && at == node
            && holder != self.rank
        {
            self.relay_queries(from, node, holder, batch);
            return;
        }
        let start =
            self.subdomain.path.iter().position(|s| s.id == node).unwrap_or(self.subdomain.path.len());
        let mut walk = self.walk();
        let mut results = LookedAt::default();
        let (mut found, mut ways) = (FoundList::default(), Vec::new());
        for (i, (&centre, &radius2)) in batch.centres.iter().zip(&batch.radii2.0).enumerate() {
            let ball = Probe { centre, radius2, home: None };
            found.clear();
            ways.clear();
            if walk.along_path(start, &ball, &mut ways)
                && let Some((_, tree)) = &self.subdomain.tree
            {
                walk.down(tree, &ball, &mut found);
            }
            found.keep_nearest(batch.wanted as usize, radius2);
            results.push(i, found.numbers().iter().copied(), &ways);
        }
        self.count_walk(&walk.into_counts());
        let asked = self.engine.asked.len() as u32;
        let mut groups =
            (0u64..).zip(&batch.groups.0).flat_map(|(at, &n)| std::iter::repeat_n(at, n as usize));
        // What was found for those that go on.
        let (block, mut numbers) = (self.engine.chains.next_block(), Vec::new());
        let mut outstanding = 0;
        for (i, found, ways) in results.iter() {
            let group = groups.next().unwrap_or_default();
            if ways.is_empty() {
                continue;
            }
            let (centre, radius2) = (batch.centres[i], batch.radii2[i]);
            // One leaf's balls come in one batch.
            forwards.add(self, ways, centre, radius2, u64::from(asked) << 32 | group);
            let mut list = Chain::EMPTY;
            self.engine.chains.add(&mut list, block, numbers.len()..numbers.len() + found.len());
            numbers.extend_from_slice(found);
            outstanding += 1;
            self.engine.pending.push(Pending {
                origin: Some((asked, i as u32)),
                home: u32::MAX,
                outstanding: ways.len() as u32,
                centre,
                radius2,
                list,
            });
        }
        self.engine.chains.take_block(numbers);
        self.ask_for(from, batch, results.found, outstanding);
    }

    /// Passes queries for a node that turned out a leaf on to the rank that holds it.
    fn relay_queries(&mut self, from: Rank, node: NodeId, holder: Rank, batch: QueryBatch<P>) {
        let mut on = batch.clone();
        let queries = batch.slots.len();
        let nothing = std::iter::repeat_n(Vec::new(), queries).collect();
        let asked = self.ask_for(from, batch, nothing, queries as u32);
        for (i, slot) in on.slots.iter_mut().enumerate() {
            *slot = self.engine.pending.len() as u32;
            self.engine.pending.push(Pending {
                origin: Some((asked, i as u32)),
                home: u32::MAX,
                outstanding: 1,
                centre: on.centres[i],
                radius2: on.radii2[i],
                list: Chain::EMPTY,
            });
        }
        self.out.send(holder, node, 0, Body::Query(on));
    }

    /// Enters the lists of an answer, which become numbers of the table where they stand; nothing if some were not asked.
    fn on_answer(&mut self, batch: AnswerBatch<P>) -> Option<()> {
        let AnswerBatch { slots, counts, groups, sizes, places, points } = batch;
        // Their own leaves were not asked: no home point is among them.
        let each = points.ids.iter().zip(&points.positions.0).zip(&points.owners.0);
        let numbers: Vec<u32> = each.map(|((&id, &x), &owner)| self.table.receive(id, x, owner).0).collect();
        let (mut places, mut counted) = (places.0, counts.iter());
        let (mut rest, mut begin) = (places.as_mut_slice(), 0);
        for (&queries, &size) in groups.iter().zip(&sizes.0) {
            let items = counted.by_ref().take(queries as usize).map(|&count| count as usize).sum();
            let (own, after) = rest.split_at_mut(items);
            let named = &numbers[begin..begin + size as usize];
            for place in own {
                *place = named[*place as usize];
            }
            (rest, begin) = (after, begin + size as usize);
        }
        let (block, mut begin) = (self.engine.chains.next_block(), 0);
        self.engine.chains.take_block(places);
        for (&slot, &count) in slots.iter().zip(&counts.0) {
            let run = begin..begin + count as usize;
            begin = run.end;
            let Engine { pending, chains, .. } = &mut self.engine;
            let pending = pending.get_mut(slot as usize)?;
            pending.outstanding = pending.outstanding.checked_sub(1)?;
            chains.add(&mut pending.list, block, run);
            if pending.outstanding == 0 {
                self.complete(slot);
            }
        }
        Some(())
    }

    /// A query whose answers are all there.
    fn complete(&mut self, slot: u32) {
        let Engine { pending, chains, scratch, done, asked, ask, .. } = &mut self.engine;
        let pending = &pending[slot as usize];
        let positions = &self.table.positions;
        scratch.clear();
        for part in chains.parts(pending.list) {
            scratch.extend(part, |j| dist2(positions[j as usize], pending.centre));
        }
        let kth2 = scratch.keep_nearest(ask.wanted as usize, pending.radius2);
        let list = scratch.numbers().iter().copied();
        match pending.origin {
            None => done.push(pending.home, kth2, list),
            Some((of, query)) => asked[of as usize].answer(query, list),
        }
    }

    /// Charges the phase that is over and takes the finished lists.
    pub(crate) fn land(&mut self, phase: Phase) -> Done {
        let (charges, done) = self.take_landed();
        for (node, cost, items) in charges {
            self.ledger.charge(phase, node, cost, items);
        }
        done
    }

    /// What the queries cost at each node, and the finished lists.
    pub(crate) fn take_landed(&mut self) -> (Vec<Charged>, Done) {
        let engine = std::mem::take(&mut self.engine);
        let mut charges = Vec::new();
        for (node, down) in engine.down {
            let mut cost = Cost::ZERO;
            let items = down.items();
            cost.swept(down);
            cost.swept(engine.up.get(&node).copied().unwrap_or_default());
            charges.push((node, cost, items));
        }
        for (node, pairs) in engine.pairs {
            let mut cost = Cost::ZERO;
            let items = pairs.items();
            cost.swept(pairs);
            charges.push((node, cost, items));
        }
        (charges, engine.done)
    }

    /// Forgets all queries and asks for something else.
    pub(crate) fn ask_afresh(&mut self, ask: Ask) {
        self.engine = Engine { ask, ..Engine::default() };
    }
}
