//! The partition tree: shared nodes in rounds of messages, a worker's own piece by itself.
//!
//! **Statement** (paper, Section 4.3, step 2, with `<= ((d+1)/(d+2) + eps) n` for the sides). A random
//! sphere splits the points; both sides are split in the same way, down to the floor. The tree is a
//! function of (points, seed, parameters): which samples are taken, which spheres are drawn and which are
//! accepted does not depend on the number of workers. Where only the answer is wanted separators halve
//! ([`septet_geometry::separator::draw_halves`]).
//!
//! **Rounds.** Four a level: samples to the leader; the sphere to the members; counts to the leader; the
//! verdict to the members, who move the points and send the children's samples in the same step.
//!
//! **Work and depth.** O(m) and O(1) for a node of `m` points and each attempt, plus the draw.

use std::ops::Range;

use septet_geometry::cost::Cost;
use septet_geometry::incremental::insertion_order;
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::separator::{DrawKey, Separator, Side};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::{Body, Child, Message, PointBatch, Verdict};

use crate::config::{Task, WorkerConfig, map_in};
use crate::grow::{Builder, Grown};
use crate::leader::{by_node, is_leaf, separator_of};
use crate::table::Table;
use crate::tree::{Bounds, Inner, Leaf, Shared, Split, Tree, bounds};
use crate::worker::{Holding, Worker};

impl<P: Point> Worker<P> {
    /// Sends the root's samples, or its points where one worker takes it whole.
    pub(crate) fn begin_partition(&mut self) {
        let Some(holding) = self.holdings.get_mut(&NodeId::ROOT) else { return };
        holding.child.leaf = is_leaf(&self.config, NodeId::ROOT, self.population);
        holding.population = self.population;
        let child = holding.child;
        if child.ranks == 1 || child.leaf {
            let points = std::mem::take(&mut holding.points);
            self.holdings.clear();
            self.hand_over(NodeId::ROOT, &child, points);
        } else {
            let leader = septet_protocol::ids::COORDINATOR;
            self.send_samples(NodeId::ROOT, leader, 0);
        }
    }

    fn hand_over(&mut self, node: NodeId, child: &Child, points: PointBatch<P>) {
        // The holder always hears from itself, so that it starts even if nobody else has points.
        if !points.is_empty() || child.first == self.rank {
            self.out.send(child.first, node, 0, Body::Move(points));
        }
    }

    /// The node's samples among this worker's share, to the leader.
    fn send_samples(&mut self, node: NodeId, leader: u32, attempt: u32) {
        let holding = &self.holdings[&node];
        let mut cost = Cost::ZERO;
        let key = DrawKey { seed: self.config.seed, node: node.0, attempt };
        let sampler = self.config.sampler(key, holding.population);
        let samples = cost.pack(&holding.points.positions, |&x| sampler.takes(x));
        // Members before and after a move both charge this step: only the count step states the items.
        self.ledger.charge(Phase::Partition, node, cost, 0);
        self.out.send(leader, node, attempt, Body::Samples(Bulk(samples)));
    }

    pub(crate) fn on_partition(&mut self, inbox: &mut Vec<Message<P>>) {
        self.on_moves(inbox);
        self.lead_partition(inbox);
        let spheres = by_node(inbox, |m| match &mut m.body {
            Body::Sphere(words) => Some((m.from, m.attempt, std::mem::take(&mut words.0))),
            _ => None,
        });
        for (node, sphere) in spheres {
            for (leader, attempt, words) in sphere {
                self.count_sides(node, leader, attempt, &words);
            }
        }
        let decisions = by_node(inbox, |m| match &mut m.body {
            Body::Decision { verdict, boxes } => {
                Some((m.from, verdict.clone(), std::mem::take(&mut boxes.0)))
            }
            _ => None,
        });
        for (node, all) in decisions {
            for (leader, verdict, boxes) in all {
                self.obey(node, leader, &verdict, &boxes);
            }
        }
    }

    /// Points that arrive at a node: kept as its share, or, if it is this worker's alone, split here.
    fn on_moves(&mut self, inbox: &mut Vec<Message<P>>) {
        let moves = by_node(inbox, |m| match &mut m.body {
            Body::Move(points) => Some(std::mem::take(points)),
            _ => None,
        });
        for (node, batches) in moves {
            let shared = self.holdings.get(&node).is_some_and(|h| h.child.ranks > 1 && !h.child.leaf);
            if shared {
                let Some(holding) = self.holdings.get_mut(&node) else { continue };
                let own = std::mem::take(&mut holding.points);
                holding.points = united(own, batches);
            } else {
                let own = self.holdings.remove(&node).map_or_else(PointBatch::default, |h| h.points);
                self.own(node, united(own, batches));
            }
        }
    }

    fn lead_partition(&mut self, inbox: &mut Vec<Message<P>>) {
        let plans = by_node(inbox, |m| match &mut m.body {
            Body::Plan { nodes, leaves } => {
                Some((std::mem::take(&mut nodes.0), std::mem::take(&mut leaves.0)))
            }
            _ => None,
        });
        for (nodes, leaves) in plans.into_values().flatten() {
            self.leader.plan(&nodes, &leaves);
        }
        lead_partition(inbox, &mut self.leader, &self.config, &mut self.out, &mut self.ledger, self.phase);
    }

    /// Counts this worker's points on either side of a sphere.
    fn count_sides(&mut self, node: NodeId, leader: u32, attempt: u32, words: &[f64]) {
        let Some(holding) = self.holdings.get_mut(&node) else { return };
        let Some(separator) = separator_of::<P>(words) else {
            let body = Body::Counts { inside: 0, outside: 0, boxes: Bulk(Vec::new()) };
            self.out.send(leader, node, attempt, body);
            return;
        };
        let mut cost = Cost::ZERO;
        let counted = sides_of(&separator, &holding.points.positions, &mut cost);
        let items = holding.points.len() as u64;
        self.ledger.charge(Phase::Partition, node, cost, items);
        let (inside, outside) = (counted.inside, counted.of.len() as u64 - counted.inside);
        let [a, b] = counted.boxes;
        holding.sides = counted.of;
        holding.separator = Some(separator);
        let boxes = Bulk(vec![a.0, a.1, b.0, b.1]);
        self.out.send(leader, node, attempt, Body::Counts { inside, outside, boxes });
    }

    fn obey(&mut self, node: NodeId, leader: u32, verdict: &Verdict, boxes: &[P]) {
        let Some(holding) = self.holdings.get_mut(&node) else { return };
        match verdict {
            Verdict::Retry => {
                holding.attempt += 1;
                let attempt = holding.attempt;
                self.send_samples(node, leader, attempt);
            }
            Verdict::Leaf => {
                let points = std::mem::take(&mut holding.points);
                let child = holding.child;
                self.holdings.remove(&node);
                self.relay = Some((node, child.first));
                if let Some(parent) = self.path.last_mut() {
                    parent.children[parent.mine].leaf = true;
                    parent.goes_on = child.first == self.rank;
                }
                self.hand_over(node, &child, points);
            }
            Verdict::Split(children) => self.split(node, leader, *children, boxes),
        }
    }

    /// Moves the points to the children's groups and sends the children's samples.
    fn split(&mut self, node: NodeId, leader: u32, children: [Child; 2], boxes: &[P]) {
        let Some(holding) = self.holdings.remove(&node) else { return };
        let (Some(separator), [a, b, c, d]) = (holding.separator, boxes) else { return };
        let member = |side: usize| {
            let child = &children[side];
            (child.first..child.first + child.ranks).contains(&self.rank)
        };
        let mine = usize::from(!member(0));
        let shared = Shared {
            id: node,
            first: holding.child.first,
            ranks: holding.child.ranks,
            leader,
            split: Split { separator, boxes: [(*a, *b), (*c, *d)] },
            children,
            mine,
            goes_on: !children[mine].leaf || children[mine].first == self.rank,
            summaries: None,
        };
        let mut cost = Cost::ZERO;
        let items = holding.points.len() as u64;
        let parts = split_batch(holding.points, &holding.sides, mine, &mut cost);
        self.ledger.charge(Phase::Partition, node, cost, items);
        for (side, points) in parts.into_iter().enumerate() {
            let (id, child) = (node.child(side), children[side]);
            let whole = child.ranks == 1 || child.leaf;
            let mine = shared.mine == side;
            self.holdings.insert(id, Holding::of(points, child));
            if !whole {
                if child.first == self.rank {
                    self.leader.lead(id, child.population, child.first, child.ranks);
                }
                self.send_samples(id, child.first, 0);
            }
            if whole || !mine {
                let Some(holding) = self.holdings.remove(&id) else { continue };
                let to = shared.member_below(self.rank, side);
                if whole {
                    self.hand_over(id, &child, holding.points);
                } else if !holding.points.is_empty() {
                    self.out.send(to, id, 0, Body::Move(holding.points));
                }
            }
        }
        self.path.push(shared);
    }

    /// Takes a node whole: splits it down to the floor (or not at all, if only the answer is wanted).
    fn own(&mut self, node: NodeId, points: PointBatch<P>) {
        if !self.config.counted {
            self.settle_whole(node, points);
            return;
        }
        let site = self.out.site();
        let builder = Builder { config: &self.config, site, positions: &points.positions };
        let everyone: Vec<u32> = (0..points.len() as u32).collect();
        let mut grown = Grown::default();
        // A node that its group could not split has had all its attempts.
        let refused = self.relay.is_some_and(|(at, _)| at == node);
        if refused {
            grown.leaves.push((node, everyone));
            grown.tree.push(Sketch::Leaf);
        } else {
            grown = builder.grow(node, everyone, &self.pool);
        }
        let round = self.out.round();
        let tally = self.ledger.tally(round, Phase::Partition);
        for facts in grown.facts.nodes.values() {
            tally.active += u64::from(facts.attempts > 0);
            tally.separators += facts.attempts;
            tally.retries += facts.attempts.saturating_sub(1);
        }
        for (node, cost, items) in &grown.charges {
            self.ledger.charge(Phase::Partition, *node, *cost, *items);
        }
        for (node, facts) in std::mem::take(&mut grown.facts.nodes) {
            self.ledger.facts(node).add(&facts);
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.grown(&mut grown, points.len() as u64);
        }
        self.settle(node, &points, &grown.leaves, grown.tree);
    }

    /// Numbers the home points of a worker that triangulates them at once, in the order of insertion: neighbours lie
    /// near each other in memory.
    fn settle_whole(&mut self, node: NodeId, points: PointBatch<P>) {
        let PointBatch { ids: Bulk(mut ids), positions: Bulk(mut positions), .. } = points;
        let order = insertion_order(&positions);
        // The copy is given back, so that the piece's own points find room where it was.
        permute(&mut ids, &order);
        permute(&mut positions, &order);
        drop(order);
        let bounds = bounds(positions.iter().copied());
        let end = positions.len() as u32;
        self.leaves.push(Leaf { id: node, start: 0, end, bounds, max_radius2: 0.0, ghosts: Vec::new() });
        self.ledger.facts(node).population = u64::from(end);
        self.table = Table::of_whole(ids, positions, self.rank);
        self.inner_ids.clear();
        self.tree = Some((node, Tree::Leaf(0)));
    }

    /// Numbers the home points leaf by leaf, each leaf in lexicographic order.
    fn settle(
        &mut self,
        node: NodeId,
        points: &PointBatch<P>,
        leaves: &[(NodeId, Vec<u32>)],
        sketch: Vec<Sketch<P>>,
    ) {
        let mut ids = Vec::with_capacity(points.len());
        let mut positions = Vec::with_capacity(points.len());
        let ordered = map_in(&self.pool, leaves, |(_, members)| {
            let mut members = members.clone();
            members.sort_unstable_by(|&a, &b| {
                lex_cmp(&points.positions[a as usize], &points.positions[b as usize])
            });
            members
        });
        for ((id, _), members) in leaves.iter().zip(&ordered) {
            let start = ids.len() as u32;
            ids.extend(members.iter().map(|&i| points.ids[i as usize]));
            positions.extend(members.iter().map(|&i| points.positions[i as usize]));
            let end = ids.len() as u32;
            let of = |r: Range<u32>| bounds(positions[r.start as usize..r.end as usize].iter().copied());
            self.leaves.push(Leaf {
                id: *id,
                start,
                end,
                bounds: of(start..end),
                max_radius2: 0.0,
                ghosts: Vec::new(),
            });
            self.ledger.facts(*id).population = u64::from(end - start);
        }
        self.table = Table::of_home(ids, positions, self.rank);
        if self.config.task != Task::Delaunay {
            self.table.radii2 = ordered.iter().flatten().map(|&i| points.radii2[i as usize]).collect();
        }
        self.inner_ids.clear();
        let (mut inner, mut leaf) = (Vec::new(), 0);
        let mut sketch = sketch.into_iter();
        let tree = raise(node, &mut sketch, &mut inner, &mut leaf);
        self.inner_ids = inner;
        self.tree = Some((node, tree));
    }
}

/// What a leader (of any rank, the coordinator too) does in the partition phase.
pub fn lead_partition<P: Point>(
    inbox: &mut Vec<Message<P>>,
    leader: &mut crate::leader::Leader<P>,
    config: &WorkerConfig,
    out: &mut crate::outbox::Outbox<P>,
    ledger: &mut LedgerPart,
    phase: Phase,
) {
    let samples = by_node(inbox, |m| match &mut m.body {
        Body::Samples(points) => Some((m.round, std::mem::take(&mut points.0))),
        _ => None,
    });
    for (node, parts) in samples {
        let round = parts.first().map_or(0, |p| p.0);
        let all = parts.into_iter().flat_map(|p| p.1).collect();
        let tally = ledger.tally(round, phase);
        tally.active += 1;
        tally.separators += 1;
        leader.on_samples(node, all, config, out, ledger);
    }
    let counts = by_node(inbox, |m| match &mut m.body {
        Body::Counts { inside, outside, boxes } => {
            Some((m.round, m.attempt, (*inside, *outside, std::mem::take(&mut boxes.0))))
        }
        _ => None,
    });
    for (node, parts) in counts {
        let (round, attempt) = parts.first().map_or((0, 0), |p| (p.0, p.1));
        let all: Vec<_> = parts.into_iter().map(|p| p.2).collect();
        let tally = ledger.tally(round, phase);
        tally.retries += u64::from(attempt > 0);
        leader.on_counts(node, &all, config, out, ledger);
    }
}

/// Puts `items[order[i]]` to place `i`.
fn permute<T: Copy>(items: &mut [T], order: &[u32]) {
    let permuted: Vec<T> = order.iter().map(|&i| items[i as usize]).collect();
    items.copy_from_slice(&permuted);
}

/// Points on their way home, in one batch.
fn united<P: Copy>(mut own: PointBatch<P>, mut batches: Vec<PointBatch<P>>) -> PointBatch<P> {
    if own.is_empty() && !batches.is_empty() {
        own = batches.remove(0);
    }
    let more: usize = batches.iter().map(PointBatch::len).sum();
    if own.positions.capacity() - own.positions.len() < more {
        // It has to grow: with room for others' points near the border.
        let room = more + (own.len() + more) / 8;
        own.ids.reserve_exact(room);
        own.positions.reserve_exact(room);
    }
    for mut batch in batches {
        own.ids.append(&mut batch.ids);
        own.positions.append(&mut batch.positions);
        own.radii2.append(&mut batch.radii2);
    }
    own
}

/// Sides of points, how many lie inside, and the boxes of either side.
pub(crate) struct Sides<P> {
    pub(crate) of: Vec<u8>,
    pub(crate) inside: u64,
    pub(crate) boxes: [Bounds<P>; 2],
}

/// The member's steps of an attempt: the separator to every point (a copy-scan), the side of every point
/// (a vector step), counts and boxes (a scan).
pub(crate) fn sides_of<P: Point>(separator: &Separator<P>, points: &[P], cost: &mut Cost) -> Sides<P> {
    let sides = cost.map_with(separator, points, |s, &x| u8::from(s.side(x) == Side::Exterior));
    let mut inside = 0;
    let empty = bounds(std::iter::empty::<P>());
    let mut side_of = sides.iter();
    let boxes = cost.reduce(points, [empty, empty], |mut boxes, &x| {
        let interior = side_of.next() == Some(&0);
        inside += u64::from(interior);
        for i in 0..P::DIM {
            // Both boxes at once, one of them with what changes nothing: the sides of points are not foreseeable.
            let at = x.coord(i);
            let [(low, high), (far_low, far_high)] = &mut boxes;
            low.set_coord(i, less(low.coord(i), if interior { at } else { f64::INFINITY }));
            high.set_coord(i, more(high.coord(i), if interior { at } else { f64::NEG_INFINITY }));
            far_low.set_coord(i, less(far_low.coord(i), if interior { f64::INFINITY } else { at }));
            far_high.set_coord(i, more(far_high.coord(i), if interior { f64::NEG_INFINITY } else { at }));
        }
        boxes
    });
    Sides { of: sides, inside, boxes }
}

/// The lesser of two numbers: one instruction.
#[inline]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers.
#[inline]
fn more(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Both sides of a batch; those that stay keep its storage.
fn split_batch<P: Point>(
    mut points: PointBatch<P>,
    sides: &[u8],
    stay: usize,
    cost: &mut Cost,
) -> [PointBatch<P>; 2] {
    let columns = (&mut points.ids.0, &mut points.positions.0, &mut points.radii2.0);
    let (ids, positions, radii2) = cost.split_columns(sides, stay as u8, columns);
    let gone = PointBatch { radii2: Bulk(radii2), ..PointBatch::homeless(ids, positions) };
    if stay == 0 { [points, gone] } else { [gone, points] }
}

/// A subtree in preorder.
pub(crate) enum Sketch<P> {
    Leaf,
    Inner(Box<Split<P>>),
}

fn raise<P: Point>(
    node: NodeId,
    sketch: &mut impl Iterator<Item = Sketch<P>>,
    inner: &mut Vec<NodeId>,
    leaf: &mut usize,
) -> Tree<P> {
    match sketch.next() {
        Some(Sketch::Inner(split)) => {
            let number = inner.len();
            inner.push(node);
            let interior = raise(node.child(0), sketch, inner, leaf);
            let exterior = raise(node.child(1), sketch, inner, leaf);
            Tree::Node(Box::new(Inner {
                id: node,
                number,
                split: *split,
                children: [interior, exterior],
                max_radius2: [f64::INFINITY; 2],
                smallest: [0; 2],
            }))
        }
        Some(Sketch::Leaf) | None => {
            *leaf += 1;
            Tree::Leaf(*leaf - 1)
        }
    }
}
