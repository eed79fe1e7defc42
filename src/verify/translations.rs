//! The translations of a cell that may contain a place.
//!
//! **Statement.** [`translations`] lists all translations of the lattice that move a box of floats, with the cell in it, onto
//! some point of another box. There may be more: the caller decides exactly.
//!
//! **Rounding.** Along an axis, translations by `k` lengths `L` with `low - most <= k L <= high - least` are sought. The rounded
//! quotients differ from the exact ones by at most four roundings of numbers that are at most `size / L`, where `size` is the
//! sum of all sizes. The margin is twice as large.
//!
//! **Work.** O(1) for each translation. In a triangulation, a cell is at most one length long along each axis, so there are at
//! most three along each axis.

use super::place::{FARTHEST, Place, Steps};
use super::soup::Soup;

/// A box around something: its lower and its upper corner.
pub(super) type Enclosure<const D: usize> = [[f64; D]; 2];

/// Returns a box around places.
pub(super) fn around<P: Place<D>, const D: usize>(places: &[P]) -> Enclosure<D> {
    // The sum is rounded once, by less than the margin of its size.
    let bound = |side: f64, axis: usize| {
        let of = |place: &P| {
            let (near, slack) = (place.near()[axis], place.slack(axis));
            if slack == 0.0 { near } else { near + side * (slack + f64::EPSILON * near.abs()) }
        };
        places.iter().map(of).fold(-side * f64::INFINITY, if side < 0.0 { f64::min } else { f64::max })
    };
    [std::array::from_fn(|axis| bound(-1.0, axis)), std::array::from_fn(|axis| bound(1.0, axis))]
}

/// Returns the translations of a box, with a cell in it, that may meet another box.
pub(super) fn translations<P: Place<D>, const D: usize, const N: usize>(
    soup: &Soup<P, D, N>,
    cell: &Enclosure<D>,
    other: &Enclosure<D>,
) -> Vec<P::Steps> {
    let mut found = vec![P::Steps::ZERO];
    for axis in 0..D {
        let (least, most) = (cell[0][axis], cell[1][axis]);
        let (low, high) = (other[0][axis], other[1][axis]);
        let length = soup.lengths[axis];
        if length == 0.0 {
            if most < low || least > high {
                found.clear();
            }
            continue;
        }
        let size = least.abs() + most.abs() + low.abs() + high.abs();
        let margin = 8.0 * f64::EPSILON * (size / length + 1.0);
        let bound = 4.0 * f64::from(FARTHEST);
        let from = ((low - most) / length - margin).ceil().clamp(-bound, bound) as i32;
        let to = ((high - least) / length + margin).floor().clamp(-bound, bound) as i32;
        let moved = |by: P::Steps| (from..=to).map(move |steps| by.plus(P::Steps::along(axis, steps)));
        found = found.into_iter().flat_map(moved).collect();
    }
    found
}
