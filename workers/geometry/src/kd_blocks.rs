//! Points in blocks of eight nearby points, for searches that need only a few of many points.
//!
//! **Statement.** The set is bisected along the longest side of its bounding box until each part is one block (a k-d
//! tree, Bentley 1975). The first half has a multiple of eight points. If the bounding box of a block is farther than
//! the limit, no point of the block is within the limit. This holds in spite of rounding, which is monotone: the
//! expression of [`dist2`](crate::point::dist2) computes the distance to a box from gaps that are no larger than the
//! differences of coordinates. The result therefore equals the result of a search over all pairs, bit for bit.
//!
//! **Work and depth.** The machine tests all pairs in one vector step, and its primitives charge for all of them
//! ([`Cost::all_pairs_in_blocks`](crate::cost::Cost::all_pairs_in_blocks),
//! [`Sweep::each_in_blocks`](crate::cost::Sweep::each_in_blocks)). A processor first tests the bounding boxes of groups
//! of eight blocks, eight at a time. It then tests the boxes of the blocks in the groups within the limit, and the
//! points of the blocks within the limit.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

use std::marker::PhantomData;

use crate::bounds::{Bounds, bounds, join_bounds};
use crate::coordinate_arrays::{LANES, PairVisitor, add_squares};
use crate::point::{Array, Point};
use crate::selection::NeighbourList;
use crate::simd::{Interval, Masks, each_bit, larger, widest};

/// Points in blocks, as positions in a slice.
#[derive(Clone, Debug)]
pub struct KdBlocks<P: Point> {
    /// Number of points.
    len: usize,
    /// Position of each point in the slice, block after block. Zeros fill the last block.
    order: Vec<u32>,
    /// Coordinates in that order. NaN fills the last block and the blocks of the last group.
    axes: P::Axes<Vec<f64>>,
    /// Bounding boxes of the blocks, in groups of eight.
    boxes: Vec<Boxes<P>>,
    /// Bounding boxes of the groups, again in groups of eight.
    groups: Vec<Boxes<P>>,
    marker: PhantomData<P>,
}

/// Minimum and maximum coordinates of eight boxes; infinite for unused boxes.
type Boxes<P> = [<P as Point>::Axes<[f64; LANES]>; 2];

impl<P: Point> KdBlocks<P> {
    /// Divides points into blocks.
    pub fn of(points: &[P]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        divide(points, &mut order, &mut Vec::new());
        let groups = order.len().div_ceil(LANES * LANES);
        let axes = P::Axes::from_fn(|axis| {
            if axis >= P::DIM {
                return Vec::new();
            }
            let mut column: Vec<f64> = order.iter().map(|&i| points[i as usize].coord(axis)).collect();
            column.resize(groups * LANES * LANES, f64::NAN);
            column
        });
        let around = |block: &[u32]| bounds(block.iter().map(|&i| points[i as usize]));
        let sides: Vec<Bounds<P>> = order.chunks(LANES).map(around).collect();
        let joined = |group: &[Bounds<P>]| group[1..].iter().fold(group[0], |a, &b| join_bounds(a, b));
        let (boxes, groups) =
            (boxes_of(&sides), boxes_of(&sides.chunks(LANES).map(joined).collect::<Vec<_>>()));
        order.resize(points.len().next_multiple_of(LANES), 0);
        KdBlocks { len: points.len(), order, axes, boxes, groups, marker: PhantomData }
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Positions of the points in the slice, block after block.
    pub fn order(&self) -> &[u32] {
        &self.order[..self.len]
    }

    /// Passes the points within the limit of each point to the visitor. Rows and columns are positions in
    /// [`KdBlocks::order`].
    pub(crate) fn each_row(&self, visitor: &mut impl PairVisitor) {
        let masks = Masks::default();
        widest(
            #[inline(always)]
            || {
                for row in 0..self.len() {
                    let mut limit = Some(visitor.begin(row));
                    let of_axis =
                        |axis: usize| if axis < P::DIM { self.axes.as_ref()[axis][row] } else { 0.0 };
                    let at = P::Axes::from_fn(of_axis);
                    while let Some(limit2) = limit {
                        self.each_block(
                            masks,
                            &at,
                            limit2,
                            #[inline(always)]
                            |first, distances2, limit2| visitor.visit_lanes(first, distances2, limit2),
                        );
                        limit = visitor.retry(row);
                    }
                    visitor.end(row);
                }
            },
        );
    }

    /// Appends the points no farther than the limit, except those at `centre`. The position of a point in the list is
    /// its position in the slice plus `start`.
    pub(crate) fn find_within(&self, centre: P, limit2: f64, start: u32, found: &mut NeighbourList) {
        let at = P::Axes::from_fn(|axis| if axis < P::DIM { centre.coord(axis) } else { 0.0 });
        let masks = Masks::default();
        widest(
            #[inline(always)]
            || {
                self.each_block(
                    masks,
                    &at,
                    limit2,
                    #[inline(always)]
                    |first, distances2, limit2| {
                        // The padding of the last block has NaN as distances and 0 as positions.
                        let numbers = self.order[first..].first_chunk().copied().unwrap_or_default();
                        found.take_lanes(
                            distances2,
                            &numbers.map(|number: u32| start.wrapping_add(number)),
                            Interval { above: 0.0, limit: limit2 },
                        );
                        limit2
                    },
                );
            },
        );
    }

    /// Computes the squared distances to the points of a block.
    #[inline(always)]
    fn distances2(&self, block: usize, at: &[f64]) -> [f64; LANES] {
        let mut distances2 = [0.0; LANES];
        for (column, &at) in self.axes.as_ref()[..P::DIM].iter().zip(at) {
            add_squares(&mut distances2, &column[block * LANES..][..LANES], at);
        }
        distances2
    }

    /// Calls `near` for each block with a point within the limit. The arguments are the position of the block's first
    /// point in the order and the eight squared distances. Each call returns the limit for the following blocks.
    #[inline(always)]
    fn each_block(
        &self,
        masks: Masks,
        at: &P::Axes<f64>,
        mut limit2: f64,
        mut near: impl FnMut(usize, &[f64; LANES], f64) -> f64,
    ) {
        for (many, sides) in self.groups.iter().enumerate() {
            for group in each_bit(u64::from(within::<P>(masks, sides, at, limit2))) {
                let group = many * LANES + group;
                // An infinite limit also selects unused groups.
                let Some(boxes) = self.boxes.get(group) else { continue };
                for block in each_bit(u64::from(within::<P>(masks, boxes, at, limit2))) {
                    let block = group * LANES + block;
                    let distances2 = self.distances2(block, at.as_ref());
                    if distances2.iter().fold(false, |any, &d2| any | (d2 <= limit2)) {
                        limit2 = near(block * LANES, &distances2, limit2);
                    }
                }
            }
        }
    }
}

/// Arranges bounding boxes in groups of eight.
fn boxes_of<P: Point>(all: &[Bounds<P>]) -> Vec<Boxes<P>> {
    let unused = [0, 1].map(|_| P::Axes::from_fn(|_| [f64::INFINITY; LANES]));
    let mut boxes: Vec<Boxes<P>> = vec![unused; all.len().div_ceil(LANES)];
    for (number, (low, high)) in all.iter().enumerate() {
        let [lows, highs] = &mut boxes[number / LANES];
        for axis in 0..P::DIM {
            lows.as_mut()[axis][number % LANES] = low.coord(axis);
            highs.as_mut()[axis][number % LANES] = high.coord(axis);
        }
    }
    boxes
}

/// Computes the squared distances to eight boxes.
#[inline(always)]
fn gaps2(lows: &[[f64; LANES]], highs: &[[f64; LANES]], at: &[f64]) -> [f64; LANES] {
    let mut gaps2 = [0.0; LANES];
    for ((low, high), &at) in lows.iter().zip(highs).zip(at) {
        for ((sum, low), high) in gaps2.iter_mut().zip(low).zip(high) {
            let gap = larger(larger(low - at, at - high), 0.0);
            *sum += gap * gap;
        }
    }
    gaps2
}

/// Returns the boxes within the limit as a bit mask.
#[inline(always)]
fn within<P: Point>(masks: Masks, sides: &Boxes<P>, at: &P::Axes<f64>, limit2: f64) -> u32 {
    let (at, [lows, highs]) = (at.as_ref(), sides.each_ref().map(AsRef::as_ref));
    let gaps2 = gaps2(&lows[..P::DIM], &highs[..P::DIM], at);
    let any = gaps2.iter().fold(false, |any, &gap2| any | (gap2 <= limit2));
    if any { masks.at_most(&gaps2, limit2) } else { 0 }
}

/// Bisects a set until its parts are blocks. Coordinates are compared by their leading bits only, because the last bits
/// of a key hold the position of the point. Any division would be correct.
fn divide<P: Point>(points: &[P], order: &mut [u32], keys: &mut Vec<u64>) {
    if order.len() <= LANES {
        return;
    }
    let (low, high) = bounds(order.iter().map(|&i| points[i as usize]));
    let side = |axis: usize| high.coord(axis) - low.coord(axis);
    let axis = (1..P::DIM).fold(0, |longest, axis| if side(axis) > side(longest) { axis } else { longest });
    let half = order.len().div_ceil(LANES).div_ceil(2) * LANES;
    let position_bits = order.len().next_power_of_two() as u64 - 1;
    keys.clear();
    keys.extend((0u64..).zip(order.iter()).map(|(at, &i)| {
        let bits = points[i as usize].coord(axis).to_bits();
        // Negative numbers have all bits inverted, so that keys are ordered as the coordinates are.
        let ordered = if bits >> 63 == 0 { bits | 1 << 63 } else { !bits };
        ordered & !position_bits | at
    }));
    keys.select_nth_unstable(half);
    // Each position is replaced by the point at that position.
    for key in keys.iter_mut() {
        *key = u64::from(order[(*key & position_bits) as usize]);
    }
    for (i, &key) in order.iter_mut().zip(keys.iter()) {
        *i = key as u32;
    }
    let (below, above) = order.split_at_mut(half);
    divide(points, below, keys);
    divide(points, above, keys);
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::incremental::tests::nasty::{KINDS, set};
    use crate::point::dist2;

    fn check_searches<P: Point>() {
        for kind in KINDS {
            for size in [1, 2, 7, 8, 9, 63, 64, 65, 200, 600] {
                let points = set::<P>(kind, size, 3);
                let blocks = KdBlocks::of(&points);
                let mut positions = blocks.order().to_vec();
                positions.sort_unstable();
                assert!(positions.into_iter().eq(0..points.len() as u32), "{kind}");
                for (i, &centre) in points.iter().enumerate() {
                    for limit2 in [0.0, dist2(centre, points[i * 7 % points.len()]), f64::INFINITY] {
                        let mut list = NeighbourList::default();
                        list.push((9.0, 9));
                        blocks.find_within(centre, limit2, 100, &mut list);
                        let mut found: Vec<_> = list.iter().collect();
                        assert_eq!(found.remove(0), (9.0, 9));
                        found.sort_by_key(|found| found.1);
                        let all = points.iter().zip(100..).map(|(&x, number)| (dist2(x, centre), number));
                        let near: Vec<(f64, u32)> = all.filter(|&(d2, _)| d2 > 0.0 && d2 <= limit2).collect();
                        assert_eq!(found, near, "{kind} {size}");
                    }
                }
            }
        }
    }

    #[test]
    fn searches_match_all_pairs_in_space() {
        check_searches::<DVec3>();
    }

    #[test]
    fn searches_match_all_pairs_in_the_plane() {
        check_searches::<DVec2>();
    }

    #[test]
    fn an_empty_set_has_no_neighbours() {
        let blocks = KdBlocks::<DVec3>::of(&[]);
        let mut found = NeighbourList::default();
        blocks.find_within(DVec3::ZERO, f64::INFINITY, 0, &mut found);
        assert!(blocks.is_empty() && found.is_empty());
    }
}
