//! Nearest-neighbour balls of all points (Section 4.3): radii inside every leaf, then the descent.
//!
//! **Statement.** A ball starts with the distance to the nearest point of its leaf. Balls much larger than their leaf's
//! median probe first; then all descend ([`crate::neighbours::descent`]), and each takes the nearest point found. The
//! baseline corrects them bottom-up instead ([`crate::neighbours::bottom_up`]).
//!
//! **Work and depth.** All pairs of a leaf, and the descent's.
//!
//! **Rounds.** None for the radii inside leaves; those of two descents, or of the passes of the baseline.

use septet_geometry::cost::Cost;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::config::{Correction, map_in};
use crate::machine::context::Context;
use crate::neighbours::ask::{Ask, Ball};
use crate::neighbours::bottom_up::correct_bottom_up;
use crate::neighbours::descent::descend;
use crate::state::subdomain::{Leaf, Subdomain};
use crate::state::table::Table;

/// A ball with a radius above this multiple of its leaf's median probes first.
const PUNT_RADIUS: f64 = 4.0;

/// Finds the nearest neighbour of every home point: its squared distance becomes the point's squared radius.
pub(crate) async fn nearest_balls<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    leaf_radii(cx, subdomain, table).await?;
    if cx.config.graph.correction == Correction::Naive {
        return correct_bottom_up(cx, subdomain, table).await;
    }
    let nearest = |phase, probe| Ask { phase, wanted: 1, probe, own_leaf: false };
    cx.enter(Phase::Probe)?;
    let large = large_balls(&subdomain.leaves, &table.radii2);
    let probed = descend(cx, subdomain, table, nearest(Phase::Probe, true), large).await?;
    probed.shrink(&mut table.radii2);
    drop(probed);
    cx.enter(Phase::Neighbours)?;
    let all = all_balls(&subdomain.leaves, &table.radii2);
    let found = descend(cx, subdomain, table, nearest(Phase::Neighbours, false), all).await?;
    found.shrink(&mut table.radii2);
    Ok(())
}

/// Finds the nearest neighbour of every home point inside its leaf.
async fn leaf_radii<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    cx.enter(Phase::Radii)?;
    let (positions, site, fault) = (&table.positions, cx.site(), cx.config.fault);
    let results = map_in(&cx.pool, &subdomain.leaves, |leaf| {
        let _span = site.subproblem(Phase::Radii, leaf.id, "leaf radii", leaf.owned_len());
        let members: Vec<u32> = leaf.owned().collect();
        let mut cost = Cost::ZERO;
        let all = |_| f64::INFINITY;
        let nearest = nearest_direct(positions, &members, &members, 1, all, &mut cost);
        let cost = fault.and_then(|fault| fault.charge_of_radii(&members)).unwrap_or(cost);
        (nearest.kth2, cost)
    });
    let mut radii2 = Vec::with_capacity(table.owned as usize);
    for (leaf, (nearest2, cost)) in subdomain.leaves.iter().zip(results) {
        cx.charge(Account::member(Phase::Radii, leaf.id), cost, leaf.owned_len() * leaf.owned_len());
        radii2.extend(nearest2);
    }
    table.radii2[..radii2.len()].copy_from_slice(&radii2);
    drop(radii2);
    while cx.exchange().await? {}
    Ok(())
}

/// The balls of all home points, by their squared radii.
pub(crate) fn all_balls<P>(leaves: &[Leaf<P>], radii2: &[f64]) -> Vec<Ball> {
    balls_above(leaves, radii2, |_| f64::NEG_INFINITY)
}

/// The balls that probe: those far larger than their leaf's median.
pub(crate) fn large_balls<P>(leaves: &[Leaf<P>], radii2: &[f64]) -> Vec<Ball> {
    balls_above(leaves, radii2, punt_limit)
}

/// The balls whose squared radius is above the limit of their leaf, or infinite.
fn balls_above<P>(leaves: &[Leaf<P>], radii2: &[f64], limit2: impl Fn(&[f64]) -> f64) -> Vec<Ball> {
    let mut balls = Vec::new();
    for (at, leaf) in leaves.iter().enumerate() {
        let radii2 = &radii2[leaf.start as usize..leaf.end as usize];
        let limit2 = limit2(radii2);
        for (owned, &radius2) in leaf.owned().zip(radii2) {
            if radius2 > limit2 || radius2 == f64::INFINITY {
                balls.push(Ball { owned, leaf: at, radius2 });
            }
        }
    }
    balls
}

/// The squared radius above which a ball of a leaf probes.
fn punt_limit(radii2: &[f64]) -> f64 {
    if radii2.is_empty() {
        return f64::INFINITY;
    }
    let mut sorted = radii2.to_vec();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    PUNT_RADIUS * PUNT_RADIUS * median
}
