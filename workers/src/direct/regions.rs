//! The regions of all workers, which `triangulate` needs to send a point directly to every worker that needs it.
//!
//! **Statement.** The *region* of a worker lies on its side of every separator on its path from the root. The leaders of
//! the shared nodes send their splits to the leader of the root, which sends all of them to every worker. So a worker can
//! find all workers whose regions a ball reaches.
//!
//! **Rounds.** `2 h`, if the tree of all workers has height `h` ([`crate::machine::group_tree`]). None for two workers,
//! which both know the only split.
//!
//! **Work and memory.** O(p) on each of `p` workers, about 180 bytes per worker in space. This is not charged. p4est, which
//! runs on hundreds of thousands of processes, also stores the partition on each of them (Burstedde, Wilcox and Ghattas,
//! "p4est: scalable algorithms for parallel adaptive mesh refinement on forests of octrees", 2011). The alternative,
//! forwarding points along the path, needs O(log p) memory, but sends each ghost several times.

use std::collections::BTreeMap;

use septet_geometry::point::Point;
use septet_geometry::separator::{SEPARATOR_WORDS, Separator};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Rank};
use septet_protocol::message::{Body, Child, SplitBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::machine::group_tree::{Divided, Joined, Parts};
use crate::state::subdomain::{Group, Subdomain};
use crate::state::tree::Split;

/// The regions of all other workers, as a worker sees them from its path.
#[derive(Debug)]
pub(super) struct Regions<P> {
    /// For each node of the path, the regions on the other side of its separator.
    beyond: Vec<Region<P>>,
}

impl<P> Default for Regions<P> {
    fn default() -> Self {
        Regions { beyond: Vec::new() }
    }
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

/// Returns the regions of all other workers.
///
/// # Errors
/// Fails if the splits do not form a tree. See [`Context::exchange`] for other errors.
pub(super) async fn exchange_splits<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
) -> Result<Regions<P>, TransportError> {
    let Some(root) = subdomain.path().first().map(|shared| *shared.group()) else {
        return Ok(Regions::default());
    };
    let own = Splits(led_splits(subdomain));
    let Splits(all) = if root.child.ranks > 2 { share_splits(cx, &root, own).await? } else { own };
    Regions::of(subdomain, &all).ok_or_else(|| {
        let reason = "the splits of the shared nodes do not form a tree".to_string();
        TransportError::BadMessage { from: root.leader, reason }
    })
}

/// Returns the splits of all members of the group of the root.
async fn share_splits<P: Point>(
    cx: &mut Context<P>,
    root: &Group,
    own: Splits<P>,
) -> Result<Splits<P>, TransportError> {
    let all = cx.gather(root, 0, own).await?.map(|gathered| gathered.value);
    cx.distribute(root, 0, all).await
}

/// Returns the splits of the nodes that this rank leads.
fn led_splits<P: Point>(subdomain: &Subdomain<P>) -> SplitBatch<P> {
    let mut batch = SplitBatch::default();
    for shared in subdomain.led().iter().filter_map(|group| subdomain.shared(group.node)) {
        let [(a, b), (c, d)] = *shared.split().boxes();
        batch.nodes.push(shared.id().0);
        batch.interior.push(shared.children()[0].ranks);
        batch.separators.extend_from_slice(&shared.split().separator().to_array());
        batch.boxes.extend_from_slice(&[a, b, c, d]);
    }
    batch
}

impl<P: Point> Regions<P> {
    /// Finds the regions beyond each node of the path. Returns `None` if the splits do not form a tree.
    fn of(subdomain: &Subdomain<P>, splits: &SplitBatch<P>) -> Option<Self> {
        let mut rows = rows_of(splits)?;
        let beyond = subdomain.path().iter().map(|shared| {
            let side = 1 - shared.mine();
            region(&mut rows, shared.id().child(side), shared.children()[side])
        });
        Some(Regions { beyond: beyond.collect::<Option<_>>()? })
    }

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

/// Returns the rows of a batch by node. Returns `None` if a separator has no surface.
fn rows_of<P: Point>(splits: &SplitBatch<P>) -> Option<BTreeMap<NodeId, SplitRow<P>>> {
    let mut words = splits.separators.chunks_exact(SEPARATOR_WORDS);
    let mut corners = splits.boxes.as_chunks::<4>().0.iter();
    let mut rows = BTreeMap::new();
    for (&node, &interior) in splits.nodes.iter().zip(&splits.interior.0) {
        let &[a, b, c, d] = corners.next()?;
        let words = words.next()?.try_into().ok()?;
        let split = Split::new(Separator::from_array(words)?, [(a, b), (c, d)]);
        rows.insert(NodeId(node), SplitRow { split, interior });
    }
    Some(rows)
}

/// Removes the rows of a subtree from `rows`, and returns its regions. Returns `None` if a child has no ranks.
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
    let inner = Child { ranks: interior, ..child };
    let outer = Child { first: child.first + interior, ranks: exterior, ..child };
    let children = [region(rows, node.child(0), inner)?, region(rows, node.child(1), outer)?];
    Some(Region::Split(Box::new((split, children))))
}

/// The splits of some nodes, which go up and down the tree of all workers.
struct Splits<P>(SplitBatch<P>);

impl<P: Point> Parts<P> for Splits<P> {
    fn into_body(self) -> Body<P> {
        Body::Splits(self.0)
    }

    fn take_from(body: &mut Body<P>) -> Option<Self> {
        let Body::Splits(splits) = body else { return None };
        Some(Splits(std::mem::take(splits)))
    }

    fn fits(&self, _: usize) -> bool {
        true
    }
}

impl<P: Point> Joined<P> for Splits<P> {
    fn append(&mut self, Splits(next): Self) {
        let SplitBatch { nodes: Bulk(mut nodes), interior, separators, boxes } = next;
        self.0.nodes.append(&mut nodes);
        self.0.interior.extend_from_slice(&interior.0);
        self.0.separators.extend_from_slice(&separators.0);
        self.0.boxes.extend_from_slice(&boxes.0);
    }
}

impl<P: Point> Divided<P> for Splits<P> {
    fn split_off(&mut self, _: usize) -> Self {
        Splits(self.0.clone())
    }
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
        batch.separators.extend_from_slice(&Separator::<DVec2>::plane(axis, draw.unit()).to_array());
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
    fn splits_that_form_no_tree_are_refused() {
        let mut batch = SplitBatch::default();
        split_all(NodeId::ROOT, 4, &mut Draw::new(1), &mut batch);
        let regions = |batch: &SplitBatch<DVec2>, ranks| {
            region(&mut rows_of(batch)?, NodeId::ROOT, whole(ranks)).map(|_| ())
        };
        assert_eq!(regions(&batch, 4), Some(()));
        assert_eq!(regions(&batch, batch.interior[0]), None);
        let mut none = batch.clone();
        none.interior[0] = 0;
        assert_eq!(regions(&none, 4), None);
        let mut zero = batch.clone();
        zero.separators.0.fill(0.0);
        let mut short = batch;
        short.boxes.0.truncate(5);
        assert_eq!([regions(&zero, 4), regions(&short, 4)], [None, None]);
    }
}
