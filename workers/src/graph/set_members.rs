//! The members of separator sets on a rank: points, the ranks that sent them, and the neighbours found for them.
//!
//! **Statement** (paper, Section 4.3, step 5). The graph of a set is the union of the graphs of its children, without
//! multiple edges. A member that came from another rank returns its list to that rank, once all searches for its neighbours
//! are complete. So the list of an owned point is complete when the phase ends.
//!
//! **Work and depth.** For a set in which all pairs are compared, a sort and O(1) steps. At each node, one vector step
//! whose lanes sort the lists of the members in both children.

use std::collections::BTreeMap;
use std::ops::Range;

use septet_geometry::cost::{Cost, Lanes};
use septet_geometry::graph::{Supergraph, graph_direct};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::separator::{Separator, Side};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, ListBatch, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::Fault;
use crate::graph::own_steps::SetTree;
use crate::graph::sharing::Place;
use crate::machine::context::Context;
use crate::state::table::Table;

/// The members of sets on a rank.
pub(crate) struct SetMembers<'a, P> {
    table: &'a mut Table<P>,
    supergraph: Supergraph,
    tree: SetTree,
    /// A planted fault, which may change the separator sets.
    fault: Option<Fault>,
    items: Vec<SetItem>,
    /// The items that were sent. A returned list names its item by its index here.
    sent: Vec<SentItem>,
    /// For each node, the cost of uniting the lists of its children.
    unions: Unions,
    /// Node and id of each member of the sets in which this rank compared all pairs, if the run keeps them.
    sets: Vec<[u64; 2]>,
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
pub(crate) struct ItemBatch<P> {
    pub(crate) points: PointBatch<P>,
    /// For each item, the sender's index.
    pub(crate) slots: Vec<u32>,
}

/// Items that leave this rank, by node and receiver.
pub(crate) type Leaving<P> = BTreeMap<Receiver, ItemBatch<P>>;

/// A node, and the rank to which its members go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Receiver {
    pub(crate) node: NodeId,
    pub(crate) rank: Rank,
}

/// For each node, the vector step that unites the lists of its children.
struct Unions {
    /// An empty meter.
    meter: Cost,
    of_nodes: BTreeMap<NodeId, Lanes>,
}

impl<'a, P: Point> SetMembers<'a, P> {
    /// Starts with the owned points.
    pub(crate) fn of_owned(
        cx: &Context<P>,
        table: &'a mut Table<P>,
        supergraph: Supergraph,
        tree: SetTree,
    ) -> Self {
        SetMembers {
            tree,
            items: table.owned().map(|point| SetItem::new(point, None)).collect(),
            table,
            supergraph,
            fault: cx.config().fault,
            sent: Vec::new(),
            unions: Unions { meter: cx.own_cost(), of_nodes: BTreeMap::new() },
            sets: Vec::new(),
        }
    }

    /// Returns the items of the owned points.
    pub(crate) fn owned(&self) -> Vec<u32> {
        self.table.owned().collect()
    }

    /// Returns the positions of items.
    pub(crate) fn positions(&self, members: &[u32]) -> Vec<P> {
        members.iter().map(|&i| self.table.positions()[self.items[i as usize].point as usize]).collect()
    }

    /// Records that the search for the neighbours of an item ends on this rank.
    pub(crate) fn release(&mut self, item: u32) {
        self.items[item as usize].outstanding -= 1;
    }

    /// Receives items of another rank. Returns their numbers.
    pub(crate) fn receive(&mut self, rank: Rank, ItemBatch { points, slots }: ItemBatch<P>) -> Range<u32> {
        let indices = self.table.intern_all(&points);
        let first = self.items.len() as u32;
        let new = indices.iter().zip(slots);
        self.items.extend(new.map(|(&point, slot)| SetItem::new(point, Some(Origin { rank, slot }))));
        first..self.items.len() as u32
    }

    /// Stores the lists of the members of a set that this rank holds alone, and returns the lists of other ranks' items
    /// to them.
    pub(crate) fn complete(&mut self, cx: &mut Context<P>, members: &[u32], lists: Vec<Vec<u32>>) {
        for (&item, list) in members.iter().zip(lists) {
            self.items[item as usize].own = Some(list);
        }
        self.return_lists(cx);
    }

    /// Returns the side of an item at a separator, and whether its ball crosses the separator.
    pub(crate) fn place(&self, separator: &Separator<P>, item: u32) -> Place {
        let point = self.items[item as usize].point as usize;
        let (x, radius2) = (self.table.positions()[point], self.table.radii2()[point]);
        let radius = self.fault.map_or(1.0, Fault::spread) * self.supergraph.separator_radius(radius2);
        let is_removed = self.fault.is_some_and(|fault| fault.removes(x));
        let side = usize::from(separator.side(x) == Side::Exterior);
        Place { side, crosses: !is_removed && separator.crosses(x, radius) }
    }

    /// Counts the members on each side, and the members on each side whose balls cross the separator. A copy-scan copies
    /// the separator to every member.
    pub(crate) fn count(&self, separator: &Separator<P>, members: &[u32], cost: &mut Cost) -> [u64; 4] {
        let places = cost.map_with(separator, members, |separator, &i| self.place(separator, i));
        cost.reduce(&places, [0u64; 4], |mut sum, place| {
            sum[place.side] += 1;
            sum[2 + place.side] += u64::from(place.crosses);
            sum
        })
    }

    /// Sends members of a node to the rank that holds the node.
    pub(crate) fn hand_over(&mut self, cx: &mut Context<P>, node: NodeId, holder: Rank, members: Vec<u32>) {
        let mut leaving = Leaving::new();
        for item in members {
            self.send_item(item, node, Receiver { node, rank: holder }, &mut leaving);
            self.items[item as usize].outstanding -= 1;
        }
        send_items(cx, leaving);
    }

    /// Sends an item that is a member of `node` to a receiver.
    pub(crate) fn send_item(&mut self, item: u32, node: NodeId, to: Receiver, leaving: &mut Leaving<P>) {
        let ItemBatch { points, slots } = leaving.entry(to).or_default();
        self.table.export(self.items[item as usize].point, points);
        slots.push(self.sent.len() as u32);
        self.sent.push(SentItem { item, node });
        self.items[item as usize].outstanding += 1;
    }

    /// Unites the lists of the members of a node from the lists of its children.
    pub(crate) fn unite(
        &mut self,
        node: NodeId,
        sent: &[[bool; 2]],
        lists: [Vec<Vec<u32>>; 2],
    ) -> Vec<Vec<u32>> {
        let mut lists = lists.map(Vec::into_iter);
        let united = sent.iter().map(|sent| {
            let [a, b] = [0, 1].map(|to| sent[to].then(|| lists[to].next()).flatten());
            match (a, b) {
                (Some(a), Some(b)) => self.unions.unite(node, a, b),
                (a, b) => a.or(b).unwrap_or_default(),
            }
        });
        united.collect()
    }

    /// Finds the neighbours of each member of a set by comparing all pairs.
    pub(crate) fn compare_all(
        &mut self,
        cx: &mut Context<P>,
        node: NodeId,
        members: &[u32],
    ) -> Vec<Vec<u32>> {
        let (positions, radii2) = (self.table.positions(), self.table.radii2());
        let at = |i: u32| positions[self.items[i as usize].point as usize];
        let mut cost = cx.own_cost();
        let mut order: Vec<usize> = (0..members.len()).collect();
        cost.sort(&mut order, |&a, &b| lex_cmp(&at(members[a]), &at(members[b])));
        let points: Vec<u32> = order.iter().map(|&i| self.items[members[i] as usize].point).collect();
        let found = graph_direct(self.supergraph, positions, radii2, &points, &points, &mut cost);
        let pairs = (points.len() * points.len()) as u64;
        cx.charge(self.tree.comparison(node), cost, pairs);
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
    pub(crate) fn take_lists(&mut self, cx: &mut Context<P>) -> Result<(), TransportError> {
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
    pub(crate) fn finish(self, cx: &mut Context<P>) -> (Lists<u32>, Vec<[u64; 2]>) {
        let SetMembers { table, items, mut unions, sets, tree, .. } = self;
        let owned = items.into_iter().take(table.owned_len() as usize);
        let neighbours = owned.map(|mut item| item.united(&mut unions)).collect();
        let Unions { meter, of_nodes } = unions;
        for (node, lanes) in of_nodes {
            let mut cost = meter.fresh();
            cost.run_lanes(lanes);
            cx.charge(tree.union(node), cost, 0);
        }
        (neighbours, sets)
    }
}

/// Sends items to their receivers.
pub(crate) fn send_items<P: Point>(cx: &mut Context<P>, leaving: Leaving<P>) {
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

/// Items that arrive at a node, or the end of this rank's wait for items.
pub(crate) struct Arrival<P> {
    pub(crate) from: Rank,
    pub(crate) node: NodeId,
    pub(crate) batch: ItemBatch<P>,
}

/// Takes the items that arrived in this round, in the order of their senders.
pub(crate) fn taken_items<P: Point>(cx: &mut Context<P>) -> Vec<Arrival<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Items { points, slots } => {
            let (points, slots) = (std::mem::take(points), std::mem::take(&mut slots.0));
            Some(Arrival { from: m.from, node: m.node, batch: ItemBatch { points, slots } })
        }
        _ => None,
    })
}

/// Returns the members of both children of a set, from the children to which each member goes.
pub(crate) fn members_of_children(members: &[u32], sent: &[[bool; 2]]) -> [Vec<u32>; 2] {
    [0, 1].map(|to| members.iter().zip(sent).filter(|(_, sent)| sent[to]).map(|(&item, _)| item).collect())
}

/// Records the size of a set that is divided at these places, and of its parts, in the facts of its node.
pub(crate) fn enter_set<P: Point>(cx: &mut Context<P>, node: NodeId, places: &[Place]) {
    let facts = cx.facts(node);
    facts.members += places.len() as u64;
    facts.set_inside += places.iter().filter(|place| place.side == 0).count() as u64;
    facts.set_crossing += places.iter().filter(|place| place.crosses).count() as u64;
}
