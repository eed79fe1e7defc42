//! The nodes that balls and edges reach, computed from points, radii and surfaces alone.
//!
//! **Statement.** All points start at the root and descend. The caller defines the *reach* of a point into a node, such
//! as the radius of its ball. At a split node, a point continues to the child that contains its own leaf, if there is
//! one. It also continues to a child if its reach into this child is at least its distance from the child's side of the
//! surface. A machine without further knowledge of the child cannot stop the point there. The reach may depend on the
//! box of the child's points, if the machine knows this box.

use std::collections::BTreeMap;

use super::measure::X;

/// A tree over points: its split nodes with parents first, and the leaf of each point.
pub(super) struct Division<'a, F> {
    pub(super) nodes: Vec<u64>,
    pub(super) leaves: &'a [u64],
    /// Returns the signed distance of a location from the surface of the split node with this index, negative inside.
    pub(super) height: F,
}

/// The box and the largest radius of the owned points of a node.
#[derive(Clone, Copy)]
pub(super) struct Extremes {
    low: X,
    high: X,
    pub(super) radius: f64,
}

impl Extremes {
    const NONE: Extremes = Extremes { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], radius: 0.0 };

    fn add(&mut self, x: &X, radius: f64) {
        for (axis, &x) in x.iter().enumerate() {
            (self.low[axis], self.high[axis]) = (self.low[axis].min(x), self.high[axis].max(x));
        }
        self.radius = self.radius.max(radius);
    }

    /// Returns the distance of a location from the box.
    pub(super) fn distance(&self, x: &X) -> f64 {
        let gap = |axis: usize| (self.low[axis] - x[axis]).max(x[axis] - self.high[axis]).max(0.0);
        (0..3).map(|axis| gap(axis) * gap(axis)).sum::<f64>().sqrt()
    }
}

/// The counts of a descent of all points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Reached {
    /// Number of points at a split node, summed over all split nodes.
    pub(super) at_nodes: f64,
    /// Number of points that continue to both children, summed over all split nodes.
    pub(super) to_both: f64,
    /// Number of pairs of a point that reaches a leaf and an owned point of this leaf, without the pairs of two owned
    /// points.
    pub(super) pairs_with_visitors: f64,
    /// The same number, with the pairs of two owned points.
    pub(super) pairs_with_members: f64,
}

/// Returns the counts of a descent. `reach` returns the reach of a point into a node with these extremes.
pub(super) fn reached<F: Fn(usize, &X) -> f64>(
    tree: &Division<F>,
    points: &[X],
    radii: &[f64],
    reach: impl Fn(usize, &Extremes) -> f64,
) -> Reached {
    let nodes = extremes(tree.leaves, points, radii);
    let mut counts = Reached::default();
    let mut waiting: BTreeMap<u64, Vec<u32>> = BTreeMap::from([(1, (0..points.len() as u32).collect())]);
    for (at, &node) in tree.nodes.iter().enumerate() {
        let here = waiting.remove(&node).unwrap_or_default();
        counts.at_nodes += here.len() as f64;
        for i in here {
            let (x, leaf) = (&points[i as usize], tree.leaves[i as usize]);
            let height = (tree.height)(at, x);
            let mut continues = 0;
            for child in [2 * node, 2 * node + 1] {
                // Distances are rounded, so doubtful points count as missing the child.
                let beyond = (height >= 0.0) != (child % 2 == 1);
                let away = if beyond { height.abs() * (1.0 + 1e-9) } else { 0.0 };
                let enters = nodes.get(&child).is_some_and(|node| away <= reach(i as usize, node));
                if is_below(leaf, child) || enters {
                    waiting.entry(child).or_default().push(i);
                    continues += 1;
                }
            }
            counts.to_both += f64::from(u8::from(continues == 2));
        }
    }
    for (leaf, here) in waiting {
        let owned = here.iter().filter(|&&i| tree.leaves[i as usize] == leaf).count();
        counts.pairs_with_visitors += (owned * (here.len() - owned)) as f64;
        counts.pairs_with_members += (owned * here.len()) as f64;
    }
    counts
}

/// Returns `true` if a leaf is this node or lies below it.
fn is_below(leaf: u64, node: u64) -> bool {
    leaf.ilog2().checked_sub(node.ilog2()).is_some_and(|deeper| leaf >> deeper == node)
}

/// Returns the extremes of the owned points of each node.
fn extremes(leaves: &[u64], points: &[X], radii: &[f64]) -> BTreeMap<u64, Extremes> {
    let mut nodes = BTreeMap::new();
    for ((x, &radius), &leaf) in points.iter().zip(radii).zip(leaves) {
        let mut node = leaf;
        while node > 0 {
            nodes.entry(node).or_insert(Extremes::NONE).add(x, radius);
            node /= 2;
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points 0, 1, 2 and 3 on a line, and a plane at 1.5.
    #[test]
    fn balls_reach_the_other_side() {
        let points: Vec<X> = [0.0, 1.0, 2.0, 3.0].map(|x| [x, 0.0, 0.0]).to_vec();
        let tree = Division { nodes: vec![1], leaves: &[2, 2, 3, 3], height: |_, x: &X| x[0] - 1.5 };
        let found = reached(&tree, &points, &[1.0; 4], |_, node| node.radius);
        // Points 1 and 2 are at distance 0.5 from the plane.
        let expected =
            Reached { at_nodes: 4.0, to_both: 2.0, pairs_with_visitors: 4.0, pairs_with_members: 12.0 };
        assert_eq!(found, expected);
        let boxed =
            reached(
                &tree,
                &points,
                &[0.9; 4],
                |i, node| {
                    if node.distance(&points[i]) <= 0.9 { 0.9 } else { -1.0 }
                },
            );
        // The boxes are farther away than the plane.
        assert_eq!((boxed.to_both, boxed.pairs_with_members), (0.0, 8.0));
        assert!(is_below(12, 3) && is_below(3, 3) && !is_below(12, 2) && !is_below(1, 2));
    }
}
