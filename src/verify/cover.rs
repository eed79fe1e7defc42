//! The sixth level: the cells cover space once.
//!
//! **Statement.** There are a cell `t` and a point `x` inside it such that `x` lies in no other closed cell, and `t`
//! lies on the inner side of the hyperplane of every boundary facet.
//!
//! In a periodic box, every translation of a cell counts as a cell. No edge of a cell is longer than the box along a periodic
//! axis, so few translations of a cell come near `x`. The hyperplanes of boundary facets are parallel to all periodic axes, so
//! `t` is on the inner side of all translations of one or of none.
//!
//! **Choice of `x` and `t`.** `x` is a quarter of a sum of four vertices; for `d > 3`, an eighth of a sum of eight. The last
//! vertex counts as often as necessary. So `x` is dyadic, and a multiple of it is exact in the integers of [`super::exact`].
//! In a triangulation of a convex region, an interior point of a cell is in no other closed cell, and every cell is on the
//! inner side of every facet. So any cell can be `t`. Since `t` is not flat, `x` is *strictly* on the inner side of every
//! boundary facet, as the theorem of [`super`] requires.
//!
//! **Work.** O(m) comparisons of boxes, exact arithmetic for the cells whose box contains `x`, and O(1) filtered
//! orientations per boundary facet.

use std::array::from_fn;

use num_bigint::BigInt;

use super::dyadic::sign_of;
use super::exact::{form, integers};
use super::fault::Fault;
use super::place::{Place, Steps};
use super::predicates::replaced;
use super::report::Tally;
use super::runner::Runner;
use super::soup::Soup;
use super::translations::{Enclosure, around, translations};

/// Checks the level `single cover`.
pub(super) fn check<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    boundary: &[u32],
    runner: &mut Runner<'_>,
) -> Tally {
    let count = soup.cells.len() as u32;
    let candidates = (count / 2..count).chain(0..count / 2);
    let Some(chosen) = { candidates }.find(|&cell| !soup.is_flat(cell)) else {
        return Tally::default();
    };
    let corners = soup.corners(chosen);
    let inner = enclosure(&corners);
    let mut tally = runner.each("single cover", soup.cells.len(), |range, tally| {
        tally.checked += range.len() as u64;
        for cell in range {
            let cell = cell as u32;
            let places = soup.corners(cell);
            if let Some(axis) = too_long(soup, &places) {
                tally.fault(Fault::LongerThanBox { cell: cell as u64, axis: axis as u64 });
                continue;
            }
            let is_own = |by: &P::Steps| cell == chosen && *by == P::Steps::ZERO;
            let mut others = translations(soup, &around(&places), &inner).into_iter();
            if others.any(|by| !is_own(&by) && covers(&soup.corners_at(cell, by), &corners)) {
                tally.fault(Fault::CoveredTwice { cell: chosen as u64, other: cell as u64 });
            }
        }
    });
    tally.append(runner.each("inside", boundary.len(), |range, tally| {
        tally.checked += range.len() as u64;
        for &facet in &boundary[range] {
            if !soup.is_flat(facet / N as u32) {
                check_facet(soup, facet, (chosen, &corners), tally);
            }
        }
    }));
    tally
}

/// Returns an axis along which an edge of a cell is longer than the box.
fn too_long<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    cell: &[P; N],
) -> Option<usize> {
    let is_long = |axis: usize| {
        let length = soup.lengths[axis];
        (0..N).any(|i| (0..i).any(|j| cell[i].is_farther(&cell[j], axis, length)))
    };
    if P::IS_PERIODIC { soup.periodic_axes().find(|&axis| is_long(axis)) } else { None }
}

/// Checks that the chosen cell is on the inner side of the hyperplane of a boundary facet, which is parallel to all periodic
/// axes.
fn check_facet<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    facet: u32,
    (chosen, corners): (u32, &[P; N]),
    tally: &mut Tally,
) {
    let (cell, slot) = (facet / N as u32, facet as usize % N);
    let outer = soup.corners(cell);
    let vertices = || soup.facet(cell, slot);
    let vertex = soup.cells[cell as usize][usize::from(slot == 0)];
    let is_parallel = |axis: &usize| {
        let image = soup.place(vertex.moved(P::Steps::along(*axis, 1)));
        replaced(&outer, slot, &image).is_eq()
    };
    if let Some(axis) = soup.periodic_axes().find(|axis| !is_parallel(axis)) {
        tally.fault(Fault::Slanted { cell: cell as u64, facet: vertices(), axis: axis as u64 });
    } else if corners.iter().any(|p| replaced(&outer, slot, p).is_lt()) {
        let (cell, other) = (chosen as u64, cell as u64);
        tally.fault(Fault::BeyondBoundary { cell, other, facet: vertices() });
    }
}

/// Returns the sum of the weights of the vertices in the interior point: 4, or 8 for `N > 4`.
const fn total<const N: usize>() -> usize {
    N.next_power_of_two()
}

/// Returns the weight of vertex `i` in a multiple of the interior point.
fn weight<const N: usize>(i: usize) -> u32 {
    if i + 1 == N { (total::<N>() + 1 - N) as u32 } else { 1 }
}

/// Returns a box around the interior point.
///
/// A fraction of a coordinate is exact unless it underflows. Each of the at most seven sums and products has a relative error
/// of at most `2^-53`. A partial sum is at most the largest coordinate. Twice the slack covers that of the vertices.
fn enclosure<P: Place<D>, const D: usize, const N: usize>(corners: &[P; N]) -> Enclosure<D> {
    let part = 1.0 / total::<N>() as f64;
    let at = |i: usize, k: usize| corners[i].near()[k] * part * f64::from(weight::<N>(i));
    let middle: [f64; D] = from_fn(|k| (0..N).map(|i| at(i, k)).sum());
    let margin: [f64; D] = from_fn(|k| {
        let largest = corners.iter().fold(0.0, |m: f64, p| m.max(p.near()[k].abs()));
        let slack = corners.iter().fold(0.0, |m: f64, p| m.max(p.slack(k)));
        8.0 * f64::EPSILON * largest + 2.0 * slack + f64::MIN_POSITIVE
    });
    [from_fn(|k| middle[k] - margin[k]), from_fn(|k| middle[k] + margin[k])]
}

/// Returns `true` if the closed cell `other`, positive or flat, contains the interior point of `corners`. Exact.
fn covers<P: Place<D>, const D: usize, const N: usize>(other: &[P; N], corners: &[P; N]) -> bool {
    let whole = integers(&[*other, *corners].concat());
    let scaled = |i: usize| -> [BigInt; D] { from_fn(|k| &whole[i][k] * total::<N>()) };
    let cell: [[BigInt; D]; N] = from_fn(scaled);
    let inner: [BigInt; D] = from_fn(|k| (0..N).map(|i| &whole[N + i][k] * weight::<N>(i)).sum());
    (0..N).all(|slot| {
        let at = |i: usize| if i == slot { &inner } else { &cell[i] };
        let rows: [[BigInt; D]; D] = from_fn(|i| from_fn(|k| &at(i + 1)[k] - &at(0)[k]));
        sign_of(&form(&rows)).is_ge()
    })
}
