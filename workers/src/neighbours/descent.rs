//! The descent: balls of all ranks look for points, down the partition tree and back.
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
//! Not a dialogue: in one round a rank takes queries about several nodes and answers to several batches. So the
//! phase is a loop over one [`Descent`], which keeps account of both.
//!
//! **Work and depth.** At each node one vector step over its balls down and one over its replicated balls
//! up; at a leaf one vector step over (ball, point) pairs and one segmented scan.

#[cfg(test)]
mod tests;

use septet_geometry::complex::NONE;
use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::{Point, dist2};
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, Message, QueryBatch, ReplyBatch};
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::machine::context::Context;
use crate::neighbours::ask::{Ask, Ball};
use crate::neighbours::chunked_lists::{ChunkedLists, ListChain};
use crate::neighbours::launch::{Looked, Start, Walked, largest_balls, walk_balls};
use crate::neighbours::replies::Asked;
use crate::neighbours::results::{CompletedLists, Part};
use crate::neighbours::router::{QueryRouter, Replica};
use crate::neighbours::tallies::{Charge, Tallies};
use crate::neighbours::walk::{Ground, Probe};
use crate::state::subdomain::{Subdomain, Way};
use crate::state::table::Table;

/// Balls that are walked together.
const GROUP: usize = 2048;

/// Sends balls on their way; returns their lists once all answers are there. The caller has entered the phase.
pub(crate) async fn descend<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    ask: Ask,
    balls: Vec<Ball>,
) -> Result<CompletedLists, TransportError> {
    let mut descent = Descent::new(subdomain, ask, &[]);
    descent.launch(cx, table, &balls, None);
    drop(balls);
    descent.finish(cx, table).await
}

/// Whose ball it is.
#[derive(Clone, Copy, Debug)]
enum Asker {
    /// A home point.
    Owned(u32),
    /// Another rank: the number of its batch, and the position there.
    Batch { batch: u32, query: u32 },
}

/// A ball that waits for answers.
#[derive(Clone, Debug)]
pub(crate) struct Pending<P> {
    asker: Asker,
    outstanding: u32,
    centre: P,
    radius2: f64,
    /// Points found so far, none of them farther than the radius.
    list: ListChain,
}

impl<P> Pending<P> {
    /// A home point's.
    pub(crate) fn of_owned(owned: u32, centre: P, radius2: f64) -> Self {
        Pending { asker: Asker::Owned(owned), outstanding: 0, centre, radius2, list: ListChain::EMPTY }
    }
}

/// Queries that came from another rank in one message.
struct Question<P> {
    from: Rank,
    node: NodeId,
    batch: QueryBatch<P>,
}

/// One rank's account of a descent.
#[derive(Debug)]
pub(crate) struct Descent<'a, P: Point> {
    subdomain: &'a Subdomain<P>,
    /// The home points of each leaf in blocks, if lists are looked for.
    blocks: &'a [KdBlocks<P>],
    ask: Ask,
    pending: Vec<Pending<P>>,
    /// Points that pending balls found so far.
    chains: ChunkedLists,
    asked: Vec<Asked>,
    /// For each point of the table [`NONE`], between answers.
    marks: Vec<u32>,
    /// Home points whose lists are complete.
    done: CompletedLists,
    tallies: Tallies,
    scratch: NeighbourList,
}

impl<'a, P: Point> Descent<'a, P> {
    /// No balls yet.
    pub(crate) fn new(subdomain: &'a Subdomain<P>, ask: Ask, blocks: &'a [KdBlocks<P>]) -> Self {
        Descent {
            subdomain,
            blocks,
            ask,
            pending: Vec::new(),
            chains: ChunkedLists::default(),
            asked: Vec::new(),
            marks: Vec::new(),
            done: CompletedLists::default(),
            tallies: Tallies::default(),
            scratch: NeighbourList::default(),
        }
    }

    /// The lists that are complete.
    pub(crate) fn done(&self) -> &CompletedLists {
        &self.done
    }

    /// Counts a ball at a shared node, from which it goes to both sides or not.
    pub(crate) fn visit(&mut self, node: NodeId, both: bool) {
        self.tallies.visit(node, both);
    }

    /// Sends the balls of home points on their way; `known` has what each leaf found among its own points, if it
    /// looked.
    pub(crate) fn launch(
        &mut self,
        cx: &mut Context<P>,
        table: &Table<P>,
        balls: &[Ball],
        known: Option<&[NearestLists]>,
    ) {
        let (subdomain, ask) = (self.subdomain, self.ask);
        let groups: Vec<&[Ball]> = balls.chunks(GROUP).collect();
        let largest2 = largest_balls(&subdomain.leaves, balls);
        let start = Start { known, largest2: &largest2 };
        let ground = Ground { recorded: cx.recorder.is_some(), ..self.ground(table) };
        let walked = map_in(&cx.pool, &groups, |group| walk_balls(ground, ask, group, start));
        // Room for other ranks' balls, too.
        let leaving: usize = walked.iter().map(|walked| walked.leaving.len()).sum();
        self.pending.reserve(2 * leaving);
        self.chains.reserve(4 * leaving);
        let mut forwards = QueryRouter::new(cx.rank, ask);
        for (Walked { done, leaving, counts }, group) in walked.into_iter().zip(groups) {
            self.done.parts.push(done);
            self.tallies.add(subdomain, &counts, &mut cx.ledger);
            if let (Some(recorder), Some(reached)) = (&mut cx.recorder, counts.reach.reached) {
                recorder.reached(ask.phase, reached);
            }
            self.send_away(&mut forwards, table, leaving, group);
        }
        // The lists of the balls that left, as they are complete.
        self.done.parts.push(Part::with_capacity(leaving, leaving * ask.wanted as usize));
        forwards.send(cx);
    }

    fn ground<'b>(&self, table: &'b Table<P>) -> Ground<'b, P>
    where
        'a: 'b,
    {
        Ground { subdomain: self.subdomain, table, blocks: self.blocks, recorded: false }
    }

    /// Forwards those of a group of home points' balls that leave.
    fn send_away(
        &mut self,
        forwards: &mut QueryRouter<P>,
        table: &Table<P>,
        leaving: Looked,
        group: &[Ball],
    ) {
        let (block, mut begin) = (self.chains.next_block(), 0);
        for (at, found, ways) in leaving.iter() {
            let ball = &group[at];
            let mut pending =
                Pending::of_owned(ball.owned, table.positions[ball.owned as usize], ball.radius2);
            self.chains.add(&mut pending.list, block, begin..begin + found.len());
            begin += found.len();
            self.forward(forwards, ways, ball.leaf as u64, pending);
        }
        self.chains.take_block(leaving.into_found().into_items());
    }

    /// Forwards a ball, and keeps it until its answers come. Balls of one leaf have the same `group`, and follow each
    /// other.
    pub(crate) fn forward(
        &mut self,
        forwards: &mut QueryRouter<P>,
        ways: &[Way],
        group: u64,
        mut pending: Pending<P>,
    ) {
        let Pending { centre, radius2, .. } = pending;
        let replica = Replica { slot: self.pending.len() as u32, centre, radius2, group };
        forwards.add(&self.subdomain.path, ways, &replica);
        pending.outstanding = ways.len() as u32;
        self.pending.push(pending);
    }

    /// Handles queries and answers until no rank sends any; charges the phase, and returns the lists.
    pub(crate) async fn finish(
        mut self,
        cx: &mut Context<P>,
        table: &mut Table<P>,
    ) -> Result<CompletedLists, TransportError> {
        while cx.exchange().await? {
            self.receive(cx, table)?;
        }
        Ok(self.land(cx))
    }

    /// Charges the phase, which is over; returns the lists.
    pub(crate) fn land(self, cx: &mut Context<P>) -> CompletedLists {
        for Charge { node, cost, items } in self.tallies.into_charges() {
            cx.ledger.charge(self.ask.phase, node, cost, items);
        }
        self.done
    }

    /// The same for one pass of the bottom-up correction, by its level.
    pub(crate) fn land_pass(self, cx: &mut Context<P>, level: u32) -> CompletedLists {
        self.tallies.charge_pass(&mut cx.ledger, level);
        self.done
    }

    /// Handles the queries of other ranks, and the answers to own ones. Those whose arrays do not fit together, and
    /// queries for something else, stay in the context.
    ///
    /// # Errors
    /// If an answer names a query that waits for none.
    pub(crate) fn receive(
        &mut self,
        cx: &mut Context<P>,
        table: &mut Table<P>,
    ) -> Result<(), TransportError> {
        let Ask { wanted, probe, .. } = self.ask;
        let questions = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Query(batch) if batch.is_consistent() && (batch.wanted, batch.probe) == (wanted, probe) => {
                Some(Question { from: m.from, node: m.node, batch: std::mem::take(batch) })
            }
            _ => None,
        });
        let answers = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Reply(batch) if batch.is_consistent() => Some((m.from, std::mem::take(batch))),
            _ => None,
        });
        let mut forwards = QueryRouter::new(cx.rank, self.ask);
        for question in questions {
            self.on_question(cx, table, question, &mut forwards);
        }
        forwards.send(cx);
        for (from, batch) in answers {
            let unasked =
                || TransportError::BadMessage { from, reason: "it answers what was not asked".into() };
            self.on_answer(table, batch).ok_or_else(unasked)?;
        }
        self.send_answers(cx, table);
        Ok(())
    }

    /// Answers every batch whose last query is done: as many answers as there were questions.
    fn send_answers(&mut self, cx: &mut Context<P>, table: &Table<P>) {
        let Descent { asked, marks, .. } = self;
        marks.resize(table.ids.len().max(marks.len()), NONE);
        for asked in asked.iter_mut().filter(|asked| asked.is_complete()) {
            let answer = asked.take(table, marks);
            cx.send(asked.from(), NodeId::ROOT, 0, Body::Reply(answer));
        }
    }

    /// Looks for what another rank's balls ask; forwards those that go on.
    fn on_question(
        &mut self,
        cx: &mut Context<P>,
        table: &Table<P>,
        question: Question<P>,
        forwards: &mut QueryRouter<P>,
    ) {
        if let Some(holder) = self.subdomain.relayed(question.node, cx.rank) {
            self.relay(cx, question, holder);
            return;
        }
        let Question { from, node, batch } = question;
        let looked = self.look(cx, table, node, &batch);
        let asked = self.asked.len() as u32;
        let mut groups =
            (0u64..).zip(&batch.groups.0).flat_map(|(at, &n)| std::iter::repeat_n(at, n as usize));
        // Points that were found for those that go on.
        let (block, mut numbers) = (self.chains.next_block(), Vec::new());
        let mut outstanding = 0;
        for (i, found, ways) in looked.iter() {
            let group = groups.next().unwrap_or_default();
            if ways.is_empty() {
                continue;
            }
            let mut list = ListChain::EMPTY;
            self.chains.add(&mut list, block, numbers.len()..numbers.len() + found.len());
            numbers.extend_from_slice(found);
            outstanding += 1;
            let asker = Asker::Batch { batch: asked, query: i as u32 };
            let (centre, radius2) = (batch.centres[i], batch.radii2[i]);
            let pending = Pending { asker, outstanding: 0, centre, radius2, list };
            // One leaf's balls come in one batch.
            self.forward(forwards, ways, u64::from(asked) << 32 | group, pending);
        }
        self.chains.take_block(numbers);
        self.asked.push(Asked::of(from, batch, looked.into_found(), outstanding));
    }

    /// Follows a batch of balls from a node on.
    fn look(&mut self, cx: &mut Context<P>, table: &Table<P>, node: NodeId, batch: &QueryBatch<P>) -> Looked {
        let start = self.subdomain.position(node);
        let mut walk = self.ground(table).walk(self.ask);
        let mut looked = Looked::default();
        let (mut found, mut ways) = (NeighbourList::default(), Vec::new());
        for (i, (&centre, &radius2)) in batch.centres.iter().zip(&batch.radii2.0).enumerate() {
            found.clear();
            ways.clear();
            walk.follow(start, &Probe { centre, radius2, owned: None }, &mut ways, &mut found);
            found.keep_nearest(batch.wanted as usize, radius2);
            looked.push(i, found.positions().iter().copied(), &ways);
        }
        self.tallies.add(self.subdomain, &walk.into_counts(), &mut cx.ledger);
        looked
    }

    /// Passes queries about a node that turned out a leaf on to the rank that holds it.
    fn relay(&mut self, cx: &mut Context<P>, question: Question<P>, holder: Rank) {
        let Question { from, node, batch } = question;
        let mut on = batch.clone();
        let queries = batch.slots.len();
        let asked = self.asked.len() as u32;
        let nothing: Lists<u32> = std::iter::repeat_n(Vec::new(), queries).collect();
        self.asked.push(Asked::of(from, batch, nothing, queries as u32));
        for (i, slot) in on.slots.iter_mut().enumerate() {
            *slot = self.pending.len() as u32;
            self.pending.push(Pending {
                asker: Asker::Batch { batch: asked, query: i as u32 },
                outstanding: 1,
                centre: on.centres[i],
                radius2: on.radii2[i],
                list: ListChain::EMPTY,
            });
        }
        cx.send(holder, node, 0, Body::Query(on));
    }

    /// Enters the lists of an answer, which become numbers of the table in their own storage; nothing if some were
    /// not asked.
    fn on_answer(&mut self, table: &mut Table<P>, batch: ReplyBatch<P>) -> Option<()> {
        let ReplyBatch { slots, counts, groups, sizes, places, points } = batch;
        // Their own leaves were not asked: no home point is among them.
        let each = points.ids.iter().zip(&points.positions.0).zip(&points.owners.0);
        let numbers: Vec<u32> = each.map(|((&id, &x), &owner)| table.receive(id, x, owner).0).collect();
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
        let (block, mut begin) = (self.chains.next_block(), 0);
        self.chains.take_block(places);
        for (&slot, &count) in slots.iter().zip(&counts.0) {
            let run = begin..begin + count as usize;
            begin = run.end;
            let pending = self.pending.get_mut(slot as usize)?;
            pending.outstanding = pending.outstanding.checked_sub(1)?;
            self.chains.add(&mut pending.list, block, run);
            if pending.outstanding == 0 {
                self.complete(table, slot);
            }
        }
        Some(())
    }

    /// Joins the parts of a list whose answers are all there.
    fn complete(&mut self, table: &Table<P>, slot: u32) {
        let Descent { pending, chains, scratch, done, asked, ask, .. } = self;
        let pending = &pending[slot as usize];
        scratch.clear();
        for part in chains.parts(pending.list) {
            scratch.extend(part, |j| dist2(table.positions[j as usize], pending.centre));
        }
        let kth2 = scratch.keep_nearest(ask.wanted as usize, pending.radius2);
        let list = scratch.positions().iter().copied();
        match pending.asker {
            Asker::Owned(owned) => done.push(owned, kth2, list),
            Asker::Batch { batch, query } => asked[batch as usize].answer(query, list),
        }
    }
}
