//! The recursion of the paper on separator sets: every set draws its own separator, copies included.
//!
//! **Statement** (paper, Section 4.3, steps 1 to 5). A set with at most as many members as the largest leaf is solved by
//! comparing all pairs. Otherwise a separator is drawn for the set itself (`own_draw`), and the recursion continues on
//! `P_I u P_O` and `P_E u P_O`. The graph of the set is the union of both graphs. All balls have the global radii, so the
//! graph is that of the other rules (`proof.md`). The sets, their separators and their graphs are functions of points, seed
//! and parameters.
//!
//! **Departures.** The partition tree remains: it places the points on ranks, and gives the order in which radii are
//! found. The first set has all points and the root's key, so its separator is drawn as that of the root of the tree. The
//! number of a node is its place in the recursion, and the sets below it need not be those of the node of the tree with this
//! number. The members of a group keep their shares, and members that leave go to the rank at the same relative place, so
//! the shares are not levelled.
//!
//! **Rounds.** `4 h + 1` for each attempt at a shared set: samples, separator, counts and decision take `h` rounds each, the
//! height of the tree of the group ([`crate::machine::group_tree`]), and members one. Lists then go up, one round for each
//! shared set.
//!
//! **Work and depth.** O(m) work and O(1) depth for each attempt at a set of `m` members, plus the cost of the draw. All
//! pairs and unions cost as in [`crate::graph::set_members`].

use septet_geometry::graph::Supergraph;
use septet_geometry::lists::Lists;
use septet_geometry::point::Point;
use septet_geometry::separator::Separator;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::{Body, Child, Decision, SetCounts};
use septet_protocol::transport::TransportError;

use crate::graph::own_draw::{
    Attempt, Verdict, attempts, decide, draw, draw_gathered, placed, samples, separator,
};
use crate::graph::own_steps::{OwnStep, SetTree};
use crate::graph::set_members::{
    Leaving, Receiver, SetMembers, enter_set, members_of_children, send_items, taken_items,
};
use crate::graph::sharing::Crossing;
use crate::machine::context::Context;
use crate::machine::group_tree::{Divided, Joined, Parts};
use crate::state::subdomain::{Group, Shared, Subdomain};
use crate::state::table::Table;
use crate::state::tree::{Split, bounds};

/// Finds the graph neighbours of the owned points by the recursion on sets with their own separators. Also returns node and
/// id of each member of the sets in which this rank compared all pairs, if the run keeps them.
pub(crate) async fn own_recursion<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    supergraph: Supergraph,
) -> Result<(Lists<u32>, Vec<[u64; 2]>), TransportError> {
    cx.enter(Phase::OwnSets)?;
    let mut own = OwnSpheres { supergraph, all: SetMembers::of_owned(cx, table, supergraph, SetTree::Own) };
    let held = own.descend(cx, subdomain).await?;
    // No group works any more when this phase of the recursion ends, so lists can go up.
    while cx.exchange().await? {}
    if let Some(held) = held {
        own.solve_held(cx, &held);
    }
    while cx.exchange().await? {
        own.all.take_lists(cx)?;
    }
    Ok(own.all.finish(cx))
}

/// One rank's part in the recursion.
struct OwnSpheres<'a, P> {
    supergraph: Supergraph,
    all: SetMembers<'a, P>,
}

/// A set that this rank holds alone.
struct Held {
    node: NodeId,
    members: Vec<u32>,
    /// Whether a group has already failed to divide the set.
    is_refused: bool,
}

impl<P: Point> OwnSpheres<'_, P> {
    /// Divides the sets that this rank shares with others. Returns the set that it then holds alone, if any.
    async fn descend(
        &mut self,
        cx: &mut Context<P>,
        subdomain: &Subdomain<P>,
    ) -> Result<Option<Held>, TransportError> {
        let mut share = self.all.owned();
        let Some(mut group) = subdomain.path().first().map(|shared| *shared.group()) else {
            let held = Held { node: NodeId::ROOT, members: share, is_refused: false };
            return Ok(subdomain.top().map(|_| held));
        };
        while !group.is_whole() {
            let Some((separator, children)) = self.agree(cx, &group, &share).await? else {
                let members = self.gather_at_first(cx, &group, share).await?;
                let held = Held { node: group.node, members, is_refused: true };
                return Ok((group.child.first == cx.rank()).then_some(held));
            };
            let split = Split::new(separator, [bounds(std::iter::empty()); 2]);
            let mine = usize::from(children[1].first <= cx.rank());
            let shared = Shared::new(group, split, children, mine, cx.rank());
            share = self.enter_child(cx, &shared, &share).await?;
            group = group.below(mine, children[mine]);
        }
        let held = Held { node: group.node, members: share, is_refused: false };
        Ok((group.child.first == cx.rank()).then_some(held))
    }

    /// Makes attempts at a shared set until its leader accepts a separator or gives up. Returns `None` if the set is not
    /// divided.
    async fn agree(
        &self,
        cx: &mut Context<P>,
        group: &Group,
        share: &[u32],
    ) -> Result<Option<(Separator<P>, [Child; 2])>, TransportError> {
        let positions = self.all.positions(share);
        for attempt in attempts(cx, group.node, group.child.population) {
            let chosen = samples(cx, attempt, &positions);
            let gathered = cx.gather(group, attempt.number, chosen).await?;
            let words = draw_gathered(cx, attempt, gathered);
            let words = cx.distribute(group, attempt.number, words).await?;
            let separator = separator(&words);
            let counts = separator.as_ref().map(|separator| self.count(cx, attempt, separator, share));
            let counts = MemberCounts(counts.unwrap_or_default());
            let decision = cx.gather(group, attempt.number, counts).await?.map(|counts| {
                let counts = separator.map(|_| counts.value.0);
                SetSplit(placed(cx, group, decide(cx, self.supergraph, attempt, counts)))
            });
            let SetSplit(decision) = cx.distribute(group, attempt.number, decision).await?;
            match (decision, separator) {
                (Decision::Retry, _) => {}
                (Decision::Split(children), Some(separator)) => return Ok(Some((separator, children))),
                (Decision::Split(_) | Decision::Leaf, _) => return Ok(None),
            }
        }
        Ok(None)
    }

    /// Counts some members on both sides of a separator, and those of each side whose balls meet it.
    fn count(
        &self,
        cx: &mut Context<P>,
        attempt: Attempt,
        separator: &Separator<P>,
        share: &[u32],
    ) -> [u64; 4] {
        let mut cost = cx.shared_cost();
        let counts = self.all.count(separator, share, &mut cost);
        cx.charge(OwnStep::Count(attempt.number).account(attempt.node), cost, share.len() as u64);
        counts
    }

    /// Sends this rank's share of a set to the lowest rank of the group. Returns the share after that.
    async fn gather_at_first(
        &mut self,
        cx: &mut Context<P>,
        group: &Group,
        mut share: Vec<u32>,
    ) -> Result<Vec<u32>, TransportError> {
        let first = group.child.first;
        if cx.rank() != first {
            self.all.hand_over(cx, group.node, first, std::mem::take(&mut share));
        }
        self.take_members(cx, &mut share).await?;
        Ok(share)
    }

    /// Divides this rank's share of a set. Returns its share of the set of its child.
    async fn enter_child(
        &mut self,
        cx: &mut Context<P>,
        shared: &Shared<P>,
        share: &[u32],
    ) -> Result<Vec<u32>, TransportError> {
        let (node, rank) = (shared.id(), cx.rank());
        let (mut leaving, mut staying) = (Leaving::new(), Vec::new());
        for (&item, reached) in share.iter().zip(self.places(cx, node, shared.split().separator(), share)) {
            let stays = shared.follow(reached, |side| {
                let to = Receiver { node: node.child(side), rank: shared.member_below(rank, side) };
                self.all.send_item(item, node, to, &mut leaving);
            });
            if stays {
                staying.push(item);
            } else {
                self.all.release(item);
            }
        }
        send_items(cx, leaving);
        self.take_members(cx, &mut staying).await?;
        Ok(staying)
    }

    /// Ends the round, and adds the members that arrive to a share. All members of a group receive in the same round.
    async fn take_members(
        &mut self,
        cx: &mut Context<P>,
        share: &mut Vec<u32>,
    ) -> Result<(), TransportError> {
        // If no member leaves its rank, no rank may have sent a message.
        cx.exchange_if(true).await?;
        for arrival in taken_items(cx) {
            share.extend(self.all.receive(arrival.from, arrival.batch));
        }
        Ok(())
    }

    /// Returns the children to which each of some members of a divided set goes.
    fn places(
        &self,
        cx: &mut Context<P>,
        node: NodeId,
        separator: &Separator<P>,
        share: &[u32],
    ) -> Vec<[bool; 2]> {
        let mut cost = cx.shared_cost();
        let places = cost.replicate(share, |&i| self.all.place(separator, i));
        cx.charge(OwnStep::Divide.account(node), cost, share.len() as u64);
        enter_set(cx, node, &places);
        places.into_iter().map(|place| [0, 1].map(|child| Crossing::Both.sends(place, child))).collect()
    }

    /// Solves the set that this rank holds alone, and returns the lists of other ranks' items to them.
    fn solve_held(&mut self, cx: &mut Context<P>, held: &Held) {
        for &item in &held.members {
            self.all.release(item);
        }
        let lists = if held.is_refused {
            self.all.compare_all(cx, held.node, &held.members)
        } else {
            self.solve(cx, held.node, &held.members)
        };
        self.all.complete(cx, &held.members, lists);
    }

    /// Finds the neighbours of each member of a set that this rank holds alone.
    fn solve(&mut self, cx: &mut Context<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let Some(separator) = self.draw_alone(cx, node, members) else {
            return self.all.compare_all(cx, node, members);
        };
        let sent = self.places(cx, node, &separator, members);
        let [inside, outside] = members_of_children(members, &sent);
        let lists = [self.solve(cx, node.child(0), &inside), self.solve(cx, node.child(1), &outside)];
        self.all.unite(node, &sent, lists)
    }

    /// Draws the separator of a set by the steps that a group takes. Returns `None` if the set is not divided.
    fn draw_alone(&self, cx: &mut Context<P>, node: NodeId, members: &[u32]) -> Option<Separator<P>> {
        let positions = self.all.positions(members);
        for attempt in attempts(cx, node, members.len() as u64) {
            let chosen = samples(cx, attempt, &positions);
            let separator = separator(&draw(cx, attempt, chosen));
            let counts = separator.as_ref().map(|separator| self.count(cx, attempt, separator, members));
            match decide(cx, self.supergraph, attempt, counts) {
                Verdict::Retry => {}
                Verdict::Divide(_) => return separator,
                Verdict::Leaf => return None,
            }
        }
        None
    }
}

/// The counts of some members of a group.
struct MemberCounts([u64; 4]);

impl<P: Point> Parts<P> for MemberCounts {
    fn into_body(self) -> Body<P> {
        let [inside, outside, crossing_inside, crossing_outside] = self.0;
        Body::SetCounts(SetCounts { inside, outside, crossing_inside, crossing_outside })
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let Body::SetCounts(SetCounts { inside, outside, crossing_inside, crossing_outside }) = *body else {
            return None;
        };
        Some(MemberCounts([inside, outside, crossing_inside, crossing_outside]))
    }

    fn fits(&self, _: usize) -> bool {
        true
    }
}

impl<P: Point> Joined<P> for MemberCounts {
    fn append(&mut self, MemberCounts(next): Self) {
        self.0.iter_mut().zip(next).for_each(|(sum, more)| *sum += more);
    }
}

/// The decision of a leader on an attempt at a set.
struct SetSplit(Decision);

impl<P: Point> Parts<P> for SetSplit {
    fn into_body(self) -> Body<P> {
        Body::Decision { decision: self.0, boxes: Bulk(Vec::new()), routes: Box::default() }
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let Body::Decision { decision, .. } = body else { return None };
        Some(SetSplit(decision.clone()))
    }

    fn fits(&self, _: usize) -> bool {
        true
    }
}

impl<P: Point> Divided<P> for SetSplit {
    fn split_off(&mut self, _: usize) -> Self {
        SetSplit(self.0.clone())
    }
}
