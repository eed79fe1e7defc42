//! Builds the partition tree: shared nodes are split in rounds of messages, the subtree of each worker without
//! messages.
//!
//! **Statement** (paper, Section 4.3, step 2, with `<= ((d+1)/(d+2) + eps) n` for the sides). A random sphere splits
//! the points. Both sides are split in the same way until they are small enough to be leaves. The tree is a function of
//! points, seed and parameters. Samples, spheres and their acceptance do not depend on the number of workers. For
//! `triangulate`, separators bisect the points ([`septet_geometry::separator::draw_bisecting`]).
//!
//! **Rounds.** Four for each attempt at a level:
//! 1. Members send samples to the leader.
//! 2. The leader sends the sphere to the members.
//! 3. Members send counts to the leader.
//! 4. The leader sends its decision. In the same step, members move the points and send the samples of the children.
//!
//! **Work and depth.** O(m) work and O(1) depth for each attempt at a node of `m` points, plus the cost of the draw. At
//! each leaf, a sort of its points.

use septet_geometry::cost::Cost;
use septet_geometry::incremental::insertion_order;
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::separator::{DrawKey, Separator, Side};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Child, Decision, Message, PointBatch, Route};
use septet_protocol::transport::TransportError;

use crate::config::{Task, WorkerConfig};
use crate::machine::context::Context;
use crate::partition::leader::{Plan, decide_split, draw, is_leaf, separator_of};
use crate::partition::levelling;
use crate::partition::local::{Builder, Grown};
use crate::state::subdomain::{Group, Shared, Subdomain, Subtree, Unsplit};
use crate::state::table::Table;
use crate::state::tree::{Bounds, Inner, Leaf, Split, Tree, bounds};

/// Splits the points of all ranks until each rank has its subdomain. `group` is the group of the root. Returns the
/// subdomain and the table of its points.
///
/// A rank that is not a member of the group, such as the coordinator, waits until the phase ends.
pub(crate) async fn partition<P: Point>(
    cx: &mut Context<P>,
    mut group: Group,
    points: PointBatch<P>,
    mut plan: Plan,
) -> Result<(Subdomain<P>, Table<P>), TransportError> {
    cx.enter(Phase::Partition)?;
    let (mut path, mut led, mut unsplit) = (Vec::new(), Vec::new(), None);
    let mut share = group.members().contains(&cx.rank()).then_some(points);
    if let (Some(points), false) = (&share, group.is_whole()) {
        send_samples(cx, &group, 0, points);
    }
    while let Some(points) = share.as_mut().filter(|_| !group.is_whole()) {
        let Some(agreed) = agree(cx, &group, points, &mut plan).await? else {
            unsplit = Some(Unsplit { node: group.node, holder: group.child.first });
            break;
        };
        led.extend((group.leader == cx.rank()).then_some(group));
        let points = std::mem::take(points);
        let (below, kept) = enter_child(cx, &group, agreed, points, &mut path)?;
        (group, share) = (below, Some(kept));
    }
    if let (Some(_), Some(parent)) = (unsplit, path.last_mut()) {
        parent.end_in_leaf(cx.rank());
    }
    if let Some(points) = share.filter(|_| path.is_empty() || unsplit.is_some()) {
        hand_over(cx, &group, points);
    }
    let mut owned = None;
    loop {
        let round = cx.round();
        if !cx.exchange().await? {
            break;
        }
        let moves = take_moves(cx);
        if !moves.is_empty() {
            let points = united(PointBatch::default(), moves);
            cx.record_load(round, points.len());
            owned = Some(if cx.config().counted {
                grow(cx, group.node, unsplit.is_some(), &points)
            } else {
                keep_whole(cx, group.node, points)
            });
        }
    }
    let (subtree, table) = owned.unzip();
    Ok((Subdomain::new(path, unsplit, subtree, led), table.unwrap_or_default()))
}

/// Creates the group of the root: all workers.
pub(crate) fn root(config: &WorkerConfig, population: u64) -> Group {
    let leaf = is_leaf(config, NodeId::ROOT, population);
    Group::new(NodeId::ROOT, Child { population, first: 1, ranks: config.workers, leaf })
}

/// A split that a group agreed on, as one of its members knows it.
struct Agreed<P> {
    /// The groups of the children.
    children: [Child; 2],
    split: Split<P>,
    /// The side of each point of the member's share.
    sides: Vec<u8>,
    /// The member's routes to both children.
    routes: Box<[Route; 2]>,
}

/// Makes attempts at a node, of four rounds each, until its leader accepts a separator or gives up. The members have
/// already sent their samples for the first attempt. Returns `None` if the node is not split.
async fn agree<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    points: &mut PointBatch<P>,
    plan: &mut Plan,
) -> Result<Option<Agreed<P>>, TransportError> {
    let leads = cx.rank() == group.leader;
    for attempt in 0.. {
        let round = cx.round();
        // The leader receives samples. Before the first attempt, members also receive the points that move to them.
        cx.next_round().await?;
        *points = united(std::mem::take(points), take_moves(cx));
        cx.record_load(round, points.len());
        let drawn = leads.then(|| draw(cx, group, attempt));
        // The members receive the separator.
        cx.next_round().await?;
        let counted = count_sides(cx, group, attempt, points)?;
        // The leader receives the numbers of points on both sides.
        cx.next_round().await?;
        if let Some(drawn) = drawn {
            decide_split(cx, group, attempt, drawn, plan);
        }
        // The members receive the decision.
        cx.next_round().await?;
        plan.extend(take_plan(cx));
        let (decision, boxes, routes) = cx.take_one(|m| match &mut m.body {
            Body::Decision { decision, boxes, routes } => {
                Some((decision.clone(), std::mem::take(&mut boxes.0), std::mem::take(routes)))
            }
            _ => None,
        })?;
        match (decision, counted, boxes.as_slice()) {
            (Decision::Retry, _, _) => send_samples(cx, group, attempt + 1, points),
            (Decision::Split(children), Some(CountedSides { separator, sides }), &[a, b, c, d]) => {
                let split = Split::new(separator, [(a, b), (c, d)]);
                return Ok(Some(Agreed { children, split, sides, routes }));
            }
            _ => return Ok(None),
        }
    }
    Ok(None)
}

/// Moves the points to the children's groups and sends the children's samples. Returns the child's group that contains
/// this rank, and the rank's share of its points.
fn enter_child<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    Agreed { children, split, sides, routes }: Agreed<P>,
    points: PointBatch<P>,
    path: &mut Vec<Shared<P>>,
) -> Result<(Group, PointBatch<P>), TransportError> {
    let rank = cx.rank();
    let groups = [0, 1].map(|side| group.below(side, children[side]));
    let mine = usize::from(!groups[0].members().contains(&rank));
    let shared = Shared::new(*group, split, children, mine, rank);
    let mut cost = cx.shared_cost();
    let items = points.len() as u64;
    let parts = split_batch(points, &sides, mine, &mut cost);
    cx.charge(Account::member(Phase::Partition, group.node), cost, items);
    let mut kept = PointBatch::default();
    for (side, points) in parts.into_iter().enumerate() {
        let below = groups[side];
        if below.is_whole() {
            hand_over(cx, &below, points);
            continue;
        }
        send_samples(cx, &below, 0, &points);
        let stay = levelling::follow(cx, &below, points, &routes[side])?;
        if side == mine {
            kept = stay;
        }
    }
    path.push(shared);
    Ok((groups[mine], kept))
}

/// Sends this rank's share of a node to the rank that takes the whole node.
fn hand_over<P: Point>(cx: &mut Context<P>, group: &Group, points: PointBatch<P>) {
    // The holder always sends to itself, so it starts even if no other rank has points.
    if !points.is_empty() || group.child.first == cx.rank() {
        cx.send_to((group.node, group.child.first), Body::Move(points));
    }
}

/// Sends the samples in this rank's share of a node to the node's leader.
fn send_samples<P: Point>(cx: &mut Context<P>, group: &Group, attempt: u32, points: &PointBatch<P>) {
    let mut cost = cx.shared_cost();
    let key = DrawKey { seed: cx.config().seed, node: group.node.0, attempt };
    let sampler = cx.config().sampler(key, group.child.population);
    let samples = cost.pack(&points.positions, |&x| sampler.accepts(x));
    // Members charge this step both before and after points move, so only the count of the sides states the number of
    // items.
    cx.charge(Account::member(Phase::Partition, group.node), cost, 0);
    cx.contribute(group, attempt, Body::Samples(Bulk(samples)));
}

/// A separator, and the sides of a member's points.
struct CountedSides<P> {
    separator: Separator<P>,
    /// The side of each point.
    sides: Vec<u8>,
}

/// Counts this rank's points on both sides of the separator that the leader sent. Returns `None` if the leader found no
/// separator.
fn count_sides<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    attempt: u32,
    points: &PointBatch<P>,
) -> Result<Option<CountedSides<P>>, TransportError> {
    let words = cx.take_one(|m| match &mut m.body {
        Body::Sphere(words) => Some(std::mem::take(&mut words.0)),
        _ => None,
    })?;
    let Some(separator) = separator_of::<P>(&words) else {
        let body = Body::Counts { inside: 0, outside: 0, boxes: Bulk(Vec::new()) };
        cx.contribute(group, attempt, body);
        return Ok(None);
    };
    let mut cost = cx.shared_cost();
    let counted = sides_of(&separator, &points.positions, &mut cost);
    cx.charge(Account::member(Phase::Partition, group.node), cost, points.len() as u64);
    let (inside, outside) = (counted.inside, counted.of.len() as u64 - counted.inside);
    let [a, b] = counted.boxes;
    let boxes = Bulk(vec![a.0, a.1, b.0, b.1]);
    cx.contribute(group, attempt, Body::Counts { inside, outside, boxes });
    Ok(Some(CountedSides { separator, sides: counted.of }))
}

fn take_moves<P: Point>(cx: &mut Context<P>) -> Vec<PointBatch<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Move(points) => Some(std::mem::take(points)),
        _ => None,
    })
}

fn take_plan<P: Point>(cx: &mut Context<P>) -> Plan {
    let plans = cx.take(|m| match &mut m.body {
        Body::Plan { nodes, leaves } => Some((std::mem::take(&mut nodes.0), std::mem::take(&mut leaves.0))),
        _ => None,
    });
    plans.into_iter().flat_map(|(nodes, leaves)| nodes.into_iter().map(NodeId).zip(leaves)).collect()
}

/// The subtree that a rank holds, and its owned points.
type Owned<P> = (Subtree<P>, Table<P>);

/// Splits a node that this rank holds alone, down to the leaves. If the node was `refused` a split while a group shared
/// it, it becomes one leaf.
fn grow<P: Point>(cx: &mut Context<P>, node: NodeId, refused: bool, points: &PointBatch<P>) -> Owned<P> {
    let builder = Builder { config: cx.config(), site: cx.site(), positions: &points.positions };
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let mut grown = Grown::default();
    // The group has already made all attempts at this node.
    if refused {
        grown.leaves.push((node, everyone));
        grown.tree.push(Sketch::Leaf);
    } else {
        grown = builder.grow(node, everyone, cx.pool());
    }
    let round = cx.round();
    let tally = cx.tally(round);
    for facts in grown.facts.nodes.values() {
        tally.active += u64::from(facts.attempts > 0);
        tally.separators += facts.attempts;
        tally.retries += facts.attempts.saturating_sub(1);
    }
    for (node, cost, items) in std::mem::take(&mut grown.charges) {
        cx.charge(Account::member(Phase::Partition, node), cost, items);
    }
    for (node, facts) in std::mem::take(&mut grown.facts.nodes) {
        cx.facts(node).add(&facts);
    }
    settle(cx, node, points, &grown.leaves, grown.tree)
}

/// Numbers the owned points of a rank that triangulates them as a whole. Points are in insertion order, so neighbours
/// are close in memory.
fn keep_whole<P: Point>(cx: &mut Context<P>, node: NodeId, points: PointBatch<P>) -> Owned<P> {
    let PointBatch { ids: Bulk(mut ids), positions: Bulk(mut positions), .. } = points;
    let order = insertion_order(&positions);
    // `permute` frees its copy, so the points of the triangulation can use that memory.
    permute(&mut ids, &order);
    permute(&mut positions, &order);
    drop(order);
    let bounds = bounds(positions.iter().copied());
    let end = positions.len() as u32;
    cx.facts(node).population = u64::from(end);
    (Subtree::of_leaf(Leaf::new(node, 0..end, bounds)), Table::of_whole(ids, positions, cx.rank()))
}

/// Numbers the owned points leaf by leaf, each leaf in lexicographic order.
fn settle<P: Point>(
    cx: &mut Context<P>,
    node: NodeId,
    points: &PointBatch<P>,
    members: &[(NodeId, Vec<u32>)],
    sketch: Vec<Sketch<P>>,
) -> Owned<P> {
    let mut ids = Vec::with_capacity(points.len());
    let mut positions = Vec::with_capacity(points.len());
    let meter = cx.own_cost();
    let (ordered, costs): (Vec<Vec<u32>>, Vec<Cost>) = cx
        .map(members, |(_, members)| {
            let (mut members, mut cost) = (members.clone(), meter.fresh());
            let at = |i: u32| &points.positions[i as usize];
            cost.sort(&mut members, |&a, &b| lex_cmp(at(a), at(b)));
            (members, cost)
        })
        .into_iter()
        .unzip();
    // If a group has tried to split the leaf, its members have already stated their numbers of points.
    for ((leaf, _), cost) in members.iter().zip(costs) {
        cx.charge(Account::member(Phase::Partition, *leaf), cost, 0);
    }
    let mut leaves = Vec::with_capacity(members.len());
    for ((id, _), members) in members.iter().zip(&ordered) {
        let start = ids.len() as u32;
        ids.extend(members.iter().map(|&i| points.ids[i as usize]));
        positions.extend(members.iter().map(|&i| points.positions[i as usize]));
        let end = ids.len() as u32;
        let bounds = bounds(positions[start as usize..end as usize].iter().copied());
        leaves.push(Leaf::new(*id, start..end, bounds));
        cx.facts(*id).population = u64::from(end - start);
    }
    let mut table = Table::of_owned(ids, positions, cx.rank());
    if cx.config().task != Task::Delaunay {
        for (radius2, &i) in table.owned_radii2_mut().iter_mut().zip(ordered.iter().flatten()) {
            *radius2 = points.radii2[i as usize];
        }
    }
    let (mut inner_ids, mut leaf) = (Vec::new(), 0);
    let tree = raise(node, &mut sketch.into_iter(), &mut inner_ids, &mut leaf);
    (Subtree::new(node, tree, inner_ids, leaves), table)
}

/// Moves `items[order[i]]` to position `i`.
fn permute<T: Copy>(items: &mut [T], order: &[u32]) {
    let permuted: Vec<T> = order.iter().map(|&i| items[i as usize]).collect();
    items.copy_from_slice(&permuted);
}

/// Appends `batches` of points in transit to `own`.
fn united<P: Copy>(mut own: PointBatch<P>, mut batches: Vec<PointBatch<P>>) -> PointBatch<P> {
    if own.is_empty() && !batches.is_empty() {
        own = batches.remove(0);
    }
    let more: usize = batches.iter().map(PointBatch::len).sum();
    if own.positions.capacity() - own.positions.len() < more {
        // An eighth of the points is spare capacity for ghosts.
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

/// The side of each point, the number of points inside the separator, and the boxes of both sides.
pub(crate) struct Sides<P> {
    pub(crate) of: Vec<u8>,
    pub(crate) inside: u64,
    pub(crate) boxes: [Bounds<P>; 2],
}

/// Performs the steps of a member in an attempt. Copies the separator to every point (a copy-scan), computes the side
/// of every point (a vector step), and combines counts and boxes (a scan).
pub(crate) fn sides_of<P: Point>(separator: &Separator<P>, points: &[P], cost: &mut Cost) -> Sides<P> {
    let sides = cost.map_with(separator, points, |s, &x| u8::from(s.side(x) == Side::Exterior));
    let mut inside = 0;
    let empty = bounds(std::iter::empty::<P>());
    let mut side_of = sides.iter();
    let boxes = cost.reduce(points, [empty, empty], |mut boxes, &x| {
        let interior = side_of.next() == Some(&0);
        inside += u64::from(interior);
        for i in 0..P::DIM {
            // Both boxes are updated, one of them with a neutral value, because branches on the side would mispredict.
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

/// Returns the smaller of two numbers, in one instruction.
#[inline]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the larger of two numbers, in one instruction.
#[inline]
fn more(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Splits a batch by the sides of its points. The points on side `stay` remain in the memory of the batch.
fn split_batch<P: Point>(
    mut points: PointBatch<P>,
    sides: &[u8],
    stay: usize,
    cost: &mut Cost,
) -> [PointBatch<P>; 2] {
    let PointBatch { ids, positions, radii2, .. } = &mut points;
    let (ids, positions, radii2) =
        cost.split_arrays(sides, stay as u8, &mut ids.0, &mut positions.0, &mut radii2.0);
    let gone = PointBatch { radii2: Bulk(radii2), ..PointBatch::in_transit(ids, positions) };
    if stay == 0 { [points, gone] } else { [gone, points] }
}

/// A node of a subtree that is listed in preorder.
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
            Tree::Node(Box::new(Inner::new(node, number, *split, [interior, exterior])))
        }
        Some(Sketch::Leaf) | None => {
            *leaf += 1;
            Tree::Leaf(*leaf - 1)
        }
    }
}
