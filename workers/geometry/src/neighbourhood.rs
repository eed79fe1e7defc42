//! Neighbourhood systems: a ball for every point.
//!
//! **Statement** (paper, Section 2). A `k`-ply neighbourhood system of `p_1..p_n` is a set of closed balls `B_i`
//! centred at `p_i` such that no point lies strictly inside more than `k` of them. The balls that extend to the `k`-th
//! nearest neighbour have ply at most `tau_d k`, where `tau_d` is the kissing number (Miller, Teng, Thurston and
//! Vavasis 1997).
//!
//! A ball is stored by its squared radius, which [`dist2`] computes. So all workers agree that a point at exactly the
//! distance of the radius is inside. Lists of nearest neighbours keep *all* points no farther than the `k`-th
//! ([`crate::selection`]), so lists of parts can be merged in any order.
//!
//! **Work and depth.** The direct search tests `m^2` pairs in O(1) vector steps and segmented scans.

#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

pub use crate::bounds::{Bounds, bounds, box_dist2, join_bounds};
use crate::coordinate_arrays::{CoordinateArrays, LANES, PairVisitor, one_by_one};
use crate::cost::Cost;
use crate::kd_blocks::KdBlocks;
use crate::lists::Lists;
use crate::point::{Point, dist2};
use crate::selection::NeighbourList;
use crate::simd::Interval;

/// The nearest neighbours of many points, ties included. For each point it stores the squared distance of the `k`-th
/// neighbour, infinite if there are fewer, and the positions of the neighbours in the caller's table. Distances are not
/// stored; callers recompute them by [`dist2`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NearestLists {
    /// For each point, the squared distance of its `k`-th nearest neighbour.
    pub kth2: Vec<f64>,
    /// The lists of neighbours; each is unordered.
    lists: Lists<u32>,
    /// For each point, the position of its list in `lists`. Empty if the lists are in the order of the points.
    positions: Vec<u32>,
}

impl NearestLists {
    /// Creates an empty collection with room for `lists` lists and `items` neighbours in total.
    pub fn with_capacity(lists: usize, items: usize) -> Self {
        let (kth2, lists) = (Vec::with_capacity(lists), Lists::with_capacity(lists, items));
        NearestLists { kth2, lists, positions: Vec::new() }
    }

    /// Appends the list of one point, and the squared distance of its `k`-th neighbour.
    #[inline]
    pub fn push(&mut self, kth2: f64, list: impl IntoIterator<Item = u32>) {
        self.kth2.push(kth2);
        self.lists.push(list);
    }

    /// Returns the squared distance of the `k`-th neighbour of a point, and its neighbours.
    pub fn of(&self, point: u32) -> (f64, &[u32]) {
        let position = self.positions.get(point as usize).map_or(point, |&position| position);
        (self.kth2[point as usize], &self.lists[position as usize])
    }

    /// Returns the number of neighbours in all lists.
    pub fn items(&self) -> usize {
        self.lists.items()
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.kth2.len()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.kth2.is_empty()
    }

    /// Iterates over the points: the squared distance of the `k`-th neighbour, and the neighbours.
    pub fn iter(&self) -> impl Iterator<Item = (f64, &[u32])> {
        (0..self.len() as u32).map(|point| self.of(point))
    }
}

/// Finds, for every row, the columns no farther than its `k`-th nearest column, ties included, and at most
/// `limit2(row)` away. Tests all pairs. Each list is in the order of the columns. A column with the row's own table
/// position is skipped.
pub fn nearest_direct<P: Point>(
    table: &[P],
    rows: &[u32],
    cols: &[u32],
    k: usize,
    limit2: impl Fn(usize) -> f64,
    cost: &mut Cost,
) -> NearestLists {
    let at = |&i: &u32| table[i as usize];
    let points: Vec<P> = rows.iter().map(at).collect();
    let columns = CoordinateArrays::of(cols.iter().map(at));
    let bounds = (0..rows.len()).map(limit2).collect();
    let mut nearest = Nearest::new(rows, cols, k, bounds);
    cost.all_pairs_to_nearest(&points, &columns, k, &mut nearest);
    nearest.lists
}

/// Finds, for every point of a set, its `k` nearest neighbours, ties included, as [`nearest_direct`] does for the set
/// with itself. Lists are in the order of the slice from which the blocks were made. The first point of that slice has
/// the table position `start`.
pub fn nearest_in_blocks<P: Point>(
    blocks: &KdBlocks<P>,
    start: u32,
    k: usize,
    cost: &mut Cost,
) -> NearestLists {
    let members: Vec<u32> = blocks.order().iter().map(|i| start + i).collect();
    let mut nearest = Nearest::new(&members, &members, k, vec![f64::INFINITY; members.len()]);
    nearest.starts_small = k > 1;
    nearest.lists = NearestLists::with_capacity(members.len(), members.len() * k.min(members.len()));
    cost.all_pairs_in_blocks(blocks, &mut nearest);
    let mut pairs = cost.sweep();
    for _ in &members {
        pairs.visit_all(&members);
    }
    cost.charge_lists(pairs, k);
    let mut found = nearest.lists;
    let (mut kth2, mut positions) = (vec![0.0; members.len()], vec![0; members.len()]);
    for (position, (&i, &of_place)) in (0u32..).zip(blocks.order().iter().zip(&found.kth2)) {
        (kth2[i as usize], positions[i as usize]) = (of_place, position);
    }
    (found.kth2, found.positions) = (kth2, positions);
    found
}

/// Selects the `k` nearest columns of each row.
///
/// If the rows are the columns, the list of one row bounds the lists of its neighbours. Let the list of a row have
/// radius `r`, and let another row be at distance `d` from it. The ball of radius `r + d` around the second row
/// contains at least as many other points as the ball of radius `r` around the first. Most rows have enough
/// neighbours within little more than `r`. So a row that may be visited twice starts with a limit slightly above `r`.
struct Nearest<'a> {
    k: usize,
    rows: &'a [u32],
    cols: &'a [u32],
    /// For each row, the squared distance beyond which it needs no columns.
    bounds: Vec<f64>,
    are_same: bool,
    /// For each row, the nearest other row whose list is complete and contains it: its squared distance, and the
    /// squared radius of its list.
    hints: Vec<(f64, f64)>,
    limit2: f64,
    /// Whether a row may start with a smaller limit. After such a start, `wider2` is the limit of its second visit.
    starts_small: bool,
    wider2: Option<f64>,
    /// The column that is the current row, or `u32::MAX` if the row is not a column.
    own: u32,
    /// Neighbours found for the current row, as columns.
    found: NeighbourList,
    /// Length of `found` at which it is pruned.
    full: usize,
    lists: NearestLists,
}

impl<'a> Nearest<'a> {
    fn new(rows: &'a [u32], cols: &'a [u32], k: usize, bounds: Vec<f64>) -> Self {
        let are_same = rows == cols;
        let unknown = (f64::INFINITY, f64::INFINITY);
        Nearest {
            k,
            rows,
            cols,
            bounds,
            are_same,
            hints: if are_same { vec![unknown; rows.len()] } else { Vec::new() },
            limit2: 0.0,
            starts_small: false,
            wider2: None,
            own: 0,
            found: NeighbourList::default(),
            full: 0,
            lists: NearestLists::default(),
        }
    }

    /// Prunes the list when it reaches its length limit. Tied neighbours all remain, so the limit then grows to twice
    /// the length.
    #[inline]
    fn prune_if_full(&mut self) {
        if self.found.len() >= self.full {
            self.limit2 = self.limit2.min(self.found.keep_kth(self.k));
            self.full = self.full.max(2 * self.found.len());
        }
    }
}

/// Squared radius of a row's first visit, relative to the squared radius of its neighbour's list.
const FIRST_LIMIT: f64 = 1.2;

/// Returns the length at which lists are first pruned.
fn full_at(k: usize) -> usize {
    4 * k + 16
}

impl PairVisitor for Nearest<'_> {
    fn begin(&mut self, row: usize) -> f64 {
        self.found.clear();
        self.full = full_at(self.k);
        let index = self.rows[row];
        let own = if self.are_same { Some(row) } else { self.cols.iter().position(|&c| c == index) };
        self.own = own.map_or(u32::MAX, |at| at as u32);
        self.limit2 = self.bounds[row];
        self.wider2 = None;
        if let Some(&(d2, radius2)) = self.hints.get(row) {
            let reach = d2.sqrt() + radius2.sqrt();
            self.limit2 = self.limit2.min(reach * reach * (1.0 + 1e-12));
            let small2 = FIRST_LIMIT * radius2;
            if self.starts_small && small2 < self.limit2 {
                self.wider2 = Some(self.limit2);
                self.limit2 = small2;
            }
        }
        self.limit2
    }

    #[inline]
    fn visit(&mut self, column: usize, d2: f64) -> f64 {
        if column as u32 == self.own {
            return self.limit2;
        }
        if self.k == 1 && d2 < self.limit2 {
            self.found.clear();
            self.limit2 = d2;
        }
        self.found.push((d2, column as u32));
        self.prune_if_full();
        self.limit2
    }

    #[inline(always)]
    fn visit_lanes(&mut self, first: usize, distances2: &[f64; LANES], limit2: f64) -> f64 {
        if self.k == 1 || (self.own as usize).wrapping_sub(first) < LANES {
            return one_by_one(distances2, limit2, |lane, d2| self.visit(first + lane, d2));
        }
        let positions = std::array::from_fn(|lane| (first + lane) as u32);
        self.found.take_lanes(distances2, &positions, Interval { above: -1.0, limit: limit2 });
        self.prune_if_full();
        self.limit2
    }

    #[inline]
    fn retry(&mut self, _row: usize) -> Option<f64> {
        let wider2 = self.wider2.take()?;
        if self.found.len() >= self.k {
            return None;
        }
        self.found.clear();
        self.limit2 = wider2;
        Some(wider2)
    }

    fn end(&mut self, row: usize) {
        let kth = self.found.keep_kth(self.k);
        if self.are_same {
            for (d2, column) in self.found.iter().filter(|found| found.1 as usize > row) {
                let hint = &mut self.hints[column as usize];
                if d2 < hint.0 {
                    *hint = (d2, kth);
                }
            }
        }
        self.lists.push(kth, self.found.positions().iter().map(|&column| self.cols[column as usize]));
    }
}

/// Returns the largest number of balls (given by squared radii) that strictly contain one centre. It is a lower bound
/// on the ply, within a constant factor of it. Takes O(n^2) time and is meant for measurements.
pub fn ply_at_centres<P: Point>(points: &[P], radii2: &[f64]) -> usize {
    let inside = |&x: &P| points.iter().zip(radii2).filter(|&(&c, &r2)| dist2(x, c) < r2).count();
    points.iter().map(inside).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::incremental::tests::nasty::{KINDS, set};

    /// Sorts all distances. Returns the `k`-th squared distance and the other points no farther.
    fn by_sorting<P: Point>(points: &[P], row: usize, k: usize) -> (f64, Vec<u32>) {
        let others = || (0..points.len()).filter(|&i| i != row);
        let mut all: Vec<f64> = others().map(|i| dist2(points[i], points[row])).collect();
        all.sort_by(f64::total_cmp);
        let kth = all.get(k - 1).copied().unwrap_or(f64::INFINITY);
        (kth, others().filter(|&i| dist2(points[i], points[row]) <= kth).map(|i| i as u32).collect())
    }

    fn check_lists<P: Point>() {
        for kind in KINDS {
            for (size, k) in [(1, 1), (2, 1), (9, 3), (40, 1), (90, 8), (130, 48), (300, 2)] {
                let points = set::<P>(kind, size, 5);
                let members: Vec<u32> = (0..points.len() as u32).collect();
                let mut cost = Cost::default();
                let all = |_| f64::INFINITY;
                let direct = nearest_direct(&points, &members, &members, k, all, &mut cost);
                let blocks = nearest_in_blocks(&KdBlocks::of(&points), 0, k, &mut cost);
                for lists in [direct, blocks] {
                    assert_eq!(lists.len(), points.len());
                    for (row, (kth2, list)) in lists.iter().enumerate() {
                        let mut list = list.to_vec();
                        list.sort_unstable();
                        assert_eq!((kth2, list), by_sorting(&points, row, k), "{kind} {size} {k} {row}");
                    }
                }
            }
        }
    }

    #[test]
    fn lists_match_sorting_in_space() {
        check_lists::<DVec3>();
    }

    #[test]
    fn lists_match_sorting_in_the_plane() {
        check_lists::<DVec2>();
    }

    /// A row first searches little more than its neighbour's radius. If that ball has too few points, it searches the
    /// sum of radius and distance.
    #[test]
    fn a_row_is_revisited_if_its_first_limit_is_too_small() {
        let members = [0, 1, 2, 3];
        let mut nearest = Nearest::new(&members, &members, 2, vec![f64::INFINITY; 4]);
        nearest.starts_small = true;
        assert_eq!(nearest.begin(0), f64::INFINITY);
        nearest.visit(1, 1.0);
        nearest.visit(2, 4.0);
        assert_eq!(nearest.retry(0), None, "it had no limit");
        nearest.end(0);
        for (found, enough) in [(1, false), (2, true)] {
            assert_eq!(nearest.begin(1), FIRST_LIMIT * 4.0);
            (0..found).for_each(|i| {
                nearest.visit(2 * i, 1.0 + i as f64);
            });
            let again = nearest.retry(1);
            assert_eq!(again.is_none(), enough);
            if let Some(limit2) = again {
                assert!((9.0..9.0 + 1e-9).contains(&limit2) && nearest.found.is_empty());
                assert_eq!(nearest.retry(1), None, "once");
            }
        }
    }

    /// All other points have the same distance from the first. There are many more of them than a list holds before it
    /// is pruned.
    #[test]
    fn all_neighbours_at_one_distance_remain() {
        let whole = || (-10..=10).map(f64::from);
        let all = whole().flat_map(|x| whole().flat_map(move |y| whole().map(move |z| DVec3::new(x, y, z))));
        let points: Vec<DVec3> =
            std::iter::once(DVec3::ZERO).chain(all.filter(|x| x.length_squared() == 101.0)).collect();
        assert_eq!(points.len(), 1 + 168);
        let members: Vec<u32> = (0..points.len() as u32).collect();
        let mut cost = Cost::default();
        let nearest = nearest_in_blocks(&KdBlocks::of(&points), 0, 3, &mut cost);
        let (kth2, first) = nearest.of(0);
        let mut first = first.to_vec();
        first.sort_unstable();
        assert_eq!((kth2, first.as_slice()), (101.0, &members[1..]));
    }
}
