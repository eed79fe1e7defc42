//! From exact points to doubles, without flat or inverted cells.
//!
//! **Statement.** The points on parts are rounded. If a cell is then not positive (exact sign), one of its points on
//! parts moves. It moves along its part by at most half the way to its neighbours there, and by some units in the last
//! place in a direction of the grid. It stays within half the distance from its carrier that [`crate::conformity`]
//! admits. A move is accepted if all cells at the point are positive afterwards, or if fewer of them are not positive.
//! Sweeps end when no point moves.
//!
//! **Work and depth.** O(k) moves for each of the cells that are not positive, and the cells at its points.

use glam::DVec3;
use septet_geometry::predicates::{Sign, orientation};

use crate::conformity::OFF;

/// The largest number of sweeps.
const SWEEPS: usize = 16;

/// The moves along a part, relative to the distance to the next point.
const ALONG: [f64; 9] = [0.0, 0.0625, -0.0625, 0.125, -0.125, 0.25, -0.25, 0.5, -0.5];

/// The moves in a direction of the grid, in units in the last place of the largest coordinate.
const UNITS: [f64; 7] = [0.0, 1.0, 4.0, 16.0, 64.0, 256.0, 1024.0];

/// A point on a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct OnPart {
    pub(super) vertex: u32,
    /// The points before and after it on the part.
    pub(super) between: [u32; 2],
}

/// Moves points until all cells are positive. All points are moved to places that can be written (`snapped`) first.
/// Returns the number of cells that rounding would have made flat or inverted.
///
/// # Errors
/// Returns the cells that are not positive.
pub(super) fn settle(
    at: &mut [DVec3],
    movable: &[OnPart],
    cells: &[[u32; 4]],
    snapped: impl Fn(DVec3) -> DVec3,
) -> Result<u64, Vec<[u32; 4]>> {
    let bad = |at: &[DVec3]| cells.iter().copied().filter(|c| !is_good(at, c)).collect::<Vec<_>>();
    for point in movable {
        at[point.vertex as usize] = snapped(at[point.vertex as usize]);
    }
    let mut open = bad(at);
    let first = open.len() as u64;
    if open.is_empty() {
        return Ok(first);
    }
    let mut star: Vec<Vec<u32>> = vec![Vec::new(); at.len()];
    for (i, cell) in (0u32..).zip(cells) {
        for &v in cell {
            star[v as usize].push(i);
        }
    }
    let largest = at.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    for _ in 0..SWEEPS {
        let mut touched: Vec<u32> = open.as_flattened().to_vec();
        touched.sort_unstable();
        touched.dedup();
        let mut has_moved = false;
        for point in movable.iter().filter(|p| touched.binary_search(&p.vertex).is_ok()) {
            let around = star[point.vertex as usize].iter().map(|&c| cells[c as usize]);
            let wishes = places(at, point, largest).map(&snapped);
            has_moved |= shift(at, point.vertex, &around.collect::<Vec<_>>(), wishes);
        }
        open = bad(at);
        if open.is_empty() {
            return Ok(first);
        }
        if !has_moved {
            break;
        }
    }
    Err(open)
}

/// Whether a cell is positive.
fn is_good(at: &[DVec3], cell: &[u32; 4]) -> bool {
    orientation(&cell.map(|v| at[v as usize])) == Sign::Positive
}

/// Moves a vertex to the first of some places where all cells around it are positive, or else to the first one where
/// the fewest are not. Returns whether it moved.
fn shift(at: &mut [DVec3], vertex: u32, around: &[[u32; 4]], wishes: impl Iterator<Item = DVec3>) -> bool {
    let v = vertex as usize;
    let wrong = |at: &[DVec3]| around.iter().filter(|cell| !is_good(at, cell)).count();
    let (first, mut best) = (at[v], (wrong(at), at[v]));
    if best.0 == 0 {
        return false;
    }
    for place in wishes {
        at[v] = place;
        let count = wrong(at);
        if count < best.0 {
            best = (count, place);
            if count == 0 {
                break;
            }
        }
    }
    at[v] = best.1;
    at[v] != first
}

/// Returns the places to which a point may move, in the order in which they are tried.
fn places<'a>(at: &[DVec3], point: &OnPart, largest: f64) -> impl Iterator<Item = DVec3> + use<'a> {
    let from = at[point.vertex as usize];
    let [before, after] = point.between.map(|v| at[v as usize]);
    let unit = f64::EPSILON * 0.5 * largest;
    let grid =
        (0..27).map(|i| DVec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1)));
    let grid: Vec<DVec3> = grid.filter(|d| *d != DVec3::ZERO).collect();
    let most = 0.5 * OFF * largest;
    UNITS.into_iter().flat_map(move |units| {
        let grid = grid.clone();
        ALONG.into_iter().flat_map(move |along| {
            let to = if along < 0.0 { before } else { after };
            let middle = from + (to - from) * along.abs();
            let count = if units == 0.0 { 1 } else { grid.len() };
            let offsets: Vec<DVec3> = grid[..count].iter().map(|d| *d * (units * unit)).collect();
            offsets.into_iter().filter(move |o| o.length() <= most).map(move |o| middle + o)
        })
    })
}
