//! Nearest-neighbour balls of all points (paper, Section 4.3): radii within each leaf, then the descent.
//!
//! **Statement.** The initial radius of a ball is the distance to the nearest other point of its leaf. A ball much
//! larger than the median ball of its leaf probes first. Then all balls descend. Both steps are defined in
//! [`crate::neighbours::descent`]. The final radius is the distance to the nearest point found. The baseline and the
//! correction in stages correct the balls bottom-up instead ([`crate::neighbours::bottom_up`]).
//!
//! **Pairs.** With `pairs`, the initial radii come from the well-separated pairs of a fair split tree of each leaf
//! ([`crate::neighbours::fair_split`]). Departure: the tree of Callahan and Kosaraju has all points. Here, a pair of points
//! in different leaves is not in a pair of nodes. The balls of both points find it in the descent. A leaf belongs to one
//! rank, so the pairs do not depend on the number of ranks.
//!
//! **Work and depth.** All pairs of points within each leaf, or its well-separated pairs, and the descents.
//!
//! **Rounds.** The radii within leaves need no messages. The two descents, or the passes of the baseline, take
//! rounds.

use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::message::UNKNOWN_RADIUS2;
use septet_protocol::transport::TransportError;

use crate::config::Correction;
use crate::machine::context::Context;
use crate::neighbours::bottom_up::correct_bottom_up;
use crate::neighbours::descent::descend;
use crate::neighbours::fair_split::{Found, nearest_by_pairs};
use crate::neighbours::search::{Ball, Search};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::Leaf;

/// A ball probes first if its radius exceeds this multiple of the median radius in its leaf.
const PUNT_RADIUS: f64 = 4.0;

/// Finds the nearest neighbour of each owned point. Stores the squared distance as the squared radius of the point.
pub(crate) async fn nearest_balls<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    leaf_radii(cx, subdomain, table).await?;
    match cx.config().graph.correction {
        Correction::BottomUp | Correction::Stages => return correct_bottom_up(cx, subdomain, table).await,
        Correction::Descent | Correction::Pairs => {}
    }
    let nearest = |phase, probe| Search { phase, wanted: 1, probe, own_leaf: false, everywhere: false };
    cx.enter(Phase::Probe)?;
    let large = large_balls(subdomain.leaves(), table.radii2());
    let probed = descend(cx, subdomain, table, nearest(Phase::Probe, true), large).await?;
    probed.shrink(table.owned_radii2_mut());
    drop(probed);
    cx.enter(Phase::Neighbours)?;
    let all = all_balls(subdomain.leaves(), table.radii2());
    let found = descend(cx, subdomain, table, nearest(Phase::Neighbours, false), all).await?;
    found.shrink(table.owned_radii2_mut());
    Ok(())
}

/// Finds the nearest neighbour of each owned point within its leaf.
async fn leaf_radii<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    cx.enter(Phase::Radii)?;
    let (positions, site, fault) = (table.positions(), cx.site(), cx.config().fault);
    let meter = cx.own_cost();
    let by_pairs = cx.config().graph.correction == Correction::Pairs;
    let results = cx.map(subdomain.leaves(), |leaf| {
        let _span = site.subproblem(Phase::Radii, leaf.id(), "leaf radii", leaf.owned_len());
        let members: Vec<u32> = leaf.owned().collect();
        let mut cost = meter.fresh();
        let (nearest2, pairs) = if by_pairs {
            let Found { nearest2, pairs } = nearest_by_pairs(&positions[leaf.indices()], &mut cost);
            (nearest2, pairs)
        } else {
            let all = |_| f64::INFINITY;
            (nearest_direct(positions, &members, &members, 1, all, &mut cost).kth2, 0)
        };
        let cost = fault.and_then(|fault| fault.charge_of_radii(&members, &meter)).unwrap_or(cost);
        (nearest2, pairs, cost)
    });
    let mut radii2 = Vec::with_capacity(table.owned_len() as usize);
    for (leaf, (nearest2, pairs, cost)) in subdomain.leaves().iter().zip(results) {
        cx.charge(Account::member(Phase::Radii, leaf.id()), cost, leaf.owned_len() * leaf.owned_len());
        cx.facts(leaf.id()).pairs += pairs;
        radii2.extend(nearest2);
    }
    table.owned_radii2_mut().copy_from_slice(&radii2);
    drop(radii2);
    while cx.exchange().await? {}
    Ok(())
}

/// Returns the balls of all owned points.
pub(crate) fn all_balls<P>(leaves: &[Leaf<P>], radii2: &[f64]) -> Vec<Ball> {
    balls_above(leaves, radii2, |_| f64::NEG_INFINITY)
}

/// Returns the balls that probe: those much larger than the median ball of their leaf.
pub(crate) fn large_balls<P>(leaves: &[Leaf<P>], radii2: &[f64]) -> Vec<Ball> {
    balls_above(leaves, radii2, punt_limit)
}

/// Returns the balls whose squared radius is unknown or exceeds the limit of their leaf.
fn balls_above<P>(leaves: &[Leaf<P>], radii2: &[f64], limit2: impl Fn(&[f64]) -> f64) -> Vec<Ball> {
    let mut balls = Vec::new();
    for (at, leaf) in leaves.iter().enumerate() {
        let radii2 = &radii2[leaf.indices()];
        let limit2 = limit2(radii2);
        for (point, &radius2) in leaf.owned().zip(radii2) {
            if radius2 > limit2 || radius2 == UNKNOWN_RADIUS2 {
                balls.push(Ball { point, leaf: at, radius2 });
            }
        }
    }
    balls
}

/// Returns the squared radius above which a ball probes, given the squared radii in its leaf.
fn punt_limit(radii2: &[f64]) -> f64 {
    if radii2.is_empty() {
        return f64::INFINITY;
    }
    let mut sorted = radii2.to_vec();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    PUNT_RADIUS * PUNT_RADIUS * median
}
