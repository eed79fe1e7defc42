//! Separator sets by the paper's recursion, and the union of the graphs it returns.
//!
//! **Statement** (paper, Section 4.3). The set of a node is divided by its separator; the points whose
//! balls cross it, `P_O`, belong to the sets of both children (rule `both`); the graph of the node is the
//! union of the children's graphs, multiple edges deleted. For the density graph the crossing points of one
//! side suffice (rule `smaller`): every edge that crosses has *both* ends in `P_O`. The balls are always the
//! global ones.
//!
//! **Departure.** The recursion follows the separators of the partition tree, which were drawn for the home
//! points alone, and stops where the larger child's set would hold more than 93 % of its parent's: then the
//! graph is found directly.
//!
//! **Rounds.** Three a shared level down (counts, the rule, the points) and one up.
//!
//! **Work and depth.** O(1) steps a level; at the bottom all pairs of a set, O(1) steps.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::graph_direct;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, ListBatch, Message, PointBatch};

use crate::neighbours::done::Done;
use crate::partition::leader::{by_node, decide_sets};
use crate::state::subdomain::{Split, Tree};
use crate::worker::Worker;

/// A member of sets on this worker: a point, and the neighbours found for it.
#[derive(Clone, Debug)]
struct Item {
    point: u32,
    origin: Option<(Rank, u32)>,
    /// Places where its neighbours are still looked for: here, and where it was sent.
    outstanding: u32,
    /// Its neighbours in this worker's piece, once found.
    own: Option<Vec<u32>>,
    /// Its neighbours below other nodes: where it was sent from, and the list that came back.
    returned: Vec<(NodeId, Vec<u32>)>,
}

/// Items that leave, with the sender's names of them, by node and receiver.
type Leaving<P> = BTreeMap<(NodeId, Rank), (PointBatch<P>, Vec<u32>)>;

/// The state of the recursion, keyed by subproblem.
#[derive(Clone, Debug, Default)]
pub(crate) struct SetEngine {
    /// The k nearest of each home point, until they are united with the other ends of edges.
    pub(crate) nearest: Done,
    /// Edges whose other end is told and does not know them: a home point, and who is joined to it.
    pub(crate) reverse: Vec<(u32, u32)>,
    /// Of each leaf, the edges that its points were told.
    pub(crate) told: Vec<Sweep>,
    /// Ghost descents' steps, by node.
    pub(crate) sweeps: BTreeMap<NodeId, Sweep>,
    items: Vec<Item>,
    /// Items sent: which, and the node that shared it. Their position is the name under which the list returns.
    sent: Vec<(u32, NodeId)>,
    /// What uniting lists costs, by the node whose children's they are.
    unions: BTreeMap<NodeId, Cost>,
    /// Members of each node's set on this worker.
    members: BTreeMap<NodeId, Vec<u32>>,
    /// Nodes to count or to solve in the next step.
    due: Vec<NodeId>,
    replicated: BTreeMap<NodeId, Sweep>,
    /// Nodes that wait one more step for their members, and the step when the first came.
    delayed: BTreeMap<NodeId, u32>,
    /// Shared nodes that stopped: their set is solved whole here.
    stopped: Vec<NodeId>,
}

impl SetEngine {
    /// A home point of a leaf, with this squared radius, is told who is joined to it, so far from it. All points as near
    /// as the last in its list are in the list, so by their distance it sees whether it knows.
    #[inline]
    pub(crate) fn tell(&mut self, edge: (u32, u32), leaf: u32, distance2: f64, radius2: f64) {
        self.told[leaf as usize].visit();
        if distance2 > radius2 {
            self.reverse.push(edge);
        }
    }

    /// Is there a node to handle in the next step?
    pub(crate) fn is_pending(&self) -> bool {
        !self.due.is_empty()
    }
}

impl<P: Point> Worker<P> {
    /// Every home point is a member of the root's set.
    pub(crate) fn begin_set_recursion(&mut self) {
        self.sets.items = (0..self.table.home).map(|point| Item::new(point, None)).collect();
        let members: Vec<u32> = (0..self.table.home).collect();
        let root = self.subdomain.path.first().map(|s| s.id).or(self.subdomain.tree.as_ref().map(|t| t.0));
        if let Some(root) = root {
            self.sets.members.insert(root, members);
            self.sets.due.push(root);
        }
    }

    pub(crate) fn on_sets(&mut self, inbox: &mut Vec<Message<P>>) {
        self.lead_sets(inbox);
        self.take_items(inbox);
        let decisions = by_node(inbox, |m| match m.body {
            Body::SetDecision(d) => Some(d),
            _ => None,
        });
        for (node, decision) in decisions.into_iter().flat_map(|(n, d)| d.into_iter().map(move |d| (n, d))) {
            self.share_set(node, decision);
        }
        let mut due = std::mem::take(&mut self.sets.due);
        due.sort_unstable();
        due.dedup();
        for node in due {
            if self.subdomain.path.iter().any(|s| s.id == node) && !self.sets.stopped.contains(&node) {
                self.count_set(node);
            } else {
                self.solve_set(node);
            }
        }
        self.take_lists(inbox);
    }

    fn lead_sets(&mut self, inbox: &mut Vec<Message<P>>) {
        let rule = self.set_rule();
        let counts = by_node(inbox, |m| match &mut m.body {
            Body::SetCounts(c) => Some(std::mem::take(&mut c.0)),
            _ => None,
        });
        for (node, all) in counts {
            self.leader.on_set_counts(node, &all, rule, &mut self.out);
        }
    }

    /// Side and crossing of a point at a split.
    fn place_item(&self, split: &Split<P>, item: u32) -> (usize, bool) {
        let point = self.sets.items[item as usize].point as usize;
        let (x, radius2) = (self.table.positions[point], self.table.radii2[point]);
        let radius = self.supergraph().separator_radius(radius2);
        (split.side(x), split.separator.crosses(x, radius))
    }

    /// The member's count of a shared node's set, to its leader.
    fn count_set(&mut self, node: NodeId) {
        let members = self.sets.members.get(&node).cloned().unwrap_or_default();
        let Some(shared) = self.subdomain.path.iter().find(|s| s.id == node) else { return };
        let (split, leader) = (shared.split.clone(), shared.leader);
        let mut cost = Cost::ZERO;
        let sum = self.count_members(&split, &members, &mut cost);
        self.ledger.charge(Phase::Sets, node, cost, members.len() as u64);
        self.out.send(leader, node, 0, Body::SetCounts(Bulk(sum.to_vec())));
    }

    fn count_members(&self, split: &Split<P>, members: &[u32], cost: &mut Cost) -> [u64; 4] {
        let places = cost.map(members, |&i| self.place_item(split, i));
        cost.reduce(&places, [0u64; 4], |mut sum, &(side, crosses)| {
            sum[side] += 1;
            sum[2 + side] += u64::from(crosses);
            sum
        })
    }

    /// Obeys the leader: divides this worker's share of the set, or hands it to the lowest rank.
    fn share_set(&mut self, node: NodeId, decision: u8) {
        let members = self.sets.members.remove(&node).unwrap_or_default();
        let Some(at) = self.subdomain.path.iter().position(|s| s.id == node) else { return };
        let shared = self.subdomain.path[at].clone();
        let mut leaving: Leaving<P> = BTreeMap::new();
        if decision == 0 {
            let holder = shared.first;
            if self.rank == holder {
                self.sets.stopped.push(node);
                self.sets.members.insert(node, members);
                self.wait_for_items(node);
                return;
            }
            for item in members {
                self.send_item(item, node, (node, holder), &mut leaving);
                self.sets.items[item as usize].outstanding -= 1;
            }
        } else {
            let mut staying = Vec::new();
            let mut cost = Cost::ZERO;
            let places = cost.map(&members, |&i| self.place_item(&shared.split, i));
            for (&item, (side, crosses)) in members.iter().zip(places) {
                let mut stays = false;
                for to in (0..2).filter(|&to| goes_to(to, side, crosses, decision)) {
                    if to == shared.mine && shared.goes_on {
                        stays = true;
                    } else {
                        let member = shared.member_below(self.rank, to);
                        self.send_item(item, node, (node.child(to), member), &mut leaving);
                    }
                }
                if stays {
                    staying.push(item);
                } else {
                    self.sets.items[item as usize].outstanding -= 1;
                }
                if crosses {
                    self.sets.replicated.entry(node).or_default().visit();
                }
            }
            self.ledger.charge(Phase::Sets, node, cost, 0);
            let id = node.child(shared.mine);
            self.sets.members.entry(id).or_default().extend(staying);
            let relayed = self.subdomain.relay.is_some_and(|r| r.0 == id);
            if relayed
                || self.subdomain.path.len() > at + 1
                || self.subdomain.tree.as_ref().is_some_and(|t| t.0 == id)
            {
                self.wait_for_items(id);
            }
        }
        for ((id, to), (points, slots)) in leaving {
            self.out.send(to, id, 0, Body::Items { points, slots: Bulk(slots) });
        }
    }

    /// Sends an item from a node to the place below it, or to the rank that holds it.
    fn send_item(&mut self, item: u32, node: NodeId, to: (NodeId, Rank), leaving: &mut Leaving<P>) {
        let (points, slots) = leaving.entry(to).or_default();
        self.table.export(self.sets.items[item as usize].point, points);
        slots.push(self.sets.sent.len() as u32);
        self.sets.sent.push((item, node));
        self.sets.items[item as usize].outstanding += 1;
    }

    fn take_items(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Items { points, slots } => {
                received.push((m.from, m.node, std::mem::take(points), std::mem::take(&mut slots.0)));
                false
            }
            _ => true,
        });
        for (from, node, points, slots) in received {
            let numbers = self.table.intern_all(&points);
            let first = self.sets.items.len() as u32;
            let new = numbers.iter().zip(slots).map(|(&point, slot)| Item::new(point, Some((from, slot))));
            self.sets.items.extend(new);
            let last = self.sets.items.len() as u32;
            self.sets.members.entry(node).or_default().extend(first..last);
            match self.subdomain.relay {
                Some((at, holder)) if at == node && holder != self.rank => self.relay_items(node, holder),
                // The group's other ranks hand on in this step what they were sent as well: wait for it.
                Some((at, _)) if at == node && !self.sets.delayed.contains_key(&node) => {
                    self.sets.delayed.insert(node, self.step);
                    self.wait_for_items(node);
                }
                _ if self.sets.delayed.get(&node) == Some(&self.step) => {}
                _ => self.sets.due.push(node),
            }
        }
    }

    /// Others send their share of the node's set in this step: handle it in the next one.
    fn wait_for_items(&mut self, node: NodeId) {
        let body = Body::Items { points: PointBatch::default(), slots: Bulk(Vec::new()) };
        self.out.send(self.rank, node, 0, body);
    }

    /// Hands the members of a node that turned out a leaf to the rank that holds it.
    fn relay_items(&mut self, node: NodeId, holder: Rank) {
        let mut leaving = BTreeMap::new();
        for item in self.sets.members.remove(&node).unwrap_or_default() {
            self.send_item(item, node, (node, holder), &mut leaving);
            self.sets.items[item as usize].outstanding -= 1;
        }
        for ((id, to), (points, slots)) in leaving {
            self.out.send(to, id, 0, Body::Items { points, slots: Bulk(slots) });
        }
    }

    /// Solves the set of a piece that this worker holds whole; answers for items of others.
    fn solve_set(&mut self, node: NodeId) {
        let members = self.sets.members.remove(&node).unwrap_or_default();
        for &item in &members {
            self.sets.items[item as usize].outstanding -= 1;
        }
        let tree = self.subdomain.tree.take();
        let lists = match &tree {
            Some((root, tree)) if *root == node => self.solve(tree, node, &members),
            _ => self.solve_direct(node, &members),
        };
        self.subdomain.tree = tree;
        for (&item, list) in members.iter().zip(lists) {
            self.sets.items[item as usize].own = Some(list);
        }
        self.answer_items();
    }

    /// The graph of a set in this worker's piece: the neighbours of each member.
    fn solve(&mut self, tree: &Tree<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let Tree::Node(inner) = tree else { return self.solve_direct(node, members) };
        let mut cost = Cost::ZERO;
        let sum = self.count_members(&inner.split, members, &mut cost);
        let decision = decide_sets(sum, self.set_rule());
        self.ledger.charge(Phase::Sets, node, cost, members.len() as u64);
        if decision == 0 {
            return self.solve_direct(node, members);
        }
        let mut cost = Cost::ZERO;
        let places = cost.map(members, |&i| self.place_item(&inner.split, i));
        self.ledger.charge(Phase::Sets, node, cost, 0);
        let mut children = [Vec::new(), Vec::new()];
        for (&item, &(side, crosses)) in members.iter().zip(&places) {
            for (to, child) in children.iter_mut().enumerate() {
                if goes_to(to, side, crosses, decision) {
                    child.push(item);
                }
            }
            if crosses {
                self.sets.replicated.entry(node).or_default().visit();
            }
        }
        let [inside, outside] = &children;
        let mut lists = [
            self.solve(&inner.children[0], node.child(0), inside).into_iter(),
            self.solve(&inner.children[1], node.child(1), outside).into_iter(),
        ];
        let unions = self.sets.unions.entry(node).or_default();
        let united = places.into_iter().map(|(side, crosses)| {
            let mut own = [0, 1].map(|to| {
                let there = goes_to(to, side, crosses, decision);
                there.then(|| lists[to].next()).flatten()
            });
            match own.each_mut().map(Option::take) {
                [Some(a), Some(b)] => unite(a, b, unions),
                [a, b] => a.or(b).unwrap_or_default(),
            }
        });
        united.collect()
    }

    /// The base case: all pairs.
    fn solve_direct(&mut self, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let at = |i: u32| self.table.positions[self.sets.items[i as usize].point as usize];
        let mut order: Vec<usize> = (0..members.len()).collect();
        order.sort_unstable_by(|&a, &b| lex_cmp(&at(members[a]), &at(members[b])));
        let points: Vec<u32> = order.iter().map(|&i| self.sets.items[members[i] as usize].point).collect();
        let mut cost = Cost::ZERO;
        let (table, rule) = (&self.table, self.supergraph());
        let found = graph_direct(rule, &table.positions, &table.radii2, &points, &points, &mut cost);
        let pairs = (points.len() * points.len()) as u64;
        self.ledger.charge(Phase::Graph, node, cost, pairs);
        self.ledger.facts(node).members += points.len() as u64;
        let mut lists = vec![Vec::new(); members.len()];
        for (i, list) in order.into_iter().zip(found.iter()) {
            lists[i] = list.to_vec();
        }
        lists
    }

    /// Lists that are complete go back to where their item came from.
    fn answer_items(&mut self) {
        let mut answers: BTreeMap<Rank, ListBatch<P>> = BTreeMap::new();
        for item in &mut self.sets.items {
            let Some((to, slot)) = item.origin.filter(|_| item.outstanding == 0) else { continue };
            item.origin = None;
            let list = item.united(&mut self.sets.unions);
            let batch = answers.entry(to).or_default();
            batch.slots.push(slot);
            batch.counts.push(list.len() as u32);
            for n in list {
                self.table.export(n, &mut batch.points);
            }
            item.point = u32::MAX;
        }
        for (to, batch) in answers {
            self.out.send(to, NodeId::ROOT, 0, Body::Lists(batch));
        }
    }

    fn take_lists(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Lists(batch) => {
                received.push(std::mem::take(batch));
                false
            }
            _ => true,
        });
        if received.is_empty() {
            return;
        }
        for batch in received {
            let numbers = self.table.intern_all(&batch.points);
            let mut at = 0;
            for (&slot, &count) in batch.slots.iter().zip(&batch.counts.0) {
                let end = at + count as usize;
                let (item, node) = self.sets.sent[slot as usize];
                let item = &mut self.sets.items[item as usize];
                item.returned.push((node, numbers[at..end].to_vec()));
                item.outstanding -= 1;
                at = end;
            }
        }
        self.answer_items();
    }

    /// The union of what the leaves found, as the home points' graph neighbours.
    pub(crate) fn finish_set_recursion(&mut self) {
        for (node, sweep) in std::mem::take(&mut self.sets.replicated) {
            let mut cost = Cost::ZERO;
            let items = sweep.items();
            cost.swept(sweep);
            self.ledger.charge(Phase::Sets, node, cost, items);
        }
        let mut unions = std::mem::take(&mut self.sets.unions);
        let items = std::mem::take(&mut self.sets.items);
        let homes = items.into_iter().take(self.table.home as usize);
        self.adjacency = homes.map(|mut item| item.united(&mut unions)).collect();
        for (node, cost) in unions {
            self.ledger.charge(Phase::Sets, node, cost, 0);
        }
        self.sets.sent = Vec::new();
    }
}

/// Does a member go to child `to`, under the leader's decision?
fn goes_to(to: usize, side: usize, crosses: bool, decision: u8) -> bool {
    to == side || (crosses && (decision == 1 || usize::from(decision) == 2 + side))
}

/// The neighbours of a point in both children's graphs, multiple edges deleted: an item of the vector step over
/// the points that both children have.
fn unite(mut list: Vec<u32>, other: Vec<u32>, all: &mut Cost) -> Vec<u32> {
    list.extend(other);
    let mut own = Cost::ZERO;
    own.distinct_inside(&mut list, Ord::cmp);
    all.beside(own);
    list
}

impl Item {
    fn new(point: u32, origin: Option<(Rank, u32)>) -> Self {
        Item { point, origin, outstanding: 1, own: None, returned: Vec::new() }
    }

    /// Its neighbours in the set's graph: the lists of its way, united node by node from the lowest up.
    fn united(&mut self, unions: &mut BTreeMap<NodeId, Cost>) -> Vec<u32> {
        let mut lists = std::mem::take(&mut self.returned);
        lists.sort_by_key(|(node, _)| std::cmp::Reverse(node.level()));
        let mut all = self.own.take();
        for (node, list) in lists {
            all = Some(match all {
                Some(below) => unite(below, list, unions.entry(node).or_default()),
                None => list,
            });
        }
        all.unwrap_or_default()
    }
}
