//! Separator sets by the recursion of the paper, and the union of the graphs that the recursion returns.
//!
//! **Statement** (paper, Section 4.3). The separator of a node divides the set of the node. The points whose balls
//! cross the separator, `P_O`, belong to the sets of both children (rule `both`). The graph of the node is the union of
//! the graphs of its children, without multiple edges. For the density graph, the crossing points of one side suffice
//! (rule `smaller`), because *both* ends of every edge that crosses are in `P_O`. All balls have the global radii.
//!
//! **Departure.** The recursion follows the separators of the partition tree, which were drawn for the owned points
//! alone. It stops if the set of the larger child would contain more than 93 % of the set of its parent. In such a set,
//! all pairs are compared.
//!
//! **Rounds.** `2 h + 1` for each shared level on the way down, and one on the way up. Counts and decision each take
//! `h` rounds, the height of the tree of the group ([`crate::machine::group_tree`]), and points take one.
//!
//! **Work and depth.** At each node, a copy-scan of the separator, the counts, and the replication of the members to the
//! children ([`septet_geometry::cost::Cost::charge_replication`]). At the bottom, a sort and O(1) steps for all pairs of each set. On the way up,
//! one vector step whose lanes sort the lists of the members in both children.

use std::collections::BTreeMap;

use septet_geometry::graph::Supergraph;
use septet_geometry::lists::Lists;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::config::{Fault, SetRule};
use crate::graph::own_steps::SetTree;
use crate::graph::set_members::{
    Arrival, ItemBatch, Leaving, Receiver, SetMembers, enter_set, members_of_children, send_items,
    taken_items,
};
use crate::graph::sharing::{Crossing, Place, SetStep, SetVotes, Sharing, set_rule};
use crate::machine::context::Context;
use crate::state::subdomain::{Entry, Shared, Subdomain, Way};
use crate::state::table::Table;
use crate::state::tree::Tree;

/// Finds the graph neighbours of the owned points in the sets of the leaves, and unites them on the way up. Also returns
/// node and id of each member of the sets in which this rank compared all pairs, if the run keeps them.
pub(crate) async fn set_recursion<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    supergraph: Supergraph,
) -> Result<(Lists<u32>, Vec<[u64; 2]>), TransportError> {
    let mut recursion = Recursion::of_owned(cx, subdomain, table, supergraph);
    while cx.exchange_if(recursion.is_pending()).await? {
        recursion.agenda.step += 1;
        let at = recursion.step();
        recursion.votes.receive(cx, subdomain, at);
        recursion.take_items(cx);
        recursion.apply_decisions(cx);
        recursion.handle_ready(cx);
        recursion.all.take_lists(cx)?;
    }
    Ok(recursion.all.finish(cx))
}

/// The nodes that a rank handles, by the step in which it handles them.
#[derive(Default)]
struct Agenda {
    /// The number of rounds since the phase began.
    step: u32,
    /// Nodes whose sets are counted or solved in this step.
    ready: Vec<NodeId>,
    /// Nodes whose members other ranks send in this step. They are handled in the next step.
    waiting: Vec<NodeId>,
    /// Nodes that wait one more step for their members, with the step in which the first members arrived.
    delayed: BTreeMap<NodeId, u32>,
    /// Shared nodes whose sets are not divided. This rank solves each as a whole.
    stopped: Vec<NodeId>,
}

/// One rank's part in the recursion. A rank may lead, count, solve and reply for several nodes in a round.
struct Recursion<'a, P> {
    subdomain: &'a Subdomain<P>,
    rule: SetRule,
    /// A planted fault, which may change the separator sets.
    fault: Option<Fault>,
    agenda: Agenda,
    votes: SetVotes,
    /// The members of all sets on this rank.
    all: SetMembers<'a, P>,
    /// For each node, the members of its set on this rank.
    members: BTreeMap<NodeId, Vec<u32>>,
}

impl<'a, P: Point> Recursion<'a, P> {
    /// Starts with the owned points as members of the root's set.
    fn of_owned(
        cx: &Context<P>,
        subdomain: &'a Subdomain<P>,
        table: &'a mut Table<P>,
        supergraph: Supergraph,
    ) -> Self {
        let root = subdomain.top();
        let members = root.map(|root| (root, table.owned().collect()));
        Recursion {
            subdomain,
            rule: set_rule(cx.config().graph.sets, supergraph),
            fault: cx.config().fault,
            agenda: Agenda { ready: root.into_iter().collect(), ..Agenda::default() },
            votes: SetVotes::default(),
            all: SetMembers::of_owned(cx, table, supergraph, SetTree::Partition),
            members: members.into_iter().collect(),
        }
    }

    /// Returns `true` if this rank handles a node in the next step.
    fn is_pending(&self) -> bool {
        !self.agenda.ready.is_empty() || !self.agenda.waiting.is_empty() || self.votes.is_pending()
    }

    /// Returns the rule and the current step.
    fn step(&self) -> SetStep {
        SetStep { rule: self.rule, step: self.agenda.step }
    }

    /// Applies the decisions of the leaders.
    fn apply_decisions(&mut self, cx: &mut Context<P>) {
        let subdomain = self.subdomain;
        for (node, sharing) in self.votes.take_decisions(self.step()) {
            let members = self.members.remove(&node).unwrap_or_default();
            let Some(shared) = subdomain.shared(node) else { continue };
            match sharing {
                Sharing::Stop => self.stop(cx, shared, members),
                Sharing::Crossing(crossing) => self.divide(cx, shared, &members, crossing),
            }
        }
    }

    /// Counts or solves the nodes whose members are complete.
    fn handle_ready(&mut self, cx: &mut Context<P>) {
        let mut ready = std::mem::take(&mut self.agenda.ready);
        ready.sort_unstable();
        ready.dedup();
        let subdomain = self.subdomain;
        for node in ready {
            match subdomain.shared(node).filter(|_| !self.agenda.stopped.contains(&node)) {
                Some(shared) => self.count_set(cx, shared),
                None => self.solve_set(cx, node),
            }
        }
    }

    /// Counts this rank's share of the set of a shared node, for the leader.
    fn count_set(&mut self, cx: &mut Context<P>, shared: &Shared<P>) {
        let members = self.members.get(&shared.id()).map_or(&[][..], Vec::as_slice);
        let mut cost = cx.shared_cost();
        let sum = self.all.count(shared.split().separator(), members, &mut cost);
        cx.charge(Account::member(Phase::Sets, shared.id()), cost, members.len() as u64);
        self.votes.add(cx, shared.group(), sum, self.step());
    }

    /// Ends the division of a set: sends this rank's share of the set to the lowest rank of the group, which solves it.
    fn stop(&mut self, cx: &mut Context<P>, shared: &Shared<P>, members: Vec<u32>) {
        let (node, holder) = (shared.id(), shared.first());
        if cx.rank() == holder {
            self.agenda.stopped.push(node);
            self.members.insert(node, members);
            self.agenda.waiting.push(node);
        } else {
            self.all.hand_over(cx, node, holder, members);
        }
    }

    /// Divides this rank's share of a set. Items take one step of the path, because the next leader decides first.
    fn divide(&mut self, cx: &mut Context<P>, shared: &Shared<P>, members: &[u32], crossing: Crossing) {
        let (node, subdomain) = (shared.id(), self.subdomain);
        let level = subdomain.position(node);
        let (mut leaving, mut staying) = (Leaving::new(), Vec::new());
        let mut cost = cx.shared_cost();
        let replicated = cost.replicate(members, |&i| self.all.place(shared.split().separator(), i));
        self.enter_set(cx, node, &replicated);
        for (&item, place) in members.iter().zip(replicated) {
            let reached = [0, 1].map(|side| crossing.sends(place, side));
            let stays = shared.follow(reached, |side| {
                let (child, rank) = subdomain.beyond(Way { level, side }, cx.rank());
                self.all.send_item(item, node, Receiver { node: child, rank }, &mut leaving);
            });
            if stays {
                staying.push(item);
            } else {
                self.all.release(item);
            }
        }
        cx.charge(Account::member(Phase::Sets, node), cost, 0);
        let id = node.child(shared.mine());
        self.members.entry(id).or_default().extend(staying);
        if subdomain.unsplit().is_some_and(|end| end.node == id)
            || subdomain.path().last().is_some_and(|last| last.id() != node)
            || subdomain.holds(id)
        {
            self.agenda.waiting.push(id);
        }
        send_items(cx, leaving);
    }

    /// Receives members of sets from other ranks. The end of a wait counts as an arrival without points from this rank.
    fn take_items(&mut self, cx: &mut Context<P>) {
        let mut arrivals = taken_items(cx);
        let nothing = |node| Arrival { from: cx.rank(), node, batch: ItemBatch::default() };
        arrivals.extend(std::mem::take(&mut self.agenda.waiting).into_iter().map(nothing));
        arrivals.sort_by_key(|arrival| arrival.from);
        for Arrival { from, node, batch } in arrivals {
            let new = self.all.receive(from, batch);
            self.members.entry(node).or_default().extend(new);
            // A relay keeps its items, because their lists return by this rank.
            if let Entry::Relay(holder) = self.subdomain.entry(node, cx.rank()) {
                let members = self.members.remove(&node).unwrap_or_default();
                self.all.hand_over(cx, node, holder, members);
                continue;
            }
            match self.subdomain.unsplit().filter(|end| end.node == node) {
                // The other ranks of the group relay the members that they received in this step. Wait for them.
                Some(_) if !self.agenda.delayed.contains_key(&node) => {
                    self.agenda.delayed.insert(node, self.agenda.step);
                    self.agenda.waiting.push(node);
                }
                _ if self.agenda.delayed.get(&node) == Some(&self.agenda.step) => {}
                _ => self.agenda.ready.push(node),
            }
        }
    }

    /// Solves a set that this rank holds alone, and returns the lists of other ranks' items to them.
    fn solve_set(&mut self, cx: &mut Context<P>, node: NodeId) {
        let members = self.members.remove(&node).unwrap_or_default();
        for &item in &members {
            self.all.release(item);
        }
        let subdomain = self.subdomain;
        let lists = match subdomain.tree().filter(|_| subdomain.holds(node)) {
            Some(tree) => self.solve(cx, tree, node, &members),
            None => self.all.compare_all(cx, node, &members),
        };
        self.all.complete(cx, &members, lists);
    }

    /// Finds the neighbours of each member of a set by the recursion in this rank's subtree.
    fn solve(&mut self, cx: &mut Context<P>, tree: &Tree<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let Tree::Node(inner) = tree else { return self.all.compare_all(cx, node, members) };
        let mut cost = cx.shared_cost();
        let sum = self.all.count(inner.split().separator(), members, &mut cost);
        cx.charge(Account::member(Phase::Sets, node), cost, members.len() as u64);
        let Sharing::Crossing(crossing) = Sharing::decide(sum, self.rule, self.fault) else {
            return self.all.compare_all(cx, node, members);
        };
        let mut cost = cx.shared_cost();
        let places = cost.replicate(members, |&i| self.all.place(inner.split().separator(), i));
        self.enter_set(cx, node, &places);
        cx.charge(Account::member(Phase::Sets, node), cost, 0);
        let sent: Vec<[bool; 2]> =
            places.into_iter().map(|place| [0, 1].map(|child| crossing.sends(place, child))).collect();
        let [inside, outside] = members_of_children(members, &sent);
        let lists = [
            self.solve(cx, &inner.children()[0], node.child(0), &inside),
            self.solve(cx, &inner.children()[1], node.child(1), &outside),
        ];
        self.all.unite(node, &sent, lists)
    }

    /// Records the size of a divided set, if the run uses the owners' separators in place of own ones.
    fn enter_set(&self, cx: &mut Context<P>, node: NodeId, places: &[Place]) {
        if self.rule == SetRule::Own {
            enter_set(cx, node, places);
        }
    }
}
