//! The regions of all workers, which `triangulate` needs to send a point directly to every worker that needs it.
//!
//! **Statement.** The *region* of a worker lies on its side of every separator on its path from the root. Every worker
//! knows the splits on its own path. From the end of the path upwards, the groups of both children of a node exchange the
//! splits below the children. At the root, every worker has all splits, so it can find all workers whose regions a ball
//! reaches.
//!
//! **Rounds.** At most one for each level at which a child is shared: `h - 1` if `2^h` workers are halved `h` times.
//!
//! **Work and memory.** O(p) on each of `p` workers, which also sends and receives O(p) bytes: 180 bytes per split on the
//! wire and about 240 in memory, in space. This is not charged. p4est, which runs on hundreds of thousands of processes,
//! also stores the partition on each of them (Burstedde, Wilcox and Ghattas, "p4est: scalable algorithms for parallel
//! adaptive mesh refinement on forests of octrees", 2011). The alternative, forwarding points along the path, needs
//! O(log p) memory, but sends each ghost several times. If one leader sent all splits to all workers, it would send far
//! more than any other worker.

use std::collections::BTreeMap;
use std::ops::Range;

use septet_geometry::point::Point;
use septet_geometry::separator::Separator;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Child, SplitBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::state::subdomain::{Shared, Subdomain};
use crate::state::tree::Split;

/// The regions of all other workers, as a worker sees them from its path.
#[derive(Debug)]
pub(super) struct Regions<P> {
    /// For each node of the path, the regions on the other side of its separator.
    beyond: Vec<Region<P>>,
}

/// A part of the partition tree.
#[derive(Debug)]
enum Region<P> {
    /// The region of one worker.
    Worker(Rank),
    /// The regions inside and outside of a separator.
    Split(Box<(Split<P>, [Region<P>; 2])>),
}

/// The split of a shared node, and the number of ranks of its interior child.
struct SplitRow<P> {
    split: Split<P>,
    interior: u32,
}

/// Returns the regions of all other workers. Enters phase `halo` again, because the last exchange delivers no message.
///
/// # Errors
/// Fails if the splits do not form a tree. See [`Context::exchange`] for other errors.
pub(super) async fn exchange_splits<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
) -> Result<Regions<P>, TransportError> {
    let mut own = SplitExchange::new(subdomain);
    own.advance(cx)?;
    while cx.exchange().await? {
        own.receive(cx)?;
        own.advance(cx)?;
    }
    cx.enter(Phase::Halo)?;
    own.finish(cx.rank())
}

/// A worker's part in the exchange of splits, in which it goes up its path.
struct SplitExchange<'a, P> {
    subdomain: &'a Subdomain<P>,
    /// The nodes of the path above the known subtree.
    above: &'a [Shared<P>],
    /// Whether the other child's group has been sent the known splits.
    is_sent: bool,
    /// All splits below the node at the end of `above`, on this worker's side.
    known: SplitBatch<P>,
    /// Splits that arrived and are not used, by the child whose subtree has them, with their sender.
    arrived: BTreeMap<NodeId, (Rank, SplitBatch<P>)>,
    /// The regions beyond the nodes that are done, last node of the path first.
    beyond: Vec<Region<P>>,
}

impl<'a, P: Point> SplitExchange<'a, P> {
    fn new(subdomain: &'a Subdomain<P>) -> Self {
        let (known, arrived) = (SplitBatch::default(), BTreeMap::new());
        SplitExchange {
            subdomain,
            above: subdomain.path(),
            is_sent: false,
            known,
            arrived,
            beyond: Vec::new(),
        }
    }

    /// Goes up to the first node whose other child's splits have not arrived. Sends the known splits on the way.
    fn advance(&mut self, cx: &mut Context<P>) -> Result<(), TransportError> {
        while let Some((shared, above)) = self.above.split_last() {
            let [own, other] = [shared.mine(), 1 - shared.mine()].map(|side| shared.children()[side]);
            let (own_node, other_node) =
                (shared.id().child(shared.mine()), shared.id().child(1 - shared.mine()));
            // The other group does not know whether this group could split its node.
            let could_be_split =
                !own.leaf || self.subdomain.unsplit().is_some_and(|end| end.node == own_node);
            if !self.is_sent && own.ranks > 1 && could_be_split {
                let receivers = receivers(own, other, cx.rank());
                cx.route(receivers.map(|rank| ((own_node, rank), Body::Splits(self.known.clone()))));
            }
            self.is_sent = true;
            let (from, splits) = if other.ranks > 1 && !other.leaf {
                let Some(arrived) = self.arrived.remove(&other_node) else { return Ok(()) };
                arrived
            } else {
                (cx.rank(), SplitBatch::default())
            };
            let region = whole_region(&splits, other_node, other).ok_or_else(|| no_tree(from))?;
            self.beyond.push(region);
            self.known.append(splits);
            push_split(&mut self.known, shared);
            (self.above, self.is_sent) = (above, false);
        }
        Ok(())
    }

    /// Takes the splits that arrived in a round.
    fn receive(&mut self, cx: &mut Context<P>) -> Result<(), TransportError> {
        let batches = cx.take(|m| match &mut m.body {
            Body::Splits(splits) => Some((m.node, m.from, std::mem::take(splits))),
            _ => None,
        });
        for (node, from, splits) in batches {
            if self.arrived.insert(node, (from, splits)).is_some() {
                return Err(no_tree(from));
            }
        }
        Ok(())
    }

    /// Returns the regions beyond all nodes of the path.
    fn finish(mut self, own: Rank) -> Result<Regions<P>, TransportError> {
        if let Some((from, _)) = self.arrived.into_values().next() {
            return Err(no_tree(from));
        }
        if !self.above.is_empty() {
            let reason = "the splits of a shared node are missing".to_string();
            return Err(TransportError::WorkerFailed { rank: own, reason });
        }
        self.beyond.reverse();
        Ok(Regions { beyond: self.beyond })
    }
}

/// Returns the members of a child's group to which a member of the other child's group sends. Every member of `to` receives
/// from one member of `from`. A rank outside of `from`, which only a corrupt message can cause, sends to none.
fn receivers(from: Child, to: Child, rank: Rank) -> Range<Rank> {
    let Some(at) = rank.checked_sub(from.first).filter(|&at| at < from.ranks) else { return 0..0 };
    let at = u64::from(at);
    let bound = |at: u64| (at * u64::from(to.ranks)).div_ceil(u64::from(from.ranks)) as u32;
    to.first + bound(at)..to.first + bound(at + 1)
}

fn no_tree(from: Rank) -> TransportError {
    let reason = "its splits of shared nodes do not form a tree".to_string();
    TransportError::BadMessage { from, reason }
}

/// Appends the split of a shared node.
fn push_split<P: Point>(batch: &mut SplitBatch<P>, shared: &Shared<P>) {
    let [(a, b), (c, d)] = *shared.split().boxes();
    batch.nodes.push(shared.id().0);
    batch.interior.push(shared.children()[0].ranks);
    batch.separators.extend_from_slice(shared.split().separator().to_array().as_ref());
    batch.boxes.extend_from_slice(&[a, b, c, d]);
}

impl<P: Point> Regions<P> {
    /// Calls `f` with every worker beyond the separator of a level of the path whose region an item reaches. `reaches`
    /// returns whether the item may reach points on a side of a split. The item reaches the other side of that level.
    pub(super) fn each_reached(
        &self,
        level: usize,
        reaches: &impl Fn(&Split<P>, usize) -> bool,
        f: &mut impl FnMut(Rank),
    ) {
        self.beyond[level].each_reached(reaches, f);
    }
}

impl<P: Point> Region<P> {
    fn each_reached(&self, reaches: &impl Fn(&Split<P>, usize) -> bool, f: &mut impl FnMut(Rank)) {
        match self {
            Region::Worker(rank) => f(*rank),
            Region::Split(inner) => {
                let (split, children) = &**inner;
                let reached = (0..2).filter(|&side| reaches(split, side));
                reached.for_each(|side| children[side].each_reached(reaches, f));
            }
        }
    }
}

/// Returns the rows of a batch by node. Returns `None` if a separator has no surface, a column is too short, or a node
/// occurs twice.
fn rows_of<P: Point>(splits: &SplitBatch<P>) -> Option<BTreeMap<NodeId, SplitRow<P>>> {
    let mut words = splits.separators.chunks_exact(Separator::<P>::WORDS);
    let mut corners = splits.boxes.as_chunks::<4>().0.iter();
    let mut rows = BTreeMap::new();
    for (&node, &interior) in splits.nodes.iter().zip(&splits.interior.0) {
        let &[a, b, c, d] = corners.next()?;
        let split = Split::new(Separator::from_array(words.next()?)?, [(a, b), (c, d)]);
        if rows.insert(NodeId(node), SplitRow { split, interior }).is_some() {
            return None;
        }
    }
    Some(rows)
}

/// Returns the regions of a subtree. Returns `None` if the splits are not those of a tree with this root.
fn whole_region<P: Point>(splits: &SplitBatch<P>, node: NodeId, child: Child) -> Option<Region<P>> {
    let mut rows = rows_of(splits)?;
    region(&mut rows, node, child).filter(|_| rows.is_empty())
}

/// Removes the rows of a subtree from `rows`, and returns its regions. Returns `None` if a child has no ranks, or if the
/// tree is too deep.
fn region<P: Point>(
    rows: &mut BTreeMap<NodeId, SplitRow<P>>,
    node: NodeId,
    child: Child,
) -> Option<Region<P>> {
    // One rank holds a node without a split.
    let Some(SplitRow { split, interior }) = rows.remove(&node) else {
        return Some(Region::Worker(child.first));
    };
    let exterior = child.ranks.checked_sub(interior).filter(|&exterior| exterior > 0 && interior > 0)?;
    if node.level() >= NodeId::DEEPEST {
        return None;
    }
    let inner = Child { ranks: interior, ..child };
    let outer = Child { first: child.first + interior, ranks: exterior, ..child };
    let children = [region(rows, node.child(0), inner)?, region(rows, node.child(1), outer)?];
    Some(Region::Split(Box::new((split, children))))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use septet_geometry::hash::Draw;

    use super::*;

    /// Splits the ranks of a node by alternating planes, down to single ranks. The boxes are unbounded.
    fn split_all(node: NodeId, ranks: u32, draw: &mut Draw, batch: &mut SplitBatch<DVec2>) {
        if ranks < 2 {
            return;
        }
        let axis = node.level() as usize % 2;
        let interior = 1 + draw.below(ranks as usize - 1) as u32;
        batch.nodes.push(node.0);
        batch.interior.push(interior);
        batch.separators.extend_from_slice(&Separator::<DVec2>::plane(axis, draw.unit()).to_array()[..]);
        let [low, high] = [f64::NEG_INFINITY, f64::INFINITY].map(DVec2::splat);
        batch.boxes.extend_from_slice(&[low, high, low, high]);
        split_all(node.child(0), interior, draw, batch);
        split_all(node.child(1), ranks - interior, draw, batch);
    }

    fn whole(ranks: u32) -> Child {
        Child { population: 1, first: 5, ranks, leaf: false }
    }

    fn reached(region: &Region<DVec2>, reaches: impl Fn(&Split<DVec2>, usize) -> bool) -> Vec<Rank> {
        let mut ranks = Vec::new();
        region.each_reached(&reaches, &mut |rank| ranks.push(rank));
        ranks
    }

    #[test]
    fn regions_divide_the_space_among_all_ranks() {
        let mut draw = Draw::new(3);
        for ranks in [1, 2, 3, 8, 33, 100] {
            let mut batch = SplitBatch::default();
            split_all(NodeId::ROOT, ranks, &mut draw, &mut batch);
            let mut rows = rows_of(&batch).unwrap();
            let root = region(&mut rows, NodeId::ROOT, whole(ranks)).unwrap();
            assert!(rows.is_empty());
            assert!(reached(&root, |_, _| true).into_iter().eq(5..5 + ranks));
            assert_eq!(reached(&root, |_, _| false).len(), usize::from(ranks == 1));
            for _ in 0..50 {
                let x: DVec2 = draw.point();
                let own = reached(&root, |split, side| split.side(x) == side);
                assert_eq!(own.len(), 1);
                let near = reached(&root, |split, side| split.reaches(x, 0.01, side));
                assert!(near.contains(&own[0]) && near.is_sorted());
            }
        }
    }

    #[test]
    fn every_member_receives_from_one_member() {
        let child = |first, ranks| Child { population: 1, first, ranks, leaf: false };
        for (a, b) in [(1, 1), (1, 5), (5, 1), (2, 2), (3, 7), (7, 3), (16, 16), (33, 100)] {
            let (from, to) = (child(5, a), child(5 + a, b));
            let all = (0..a).flat_map(|at| receivers(from, to, 5 + at));
            assert!(all.eq(5 + a..5 + a + b), "{a}, {b}");
            assert!([0, 4, 5 + a].iter().all(|&rank| receivers(from, to, rank).is_empty()));
        }
    }

    #[test]
    fn splits_that_form_no_tree_are_refused() {
        let mut batch = SplitBatch::default();
        split_all(NodeId::ROOT, 4, &mut Draw::new(1), &mut batch);
        let regions =
            |batch: &SplitBatch<DVec2>, ranks| whole_region(batch, NodeId::ROOT, whole(ranks)).map(|_| ());
        assert_eq!(regions(&batch, 4), Some(()));
        assert_eq!(regions(&batch, batch.interior[0]), None);
        let mut none = batch.clone();
        none.interior[0] = 0;
        assert_eq!(regions(&none, 4), None);
        let mut zero = batch.clone();
        zero.separators.0.fill(0.0);
        let mut short = batch.clone();
        short.boxes.0.truncate(5);
        let mut twice = batch.clone();
        twice.append(batch.clone());
        let mut renamed = batch;
        renamed.nodes[1] = 1 << 40;
        assert_eq!([zero, short, twice, renamed].map(|batch| regions(&batch, 4)), [None; 4]);
    }
}
