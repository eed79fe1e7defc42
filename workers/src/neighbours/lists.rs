//! The k nearest neighbours of all points (Section 4.5): lists inside every leaf, then the descent.
//!
//! **Statement.** A ball starts with the k nearest points of its leaf. Balls much larger than their leaf's median probe
//! first. Then all descend from their own leaf's list: a ball finds again the points that its probe found, so that no
//! leaf answers twice, and keeps only the radius.
//!
//! **Work and depth.** All pairs of a leaf, and the descent's. **Rounds.** Those of two descents.

use septet_geometry::cost::Cost;
use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::neighbourhood::{NearestLists, nearest_in_blocks};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::machine::context::Context;
use crate::neighbours::ask::Ask;
use crate::neighbours::balls::{all_balls, large_balls};
use crate::neighbours::descent::Descent;
use crate::neighbours::results::CompletedLists;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Finds the `k` nearest of every home point; the squared distance of the last becomes the point's squared radius.
pub(crate) async fn nearest_lists<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    k: u32,
) -> Result<CompletedLists, TransportError> {
    cx.enter(Phase::KnnRadii)?;
    let LeafLists { blocks, nearest } = leaf_lists(cx, subdomain, table, k);
    while cx.exchange().await? {}

    cx.enter(Phase::KnnProbe)?;
    let mut radii2: Vec<f64> = nearest.iter().flat_map(|leaf| &leaf.kth2).copied().collect();
    let ask = Ask { phase: Phase::KnnProbe, wanted: k, probe: true, own_leaf: false };
    let mut descent = Descent::new(subdomain, ask, &blocks);
    descent.launch(cx, table, &large_balls(&subdomain.leaves, &radii2), Some(&nearest));
    descent.finish(cx, table).await?.shrink(&mut radii2);

    cx.enter(Phase::Knn)?;
    let ask = Ask { phase: Phase::Knn, wanted: k, probe: false, own_leaf: false };
    let mut descent = Descent::new(subdomain, ask, &blocks);
    descent.launch(cx, table, &all_balls(&subdomain.leaves, &radii2), Some(&nearest));
    drop((radii2, nearest));
    let done = descent.finish(cx, table).await?;
    for (owned, kth2, _) in done.iter() {
        table.radii2[owned as usize] = kth2;
    }
    Ok(done)
}

/// The home points of each leaf.
struct LeafLists<P> {
    /// In blocks.
    blocks: Vec<KdBlocks<P>>,
    /// The `k` nearest of each among them.
    nearest: Vec<NearestLists>,
}

/// Finds the `k` nearest inside every leaf.
fn leaf_lists<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    k: u32,
) -> LeafLists<P> {
    let site = cx.site();
    let results = map_in(&cx.pool, &subdomain.leaves, |leaf| {
        let _span = site.subproblem(Phase::KnnRadii, leaf.id, "leaf lists", leaf.owned_len());
        let blocks = KdBlocks::of(&table.positions[leaf.start as usize..leaf.end as usize]);
        let mut cost = Cost::ZERO;
        let nearest = nearest_in_blocks(&blocks, leaf.start, k as usize, &mut cost);
        (blocks, nearest, cost)
    });
    let (mut all_blocks, mut all_nearest) = (Vec::new(), Vec::new());
    for (leaf, (blocks, nearest, cost)) in subdomain.leaves.iter().zip(results) {
        cx.charge(Account::member(Phase::KnnRadii, leaf.id), cost, leaf.owned_len() * leaf.owned_len());
        all_blocks.push(blocks);
        all_nearest.push(nearest);
    }
    LeafLists { blocks: all_blocks, nearest: all_nearest }
}
