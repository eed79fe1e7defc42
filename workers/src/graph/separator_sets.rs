//! Separator sets by the paper's recursion, and the union of the graphs it returns.
//!
//! **Statement** (paper, Section 4.3). The set of a node is divided by its separator; the points whose
//! balls cross it, `P_O`, belong to the sets of both children (rule `both`); the graph of the node is the
//! union of the children's graphs, multiple edges deleted. For the density graph the crossing points of one
//! side suffice (rule `smaller`): every edge that crosses has *both* ends in `P_O`. The balls are always the
//! global ones.
//!
//! **Departure.** The recursion follows the separators of the partition tree, which were drawn for the home
//! points alone. It stops where the larger child's set would hold more than 93 % of its parent's; there
//! the graph is found directly.
//!
//! **Rounds.** Three a shared level down (counts, the rule, the points) and one up.
//!
//! **Work and depth.** O(1) steps a level; at the bottom all pairs of a set, O(1) steps.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::{Supergraph, graph_direct};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, ListBatch, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::SetRule;
use crate::graph::sharing::{Crossing, Place, Sharing, counts_of, lead, set_rule};
use crate::machine::context::Context;
use crate::state::subdomain::{Shared, Split, Subdomain, Tree};
use crate::state::table::Table;

/// The graph neighbours of the home points, found in the leaves' sets and united on the way up.
pub(crate) async fn set_recursion<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    supergraph: Supergraph,
) -> Result<Lists<u32>, TransportError> {
    let mut recursion = Recursion::of_owned(cx, subdomain, table, supergraph);
    while cx.exchange_if(recursion.is_pending()).await? {
        recursion.agenda.step += 1;
        lead(cx, &subdomain.led, recursion.rule);
        recursion.take_items(cx);
        recursion.obey(cx);
        recursion.handle_due(cx);
        recursion.take_lists(cx);
    }
    Ok(recursion.finish(cx))
}

/// Which of a sender's items a list belongs to.
#[derive(Clone, Copy, Debug)]
struct Origin {
    rank: Rank,
    /// The sender's name of it.
    slot: u32,
}

/// A member of sets on this rank: a point, and the neighbours found for it.
#[derive(Clone, Debug)]
struct Item {
    point: u32,
    origin: Option<Origin>,
    /// Places where its neighbours are still looked for: here, and where it was sent.
    outstanding: u32,
    /// Its neighbours in this rank's piece, once found.
    own: Option<Vec<u32>>,
    /// Its neighbours below other nodes: where it was sent from, and the list that came back.
    returned: Vec<(NodeId, Vec<u32>)>,
}

/// An item that was sent, and the node that shared it.
#[derive(Clone, Copy, Debug)]
struct Sent {
    item: u32,
    node: NodeId,
}

/// Items that leave, with the sender's names of them, by node and receiver.
type Leaving<P> = BTreeMap<(NodeId, Rank), (PointBatch<P>, Vec<u32>)>;

/// Items that come, or the end of a rank's own wait for them.
struct Arrival<P> {
    from: Rank,
    node: NodeId,
    points: PointBatch<P>,
    slots: Vec<u32>,
}

/// The nodes that a rank handles, and when.
#[derive(Default)]
struct Agenda {
    /// Rounds since the phase began.
    step: u32,
    /// Nodes to count or to solve in this step.
    due: Vec<NodeId>,
    /// Nodes whose members other ranks send in this step: they are handled in the next one.
    waiting: Vec<NodeId>,
    /// Nodes that wait one more step for their members, and the step when the first came.
    delayed: BTreeMap<NodeId, u32>,
    /// Shared nodes that stopped: their set is solved whole here.
    stopped: Vec<NodeId>,
}

/// The recursion as one rank takes part in it. It may lead, count, solve and answer for several nodes in a round.
struct Recursion<'a, P> {
    subdomain: &'a Subdomain<P>,
    table: &'a mut Table<P>,
    supergraph: Supergraph,
    rule: SetRule,
    agenda: Agenda,
    items: Vec<Item>,
    /// A position in it is the name under which the list returns.
    sent: Vec<Sent>,
    /// What uniting lists costs, by the node whose children's they are.
    unions: BTreeMap<NodeId, Cost>,
    /// Members of each node's set on this rank.
    members: BTreeMap<NodeId, Vec<u32>>,
    /// Points that went to both sides of a node.
    replicated: BTreeMap<NodeId, Sweep>,
}

impl<'a, P: Point> Recursion<'a, P> {
    /// Every home point is a member of the root's set.
    fn of_owned(
        cx: &Context<P>,
        subdomain: &'a Subdomain<P>,
        table: &'a mut Table<P>,
        supergraph: Supergraph,
    ) -> Self {
        let items = (0..table.owned).map(|point| Item::new(point, None)).collect();
        let root = subdomain.path.first().map(|s| s.id).or(subdomain.tree.as_ref().map(|t| t.0));
        let members = root.map(|root| (root, (0..table.owned).collect()));
        Recursion {
            subdomain,
            table,
            supergraph,
            rule: set_rule(cx.config.graph.sets, supergraph),
            agenda: Agenda { due: root.into_iter().collect(), ..Agenda::default() },
            items,
            sent: Vec::new(),
            unions: BTreeMap::new(),
            members: members.into_iter().collect(),
            replicated: BTreeMap::new(),
        }
    }

    /// Whether there is a node to handle in the next step.
    fn is_pending(&self) -> bool {
        !self.agenda.due.is_empty() || !self.agenda.waiting.is_empty()
    }

    /// Does what the leaders decided.
    fn obey(&mut self, cx: &mut Context<P>) {
        let mut decisions = cx.take(|m: &mut Message<P>| match m.body {
            Body::SetDecision(decision) => Some((m.node, Sharing::from(decision))),
            _ => None,
        });
        decisions.sort_by_key(|(node, _)| *node);
        let subdomain = self.subdomain;
        for (node, sharing) in decisions {
            let members = self.members.remove(&node).unwrap_or_default();
            let Some(shared) = subdomain.shared(node) else { continue };
            match sharing {
                Sharing::Stop => self.stop(cx, shared, members),
                Sharing::Crossing(crossing) => self.divide(cx, shared, &members, crossing),
            }
        }
    }

    /// Counts or solves the nodes whose members are here.
    fn handle_due(&mut self, cx: &mut Context<P>) {
        let mut due = std::mem::take(&mut self.agenda.due);
        due.sort_unstable();
        due.dedup();
        let subdomain = self.subdomain;
        for node in due {
            match subdomain.shared(node).filter(|_| !self.agenda.stopped.contains(&node)) {
                Some(shared) => self.count_set(cx, shared),
                None => self.solve_set(cx, node),
            }
        }
    }

    /// Side and crossing of a point at a split.
    fn place(&self, split: &Split<P>, item: u32) -> Place {
        let point = self.items[item as usize].point as usize;
        let (x, radius2) = (self.table.positions[point], self.table.radii2[point]);
        let radius = self.supergraph.separator_radius(radius2);
        Place { side: split.side(x), crosses: split.separator.crosses(x, radius) }
    }

    /// Sends the leader of a shared node the counts of this rank's share of the set.
    fn count_set(&mut self, cx: &mut Context<P>, shared: &Shared<P>) {
        let members = self.members.get(&shared.id).map_or(&[][..], Vec::as_slice);
        let mut cost = Cost::ZERO;
        let sum = self.count_members(&shared.split, members, &mut cost);
        cx.charge(Account::member(Phase::Sets, shared.id), cost, members.len() as u64);
        cx.send(shared.leader, shared.id, 0, Body::SetCounts(counts_of(sum)));
    }

    /// How many members are on either side, and how many of these cross.
    fn count_members(&self, split: &Split<P>, members: &[u32], cost: &mut Cost) -> [u64; 4] {
        let places = cost.map(members, |&i| self.place(split, i));
        cost.reduce(&places, [0u64; 4], |mut sum, place| {
            sum[place.side] += 1;
            sum[2 + place.side] += u64::from(place.crosses);
            sum
        })
    }

    /// Hands this rank's share of a set that is not divided to the lowest rank, which solves the set.
    fn stop(&mut self, cx: &mut Context<P>, shared: &Shared<P>, members: Vec<u32>) {
        let (node, holder) = (shared.id, shared.first);
        if cx.rank == holder {
            self.agenda.stopped.push(node);
            self.members.insert(node, members);
            self.agenda.waiting.push(node);
        } else {
            self.hand_over(cx, node, holder, members);
        }
    }

    /// Hands members of a node to the rank that holds it.
    fn hand_over(&mut self, cx: &mut Context<P>, node: NodeId, holder: Rank, members: Vec<u32>) {
        let mut leaving = Leaving::new();
        for item in members {
            self.send_item(item, node, (node, holder), &mut leaving);
            self.items[item as usize].outstanding -= 1;
        }
        send_items(cx, leaving);
    }

    /// Divides this rank's share of a set.
    fn divide(&mut self, cx: &mut Context<P>, shared: &Shared<P>, members: &[u32], crossing: Crossing) {
        let node = shared.id;
        let (mut leaving, mut staying) = (Leaving::new(), Vec::new());
        let mut cost = Cost::ZERO;
        let places = cost.map(members, |&i| self.place(&shared.split, i));
        for (&item, place) in members.iter().zip(places) {
            let mut stays = false;
            for to in (0..2).filter(|&to| crossing.sends(place, to)) {
                if to == shared.mine && shared.goes_on {
                    stays = true;
                } else {
                    let member = shared.member_below(cx.rank, to);
                    self.send_item(item, node, (node.child(to), member), &mut leaving);
                }
            }
            if stays {
                staying.push(item);
            } else {
                self.items[item as usize].outstanding -= 1;
            }
            if place.crosses {
                self.replicated.entry(node).or_default().visit();
            }
        }
        cx.charge(Account::member(Phase::Sets, node), cost, 0);
        let id = node.child(shared.mine);
        self.members.entry(id).or_default().extend(staying);
        let Subdomain { path, relay, tree, .. } = self.subdomain;
        if relay.is_some_and(|(at, _)| at == id)
            || path.last().is_some_and(|last| last.id != node)
            || tree.as_ref().is_some_and(|(root, _)| *root == id)
        {
            self.agenda.waiting.push(id);
        }
        send_items(cx, leaving);
    }

    /// Sends an item from a node to the place below it, or to the rank that holds it.
    fn send_item(&mut self, item: u32, node: NodeId, to: (NodeId, Rank), leaving: &mut Leaving<P>) {
        let (points, slots) = leaving.entry(to).or_default();
        self.table.export(self.items[item as usize].point, points);
        slots.push(self.sent.len() as u32);
        self.sent.push(Sent { item, node });
        self.items[item as usize].outstanding += 1;
    }

    /// Takes the members of nodes' sets that other ranks sent. A wait that is over counts as an arrival without points
    /// from this rank.
    fn take_items(&mut self, cx: &mut Context<P>) {
        let mut arrivals = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Items { points, slots } => {
                let (points, slots) = (std::mem::take(points), std::mem::take(&mut slots.0));
                Some(Arrival { from: m.from, node: m.node, points, slots })
            }
            _ => None,
        });
        let nothing =
            |node| Arrival { from: cx.rank, node, points: PointBatch::default(), slots: Vec::new() };
        arrivals.extend(std::mem::take(&mut self.agenda.waiting).into_iter().map(nothing));
        arrivals.sort_by_key(|arrival| arrival.from);
        for Arrival { from, node, points, slots } in arrivals {
            let numbers = self.table.intern_all(&points);
            let first = self.items.len() as u32;
            let new = numbers.iter().zip(slots);
            self.items.extend(new.map(|(&point, slot)| Item::new(point, Some(Origin { rank: from, slot }))));
            let last = self.items.len() as u32;
            self.members.entry(node).or_default().extend(first..last);
            match self.subdomain.relay {
                Some((at, holder)) if at == node && holder != cx.rank => {
                    let members = self.members.remove(&node).unwrap_or_default();
                    self.hand_over(cx, node, holder, members);
                }
                // The group's other ranks hand on in this step what they were sent as well: wait for it.
                Some((at, _)) if at == node && !self.agenda.delayed.contains_key(&node) => {
                    self.agenda.delayed.insert(node, self.agenda.step);
                    self.agenda.waiting.push(node);
                }
                _ if self.agenda.delayed.get(&node) == Some(&self.agenda.step) => {}
                _ => self.agenda.due.push(node),
            }
        }
    }

    /// Solves the set of a piece that this rank holds whole; answers for items of others.
    fn solve_set(&mut self, cx: &mut Context<P>, node: NodeId) {
        let members = self.members.remove(&node).unwrap_or_default();
        for &item in &members {
            self.items[item as usize].outstanding -= 1;
        }
        let subdomain = self.subdomain;
        let lists = match &subdomain.tree {
            Some((root, tree)) if *root == node => self.solve(cx, tree, node, &members),
            _ => self.solve_direct(cx, node, &members),
        };
        for (&item, list) in members.iter().zip(lists) {
            self.items[item as usize].own = Some(list);
        }
        self.answer_items(cx);
    }

    /// The graph of a set in this rank's piece: the neighbours of each member.
    fn solve(&mut self, cx: &mut Context<P>, tree: &Tree<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let Tree::Node(inner) = tree else { return self.solve_direct(cx, node, members) };
        let mut cost = Cost::ZERO;
        let sum = self.count_members(&inner.split, members, &mut cost);
        cx.charge(Account::member(Phase::Sets, node), cost, members.len() as u64);
        let Sharing::Crossing(crossing) = Sharing::decide(sum, self.rule) else {
            return self.solve_direct(cx, node, members);
        };
        let mut cost = Cost::ZERO;
        let places = cost.map(members, |&i| self.place(&inner.split, i));
        cx.charge(Account::member(Phase::Sets, node), cost, 0);
        let mut children = [Vec::new(), Vec::new()];
        for (&item, &place) in members.iter().zip(&places) {
            for (to, child) in children.iter_mut().enumerate() {
                if crossing.sends(place, to) {
                    child.push(item);
                }
            }
            if place.crosses {
                self.replicated.entry(node).or_default().visit();
            }
        }
        let [inside, outside] = &children;
        let mut lists = [
            self.solve(cx, &inner.children[0], node.child(0), inside).into_iter(),
            self.solve(cx, &inner.children[1], node.child(1), outside).into_iter(),
        ];
        let unions = self.unions.entry(node).or_default();
        let united = places.into_iter().map(|place| {
            let mut own = [0, 1].map(|to| crossing.sends(place, to).then(|| lists[to].next()).flatten());
            match own.each_mut().map(Option::take) {
                [Some(a), Some(b)] => unite(a, b, unions),
                [a, b] => a.or(b).unwrap_or_default(),
            }
        });
        united.collect()
    }

    /// The base case: all pairs.
    fn solve_direct(&mut self, cx: &mut Context<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let Table { positions, radii2, .. } = &*self.table;
        let at = |i: u32| positions[self.items[i as usize].point as usize];
        let mut order: Vec<usize> = (0..members.len()).collect();
        order.sort_unstable_by(|&a, &b| lex_cmp(&at(members[a]), &at(members[b])));
        let points: Vec<u32> = order.iter().map(|&i| self.items[members[i] as usize].point).collect();
        let mut cost = Cost::ZERO;
        let found = graph_direct(self.supergraph, positions, radii2, &points, &points, &mut cost);
        let pairs = (points.len() * points.len()) as u64;
        cx.charge(Account::member(Phase::Graph, node), cost, pairs);
        cx.facts(node).members += points.len() as u64;
        let mut lists = vec![Vec::new(); members.len()];
        for (i, list) in order.into_iter().zip(found.iter()) {
            lists[i] = list.to_vec();
        }
        lists
    }

    /// Lists that are complete go back to where their item came from.
    fn answer_items(&mut self, cx: &mut Context<P>) {
        let mut answers: BTreeMap<Rank, ListBatch<P>> = BTreeMap::new();
        for item in &mut self.items {
            let Some(origin) = item.origin.filter(|_| item.outstanding == 0) else { continue };
            item.origin = None;
            let list = item.united(&mut self.unions);
            let batch = answers.entry(origin.rank).or_default();
            batch.slots.push(origin.slot);
            batch.counts.push(list.len() as u32);
            for n in list {
                self.table.export(n, &mut batch.points);
            }
            item.point = u32::MAX;
        }
        for (to, batch) in answers {
            cx.send(to, NodeId::ROOT, 0, Body::Lists(batch));
        }
    }

    fn take_lists(&mut self, cx: &mut Context<P>) {
        let received = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Lists(batch) => Some(std::mem::take(batch)),
            _ => None,
        });
        if received.is_empty() {
            return;
        }
        for batch in received {
            let numbers = self.table.intern_all(&batch.points);
            let mut at = 0;
            for (&slot, &count) in batch.slots.iter().zip(&batch.counts.0) {
                let end = at + count as usize;
                let Sent { item, node } = self.sent[slot as usize];
                let item = &mut self.items[item as usize];
                item.returned.push((node, numbers[at..end].to_vec()));
                item.outstanding -= 1;
                at = end;
            }
        }
        self.answer_items(cx);
    }

    /// The union of what the leaves found, as the home points' graph neighbours.
    fn finish(self, cx: &mut Context<P>) -> Lists<u32> {
        let Recursion { table, items, mut unions, replicated, .. } = self;
        for (node, sweep) in replicated {
            let mut cost = Cost::ZERO;
            let items = sweep.items();
            cost.swept(sweep);
            cx.charge(Account::member(Phase::Sets, node), cost, items);
        }
        let owned_points = items.into_iter().take(table.owned as usize);
        let neighbours = owned_points.map(|mut item| item.united(&mut unions)).collect();
        for (node, cost) in unions {
            cx.charge(Account::member(Phase::Sets, node), cost, 0);
        }
        neighbours
    }
}

fn send_items<P: Point>(cx: &mut Context<P>, leaving: Leaving<P>) {
    for ((node, to), (points, slots)) in leaving {
        cx.send(to, node, 0, Body::Items { points, slots: Bulk(slots) });
    }
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
    fn new(point: u32, origin: Option<Origin>) -> Self {
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
