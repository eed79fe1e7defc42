//! Fair split trees, and the well-separated pairs of their nodes.
//!
//! **Statement.** A node of a *fair split tree* is a set of points with its bounding box. The plane through the middle of the
//! longest side of the box divides the set. Let s be the separation. Two sets are *well separated* if two balls of one radius
//! r, whose distance is at least `s r`, contain their boxes. Every two points occur in exactly one pair of well-separated
//! nodes. If q is the nearest neighbour of p, then p is alone in its node of that pair: any other point of the node is closer
//! to p than q. So the nearest neighbours are among the pairs with a node of one point.
//!
//! **Source.** Callahan and Kosaraju (1995), with s = 2. A margin of `1e-9` keeps the statement true under rounding.
//!
//! **Work and depth.** All nodes of one level of the tree are split together: segmented reductions yield the boxes, and the
//! points are separated. All pairs of candidates are tested together, round by round. A pair that is not well separated becomes
//! two pairs. Last, all points of the nodes that are paired with a single point are tested against this point.
//!
//! **Departures.** A level of the tree costs a constant depth, so a set whose boxes shrink slowly takes a depth up to its number
//! of points. Callahan and Kosaraju contract such chains. The leaves of the partition tree are small, so the number of levels
//! is bounded.

use septet_geometry::cost::Cost;
use septet_geometry::neighbourhood::{Bounds, bounds};
use septet_geometry::point::{Point, dist2};

/// The separation.
const SEPARATION: f64 = 2.0;

/// The margin that covers rounding.
const MARGIN: f64 = 1.0 + 1e-9;

/// A node: the points `start..end` in the order of the tree.
struct Node<P> {
    start: usize,
    end: usize,
    bounds: Bounds<P>,
    /// The squared diagonal of the box.
    diagonal2: f64,
    children: Option<[usize; 2]>,
}

/// The nearest neighbours that well-separated pairs yield.
pub(crate) struct Found {
    /// For each point, the squared distance to the nearest other point, infinite if there is none.
    pub(crate) nearest2: Vec<f64>,
    /// Number of well-separated pairs.
    pub(crate) pairs: u64,
}

/// Finds the nearest neighbour of each point. The points are distinct.
pub(crate) fn nearest_by_pairs<P: Point>(points: &[P], cost: &mut Cost) -> Found {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let nodes = split(points, &mut order, cost);
    let pairs = separate(&nodes, cost);
    let mut nearest2 = vec![f64::INFINITY; points.len()];
    let mut tested = cost.sweep();
    for &(a, b) in &pairs {
        let [a, b] = [a, b].map(|at| &order[nodes[at].start..nodes[at].end]);
        for (single, others) in [(a, b), (b, a)] {
            let [p] = *single else { continue };
            tested.each(others, |&q| nearest2[p] = nearest2[p].min(dist2(points[q], points[p])));
        }
    }
    cost.charge_pairs(tested);
    Found { nearest2, pairs: pairs.len() as u64 }
}

/// Builds the fair split tree, level by level. Brings the points into its order.
fn split<P: Point>(points: &[P], order: &mut [usize], cost: &mut Cost) -> Vec<Node<P>> {
    let mut nodes = vec![node_of(points, order, 0, order.len())];
    let mut level = 0..1;
    while !level.is_empty() {
        let (mut measured, mut divided) = (cost.sweep(), cost.sweep());
        for at in level.clone() {
            let (start, end, bounds) = (nodes[at].start, nodes[at].end, nodes[at].bounds);
            let set = measured.visit_all(&order[start..end]);
            if set.len() < 2 {
                continue;
            }
            divided.each(set, |_| {});
            let cut = start + divide(points, &mut order[start..end], bounds);
            nodes[at].children = Some([nodes.len(), nodes.len() + 1]);
            nodes.extend([(start, cut), (cut, end)].map(|(start, end)| node_of(points, order, start, end)));
        }
        cost.charge_sweep(measured);
        cost.charge_replication(divided);
        level = level.end..nodes.len();
    }
    nodes
}

fn node_of<P: Point>(points: &[P], order: &[usize], start: usize, end: usize) -> Node<P> {
    let bounds = bounds(order[start..end].iter().map(|&i| points[i]));
    let diagonal2 = if end > start { dist2(bounds.0, bounds.1) } else { 0.0 };
    Node { start, end, bounds, diagonal2, children: None }
}

/// Divides a set at the middle of the longest side of its box. Returns the size of the lower part. No part is empty.
fn divide<P: Point>(points: &[P], order: &mut [usize], (low, high): Bounds<P>) -> usize {
    let side = |axis: usize| high.coord(axis) - low.coord(axis);
    let longest =
        (1..P::DIM).fold(0, |longest, axis| if side(axis) > side(longest) { axis } else { longest });
    let (least, most) = (low.coord(longest), high.coord(longest));
    let middle = least + 0.5 * (most - least);
    // Rounding may move the middle to the upper end.
    let middle = if middle < most { middle } else { least };
    order.sort_by_key(|&i| points[i].coord(longest) > middle);
    order.partition_point(|&i| points[i].coord(longest) <= middle)
}

/// Returns the well-separated pairs of all points, round by round.
fn separate<P: Point>(nodes: &[Node<P>], cost: &mut Cost) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    let mut candidates: Vec<(usize, usize)> =
        nodes.iter().filter_map(|node| node.children).map(|[a, b]| (a, b)).collect();
    while !candidates.is_empty() {
        let (mut tested, mut divided) = (cost.sweep(), cost.sweep());
        let mut next = Vec::new();
        for &(a, b) in tested.visit_all(&candidates) {
            let (a, b) = if nodes[a].diagonal2 < nodes[b].diagonal2 { (b, a) } else { (a, b) };
            match nodes[a].children {
                Some([low, high]) if !are_separated(&nodes[a], &nodes[b]) => {
                    divided.visit();
                    next.extend([(low, b), (high, b)]);
                }
                _ => pairs.push((a, b)),
            }
        }
        cost.charge_sweep(tested);
        cost.charge_replication(divided);
        candidates = next;
    }
    pairs
}

/// Returns `true` if two nodes are well separated. Their balls have the larger of the two diagonals as diameter D. So the
/// distance of the centres is at least `(s + 2) D / 2`. Both sides are doubled.
fn are_separated<P: Point>(a: &Node<P>, b: &Node<P>) -> bool {
    let doubled = (a.bounds.0 - b.bounds.0) + (a.bounds.1 - b.bounds.1);
    let least2 = (SEPARATION + 2.0) * (SEPARATION + 2.0) * a.diagonal2.max(b.diagonal2);
    doubled.norm2() > least2 * MARGIN
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use septet_geometry::hash::mix;

    use super::*;

    fn check<P: Point>(points: &[P], what: &str) -> Found {
        let mut cost = Cost::of_subproblem(false);
        let found = nearest_by_pairs(points, &mut cost);
        for (i, &p) in points.iter().enumerate() {
            let others = points.iter().enumerate().filter(|&(j, _)| j != i);
            let expected = others.map(|(_, &q)| dist2(q, p)).fold(f64::INFINITY, f64::min);
            assert_eq!(found.nearest2[i].to_bits(), expected.to_bits(), "{what}: point {i}");
        }
        found
    }

    fn unit(i: u64, axis: u64) -> f64 {
        (mix(mix(7, i), axis) >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn pairs_yield_the_nearest_neighbours() {
        for n in [0, 1, 2, 3, 10, 300] {
            let plane: Vec<DVec2> = (0..n).map(|i| DVec2::new(unit(i, 0), unit(i, 1))).collect();
            check(&plane, "plane");
            // Far from the origin, and nearly collinear.
            let far: Vec<DVec2> = plane.iter().map(|p| *p * DVec2::new(1.0, 1e-9) + 4096.0).collect();
            check(&far, "far");
            let space: Vec<DVec3> = (0..n).map(|i| DVec3::new(unit(i, 0), unit(i, 1), unit(i, 2))).collect();
            let pairs = check(&space, "space").pairs;
            assert!(pairs <= n * n.saturating_sub(1) / 2 && (n < 2 || pairs >= n - 1), "{n}: {pairs}");
        }
        let grid: Vec<DVec3> =
            (0..216).map(|i| DVec3::new(f64::from(i % 6), f64::from(i / 6 % 6), f64::from(i / 36))).collect();
        check(&grid, "lattice");
        let close: Vec<DVec2> = (0..40).map(|i| DVec2::new(0.0, 0.5f64.powi(i))).collect();
        check(&close, "chain");
    }

    /// Every two points occur in one pair.
    #[test]
    fn pairs_cover_all_points_once() {
        let points: Vec<DVec2> = (0..120).map(|i| DVec2::new(unit(i, 0), unit(i, 1))).collect();
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut cost = Cost::of_subproblem(false);
        let nodes = split(&points, &mut order, &mut cost);
        let mut covered = vec![0; points.len() * points.len()];
        for (a, b) in separate(&nodes, &mut cost) {
            for &p in &order[nodes[a].start..nodes[a].end] {
                for &q in &order[nodes[b].start..nodes[b].end] {
                    covered[p.min(q) * points.len() + p.max(q)] += 1;
                }
            }
        }
        for (at, count) in covered.iter().enumerate() {
            assert_eq!(*count, i32::from(at / points.len() < at % points.len()), "{at}");
        }
    }
}
