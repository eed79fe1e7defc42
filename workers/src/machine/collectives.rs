//! Collective operations of groups of ranks, in terms of messages.
//!
//! A *group* is a node of the partition tree with the ranks that share it. One of them leads it (`leader`). Members
//! send to their leader, a leader sends to its members through the tree of the group
//! ([`crate::machine::group_tree`]), and results of children are combined on the way up the partition tree. Every
//! operation of this file queues messages of the current round and never waits.

use std::collections::BTreeMap;
use std::ops::Range;

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Rank};
use septet_protocol::message::Body;

use crate::machine::context::Context;
use crate::machine::group::Group;
use crate::machine::group_tree::FAN;

impl<P: Point> Context<P> {
    /// Sends the same body from the leader of a group to every member, itself included, through the tree of the group.
    /// Every receiver calls [`Context::pass_down`].
    pub(crate) fn broadcast(&mut self, group: &Group, mut body: impl FnMut() -> Body<P>) {
        self.send(self.rank(), group.node, 0, body());
        self.send_below(group, body);
    }

    /// Passes a body that the leader of a group sent to every member to the members below this one. The leader has already
    /// done this.
    pub(crate) fn pass_down(&mut self, group: &Group, body: impl FnMut() -> Body<P>) {
        if self.rank() != group.leader {
            self.send_below(group, body);
        }
    }

    fn send_below(&mut self, group: &Group, mut body: impl FnMut() -> Body<P>) {
        for rank in group.place(self.rank()).below() {
            self.send(rank, group.node, 0, body());
        }
    }

    /// Sends a body to the leader of a group.
    pub(crate) fn contribute(&mut self, group: &Group, attempt: u32, body: Body<P>) {
        self.send(group.leader, group.node, attempt, body);
    }

    /// Sends the value of a node to the leader of its parent, one of the groups of `path`. Sends nothing for the root.
    pub(crate) fn contribute_up<'a>(
        &mut self,
        path: impl IntoIterator<Item = &'a Group>,
        node: NodeId,
        body: Body<P>,
    ) {
        let parent = node.parent();
        if let Some(group) = path.into_iter().find(|group| Some(group.node) == parent) {
            self.send(group.leader, node, 0, body);
        }
    }

    /// Sends each of these ranks its own body about the whole set.
    pub(crate) fn send_each(&mut self, attempt: u32, bodies: impl IntoIterator<Item = (Rank, Body<P>)>) {
        for (rank, body) in bodies {
            self.send(rank, NodeId::ROOT, attempt, body);
        }
    }

    /// Sends a body about a node to a rank.
    pub(crate) fn send_to(&mut self, (node, to): (NodeId, Rank), body: Body<P>) {
        self.send(to, node, 0, body);
    }

    /// Sends bodies about nodes to ranks, in the order of the items.
    pub(crate) fn route(&mut self, bodies: impl IntoIterator<Item = ((NodeId, Rank), Body<P>)>) {
        for (receiver, body) in bodies {
            self.send_to(receiver, body);
        }
    }

    /// Sends a body about the whole set to the coordinator.
    pub(crate) fn send_to_coordinator(&mut self, body: Body<P>) {
        self.send(COORDINATOR, NodeId::ROOT, 0, body);
    }

    /// Sends the same body about the whole set from the coordinator to every rank, itself included, through a tree. Every
    /// receiver calls [`Context::pass_on`].
    pub(crate) fn send_to_all(&mut self, mut body: impl FnMut() -> Body<P>) {
        self.send(self.rank(), NodeId::ROOT, 0, body());
        self.send_down(body);
    }

    /// Passes a body that the coordinator sent to all ranks to the ranks below this one. The coordinator has already done
    /// this.
    pub(crate) fn pass_on(&mut self, body: impl FnMut() -> Body<P>) {
        if !self.is_coordinator() {
            self.send_down(body);
        }
    }

    fn send_down(&mut self, mut body: impl FnMut() -> Body<P>) {
        for rank in ranks_below(self.rank(), self.config().ranks()) {
            self.send(rank, NodeId::ROOT, 0, body());
        }
    }
}

/// Returns the ranks below a rank in the tree of all ranks, whose root is the coordinator. Worker r is at level 1 for
/// r <= 32, at level 2 for r <= 1,056, and so on.
pub(super) fn ranks_below(rank: Rank, ranks: u32) -> Range<Rank> {
    let fan = u64::from(FAN);
    let at = |i: u64| (fan * u64::from(rank) + i).min(u64::from(ranks)) as Rank;
    at(1)..at(fan + 1)
}

/// Counts the reports of all ranks, the coordinator included, at the coordinator.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reports(u32);

impl Reports {
    /// Adds the reports of a round. Returns `true`, and starts again, if every one of `ranks` has reported.
    pub(crate) fn complete(&mut self, arrived: usize, ranks: u32) -> bool {
        self.0 += arrived as u32;
        let complete = self.0 == ranks;
        if complete {
            self.0 = 0;
        }
        complete
    }
}

/// A value of a node that goes up the tree.
#[derive(Clone, Debug)]
pub(crate) struct Rising<T> {
    /// The node.
    pub(crate) node: NodeId,
    /// The round in which the value was sent.
    pub(crate) round: u32,
    /// The value.
    pub(crate) value: T,
}

/// One leader's part in a reduction up the tree: values of children that wait for their siblings.
///
/// **Rounds.** One for each level of shared nodes.
#[derive(Debug)]
pub(crate) struct Reduction<T>(BTreeMap<NodeId, T>);

impl<T> Default for Reduction<T> {
    fn default() -> Self {
        Reduction(BTreeMap::new())
    }
}

impl<T> Reduction<T> {
    /// Takes the values of children of the nodes that this rank leads. Calls `combine` with every group whose children
    /// have both arrived, with the interior child's value first and the round of the last. Returns the combined values,
    /// in the order of the children that completed them.
    pub(crate) fn join(
        &mut self,
        led: &[Group],
        mut arrived: Vec<Rising<T>>,
        mut combine: impl FnMut(&Group, [T; 2], u32) -> T,
    ) -> Vec<(NodeId, T)> {
        arrived.sort_by_key(|rising| rising.node);
        let mut joined = Vec::new();
        for Rising { node, round, value } in arrived {
            let Some(group) = led.iter().find(|group| Some(group.node) == node.parent()) else { continue };
            let Some(sibling) = self.0.remove(&group.node) else {
                self.0.insert(group.node, value);
                continue;
            };
            let both = if node.side() == 0 { [value, sibling] } else { [sibling, value] };
            joined.push((group.node, combine(group, both, round)));
        }
        joined
    }
}

#[cfg(test)]
mod tests {
    use septet_protocol::message::Child;

    use super::*;

    fn group(node: u64) -> Group {
        Group::new(NodeId(node), Child { population: 0, first: 3, ranks: 2, leaf: false })
    }

    /// Counts the groups that each rank leads, if groups are split at `cut` of their ranks.
    fn led(first: Rank, ranks: u32, cut: &impl Fn(u32) -> u32, counts: &mut [u32]) {
        if ranks < 2 {
            return;
        }
        let group =
            |first, ranks| Group::new(NodeId::ROOT, Child { population: 0, first, ranks, leaf: false });
        let (own, inner) = (group(first, ranks), cut(ranks).clamp(1, ranks - 1));
        assert!(own.members().contains(&own.leader));
        counts[own.leader as usize] += 1;
        led(first, inner, cut, counts);
        led(first + inner, ranks - inner, cut, counts);
    }

    #[test]
    fn no_rank_leads_many_groups() {
        let most = |ranks: u32, cut: &dyn Fn(u32) -> u32| {
            let mut counts = vec![0; ranks as usize];
            led(0, ranks, &cut, &mut counts);
            counts.into_iter().max()
        };
        assert_eq!([2, 8, 64, 512].map(|ranks| most(ranks, &|ranks| ranks / 2)), [Some(1); 4]);
        for ranks in [3, 7, 100, 511] {
            assert!(most(ranks, &|ranks| ranks * 2 / 5) <= Some(4), "{ranks}");
        }
    }

    #[test]
    fn every_worker_is_below_one_rank() {
        for ranks in [1, 2, 33, 34, 1057, 1058, 5000] {
            let below: Vec<Rank> = (0..ranks).flat_map(|rank| ranks_below(rank, ranks)).collect();
            assert_eq!(below, (1..ranks).collect::<Vec<_>>());
        }
        assert_eq!(ranks_below(2, 80), 65..80);
        assert!(ranks_below(Rank::MAX, Rank::MAX).is_empty());
    }

    #[test]
    fn a_reduction_combines_siblings_interior_first() {
        let rising =
            |node, round, value: &str| Rising { node: NodeId(node), round, value: value.to_string() };
        let led = [group(1), group(3)];
        let mut reduction = Reduction::default();
        let mut join = |arrived| {
            reduction.join(&led, arrived, |group, [a, b]: [String; 2], round| {
                format!("{a}{b}{}@{round}", group.node.0)
            })
        };
        // A child of a node that another rank leads is ignored.
        assert_eq!(join(vec![rising(7, 4, "b"), rising(2, 5, "c"), rising(5, 4, "x")]), []);
        assert_eq!(join(vec![rising(6, 6, "a")]), [(NodeId(3), "ab3@6".to_string())]);
        assert_eq!(join(vec![rising(3, 7, "d")]), [(NodeId::ROOT, "cd1@7".to_string())]);
    }

    #[test]
    fn reports_are_complete_once_all_have_come() {
        let mut reports = Reports::default();
        assert_eq!([2, 0, 1, 3].map(|arrived| reports.complete(arrived, 3)), [false, false, true, true]);
    }
}
