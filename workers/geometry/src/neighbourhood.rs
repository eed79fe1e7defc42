//! Neighbourhood systems: a ball for every point.
//!
//! **Statement** (paper, Section 2). A `k`-ply neighbourhood system of `p_1..p_n` is a set of closed balls
//! `B_i` centred at `p_i` such that no point lies strictly inside more than `k` of them. The balls that
//! reach to the `k`-th nearest neighbour have ply at most `tau_d k`, `tau_d` the kissing number (Miller,
//! Teng, Thurston and Vavasis 1997).
//!
//! Balls are kept by their squared radius, computed by [`dist2`] and nothing else, so that a point at
//! the very distance of the radius is inside on every worker. Lists of nearest neighbours keep *all*
//! points no farther than the `k`-th ([`crate::selection`]), so that lists of parts can be merged in any order.
//!
//! **Work and depth.** Direct: `m^2` pairs, O(1) vector steps and segmented scans.

#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

pub use crate::bounds::{Bounds, bounds, box_dist2, join_bounds};
use crate::coordinate_arrays::{CoordinateArrays, LANES, Rows, one_by_one};
use crate::cost::Cost;
use crate::kd_blocks::KdBlocks;
use crate::lists::Lists;
use crate::point::{Point, dist2};
use crate::selection::NeighbourList;

/// The nearest points of many, ties included: for each the squared distance of the last that was wanted, infinite if
/// there are fewer, and their positions in the caller's table. Distances are not kept: there is one expression for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NearestLists {
    /// Squared distances of the `k`-th nearest.
    pub kth2: Vec<f64>,
    /// The nearest of each, in some order.
    lists: Lists<u32>,
    /// Where each point's list stands among them; nothing if they stand in the order of the points.
    places: Vec<u32>,
}

impl NearestLists {
    /// No lists, with room for so many of so many numbers in all.
    pub fn with_capacity(lists: usize, items: usize) -> Self {
        let (kth2, lists) = (Vec::with_capacity(lists), Lists::with_capacity(lists, items));
        NearestLists { kth2, lists, places: Vec::new() }
    }

    /// Adds what one point has.
    #[inline]
    pub fn push(&mut self, kth2: f64, list: impl IntoIterator<Item = u32>) {
        self.kth2.push(kth2);
        self.lists.push(list);
    }

    /// Squared distance of the `k`-th, and the nearest, of one point.
    pub fn of(&self, point: u32) -> (f64, &[u32]) {
        let place = self.places.get(point as usize).map_or(point, |&place| place);
        (self.kth2[point as usize], &self.lists[place as usize])
    }

    /// Number of items in all lists.
    pub fn items(&self) -> usize {
        self.lists.items()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.kth2.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.kth2.is_empty()
    }

    /// Squared distance of the `k`-th, and the nearest, of each.
    pub fn iter(&self) -> impl Iterator<Item = (f64, &[u32])> {
        (0..self.len() as u32).map(|point| self.of(point))
    }
}

/// For every row point, the columns within the `k`-th nearest other column (ties included), at most
/// `limit2(row)` away, by all pairs: in the order of the columns. A column equal to its row's own position is left
/// out.
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
    cost.close_pairs(&points, &columns, &mut nearest);
    nearest.lists
}

/// For every point of a set the `k` nearest others, ties included, as [`nearest_direct`] of the set with itself; in
/// the order of the slice that the blocks were made of, whose first point has this number.
pub fn nearest_in_blocks<P: Point>(
    blocks: &KdBlocks<P>,
    start: u32,
    k: usize,
    cost: &mut Cost,
) -> NearestLists {
    let members: Vec<u32> = blocks.order().iter().map(|i| start + i).collect();
    let mut nearest = Nearest::new(&members, &members, k, vec![f64::INFINITY; members.len()]);
    nearest.guesses = k > 1;
    nearest.lists = NearestLists::with_capacity(members.len(), members.len() * k.min(members.len()));
    cost.pairs_in_blocks(blocks, &mut nearest);
    let mut found = nearest.lists;
    let (mut kth2, mut places) = (vec![0.0; members.len()], vec![0; members.len()]);
    for (place, (&i, &of_place)) in (0u32..).zip(blocks.order().iter().zip(&found.kth2)) {
        (kth2[i as usize], places[i as usize]) = (of_place, place);
    }
    (found.kth2, found.places) = (kth2, places);
    found
}

/// The `k` nearest columns of row after row.
///
/// Where the rows are the columns, a row's list bounds its neighbours': within `r + d` of a point at distance `d`
/// lie as many others as within `r` of this one. Most have as many within little more than `r`, so where it may look
/// again a row looks there first.
struct Nearest<'a> {
    k: usize,
    rows: &'a [u32],
    cols: &'a [u32],
    /// Squared distances beyond which a row asks for nothing.
    bounds: Vec<f64>,
    are_same: bool,
    /// Of every row the nearest other one whose list has been seen and holds it: squared distance, and squared
    /// radius of that list.
    hints: Vec<(f64, f64)>,
    limit2: f64,
    /// Where a row looks again if it finds too few within its first limit: is it asked to, and how far.
    guesses: bool,
    wider2: Option<f64>,
    /// The column that the row at hand is itself.
    own: u32,
    /// Columns found for the row at hand, by their positions.
    found: NeighbourList,
    /// Its length when it is pruned next.
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
            guesses: false,
            wider2: None,
            own: 0,
            found: NeighbourList::default(),
            full: 0,
            lists: NearestLists::default(),
        }
    }

    /// A list as long as it may get before it is pruned. Of many at the same distance all stay: the next time is when there
    /// are twice as many.
    #[inline]
    fn prune_if_full(&mut self) {
        if self.found.len() >= self.full {
            self.limit2 = self.limit2.min(self.found.keep_kth(self.k));
            self.full = self.full.max(2 * self.found.len());
        }
    }
}

/// The squared radius of a row's first look, to that of its neighbour's list.
const GUESS: f64 = 1.2;

/// Lists are pruned at this length.
fn full_at(k: usize) -> usize {
    4 * k + 16
}

impl Rows for Nearest<'_> {
    fn begin(&mut self, row: usize) -> f64 {
        self.found.clear();
        self.full = full_at(self.k);
        let number = self.rows[row];
        let own = if self.are_same { Some(row) } else { self.cols.iter().position(|&c| c == number) };
        self.own = own.map_or(u32::MAX, |at| at as u32);
        self.limit2 = self.bounds[row];
        self.wider2 = None;
        if let Some(&(d2, radius2)) = self.hints.get(row) {
            let reach = d2.sqrt() + radius2.sqrt();
            self.limit2 = self.limit2.min(reach * reach * (1.0 + 1e-12));
            let guess2 = GUESS * radius2;
            if self.guesses && guess2 < self.limit2 {
                self.wider2 = Some(self.limit2);
                self.limit2 = guess2;
            }
        }
        self.limit2
    }

    #[inline]
    fn near(&mut self, column: usize, d2: f64) -> f64 {
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
    fn near_together(&mut self, first: usize, distances2: &[f64; LANES], limit2: f64) -> f64 {
        if self.k == 1 || (self.own as usize).wrapping_sub(first) < LANES {
            return one_by_one(distances2, limit2, |lane, d2| self.near(first + lane, d2));
        }
        let numbers = std::array::from_fn(|lane| (first + lane) as u32);
        self.found.take_lanes(distances2, &numbers, (-1.0, limit2));
        self.prune_if_full();
        self.limit2
    }

    #[inline]
    fn again(&mut self, _row: usize) -> Option<f64> {
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
        self.lists.push(kth, self.found.numbers().iter().map(|&column| self.cols[column as usize]));
    }
}

/// The largest number of balls (squared radii) strictly containing one of the centres: a lower bound
/// of the system's ply that is within a factor of a constant of it. O(n^2); for measurements.
pub fn ply_at_centres<P: Point>(points: &[P], radii2: &[f64]) -> usize {
    let inside = |&x: &P| points.iter().zip(radii2).filter(|&(&c, &r2)| dist2(x, c) < r2).count();
    points.iter().map(inside).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::incremental::tests::nasty::{KINDS, set};

    /// By sorting all: the `k`-th squared distance, and the others no farther.
    fn by_sorting<P: Point>(points: &[P], row: usize, k: usize) -> (f64, Vec<u32>) {
        let others = || (0..points.len()).filter(|&i| i != row);
        let mut all: Vec<f64> = others().map(|i| dist2(points[i], points[row])).collect();
        all.sort_by(f64::total_cmp);
        let kth = all.get(k - 1).copied().unwrap_or(f64::INFINITY);
        (kth, others().filter(|&i| dist2(points[i], points[row]) <= kth).map(|i| i as u32).collect())
    }

    fn lists_are_those_of_sorting<P: Point>() {
        for kind in KINDS {
            for (size, k) in [(1, 1), (2, 1), (9, 3), (40, 1), (90, 8), (130, 48), (300, 2)] {
                let points = set::<P>(kind, size, 5);
                let members: Vec<u32> = (0..points.len() as u32).collect();
                let mut cost = Cost::ZERO;
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
    fn in_space() {
        lists_are_those_of_sorting::<DVec3>();
    }

    #[test]
    fn in_the_plane() {
        lists_are_those_of_sorting::<DVec2>();
    }

    /// A row looks within little more than its neighbour's radius first, and within the sum of both distances if that
    /// holds too few.
    #[test]
    fn a_row_looks_again_where_its_first_look_finds_too_few() {
        let members = [0, 1, 2, 3];
        let mut nearest = Nearest::new(&members, &members, 2, vec![f64::INFINITY; 4]);
        nearest.guesses = true;
        assert_eq!(nearest.begin(0), f64::INFINITY);
        nearest.near(1, 1.0);
        nearest.near(2, 4.0);
        assert_eq!(nearest.again(0), None, "it had no limit");
        nearest.end(0);
        for (found, enough) in [(1, false), (2, true)] {
            assert_eq!(nearest.begin(1), GUESS * 4.0);
            (0..found).for_each(|i| {
                nearest.near(2 * i, 1.0 + i as f64);
            });
            let again = nearest.again(1);
            assert_eq!(again.is_none(), enough);
            if let Some(limit2) = again {
                assert!((9.0..9.0 + 1e-9).contains(&limit2) && nearest.found.is_empty());
                assert_eq!(nearest.again(1), None, "once");
            }
        }
    }

    /// All the others are at one distance from the first: far more than a list holds before it is pruned.
    #[test]
    fn many_at_one_distance_all_stay() {
        let whole = || (-10..=10).map(f64::from);
        let all = whole().flat_map(|x| whole().flat_map(move |y| whole().map(move |z| DVec3::new(x, y, z))));
        let points: Vec<DVec3> =
            std::iter::once(DVec3::ZERO).chain(all.filter(|x| x.length_squared() == 101.0)).collect();
        assert_eq!(points.len(), 1 + 168);
        let members: Vec<u32> = (0..points.len() as u32).collect();
        let mut cost = Cost::ZERO;
        let nearest = nearest_in_blocks(&KdBlocks::of(&points), 0, 3, &mut cost);
        let (kth2, first) = nearest.of(0);
        let mut first = first.to_vec();
        first.sort_unstable();
        assert_eq!((kth2, first.as_slice()), (101.0, &members[1..]));
    }
}
