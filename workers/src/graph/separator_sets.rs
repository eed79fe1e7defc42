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
//! children ([`Cost::charge_replication`]). At the bottom, a sort and O(1) steps for all pairs of each set. On the way up,
//! one vector step whose lanes sort the lists of the members in both children.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Lanes};
use septet_geometry::graph::{Supergraph, graph_direct};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, ListBatch, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::{Fault, SetRule};
use crate::graph::sharing::{Crossing, Place, SetStep, SetVotes, Sharing, set_rule};
use crate::machine::context::Context;
use crate::state::subdomain::{Entry, Shared, Subdomain, Way};
use crate::state::table::Table;
use crate::state::tree::{Split, Tree};

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
        recursion.take_lists(cx)?;
    }
    Ok(recursion.finish(cx))
}

/// The origin of an item that another rank sent. The list of the item returns there.
#[derive(Clone, Copy, Debug)]
struct Origin {
    rank: Rank,
    /// The sender's index of the item.
    slot: u32,
}

/// A member of sets on this rank: a point, and the neighbours found for it.
#[derive(Clone, Debug)]
struct SetItem {
    point: u32,
    /// The sender. `None` for an owned point.
    origin: Option<Origin>,
    /// The number of incomplete searches for its neighbours, here and on the ranks to which it was sent.
    outstanding: u32,
    /// Its neighbours in this rank's subtree. `None` before the search is complete.
    own: Option<Vec<u32>>,
    /// The lists that other ranks returned.
    returned: Vec<ReturnedList>,
}

/// A list of neighbours that another rank returned.
#[derive(Clone, Debug)]
struct ReturnedList {
    /// The node from which the item was sent.
    node: NodeId,
    neighbours: Vec<u32>,
}

/// An item that was sent.
#[derive(Clone, Copy, Debug)]
struct SentItem {
    item: u32,
    /// The node from which it was sent.
    node: NodeId,
}

/// Items for one receiver.
#[derive(Default)]
struct ItemBatch<P> {
    points: PointBatch<P>,
    /// For each item, the sender's index.
    slots: Vec<u32>,
}

/// Items that leave this rank, by node and receiver.
type Leaving<P> = BTreeMap<Receiver, ItemBatch<P>>;

/// A node, and the rank to which its members go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Receiver {
    node: NodeId,
    rank: Rank,
}

/// Items that arrive, or the end of this rank's wait for items.
struct Arrival<P> {
    from: Rank,
    node: NodeId,
    batch: ItemBatch<P>,
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
    table: &'a mut Table<P>,
    supergraph: Supergraph,
    rule: SetRule,
    /// A planted fault, which may change the separator sets.
    fault: Option<Fault>,
    agenda: Agenda,
    votes: SetVotes,
    items: Vec<SetItem>,
    /// The items that were sent. A returned list names its item by its index here.
    sent: Vec<SentItem>,
    /// For each node, the cost of uniting the lists of its children.
    unions: Unions,
    /// For each node, the members of its set on this rank.
    members: BTreeMap<NodeId, Vec<u32>>,
    /// Node and id of each member of the sets in which this rank compared all pairs, if the run keeps them.
    sets: Vec<[u64; 2]>,
}

/// For each node, the vector step that unites the lists of its children.
struct Unions {
    /// An empty meter.
    meter: Cost,
    of_nodes: BTreeMap<NodeId, Lanes>,
}

impl<'a, P: Point> Recursion<'a, P> {
    /// Starts with the owned points as members of the root's set.
    fn of_owned(
        cx: &Context<P>,
        subdomain: &'a Subdomain<P>,
        table: &'a mut Table<P>,
        supergraph: Supergraph,
    ) -> Self {
        let items = table.owned().map(|point| SetItem::new(point, None)).collect();
        let root = subdomain.top();
        let members = root.map(|root| (root, table.owned().collect()));
        Recursion {
            subdomain,
            table,
            supergraph,
            rule: set_rule(cx.config().graph.sets, supergraph),
            fault: cx.config().fault,
            agenda: Agenda { ready: root.into_iter().collect(), ..Agenda::default() },
            votes: SetVotes::default(),
            items,
            sent: Vec::new(),
            unions: Unions { meter: cx.own_cost(), of_nodes: BTreeMap::new() },
            members: members.into_iter().collect(),
            sets: Vec::new(),
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

    /// Returns the side of an item at a split, and whether its ball crosses the separator.
    fn place(&self, split: &Split<P>, item: u32) -> Place {
        let point = self.items[item as usize].point as usize;
        let (x, radius2) = (self.table.positions()[point], self.table.radii2()[point]);
        let radius = self.fault.map_or(1.0, Fault::spread) * self.supergraph.separator_radius(radius2);
        let is_removed = self.fault.is_some_and(|fault| fault.removes(x));
        Place { side: split.side(x), crosses: !is_removed && split.separator().crosses(x, radius) }
    }

    /// Counts this rank's share of the set of a shared node, for the leader.
    fn count_set(&mut self, cx: &mut Context<P>, shared: &Shared<P>) {
        let members = self.members.get(&shared.id()).map_or(&[][..], Vec::as_slice);
        let mut cost = cx.shared_cost();
        let sum = self.count_members(shared.split(), members, &mut cost);
        cx.charge(Account::member(Phase::Sets, shared.id()), cost, members.len() as u64);
        self.votes.add(cx, shared.group(), sum, self.step());
    }

    /// Counts the members on each side, and the members on each side whose balls cross the separator. A copy-scan copies
    /// the separator to every member.
    fn count_members(&self, split: &Split<P>, members: &[u32], cost: &mut Cost) -> [u64; 4] {
        let places = cost.map_with(split, members, |split, &i| self.place(split, i));
        cost.reduce(&places, [0u64; 4], |mut sum, place| {
            sum[place.side] += 1;
            sum[2 + place.side] += u64::from(place.crosses);
            sum
        })
    }

    /// Ends the division of a set: sends this rank's share of the set to the lowest rank of the group, which solves it.
    fn stop(&mut self, cx: &mut Context<P>, shared: &Shared<P>, members: Vec<u32>) {
        let (node, holder) = (shared.id(), shared.first());
        if cx.rank() == holder {
            self.agenda.stopped.push(node);
            self.members.insert(node, members);
            self.agenda.waiting.push(node);
        } else {
            self.hand_over(cx, node, holder, members);
        }
    }

    /// Sends members of a node to the rank that holds the node.
    fn hand_over(&mut self, cx: &mut Context<P>, node: NodeId, holder: Rank, members: Vec<u32>) {
        let mut leaving = Leaving::new();
        for item in members {
            self.send_item(item, node, Receiver { node, rank: holder }, &mut leaving);
            self.items[item as usize].outstanding -= 1;
        }
        send_items(cx, leaving);
    }

    /// Divides this rank's share of a set. Items take one step of the path, because the next leader decides first.
    fn divide(&mut self, cx: &mut Context<P>, shared: &Shared<P>, members: &[u32], crossing: Crossing) {
        let (node, subdomain) = (shared.id(), self.subdomain);
        let level = subdomain.position(node);
        let (mut leaving, mut staying) = (Leaving::new(), Vec::new());
        let mut cost = cx.shared_cost();
        let replicated = cost.replicate(members, |&i| self.place(shared.split(), i));
        for (&item, place) in members.iter().zip(replicated) {
            let reached = [0, 1].map(|side| crossing.sends(place, side));
            let stays = shared.follow(reached, |side| {
                let (child, rank) = subdomain.beyond(Way { level, side }, cx.rank());
                self.send_item(item, node, Receiver { node: child, rank }, &mut leaving);
            });
            if stays {
                staying.push(item);
            } else {
                self.items[item as usize].outstanding -= 1;
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

    /// Sends an item that is a member of `node` to a receiver.
    fn send_item(&mut self, item: u32, node: NodeId, to: Receiver, leaving: &mut Leaving<P>) {
        let ItemBatch { points, slots } = leaving.entry(to).or_default();
        self.table.export(self.items[item as usize].point, points);
        slots.push(self.sent.len() as u32);
        self.sent.push(SentItem { item, node });
        self.items[item as usize].outstanding += 1;
    }

    /// Receives members of sets from other ranks. The end of a wait counts as an arrival without points from this rank.
    fn take_items(&mut self, cx: &mut Context<P>) {
        let mut arrivals = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Items { points, slots } => {
                let (points, slots) = (std::mem::take(points), std::mem::take(&mut slots.0));
                Some(Arrival { from: m.from, node: m.node, batch: ItemBatch { points, slots } })
            }
            _ => None,
        });
        let nothing = |node| Arrival { from: cx.rank(), node, batch: ItemBatch::default() };
        arrivals.extend(std::mem::take(&mut self.agenda.waiting).into_iter().map(nothing));
        arrivals.sort_by_key(|arrival| arrival.from);
        for Arrival { from, node, batch: ItemBatch { points, slots } } in arrivals {
            let indices = self.table.intern_all(&points);
            let first = self.items.len() as u32;
            let new = indices.iter().zip(slots);
            let item = |(&point, slot)| SetItem::new(point, Some(Origin { rank: from, slot }));
            self.items.extend(new.map(item));
            let last = self.items.len() as u32;
            self.members.entry(node).or_default().extend(first..last);
            // A relay keeps its items, because their lists return by this rank.
            if let Entry::Relay(holder) = self.subdomain.entry(node, cx.rank()) {
                let members = self.members.remove(&node).unwrap_or_default();
                self.hand_over(cx, node, holder, members);
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
            self.items[item as usize].outstanding -= 1;
        }
        let subdomain = self.subdomain;
        let lists = match subdomain.tree().filter(|_| subdomain.holds(node)) {
            Some(tree) => self.solve(cx, tree, node, &members),
            None => self.solve_direct(cx, node, &members),
        };
        for (&item, list) in members.iter().zip(lists) {
            self.items[item as usize].own = Some(list);
        }
        self.return_lists(cx);
    }

    /// Finds the neighbours of each member of a set by the recursion in this rank's subtree.
    fn solve(&mut self, cx: &mut Context<P>, tree: &Tree<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let Tree::Node(inner) = tree else { return self.solve_direct(cx, node, members) };
        let mut cost = cx.shared_cost();
        let sum = self.count_members(inner.split(), members, &mut cost);
        cx.charge(Account::member(Phase::Sets, node), cost, members.len() as u64);
        let Sharing::Crossing(crossing) = Sharing::decide(sum, self.rule, self.fault) else {
            return self.solve_direct(cx, node, members);
        };
        let mut cost = cx.shared_cost();
        let places = cost.replicate(members, |&i| self.place(inner.split(), i));
        cx.charge(Account::member(Phase::Sets, node), cost, 0);
        let mut children = [Vec::new(), Vec::new()];
        for (&item, &place) in members.iter().zip(&places) {
            for (to, child) in children.iter_mut().enumerate() {
                if crossing.sends(place, to) {
                    child.push(item);
                }
            }
        }
        let [inside, outside] = &children;
        let mut lists = [
            self.solve(cx, &inner.children()[0], node.child(0), inside).into_iter(),
            self.solve(cx, &inner.children()[1], node.child(1), outside).into_iter(),
        ];
        let united = places.into_iter().map(|place| {
            let mut own = [0, 1].map(|to| crossing.sends(place, to).then(|| lists[to].next()).flatten());
            match own.each_mut().map(Option::take) {
                [Some(a), Some(b)] => self.unions.unite(node, a, b),
                [a, b] => a.or(b).unwrap_or_default(),
            }
        });
        united.collect()
    }

    /// Finds the neighbours of each member of a set by comparing all pairs.
    fn solve_direct(&mut self, cx: &mut Context<P>, node: NodeId, members: &[u32]) -> Vec<Vec<u32>> {
        let (positions, radii2) = (self.table.positions(), self.table.radii2());
        let at = |i: u32| positions[self.items[i as usize].point as usize];
        let mut cost = cx.own_cost();
        let mut order: Vec<usize> = (0..members.len()).collect();
        cost.sort(&mut order, |&a, &b| lex_cmp(&at(members[a]), &at(members[b])));
        let points: Vec<u32> = order.iter().map(|&i| self.items[members[i] as usize].point).collect();
        let found = graph_direct(self.supergraph, positions, radii2, &points, &points, &mut cost);
        let pairs = (points.len() * points.len()) as u64;
        cx.charge(Account::member(Phase::Graph, node), cost, pairs);
        cx.facts(node).members += points.len() as u64;
        if cx.config().shown.with_sets {
            self.sets.extend(points.iter().map(|&i| [node.0, self.table.ids()[i as usize]]));
        }
        let mut lists = vec![Vec::new(); members.len()];
        for (i, list) in order.into_iter().zip(found.iter()) {
            lists[i] = list.to_vec();
        }
        lists
    }

    /// Returns complete lists to the senders of their items.
    fn return_lists(&mut self, cx: &mut Context<P>) {
        let mut replies: BTreeMap<Rank, ListBatch<P>> = BTreeMap::new();
        for item in &mut self.items {
            let Some(origin) = item.origin.filter(|_| item.outstanding == 0) else { continue };
            item.origin = None;
            let list = item.united(&mut self.unions);
            let batch = replies.entry(origin.rank).or_default();
            batch.slots.push(origin.slot);
            batch.counts.push(list.len() as u32);
            for n in list {
                self.table.export(n, &mut batch.points);
            }
            item.point = u32::MAX;
        }
        cx.send_each(0, replies.into_iter().map(|(to, batch)| (to, Body::Lists(batch))));
    }

    /// Receives the lists of the items that this rank sent.
    ///
    /// # Errors
    /// Fails if a list is for an item that does not wait for one.
    fn take_lists(&mut self, cx: &mut Context<P>) -> Result<(), TransportError> {
        let received = cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Lists(batch) => Some((m.from, std::mem::take(batch))),
            _ => None,
        });
        if received.is_empty() {
            return Ok(());
        }
        for (from, batch) in received {
            let unsent = || TransportError::BadMessage {
                from,
                reason: "a list is for an item that was not sent".to_string(),
            };
            let neighbours = self.table.intern_all(&batch.points);
            let mut at = 0;
            for (&slot, &count) in batch.slots.iter().zip(&batch.counts.0) {
                let end = at + count as usize;
                let &SentItem { item, node } = self.sent.get(slot as usize).ok_or_else(unsent)?;
                let item = &mut self.items[item as usize];
                item.returned.push(ReturnedList { node, neighbours: neighbours[at..end].to_vec() });
                item.outstanding = item.outstanding.checked_sub(1).ok_or_else(unsent)?;
                at = end;
            }
        }
        self.return_lists(cx);
        Ok(())
    }

    /// Unites the lists of all leaves into the graph neighbours of the owned points, and charges the unions.
    fn finish(self, cx: &mut Context<P>) -> (Lists<u32>, Vec<[u64; 2]>) {
        let Recursion { table, items, mut unions, sets, .. } = self;
        let owned = items.into_iter().take(table.owned_len() as usize);
        let neighbours = owned.map(|mut item| item.united(&mut unions)).collect();
        let Unions { meter, of_nodes } = unions;
        for (node, lanes) in of_nodes {
            let mut cost = meter.fresh();
            cost.run_lanes(lanes);
            cx.charge(Account::member(Phase::Sets, node), cost, 0);
        }
        (neighbours, sets)
    }
}

fn send_items<P: Point>(cx: &mut Context<P>, leaving: Leaving<P>) {
    let body = |ItemBatch { points, slots }| Body::Items { points, slots: Bulk(slots) };
    cx.route(leaving.into_iter().map(|(Receiver { node, rank }, batch)| ((node, rank), body(batch))));
}

impl Unions {
    /// Unites the neighbours of a point in the graphs of both children of a node, without multiple edges. This is one lane
    /// of the vector step over the points of both children.
    fn unite(&mut self, node: NodeId, mut list: Vec<u32>, other: Vec<u32>) -> Vec<u32> {
        list.extend(other);
        let mut own = self.meter.nested();
        own.distinct(&mut list, Ord::cmp);
        self.of_nodes.entry(node).or_insert_with(|| self.meter.lanes()).add(own);
        list
    }
}

impl SetItem {
    /// Creates an item whose neighbours are searched on this rank.
    fn new(point: u32, origin: Option<Origin>) -> Self {
        SetItem { point, origin, outstanding: 1, own: None, returned: Vec::new() }
    }

    /// Unites the lists of the item into its neighbours in the graph of the set, node by node from the lowest up.
    fn united(&mut self, unions: &mut Unions) -> Vec<u32> {
        let mut lists = std::mem::take(&mut self.returned);
        lists.sort_by_key(|list| std::cmp::Reverse(list.node.level()));
        let mut all = self.own.take();
        for ReturnedList { node, neighbours } in lists {
            all = Some(match all {
                Some(below) => unions.unite(node, below, neighbours),
                None => neighbours,
            });
        }
        all.unwrap_or_default()
    }
}
