//! The sixth level: the cells cover space once.
//!
//! **Statement.** There are a cell `t` and a point `x` inside it such that `x` lies in no other closed cell, and `t`
//! lies on the inner side of the plane of every boundary facet.
//!
//! **Choice of `x` and `t`.** `x` is a quarter of a sum of four vertices. In the plane, the last vertex counts twice. So `x`
//! is dyadic, and four times `x` is exact in the integers of [`super::exact`]. In a triangulation of a convex region, an
//! interior point of a cell is in no other closed cell, and every cell is on the inner side of every facet. So any cell can
//! be `t`. Since `t` is not flat, `x` is *strictly* on the inner side of every boundary facet, as the theorem of [`super`]
//! requires.
//!
//! **Work.** O(m) comparisons of boxes, exact arithmetic for the cells whose box contains `x`, and O(1) filtered
//! orientations per boundary facet.

use std::array::from_fn;

use num_bigint::BigInt;

use super::exact::{form, integers, sign_of};
use super::predicates::replaced;
use super::report::{Fault, Tally};
use super::runner::Runner;
use super::soup::Soup;

/// Checks the level `single cover`.
pub(super) fn check<const D: usize, const N: usize>(
    soup: &Soup<D, N>,
    boundary: &[u32],
    runner: &mut Runner<'_>,
) -> Tally {
    let count = soup.cells.len() as u32;
    let candidates = (count / 2..count).chain(0..count / 2);
    let Some(chosen) = { candidates }.find(|&cell| !soup.is_flat(cell)) else {
        return Tally::default();
    };
    let corners = soup.corners(chosen);
    let [low, high] = enclosure(&corners);
    let mut tally = runner.each("single cover", soup.cells.len(), |range, tally| {
        tally.checked += range.len() as u64;
        for cell in range.filter(|&cell| cell != chosen as usize) {
            let other = soup.corners(cell as u32);
            let apart =
                (0..D).any(|k| other.iter().all(|p| p[k] < low[k]) || other.iter().all(|p| p[k] > high[k]));
            if !apart && covers(&other, &corners) {
                tally.fault(Fault::CoveredTwice { cell: chosen as u64, other: cell as u64 });
            }
        }
    });
    tally.append(runner.each("inside", boundary.len(), |range, tally| {
        tally.checked += range.len() as u64;
        for &facet in &boundary[range] {
            let (cell, slot) = (facet / N as u32, facet as usize % N);
            let outer = soup.corners(cell);
            let beyond = corners.iter().any(|p| replaced(&outer, slot, p).is_lt());
            if beyond && !soup.is_flat(cell) {
                let facet = soup.facet(cell, slot);
                let (cell, other) = (chosen as u64, cell as u64);
                tally.fault(Fault::BeyondBoundary { cell, other, facet });
            }
        }
    }));
    tally
}

/// Returns the weight of vertex `i` in four times the interior point.
fn weight<const N: usize>(i: usize) -> u32 {
    if N == 3 && i == 2 { 2 } else { 1 }
}

/// Returns a box around the interior point, as its lower and upper corner.
///
/// A quarter of a coordinate is exact unless it underflows. Each of the three additions has a relative error of at most
/// `2^-53`. A partial sum is at most four quarters of the largest coordinate.
fn enclosure<const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> [[f64; D]; 2] {
    let middle: [f64; D] =
        from_fn(|k| (0..N).map(|i| corners[i][k] * 0.25 * f64::from(weight::<N>(i))).sum());
    let margin: [f64; D] = from_fn(|k| {
        let largest = corners.iter().fold(0.0, |m: f64, p| m.max(p[k].abs()));
        4.0 * f64::EPSILON * largest + f64::MIN_POSITIVE
    });
    [from_fn(|k| middle[k] - margin[k]), from_fn(|k| middle[k] + margin[k])]
}

/// Returns `true` if the closed cell `other`, positive or flat, contains the interior point of `corners`. Exact.
fn covers<const D: usize, const N: usize>(other: &[[f64; D]; N], corners: &[[f64; D]; N]) -> bool {
    let whole = integers(&[*other, *corners].concat());
    let scaled = |i: usize| -> [BigInt; D] { from_fn(|k| &whole[i][k] * 4) };
    let cell: [[BigInt; D]; N] = from_fn(scaled);
    let inner: [BigInt; D] = from_fn(|k| (0..N).map(|i| &whole[N + i][k] * weight::<N>(i)).sum());
    (0..N).all(|slot| {
        let at = |i: usize| if i == slot { &inner } else { &cell[i] };
        let rows: [[BigInt; D]; D] = from_fn(|i| from_fn(|k| &at(i + 1)[k] - &at(0)[k]));
        sign_of(&form(&rows)).is_ge()
    })
}
