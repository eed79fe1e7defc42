//! A tree of bounding boxes over simplices.
//!
//! **Statement.** Boxes are closed, and their bounds are coordinates of the simplices, without rounding. A query
//! therefore finds every box that meets the given one. The tree splits the items at the median of their centres along
//! the longest side of their box. Ties are broken by position. The tree is a function of the ordered list of items.
//!
//! **Work and depth.** `m log m` to build. A query costs one step per visited node, and one per item of a visited leaf.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;

/// A closed box with sides parallel to the axes. It is empty if `low > high` along some axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<P> {
    /// Smallest coordinates.
    pub low: P,
    /// Largest coordinates.
    pub high: P,
}

impl<P: Point> Bounds<P> {
    /// Returns the empty box.
    pub fn empty() -> Self {
        Bounds { low: P::splat(f64::INFINITY), high: P::splat(f64::NEG_INFINITY) }
    }

    /// Returns the smallest box that contains the points.
    pub fn of(points: impl IntoIterator<Item = P>) -> Self {
        points.into_iter().fold(Bounds::empty(), |b, p| b.join(&Bounds { low: p, high: p }))
    }

    /// Returns the smallest box that contains both boxes.
    #[must_use]
    pub fn join(mut self, other: &Self) -> Self {
        for i in 0..P::DIM {
            self.low.set_coord(i, self.low.coord(i).min(other.low.coord(i)));
            self.high.set_coord(i, self.high.coord(i).max(other.high.coord(i)));
        }
        self
    }

    /// Returns `true` if the boxes share a point.
    pub fn meets(&self, other: &Self) -> bool {
        (0..P::DIM)
            .all(|i| self.low.coord(i) <= other.high.coord(i) && other.low.coord(i) <= self.high.coord(i))
    }

    /// Returns the lengths of the sides.
    pub fn extent(&self) -> P {
        self.high - self.low
    }

    /// Returns the squared distance to a point, rounded, or 0 if the point is inside.
    pub fn dist2(&self, p: P) -> f64 {
        let mut gap = P::splat(0.0);
        for i in 0..P::DIM {
            let c = p.coord(i);
            gap.set_coord(i, (self.low.coord(i) - c).max(c - self.high.coord(i)).max(0.0));
        }
        gap.norm2()
    }
}

/// A segment, prepared for tests against many boxes.
struct Segment<P> {
    from: P,
    along: P,
    /// `|from| + |along|` along each axis.
    size: P,
}

impl<P: Point> Segment<P> {
    fn new(p: P, q: P) -> Self {
        let along = q - p;
        let mut size = p;
        for i in 0..P::DIM {
            size.set_coord(i, p.coord(i).abs() + along.coord(i).abs());
        }
        Segment { from: p, along, size }
    }

    /// Returns `true` if the segment may meet the box. The box is widened by a bound on the rounding, so the answer
    /// `false` is certain.
    fn may_meet(&self, b: &Bounds<P>) -> bool {
        let (mut start, mut end) = (0.0f64, 1.0f64);
        for i in 0..P::DIM {
            let (from, along) = (self.from.coord(i), self.along.coord(i));
            let pad = 1e-12 * (self.size.coord(i) + b.low.coord(i).abs() + b.high.coord(i).abs());
            let (low, high) = (b.low.coord(i) - pad - from, b.high.coord(i) + pad - from);
            if along == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (first, last) = if along > 0.0 { (low, high) } else { (high, low) };
            start = start.max(first / along);
            end = end.min(last / along);
            if start > end {
                return false;
            }
        }
        true
    }
}

/// The maximum number of items in a leaf.
const LEAF: usize = 4;

#[derive(Clone, Debug)]
struct Node<P> {
    bounds: Bounds<P>,
    /// The range in `order`.
    range: (u32, u32),
    /// The right child, or 0 for a leaf. The left child is the next node.
    right: u32,
}

/// The tree.
#[derive(Clone, Debug)]
pub struct Bvh<P> {
    nodes: Vec<Node<P>>,
    order: Vec<u32>,
    boxes: Vec<Bounds<P>>,
}

impl<P: Point> Bvh<P> {
    /// Builds a tree over boxes. Queries return positions in `boxes`.
    pub fn new(boxes: Vec<Bounds<P>>) -> Self {
        let mut tree = Bvh { nodes: Vec::new(), order: (0..boxes.len() as u32).collect(), boxes };
        if !tree.order.is_empty() {
            tree.build(0, tree.order.len());
        }
        tree
    }

    fn build(&mut self, from: usize, to: usize) {
        let items = &self.order[from..to];
        let bounds = items.iter().fold(Bounds::empty(), |b, &i| b.join(&self.boxes[i as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, range: (from as u32, to as u32), right: 0 });
        if to - from <= LEAF {
            return;
        }
        let extent = bounds.extent();
        let axis = (1..P::DIM).fold(0, |best, i| if extent.coord(i) > extent.coord(best) { i } else { best });
        let boxes = &self.boxes;
        let centre = |i: u32| {
            let b = &boxes[i as usize];
            b.low.coord(axis) * 0.5 + b.high.coord(axis) * 0.5
        };
        let half = usize::midpoint(from, to);
        self.order[from..to]
            .select_nth_unstable_by(half - from, |&i, &j| centre(i).total_cmp(&centre(j)).then(i.cmp(&j)));
        self.build(from, half);
        self.nodes[node].right = self.nodes.len() as u32;
        self.build(half, to);
    }

    /// Returns the bounding box of all items.
    pub fn bounds(&self) -> Bounds<P> {
        self.nodes.first().map_or_else(Bounds::empty, |n| n.bounds)
    }

    /// Returns the items whose boxes meet `query`, in ascending order.
    pub fn meeting(&self, query: &Bounds<P>) -> Vec<u32> {
        self.meeting_counted(query, &mut Sweep::default())
    }

    /// Returns the items of [`Bvh::meeting`], and counts the visited nodes and items.
    pub fn meeting_counted(&self, query: &Bounds<P>, visits: &mut Sweep) -> Vec<u32> {
        let mut found = Vec::new();
        self.visit_counted(query, visits, |i| {
            found.push(i);
            true
        });
        found.sort_unstable();
        found
    }

    /// Calls `f` with each item whose box meets `query`, in the order of the tree, until `f` returns `false`.
    pub fn visit(&self, query: &Bounds<P>, f: impl FnMut(u32) -> bool) {
        self.visit_counted(query, &mut Sweep::default(), f);
    }

    /// Visits items as [`Bvh::visit`] does, and counts the visited nodes and items.
    pub fn visit_counted(&self, query: &Bounds<P>, visits: &mut Sweep, f: impl FnMut(u32) -> bool) {
        self.visit_where(|bounds| bounds.meets(query), visits, f);
    }

    /// Calls `f` with each item whose box may meet the segment from `p` to `q`, in the order of the tree, until `f`
    /// returns `false`. Boxes are widened by a bound on the rounding.
    pub fn visit_along(&self, p: P, q: P, f: impl FnMut(u32) -> bool) {
        let segment = Segment::new(p, q);
        self.visit_where(|bounds| segment.may_meet(bounds), &mut Sweep::default(), f);
    }

    /// Calls `f` with each item whose box passes `test`, in the order of the tree, until `f` returns `false`. A box
    /// must pass if a box inside it passes.
    fn visit_where(
        &self,
        test: impl Fn(&Bounds<P>) -> bool,
        visits: &mut Sweep,
        mut f: impl FnMut(u32) -> bool,
    ) {
        // Every level halves the items, so 32 levels suffice for 2^32 leaves.
        let mut stack = [0u32; 34];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let at = stack[top];
            let node = &self.nodes[at as usize];
            visits.visit();
            if !test(&node.bounds) {
                continue;
            }
            if node.right == 0 {
                let items = &self.order[node.range.0 as usize..node.range.1 as usize];
                visits.visit_all(items);
                for &i in items.iter().filter(|&&i| test(&self.boxes[i as usize])) {
                    if !f(i) {
                        return;
                    }
                }
            } else {
                stack[top] = node.right;
                stack[top + 1] = at + 1;
                top += 2;
            }
        }
    }

    /// Calls `visit` with items in ascending order of `dist2` (ties by position), until `visit` returns `false`.
    /// `dist2` must not be smaller than the squared distance to the box of the item, up to rounding.
    pub fn nearest(&self, from: P, dist2: impl FnMut(u32) -> f64, visit: impl FnMut(u32, f64) -> bool) {
        self.nearest_counted(from, &mut Sweep::default(), dist2, visit);
    }

    /// Visits items as [`Bvh::nearest`] does, and counts the visited nodes and items.
    pub fn nearest_counted(
        &self,
        from: P,
        visits: &mut Sweep,
        mut dist2: impl FnMut(u32) -> f64,
        mut visit: impl FnMut(u32, f64) -> bool,
    ) {
        let mut queue = BinaryHeap::new();
        if let Some(root) = self.nodes.first() {
            queue.push(Reverse(Entry(root.bounds.dist2(from), false, 0)));
        }
        while let Some(Reverse(Entry(d, item, at))) = queue.pop() {
            visits.visit();
            if item {
                if !visit(at, d) {
                    return;
                }
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.right == 0 {
                for &i in &self.order[node.range.0 as usize..node.range.1 as usize] {
                    queue.push(Reverse(Entry(dist2(i).max(d), true, i)));
                }
            } else {
                for child in [at + 1, node.right] {
                    queue.push(Reverse(Entry(self.nodes[child as usize].bounds.dist2(from), false, child)));
                }
            }
        }
    }
}

/// A squared distance, whether the entry is an item, and its index. At equal distances, nodes come before items, and
/// items are ordered by position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry(f64, bool, u32);

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1)).then(self.2.cmp(&other.2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn cloud() -> Vec<DVec3> {
        (0..200u32).map(|i| DVec3::new((i * 37 % 101) as f64, (i * 53 % 97) as f64, (i % 7) as f64)).collect()
    }

    #[test]
    fn queries_agree_with_all_pairs() {
        let points = cloud();
        let boxes: Vec<_> =
            points.iter().map(|&p| Bounds { low: p, high: p + DVec3::new(3.0, 1.0, 2.0) }).collect();
        let tree = Bvh::new(boxes.clone());
        for query in &boxes {
            let all: Vec<u32> = (0..200).filter(|&i| boxes[i as usize].meets(query)).collect();
            assert_eq!(tree.meeting(query), all);
        }
        assert!(Bvh::<DVec3>::new(Vec::new()).meeting(&boxes[0]).is_empty());
    }

    #[test]
    fn nearest_comes_in_order_and_complete() {
        let points = cloud();
        let tree = Bvh::new(points.iter().map(|&p| Bounds::of([p])).collect());
        let from = DVec3::new(40.3, 51.2, 2.9);
        let mut seen = Vec::new();
        tree.nearest(
            from,
            |i| (points[i as usize] - from).length_squared(),
            |i, d| {
                seen.push((d, i));
                true
            },
        );
        let mut all: Vec<(f64, u32)> =
            (0..200).map(|i| ((points[i as usize] - from).length_squared(), i)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        assert_eq!(seen, all);
    }
}
