//! The descent: balls of all ranks search for points, down the partition tree and back.
//!
//! **Statement** (paper, Section 4.3). Each ball starts with the points found in its own leaf. All balls descend from
//! the root together. A ball that crosses a separator continues on both sides, as two replicas. A leaf replies with
//! its points that lie inside the ball. The replies of the replicas are combined on the way up. The construction of
//! the tree, the way down and the way up are three passes over the `h` levels, `3 h` steps in total.
//!
//! **Source.** Frieze, Miller and Teng (1993).
//!
//! **Departures.**
//! 1. Frieze, Miller and Teng correct the balls bottom-up, level by level. One descent of all balls needs no recursion
//!    over heights. The bottom-up correction takes O(log^2 n) depth.
//! 2. A ball much larger than the median of its leaf *probes* first (the punt). At each separator that it crosses on
//!    the way to its own leaf, a probe also visits one leaf beyond the separator. At each node below, the side of the
//!    ball's centre determines the way to this leaf. The probe shrinks the ball, which then descends.
//! 3. A ball that crosses a separator still skips a child if it misses the box of the child's owned points.
//!
//! **Rounds.** A replica needs one message for each group that it enters on the way down, and one message for each on
//! the way back. The phase takes at most twice as many rounds as there are shared levels.
//!
//! **Messages.** In one round, a rank may receive queries about several nodes and replies to several batches. The phase
//! is therefore a loop over one [`Descent`], which keeps track of both.
//!
//! **Work and depth.** At each node, the replication of its balls on the way down, and the combination of the results of
//! its replicated balls on the way up. At a leaf, all pairs of its balls and points.

pub(crate) mod centres;
#[cfg(test)]
mod tests;

use septet_geometry::complex::NONE;
use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::NearestLists;
use septet_geometry::point::{Point, dist2};
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message, QueryBatch, ReplyBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::neighbours::chunked_lists::{ChunkedLists, ListChain};
use crate::neighbours::launch::{
    LaunchInput, WalkedBall, WalkedBalls, WalkedGroup, largest_balls, walk_balls,
};
use crate::neighbours::replies::ReceivedQueries;
use crate::neighbours::results::{CompletedLists, Part};
use crate::neighbours::router::{QueryRouter, Replica};
use crate::neighbours::search::{Ball, Search};
use crate::neighbours::stages::March;
use crate::neighbours::tallies::{NodeCharge, Tallies};
use crate::neighbours::walk::{MovingBall, SearchSpace};
use crate::state::subdomain::{Subdomain, Way};
use crate::state::table::Table;

/// The number of balls that one task walks.
const GROUP: usize = 2048;

/// Sends balls down the tree and returns their complete lists. The caller must have entered the phase.
pub(crate) async fn descend<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    search: Search,
    balls: Vec<Ball>,
) -> Result<CompletedLists, TransportError> {
    let mut descent = Descent::new(subdomain, search, &[]);
    descent.launch(cx, table, &balls, None);
    drop(balls);
    descent.run(cx, table).await
}

/// The origin of a ball.
#[derive(Clone, Copy, Debug)]
enum Origin {
    /// An owned point.
    Owned(u32),
    /// A query of another rank: the index of its batch, and its position there.
    Batch { batch: u32, query: u32 },
}

/// A ball that waits for replies.
#[derive(Clone, Debug)]
pub(crate) struct WaitingBall<P> {
    origin: Origin,
    /// The number of replies that have not arrived.
    outstanding: u32,
    centre: P,
    radius2: f64,
    /// The points found so far, none farther than the radius.
    list: ListChain,
}

impl<P> WaitingBall<P> {
    /// Creates the record of an owned point's ball that has not found any points.
    pub(crate) fn of_owned(point: u32, centre: P, radius2: f64) -> Self {
        WaitingBall { origin: Origin::Owned(point), outstanding: 0, centre, radius2, list: ListChain::EMPTY }
    }
}

/// The queries of one message.
struct QueryMessage<P> {
    from: Rank,
    node: NodeId,
    batch: QueryBatch<P>,
}

/// One rank's part in a descent.
#[derive(Debug)]
pub(crate) struct Descent<'a, P: Point> {
    subdomain: &'a Subdomain<P>,
    /// The owned points of each leaf in blocks. Empty if balls search for one point only.
    blocks: &'a [KdBlocks<P>],
    search: Search,
    /// Balls that left this rank. Replies name them by their index.
    pending: Vec<WaitingBall<P>>,
    /// The points that pending balls have found so far.
    chains: ChunkedLists,
    /// The queries received from other ranks.
    received: Vec<ReceivedQueries>,
    /// A mark for each point of the table. All marks are [`NONE`] between replies.
    marks: Vec<u32>,
    /// The complete lists of owned points.
    complete: CompletedLists,
    tallies: Tallies,
    scratch: NeighbourList,
}

impl<'a, P: Point> Descent<'a, P> {
    /// Creates a descent without balls.
    pub(crate) fn new(subdomain: &'a Subdomain<P>, search: Search, blocks: &'a [KdBlocks<P>]) -> Self {
        Descent {
            subdomain,
            blocks,
            search,
            pending: Vec::new(),
            chains: ChunkedLists::default(),
            received: Vec::new(),
            marks: Vec::new(),
            complete: CompletedLists::default(),
            tallies: Tallies::default(),
            scratch: NeighbourList::default(),
        }
    }

    /// Returns the complete lists of owned points.
    pub(crate) fn complete(&self) -> &CompletedLists {
        &self.complete
    }

    /// Counts a ball at a shared node. `both` is `true` if it continues to both children.
    pub(crate) fn visit(&mut self, node: NodeId, both: bool) {
        self.tallies.visit(node, both);
    }

    /// Sends the balls of owned points down the tree. `known` contains, for each leaf, the nearest points of its
    /// points within the leaf. `known` is `None` if these points were not searched.
    pub(crate) fn launch(
        &mut self,
        cx: &mut Context<P>,
        table: &Table<P>,
        balls: &[Ball],
        known: Option<&[NearestLists]>,
    ) {
        let (subdomain, search) = (self.subdomain, self.search);
        let groups: Vec<&[Ball]> = balls.chunks(GROUP).collect();
        let largest2 = largest_balls(subdomain.leaves(), balls);
        let input = LaunchInput { known, largest2: &largest2 };
        let space = self.space(table);
        let walked = cx.map(&groups, |group| walk_balls(space, search, group, input));
        // The capacity also allows for the balls of other ranks.
        let leaving: usize = walked.iter().map(|walked| walked.leaving.len()).sum();
        self.pending.reserve(2 * leaving);
        self.chains.reserve(4 * leaving);
        let mut router = QueryRouter::new(cx.rank(), search);
        for (WalkedGroup { complete, leaving, counts }, group) in walked.into_iter().zip(groups) {
            self.complete.add_part(complete);
            self.tallies.add(cx, search.phase, &counts);
            self.forward_group(&mut router, table, leaving, group);
        }
        // The last part receives the lists of the balls that leave the path.
        self.complete.add_part(Part::with_capacity(leaving, leaving * search.wanted as usize));
        router.send(cx);
    }

    fn space<'b>(&self, table: &'b Table<P>) -> SearchSpace<'b, P>
    where
        'a: 'b,
    {
        SearchSpace { subdomain: self.subdomain, table, blocks: self.blocks }
    }

    /// Forwards the balls of a group that leave the path.
    fn forward_group(
        &mut self,
        router: &mut QueryRouter<P>,
        table: &Table<P>,
        leaving: WalkedBalls,
        group: &[Ball],
    ) {
        let (block, mut begin) = (self.chains.next_block(), 0);
        for WalkedBall { ball, found, ways } in leaving.iter() {
            let ball = &group[ball];
            let mut pending =
                WaitingBall::of_owned(ball.point, table.positions()[ball.point as usize], ball.radius2);
            self.chains.add(&mut pending.list, block, begin..begin + found.len());
            begin += found.len();
            self.forward(router, ways, ball.leaf as u64, pending);
        }
        self.chains.add_block(leaving.into_found().into_items());
    }

    /// Forwards a ball along its ways out of the path, and keeps it until the replies arrive. Consecutive balls of one
    /// leaf have the same `group`.
    pub(crate) fn forward(
        &mut self,
        router: &mut QueryRouter<P>,
        ways: &[Way],
        group: u64,
        mut pending: WaitingBall<P>,
    ) {
        let WaitingBall { centre, radius2, .. } = pending;
        let replica = Replica { slot: self.pending.len() as u32, centre, radius2, group };
        router.add(self.subdomain, ways, &replica);
        pending.outstanding = ways.len() as u32;
        self.pending.push(pending);
    }

    /// Handles queries and replies until no rank sends any. Charges the phase and returns the complete lists.
    pub(crate) async fn run(
        mut self,
        cx: &mut Context<P>,
        table: &mut Table<P>,
    ) -> Result<CompletedLists, TransportError> {
        while cx.exchange().await? {
            self.receive(cx, table)?;
        }
        Ok(self.finish(cx))
    }

    /// Charges the phase at its end. Returns the complete lists.
    pub(crate) fn finish(self, cx: &mut Context<P>) -> CompletedLists {
        for NodeCharge { node, cost, items } in
            self.tallies.into_charges(cx.shared_cost(), self.search.wanted)
        {
            cx.charge(Account::member(self.search.phase, node), cost, items);
        }
        self.complete
    }

    /// Charges the pass of the bottom-up correction at `level`. Returns the complete lists.
    pub(crate) fn finish_pass(self, cx: &mut Context<P>, level: u32, march: March) -> CompletedLists {
        self.tallies.charge_pass(cx, level, march);
        self.complete
    }

    /// Handles the queries of other ranks and the replies to this rank's queries. Leaves a message in the context if
    /// its arrays are inconsistent or if it belongs to another search.
    ///
    /// # Errors Fails if a reply names a query that does not wait for a reply.
    pub(crate) fn receive(
        &mut self,
        cx: &mut Context<P>,
        table: &mut Table<P>,
    ) -> Result<(), TransportError> {
        let Search { wanted, probe, .. } = self.search;
        let queries = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Query(batch) if batch.is_consistent() && (batch.wanted, batch.probe) == (wanted, probe) => {
                Some(QueryMessage { from: m.from, node: m.node, batch: std::mem::take(batch) })
            }
            _ => None,
        });
        let replies = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Reply(batch) if batch.is_consistent() => Some((m.from, std::mem::take(batch))),
            _ => None,
        });
        let mut router = QueryRouter::new(cx.rank(), self.search);
        for message in queries {
            self.on_queries(cx, table, message, &mut router);
        }
        router.send(cx);
        for (from, batch) in replies {
            let unasked = || TransportError::BadMessage {
                from,
                reason: "the reply names a query that was not sent".into(),
            };
            self.on_reply(table, batch).ok_or_else(unasked)?;
        }
        self.send_replies(cx, table);
        Ok(())
    }

    /// Sends a reply to each batch whose lists are complete.
    fn send_replies(&mut self, cx: &mut Context<P>, table: &Table<P>) {
        let Descent { received, marks, .. } = self;
        marks.resize(table.ids().len().max(marks.len()), NONE);
        let complete = received.iter_mut().filter(|queries| queries.is_complete());
        cx.send_each(0, complete.map(|queries| (queries.from(), Body::Reply(queries.take(table, marks)))));
    }

    /// Walks the balls of another rank. Forwards those that leave the path.
    fn on_queries(
        &mut self,
        cx: &mut Context<P>,
        table: &Table<P>,
        message: QueryMessage<P>,
        router: &mut QueryRouter<P>,
    ) {
        let (subdomain, node) = (self.subdomain, message.node);
        let received = subdomain.receive(cx, node, message, |message| self.relayed(message));
        let Some((start, QueryMessage { from, batch, .. })) = received else { return };
        let walked = self.walk_batch(cx, table, start, &batch);
        let index = self.received.len() as u32;
        let mut groups =
            (0u64..).zip(&batch.groups.0).flat_map(|(at, &n)| std::iter::repeat_n(at, n as usize));
        // The points found by the balls that leave the path.
        let (block, mut numbers) = (self.chains.next_block(), Vec::new());
        let mut outstanding = 0;
        for WalkedBall { ball, found, ways } in walked.iter() {
            let group = groups.next().unwrap_or_default();
            if ways.is_empty() {
                continue;
            }
            let mut list = ListChain::EMPTY;
            self.chains.add(&mut list, block, numbers.len()..numbers.len() + found.len());
            numbers.extend_from_slice(found);
            outstanding += 1;
            let origin = Origin::Batch { batch: index, query: ball as u32 };
            let (centre, radius2) = (batch.centres[ball], batch.radii2[ball]);
            let pending = WaitingBall { origin, outstanding: 0, centre, radius2, list };
            // The balls of one leaf arrive in one batch.
            self.forward(router, ways, u64::from(index) << 32 | group, pending);
        }
        self.chains.add_block(numbers);
        self.received.push(ReceivedQueries::of(from, batch, walked.into_found(), outstanding));
    }

    /// Walks a batch of balls from the position `start` of the path.
    fn walk_batch(
        &mut self,
        cx: &mut Context<P>,
        table: &Table<P>,
        start: usize,
        batch: &QueryBatch<P>,
    ) -> WalkedBalls {
        let mut walk = self.space(table).walk(self.search);
        let mut walked = WalkedBalls::default();
        let (mut found, mut ways) = (NeighbourList::default(), Vec::new());
        for (i, (&centre, &radius2)) in batch.centres.iter().zip(&batch.radii2.0).enumerate() {
            found.clear();
            ways.clear();
            walk.follow(start, &MovingBall { centre, radius2, own_leaf: None }, &mut ways, &mut found);
            found.keep_nearest(batch.wanted as usize, radius2);
            walked.push(i, found.positions().iter().copied(), &ways);
        }
        self.tallies.add(cx, self.search.phase, &walk.into_counts());
        walked
    }

    /// Returns the queries that this rank relays to the rank that holds their node. The replies return through this rank.
    fn relayed(&mut self, message: QueryMessage<P>) -> Body<P> {
        let QueryMessage { from, batch, .. } = message;
        let mut relayed = batch.clone();
        let queries = batch.slots.len();
        let index = self.received.len() as u32;
        let nothing: Lists<u32> = std::iter::repeat_n(Vec::new(), queries).collect();
        self.received.push(ReceivedQueries::of(from, batch, nothing, queries as u32));
        for (i, slot) in relayed.slots.iter_mut().enumerate() {
            *slot = self.pending.len() as u32;
            self.pending.push(WaitingBall {
                origin: Origin::Batch { batch: index, query: i as u32 },
                outstanding: 1,
                centre: relayed.centres[i],
                radius2: relayed.radii2[i],
                list: ListChain::EMPTY,
            });
        }
        Body::Query(relayed)
    }

    /// Adds the lists of a reply to the pending balls. Converts the lists to local indices in their received storage.
    /// Returns `None` if the reply names a query that does not wait for a reply.
    fn on_reply(&mut self, table: &mut Table<P>, batch: ReplyBatch<P>) -> Option<()> {
        let ReplyBatch { slots, counts, groups, sizes, places, points } = batch;
        // A reply contains no owned points, because a rank sends balls only to nodes in which it owns no points.
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
        self.chains.add_block(places);
        for (&slot, &count) in slots.iter().zip(&counts.0) {
            let run = begin..begin + count as usize;
            begin = run.end;
            let pending = self.pending.get_mut(slot as usize)?;
            pending.outstanding = pending.outstanding.checked_sub(1)?;
            self.chains.add(&mut pending.list, block, run);
            if pending.outstanding == 0 {
                self.complete_list(table, slot);
            }
        }
        Some(())
    }

    /// Joins the parts of a list after the last reply.
    fn complete_list(&mut self, table: &Table<P>, slot: u32) {
        let Descent { pending, chains, scratch, complete, received, search, .. } = self;
        let pending = &pending[slot as usize];
        scratch.clear();
        for part in chains.parts(pending.list) {
            scratch.extend(part, |j| dist2(table.positions()[j as usize], pending.centre));
        }
        let kth2 = scratch.keep_nearest(search.wanted as usize, pending.radius2);
        let list = scratch.positions().iter().copied();
        match pending.origin {
            Origin::Owned(point) => complete.push(point, kth2, list),
            Origin::Batch { batch, query } => received[batch as usize].complete(query, list),
        }
    }
}
