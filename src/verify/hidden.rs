//! The last level, with weights: the points that are not vertices are hidden.
//!
//! **Statement.** For every place without a vertex, a closed cell contains the place, and the lift of its heaviest point is
//! strictly above the hyperplane through the lifts of the cell. If several cells contain the place, their hyperplanes agree
//! there, so any of them decides.
//!
//! **Search.** The level runs only if all others pass. Then the cells cover a convex region once. A point beyond a boundary
//! facet is outside all cells. Otherwise, a walk leads to the point, from cell to cell, through facets that have the point
//! strictly on the outer side. If no lifts tie, such walks have no cycles (Edelsbrunner 1989). Otherwise, a random
//! choice of the facet leaves every cycle sooner or later. If a walk is longer than [`Walk::most`], all cells are searched.
//!
//! **Work.** O(h log h) for the order of h places, that of the leaves of a k-d tree. Each walk starts at the cell of the
//! place before. It is short unless the cells are thin. It takes O(m) at most.

use std::cmp::Ordering;

use super::facets::{BROKEN, Facets};
use super::predicates::replaced;
use super::report::{Fault, Tally};
use super::runner::Runner;
use super::soup::Soup;

/// The cells, where a walk searches.
pub(super) struct Walk<'a, const D: usize, const N: usize> {
    /// The cells, which cover a convex region once.
    pub soup: &'a Soup<D, N>,
    /// Their facets.
    pub facets: &'a Facets,
    /// The largest number of steps of a walk. Then all cells are searched.
    pub most: u64,
}

/// The end of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// The closed cell contains the point.
    In(u32),
    /// The point is outside all cells, beyond a boundary facet of the cell.
    Beyond(u32),
}

/// Checks the level `hidden sites`. All other levels have passed.
pub(super) fn check<const D: usize, const N: usize>(
    soup: &Soup<D, N>,
    facets: &Facets,
    runner: &mut Runner<'_>,
) -> Tally {
    let mut order = soup.concealed.clone();
    runner.on_threads(&mut || sort_by_place(&soup.points, &mut order));
    let walk = Walk { soup, facets, most: 4 * soup.cells.len() as u64 + 100 };
    runner.each("hidden sites", order.len(), |range, tally| {
        let mut start = soup.cells.len() as u32 / 2;
        for &point in &order[range] {
            tally.checked += 1;
            let cell = match walk.to(start, &soup.points[point as usize]) {
                Found::In(cell) => {
                    if soup.in_sphere(cell, &soup.corners(cell), point) != Ordering::Less {
                        tally.fault(Fault::NotHidden { point: point as u64, cell: cell as u64 });
                    }
                    cell
                }
                Found::Beyond(cell) => {
                    tally.fault(Fault::Outside { point: point as u64, cell: cell as u64 });
                    cell
                }
            };
            start = cell;
        }
    })
}

/// Orders points like the leaves of a k-d tree, so that most neighbours in the order are close to each other.
fn sort_by_place<const D: usize>(points: &[[f64; D]], order: &mut [u32]) {
    if order.len() < 2 {
        return;
    }
    let coordinate = |i: u32, axis: usize| points[i as usize][axis];
    let width = |axis: usize| {
        let all = || order.iter().map(|&i| coordinate(i, axis));
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    let axis = (1..D).fold(0, |best, axis| if width(axis) > width(best) { axis } else { best });
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&i, &j| {
        coordinate(i, axis).total_cmp(&coordinate(j, axis)).then(i.cmp(&j))
    });
    let (low, high) = order.split_at_mut(middle);
    rayon::join(|| sort_by_place(points, low), || sort_by_place(points, high));
}

/// Returns a number that looks random (splitmix64).
fn mixed(x: u64) -> u64 {
    let z = x.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (z ^ (z >> 27)) >> 32
}

impl<const D: usize, const N: usize> Walk<'_, D, N> {
    /// Walks from a cell to a place.
    pub fn to(&self, start: u32, place: &[f64; D]) -> Found {
        let (mut cell, mut entry) = (start, None);
        for step in 0..self.most {
            let corners = self.soup.corners(cell);
            let first = mixed(step) as usize % N;
            let mut slots = (first..first + N).map(|slot| slot % N).filter(|&slot| Some(slot) != entry);
            let Some(exit) = slots.find(|&slot| replaced(&corners, slot, place).is_lt()) else {
                return Found::In(cell);
            };
            let twin = self.facets.twin[cell as usize * N + exit];
            if twin >= BROKEN {
                return Found::Beyond(cell);
            }
            (cell, entry) = (twin / N as u32, Some(twin as usize % N));
        }
        let contains = |&cell: &u32| {
            let corners = self.soup.corners(cell);
            (0..N).all(|slot| replaced(&corners, slot, place).is_ge())
        };
        (0..self.soup.cells.len() as u32).find(contains).map_or(Found::Beyond(cell), Found::In)
    }
}
