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
//! In a periodic box, the walk is among all translations of cells, and leads to the image of the point in the box.
//!
//! **Work.** O(h log h) for the order of h places, that of the leaves of a k-d tree. Each walk starts at the cell of the
//! place before. It is short unless the cells are thin. It takes O(m) at most.

use std::cmp::Ordering;

use super::facets::{BROKEN, Facets};
use super::fault::Fault;
use super::place::{Place, Steps, Vertex};
use super::predicates::replaced;
use super::report::Tally;
use super::runner::Runner;
use super::soup::Soup;
use super::translations::{around, translations};

/// The cells, where a walk searches.
pub(super) struct Walk<'a, P: Place<D>, const D: usize, const N: usize> {
    /// The cells, which cover a convex region once.
    pub soup: &'a Soup<P, D, N>,
    /// Their facets.
    pub facets: &'a Facets,
    /// The largest number of steps of a walk. Then all cells are searched.
    pub most: u64,
}

/// The end of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found<S> {
    /// The closed translated cell contains the point.
    In(Moved<S>),
    /// The point is outside all cells, beyond a boundary facet of the translated cell.
    Beyond(Moved<S>),
}

/// A translated cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Moved<S> {
    pub cell: u32,
    pub by: S,
}

/// Checks the level `hidden sites`. All other levels have passed.
pub(super) fn check<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    facets: &Facets,
    runner: &mut Runner<'_>,
) -> Tally {
    let mut order = soup.concealed.clone();
    let near: Vec<[f64; D]> = if P::IS_PERIODIC {
        (0..soup.points.len() as u32).map(|i| *soup.place(soup.base(i)).near()).collect()
    } else {
        Vec::new()
    };
    let points = if P::IS_PERIODIC { &near } else { &soup.points };
    runner.on_threads(&mut || sort_by_place(points, &mut order));
    let walk = Walk { soup, facets, most: 4 * soup.cells.len() as u64 + 100 };
    runner.each("hidden sites", order.len(), |range, tally| {
        let mut start = walk.start();
        for &point in &order[range] {
            tally.checked += 1;
            let place = soup.base(point);
            start = match walk.to(start, &soup.place(place)) {
                Found::In(moved) => {
                    let Moved { cell, by } = moved;
                    // The cell stays, and the point is translated back.
                    let site = Vertex { steps: place.steps.minus(by), ..place };
                    if soup.in_sphere(cell, &soup.corners(cell), site) != Ordering::Less {
                        tally.fault(Fault::NotHidden { point: point as u64, cell: cell as u64 });
                    }
                    moved
                }
                Found::Beyond(moved) => {
                    tally.fault(Fault::Outside { point: point as u64, cell: moved.cell as u64 });
                    moved
                }
            };
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

impl<P: Place<D>, const D: usize, const N: usize> Walk<'_, P, D, N> {
    /// Returns a cell in the middle of the list, translated such that its first vertex is in the box.
    fn start(&self) -> Moved<P::Steps> {
        let cell = self.soup.cells.len() as u32 / 2;
        let by = self
            .soup
            .cells
            .get(cell as usize)
            .map_or(P::Steps::ZERO, |row| self.soup.base(row[0].row).steps.minus(row[0].steps));
        Moved { cell, by }
    }

    /// Walks from a cell to a place.
    pub fn to(&self, start: Moved<P::Steps>, place: &P) -> Found<P::Steps> {
        let (mut here, mut entry) = (start, None);
        for step in 0..self.most {
            let Moved { cell, by } = here;
            let corners = self.soup.corners_at(cell, by);
            let first = mixed(step) as usize % N;
            let mut slots = (first..first + N).map(|slot| slot % N).filter(|&slot| Some(slot) != entry);
            let Some(exit) = slots.find(|&slot| replaced(&corners, slot, place).is_lt()) else {
                return Found::In(here);
            };
            let twin = self.facets.twin[cell as usize * N + exit];
            if twin >= BROKEN {
                return Found::Beyond(here);
            }
            here = Moved { cell: twin / N as u32, by: by.plus(self.soup.across(cell, exit, twin)) };
            entry = Some(twin as usize % N);
        }
        self.search(place).map_or(Found::Beyond(here), Found::In)
    }

    /// Searches all cells for one that contains a place.
    fn search(&self, place: &P) -> Option<Moved<P::Steps>> {
        let target = around(&[*place]);
        (0..self.soup.cells.len() as u32).find_map(|cell| {
            let all = translations(self.soup, &around(&self.soup.corners(cell)), &target);
            let contains = |by: &P::Steps| {
                let corners = self.soup.corners_at(cell, *by);
                (0..N).all(|slot| replaced(&corners, slot, place).is_ge())
            };
            Some(Moved { cell, by: all.into_iter().find(contains)? })
        })
    }
}
