//! The k nearest neighbours of all points: lists within each leaf, then the descent.
//!
//! **Statement.** Graphs of k nearest neighbours (paper, Section 4.5) have the lists as edges. Overlap graphs
//! (Definition 2.2, Section 4.4) have balls that extend to the last points of the lists. A ball starts with the k nearest points of its leaf. Balls much larger than the median ball of their
//! leaf probe first. Then all balls descend with the lists of their own leaves ([`crate::neighbours::descent`]). A
//! probe passes on only the radius that it found. The descent finds the points of the probe again, so each leaf
//! contributes to a list once.
//!
//! **Work and depth.** All pairs of points within each leaf, and the descents. **Rounds.** The rounds of two
//! descents.

use septet_geometry::kd_blocks::KdBlocks;
use septet_geometry::neighbourhood::{NearestLists, nearest_in_blocks};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::config::Fault;
use crate::machine::context::Context;
use crate::neighbours::balls::{all_balls, large_balls};
use crate::neighbours::descent::Descent;
use crate::neighbours::results::CompletedLists;
use crate::neighbours::search::Search;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// A search for the lists of all points: their length, and the phases that pay for the search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ListSearch {
    k: u32,
    /// The search within the leaves.
    leaves: Phase,
    probe: Phase,
    descent: Phase,
}

impl ListSearch {
    /// Returns the search for the lists of a graph of `k` nearest neighbours.
    pub(crate) fn of_graph(k: u32) -> Self {
        ListSearch { k, leaves: Phase::KnnRadii, probe: Phase::KnnProbe, descent: Phase::Knn }
    }

    /// Returns the search for balls that extend to the `k`-th neighbour. Balls to the first neighbour have the same
    /// phases ([`crate::neighbours::balls`]).
    pub(crate) fn of_balls(k: u32) -> Self {
        ListSearch { k, leaves: Phase::Radii, probe: Phase::Probe, descent: Phase::Neighbours }
    }

    /// Returns `true` if the fault sends every ball to every leaf. Balls of overlap graphs have ghosts, which the fault
    /// sends instead.
    fn is_flooded(self, fault: Option<Fault>) -> bool {
        self.descent == Phase::Knn && fault == Some(Fault::Flood)
    }
}

/// Finds the nearest neighbours of each owned point, as many as the search wants. Stores the squared distance of the
/// last one as the squared radius of the point.
pub(crate) async fn nearest_lists<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    lists: ListSearch,
) -> Result<CompletedLists, TransportError> {
    let k = lists.k;
    cx.enter(lists.leaves)?;
    let LeafLists { blocks, nearest } = leaf_lists(cx, subdomain, table, lists);
    while cx.exchange().await? {}

    cx.enter(lists.probe)?;
    let mut radii2: Vec<f64> = nearest.iter().flat_map(|leaf| &leaf.kth2).copied().collect();
    let search = Search { phase: lists.probe, wanted: k, probe: true, own_leaf: false, everywhere: false };
    let mut descent = Descent::new(subdomain, search, &blocks);
    descent.launch(cx, table, &large_balls(subdomain.leaves(), &radii2), Some(&nearest));
    descent.run(cx, table).await?.shrink(&mut radii2);

    cx.enter(lists.descent)?;
    let everywhere = lists.is_flooded(cx.config().fault);
    let search = Search { phase: lists.descent, wanted: k, probe: false, own_leaf: false, everywhere };
    let mut descent = Descent::new(subdomain, search, &blocks);
    descent.launch(cx, table, &all_balls(subdomain.leaves(), &radii2), Some(&nearest));
    drop((radii2, nearest));
    let complete = descent.run(cx, table).await?;
    for nearest in complete.iter() {
        table.owned_radii2_mut()[nearest.point as usize] = nearest.kth2;
    }
    Ok(complete)
}

/// The owned points of each leaf, and their nearest points within it.
struct LeafLists<P: Point> {
    /// The points, in blocks.
    blocks: Vec<KdBlocks<P>>,
    /// For each leaf, the nearest points of each of its points within the leaf.
    nearest: Vec<NearestLists>,
}

/// Finds the nearest points of each owned point within its leaf.
fn leaf_lists<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    lists: ListSearch,
) -> LeafLists<P> {
    let ListSearch { k, leaves: phase, .. } = lists;
    let (site, meter) = (cx.site(), cx.own_cost());
    let results = cx.map(subdomain.leaves(), |leaf| {
        let _span = site.subproblem(phase, leaf.id(), "leaf lists", leaf.owned_len());
        let blocks = KdBlocks::of(&table.positions()[leaf.indices()]);
        let mut cost = meter.fresh();
        let nearest = nearest_in_blocks(&blocks, leaf.start(), k as usize, &mut cost);
        (blocks, nearest, cost)
    });
    let (mut all_blocks, mut all_nearest) = (Vec::new(), Vec::new());
    for (leaf, (blocks, nearest, cost)) in subdomain.leaves().iter().zip(results) {
        cx.charge(Account::member(phase, leaf.id()), cost, leaf.owned_len() * leaf.owned_len());
        all_blocks.push(blocks);
        all_nearest.push(nearest);
    }
    LeafLists { blocks: all_blocks, nearest: all_nearest }
}
