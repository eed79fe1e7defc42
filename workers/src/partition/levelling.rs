//! Moves the points of a node to the ranks of its children's groups, in equal shares.
//!
//! **Statement.** A child of `m` points has a group of `r` ranks. After the move, each of these ranks holds
//! `floor(m / r)` or `ceil(m / r)` of the points, wherever they were before. A rank of the child's group keeps its own
//! points up to that number, so no other move with these shares sends fewer points.
//!
//! **Rounds.** None of its own: the routes travel with the decision of the leader, and the points in the round after it.
//!
//! **Work.** For the leader, the number of ranks of the group. The placement of points is not a charge, because no
//! separator and no split depends on it.

use std::ops::Range;

use septet_geometry::point::Point;
use septet_protocol::ids::Rank;
use septet_protocol::message::{Body, Child, PointBatch, Route};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::state::subdomain::Group;

/// Returns the route of each of the `members` of a node to a child. `held` contains, for each member, its number of points
/// of the child.
pub(super) fn routes(members: Range<Rank>, held: &[u64], child: &Child) -> Vec<Route> {
    let receivers = child.first..child.first + if child.leaf { 1 } else { child.ranks };
    let points = u128::from(held.iter().sum::<u64>());
    let below = |rank: Rank| (points * u128::from(rank - child.first) / receivers.len() as u128) as u64;
    let share = |rank: Rank| below(rank + 1) - below(rank);
    let held = || members.clone().zip(held.iter().copied());
    let kept = |rank: Rank, has: u64| if receivers.contains(&rank) { has.min(share(rank)) } else { 0 };
    let mut gaps = held()
        .filter(|(rank, _)| receivers.contains(rank))
        .map(|(rank, has)| (rank, share(rank) - kept(rank, has)))
        .filter(|&(_, gap)| gap > 0);
    let mut gap = gaps.next();
    let mut routes = Vec::with_capacity(members.len());
    for (rank, has) in held() {
        let mut route = Route::default();
        let own = kept(rank, has);
        route.push(rank, own);
        let mut left = has - own;
        while let Some((receiver, missing)) = gap.as_mut().filter(|_| left > 0) {
            let count = left.min(*missing);
            route.push(*receiver, count);
            left -= count;
            *missing -= count;
            if *missing == 0 {
                gap = gaps.next();
            }
        }
        routes.push(route);
    }
    routes
}

/// Sends points to the members of a child's group. Returns the points that this rank keeps.
///
/// # Errors
/// Fails if the route is for another number of points.
pub(super) fn follow<P: Point>(
    cx: &mut Context<P>,
    group: &Group,
    mut points: PointBatch<P>,
    route: &Route,
) -> Result<PointBatch<P>, TransportError> {
    if route.counts.iter().sum::<u64>() != points.len() as u64 {
        let reason = format!("the route to node {} is for another number of points", group.node.0);
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    }
    let mut kept = PointBatch::default();
    // The last part comes first, because it is cut off the end of the batch.
    for (&receiver, &count) in route.receivers.iter().zip(route.counts.iter()).rev() {
        let part = points.split_off(points.len() - count as usize);
        if receiver == cx.rank() {
            kept = part;
        } else {
            cx.send_to((group.node, receiver), Body::Move(part));
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the numbers of points of all members after the move, and the number of points moved.
    fn moved(members: Range<Rank>, held: &[u64], child: &Child) -> (Vec<u64>, u64) {
        let (mut after, mut sent) = (vec![0; members.len()], 0);
        let routes = routes(members.clone(), held, child);
        assert_eq!(routes.len(), held.len());
        for ((rank, &has), route) in members.clone().zip(held).zip(routes) {
            assert_eq!(route.counts.iter().sum::<u64>(), has);
            for (&to, &count) in route.receivers.iter().zip(route.counts.iter()) {
                after[(to - members.start) as usize] += count;
                sent += if to == rank { 0 } else { count };
            }
        }
        (after, sent)
    }

    #[test]
    fn every_distribution_becomes_level_and_no_point_moves_without_need() {
        let members = 5..12;
        for held in
            [[0, 0, 0, 0, 0, 0, 1000], [1000, 0, 0, 0, 0, 0, 0], [9, 8, 7, 6, 5, 4, 3], [0; 7], [1; 7]]
        {
            for (first, ranks) in [(5, 3), (8, 4), (5, 1), (6, 6), (5, 7)] {
                let child = Child { population: held.iter().sum(), first, ranks, leaf: false };
                let (after, sent) = moved(members.clone(), &held, &child);
                let level = child.population / u64::from(ranks);
                let mut needed = child.population;
                for ((rank, &has), points) in members.clone().zip(&held).zip(after) {
                    if !(first..first + ranks).contains(&rank) {
                        assert_eq!(points, 0);
                        continue;
                    }
                    assert!(points == level || points == level + 1, "{points} of {level}");
                    needed -= has.min(points);
                }
                assert_eq!(sent, needed);
            }
        }
    }

    #[test]
    fn one_rank_takes_a_leaf() {
        let child = Child { population: 12, first: 3, ranks: 2, leaf: true };
        assert_eq!(moved(1..5, &[3, 3, 3, 3], &child).0, [0, 0, 12, 0]);
    }
}
