//! Builds the partition tree: shared nodes are split in rounds of messages, the subtree of each worker without
//! messages.
//!
//! **Statement** (paper, Section 4.3, step 2, with `<= ((d+1)/(d+2) + eps) n` for the sides). A random sphere splits
//! the points. Both sides are split in the same way until they are small enough to be leaves. The tree is a function of
//! points, seed and parameters. Samples, spheres and their acceptance do not depend on the number of workers. For
//! `triangulate`, separators bisect the points ([`septet_geometry::separator::draw_bisecting`]).
//!
//! **Rounds.** `4 h` for each attempt at a node, if the tree of its group has height `h`
//! ([`crate::machine::group_tree`]). `h` is 1 for up to 33 members, and 2 for up to 1,057:
//! 1. Members send samples up to the leader.
//! 2. The leader sends the sphere down to the members.
//! 3. Members send counts up to the leader.
//! 4. The leader sends its decision down. Then all members move the points.
//!
//! If `h` is 1, the members send the samples of both children together with the points. Otherwise, the members of each
//! child send them one round later, when the points have arrived. If one rank takes a whole child and `h` is above 1,
//! the points of this child go to the rank in `h` rounds, through a tree. So no rank receives more than 64 messages in a
//! round if the points are in random order.
//!
//! **Work and depth.** O(m) work and O(1) depth for each attempt at a node of `m` points, plus the cost of the draw. At
//! each leaf, a sort of its points.

use septet_geometry::cost::Cost;
use septet_geometry::incremental::insertion_order;
use septet_geometry::point::{Point, lex_cmp};
use septet_geometry::separator::{CurveCube, DrawKey, Separator};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Child, Decision, Message, PointBatch, Route};
use septet_protocol::transport::TransportError;

use crate::config::{Task, WorkerConfig};
use crate::machine::context::Context;
use crate::machine::group_tree::{Gathered, Parts};
use crate::partition::leader::{
    DrawOf, Plan, decide_split, draw, is_leaf, send_plan, separator_of, take_plan, words_of,
};
use crate::partition::levelling;
use crate::partition::local::{Builder, Grown, Sketch, Ungrown};
use crate::partition::parts::{Decided, Samples, SideCounts, Words};
use crate::partition::sides::sides_of;
use crate::state::subdomain::{Group, Shared, Subdomain, Subtree, Unsplit};
use crate::state::table::Table;
use crate::state::tree::{Inner, Leaf, Split, Tree, bounds};

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
    let mut entrance = Entrance::Held;
    while let Some(points) = share.as_mut().filter(|_| !group.is_whole()) {
        let samples = enter(cx, &group, entrance, points, &mut plan).await?;
        let curve = path.last().and_then(|above: &Shared<P>| above.split().separator().curve_cube());
        let ground = MemberShare { points, curve };
        let Some(agreed) = agree(cx, &group, ground, samples, &plan).await? else {
            unsplit = Some(Unsplit { node: group.node, holder: group.child.first });
            break;
        };
        let (points, children) = (std::mem::take(points), agreed.children);
        let (below, kept) = enter_child(cx, &group, agreed, points, &mut path).await?;
        if group.leader == cx.rank() {
            led.push(group);
            send_plan(cx, &group, &children, &plan);
        }
        entrance = Entrance::below(&group);
        (group, share) = (below, Some(kept));
    }
    if let (Some(_), Some(parent)) = (unsplit, path.last_mut()) {
        parent.end_in_leaf(cx.rank());
    }
    if let Some(points) = share.filter(|_| path.is_empty() || unsplit.is_some()) {
        let points = gather_points(cx, &group, &group, points).await?;
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
            owned = Some(if cx.config().by_stars::<P>() {
                let curve = path.last().and_then(|above| above.split().separator().curve_cube());
                grow(cx, group.node, unsplit.is_some(), MemberShare { points: &points, curve })
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

/// The way in which the members of a group get their points and the samples of the first attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Entrance {
    /// The members hold their points.
    Held,
    /// Points arrive in the next round.
    Points,
    /// Points arrive in the next round, and their samples at the leader.
    PointsAndSamples,
}

impl Entrance {
    /// Returns the entrance to the children of a group.
    fn below(group: &Group) -> Self {
        if group.height() > 1 { Entrance::Points } else { Entrance::PointsAndSamples }
    }
}

/// The samples of an attempt, on the leader.
type SamplesOfGroup<P> = Option<Gathered<Samples<P>>>;

/// Receives the points of a member, and on the leader the samples of the first attempt. The leader also receives its
/// plan.
async fn enter<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    entrance: Entrance,
    points: &mut PointBatch<P>,
    plan: &mut Plan,
) -> Result<SamplesOfGroup<P>, TransportError> {
    if entrance != Entrance::Held {
        let round = cx.round();
        // If all points were already in their places, no rank may have sent a message.
        cx.exchange_if(true).await?;
        *points = united(std::mem::take(points), take_moves(cx));
        plan.extend(take_plan(cx));
        if entrance == Entrance::PointsAndSamples {
            cx.record_load(round, points.len());
            if cx.rank() != group.leader {
                return Ok(None);
            }
            let samples = cx.take(|m| Samples::take_from(&mut m.body));
            let all = Samples(samples.into_iter().flat_map(|samples| samples.0).collect());
            return Ok(Some(Gathered { value: all, round }));
        }
    }
    gather_samples(cx, group, 0, points).await
}

/// Sends the samples of all members to the leader.
async fn gather_samples<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    attempt: u32,
    points: &PointBatch<P>,
) -> Result<SamplesOfGroup<P>, TransportError> {
    let samples = samples_of(cx, group, attempt, points);
    cx.record_load(cx.round(), points.len());
    cx.gather(group, attempt, samples).await
}

/// A split that a group agreed on, as one of its members knows it.
struct Agreed<P> {
    /// The groups of the children.
    children: [Child; 2],
    split: Split<P>,
    /// The side of each point of the member's share.
    sides: Vec<u8>,
    /// The member's routes to both children.
    routes: [Route; 2],
}

/// A member's share of a node, and the cube of the curve that the parent's separator cuts, if it cuts one.
struct MemberShare<'a, P> {
    points: &'a PointBatch<P>,
    curve: Option<CurveCube<P>>,
}

/// Makes attempts at a node until its leader accepts a separator or gives up. `samples` are those of the first attempt.
/// Returns `None` if the node is not split.
async fn agree<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    MemberShare { points, curve }: MemberShare<'_, P>,
    mut samples: SamplesOfGroup<P>,
    plan: &Plan,
) -> Result<Option<Agreed<P>>, TransportError> {
    for attempt in 0.. {
        let next = DrawOf { node: group.node, attempt, population: group.child.population, curve };
        let drawn = samples.map(|samples| draw(cx, group, next, samples));
        let words = drawn.as_ref().map(|drawn| Words(words_of(drawn)));
        let Words(words) = cx.distribute(group, attempt, words).await?;
        let (counts, counted) = count_sides(cx, group, &words, points);
        let counts = cx.gather(group, attempt, counts).await?;
        let decided =
            drawn.zip(counts).map(|(drawn, counts)| decide_split(cx, group, attempt, drawn, counts, plan));
        let Decided { decision, boxes, mut routes } = cx.distribute(group, attempt, decided).await?;
        let routes = routes.pop().unwrap_or_default();
        match (decision, counted, boxes.as_slice()) {
            (Decision::Retry, _, _) => samples = gather_samples(cx, group, attempt + 1, points).await?,
            (Decision::Split(children), Some(CountedSides { separator, sides }), &[a, b, c, d]) => {
                let split = Split::new(separator, [(a, b), (c, d)]);
                return Ok(Some(Agreed { children, split, sides, routes }));
            }
            _ => return Ok(None),
        }
    }
    Ok(None)
}

/// Moves the points to the children's groups, and sends the children's samples unless the children send them
/// ([`Entrance::Points`]). Returns the child's group that contains this rank, and the rank's share of its points.
async fn enter_child<P: Point>(
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
    let mut parts = split_batch(points, &sides, mine, &mut cost);
    cx.charge(Account::member(Phase::Partition, group.node), cost, items);
    for (below, part) in groups.iter().zip(&mut parts).filter(|(below, _)| below.is_whole()) {
        *part = gather_points(cx, group, below, std::mem::take(part)).await?;
    }
    let mut kept = PointBatch::default();
    for (side, points) in parts.into_iter().enumerate() {
        let below = groups[side];
        if below.is_whole() {
            hand_over(cx, &below, points);
            continue;
        }
        if Entrance::below(group) == Entrance::PointsAndSamples {
            let samples = samples_of(cx, &below, 0, &points);
            cx.contribute(&below, 0, samples.into_body());
        }
        let stay = levelling::follow(cx, &below, points, &routes[side])?;
        if side == mine {
            kept = stay;
        }
    }
    path.push(shared);
    Ok((groups[mine], kept))
}

/// Gathers the points of a node that one rank takes at this rank, if many members of `senders` hold them. Returns this
/// rank's points after that.
async fn gather_points<P: Point>(
    cx: &mut Context<P>,
    senders: &Group,
    below: &Group,
    points: PointBatch<P>,
) -> Result<PointBatch<P>, TransportError> {
    if senders.height() <= 1 {
        return Ok(points);
    }
    let tree = Group { node: below.node, leader: below.child.first, ..*senders };
    Ok(cx.gather(&tree, 0, points).await?.map_or_else(PointBatch::default, |gathered| gathered.value))
}

/// Sends this rank's share of a node to the rank that takes the whole node.
fn hand_over<P: Point>(cx: &mut Context<P>, group: &Group, points: PointBatch<P>) {
    // The holder always sends to itself, so it starts even if no other rank has points.
    if !points.is_empty() || group.child.first == cx.rank() {
        cx.send_to((group.node, group.child.first), Body::Move(points));
    }
}

/// Returns the samples in this rank's share of a node.
fn samples_of<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    attempt: u32,
    points: &PointBatch<P>,
) -> Samples<P> {
    let mut cost = cx.shared_cost();
    let key = DrawKey { seed: cx.config().seed, node: group.node.0, attempt };
    let sampler = cx.config().sampler(key, group.child.population);
    let samples = cost.pack(&points.positions, |&x| sampler.accepts(x));
    // Members charge this step both before and after points move, so only the count of the sides states the number of
    // items.
    cx.charge(Account::member(Phase::Partition, group.node), cost, 0);
    Samples(samples)
}

/// A separator, and the sides of a member's points.
struct CountedSides<P> {
    separator: Separator<P>,
    /// The side of each point.
    sides: Vec<u8>,
}

/// Counts this rank's points on both sides of the separator that the leader sent. The second result is `None` if the
/// leader found no separator.
fn count_sides<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    words: &[f64],
    points: &PointBatch<P>,
) -> (SideCounts<P>, Option<CountedSides<P>>) {
    let Some(separator) = separator_of::<P>(words) else { return (SideCounts::none(), None) };
    let mut cost = cx.shared_cost();
    let counted = sides_of(&separator, &points.positions, &mut cost);
    cx.charge(Account::member(Phase::Partition, group.node), cost, points.len() as u64);
    let (inside, outside) = (counted.inside, counted.of.len() as u64 - counted.inside);
    let [a, b] = counted.boxes;
    let counts = SideCounts { inside: vec![inside], outside: vec![outside], boxes: vec![a.0, a.1, b.0, b.1] };
    (counts, Some(CountedSides { separator, sides: counted.of }))
}

fn take_moves<P: Point>(cx: &mut Context<P>) -> Vec<PointBatch<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Move(points) => Some(std::mem::take(points)),
        _ => None,
    })
}

/// The subtree that a rank holds, and its owned points.
type Owned<P> = (Subtree<P>, Table<P>);

/// Splits a node that this rank holds alone, down to the leaves. If the node was `refused` a split while a group shared
/// it, it becomes one leaf.
fn grow<P: Point>(
    cx: &mut Context<P>,
    node: NodeId,
    refused: bool,
    MemberShare { points, curve }: MemberShare<'_, P>,
) -> Owned<P> {
    let builder = Builder { config: cx.config(), site: cx.site(), positions: &points.positions };
    let everyone: Vec<u32> = (0..points.len() as u32).collect();
    let mut grown = Grown::default();
    // The group has already made all attempts at this node.
    if refused {
        grown.leaves.push((node, everyone));
        grown.tree.push(Sketch::Leaf);
    } else {
        grown = builder.grow(Ungrown { node, members: everyone, curve }, cx.pool());
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
    if matches!(cx.config().task, Task::Independent { .. }) {
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
