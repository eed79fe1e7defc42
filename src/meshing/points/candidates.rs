//! Candidates, of which each cell of a tree over the size function has a constant number.
//!
//! **Statement.** A cell of side `s` and centre m is split iff `f(m) < k s`, with `k = max(1, 1.5 L) sqrt(d)`. The
//! tree is therefore balanced ([`crate::octree`]). The diagonal of a leaf is at most `f(m)`. Below the root, it
//! exceeds `f(m) / (2 max(1, 1.5 L) + L / 2)`. The name of a candidate consists of its cell and its index. Its
//! position in the cell is determined by a hash of seed and name.
//!
//! **Work and depth.** One evaluation of f per cell and candidate. The number of rounds is the number of levels.

use septet_geometry::cost::Cost;
use septet_geometry::hash::finalise;
use septet_geometry::point::Point;

use super::conflicts::Site;
use crate::bvh::Bounds;
use crate::executor::{Sequential, Uncounted, always};
use crate::octree::{Cell, CellKey, Cube, Decision, Grown, Rule, TooFine, grow};

/// The identity of a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name {
    /// The cell that contains it.
    pub cell: CellKey,
    /// The 0-based index within the cell.
    pub number: u32,
}

/// Hashes two 64-bit words. Every bit of the result depends on every bit of the arguments.
fn mixed(x: u64, y: u64) -> u64 {
    finalise(x ^ y.wrapping_add(0x9e37_79b9_7f4a_7c15))
}

impl Name {
    /// Returns a hash of seed, purpose and name.
    fn hash(self, seed: u64, purpose: u64) -> u64 {
        let [x, y, z] = self.cell.at.map(u64::from);
        let words = [purpose, u64::from(self.cell.level), x, y, z, u64::from(self.number)];
        words.into_iter().fold(mixed(seed, 0), mixed)
    }

    /// Returns the priority of a candidate. Smaller priorities come first. Names break ties between equal hashes.
    pub fn priority(self, seed: u64) -> (u64, Name) {
        (self.hash(seed, 0), self)
    }

    /// Returns a pseudorandom number in `[0, 1)` for each purpose.
    pub fn unit(self, seed: u64, purpose: u64) -> f64 {
        (self.hash(seed, purpose) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns the position in the cell.
    pub fn place<P: Point>(self, cell: &Cell<P>, seed: u64) -> P {
        let mut place = cell.centre;
        for i in 0..P::DIM {
            let unit = self.unit(seed, 1 + i as u64);
            place.set_coord(i, cell.centre.coord(i) + (unit - 0.5) * cell.side);
        }
        place
    }
}

/// A size function, and its Lipschitz constant.
pub struct LipschitzSize<'a, P> {
    /// The Lipschitz constant.
    pub lipschitz: f64,
    /// The function.
    pub at: &'a (dyn Fn(P) -> f64 + Sync),
}

impl<P: Point> Rule<P> for LipschitzSize<'_, P> {
    type Load = ();
    type Leaf = ();

    fn decide(&self, cell: &Cell<P>, (): &(), _own: &mut Cost) -> Decision<(), ()> {
        let k = (1.5 * self.lipschitz).max(1.0) * (P::DIM as f64).sqrt();
        if (self.at)(cell.centre) < k * cell.side { Decision::Split(()) } else { Decision::Keep(()) }
    }
}

/// Returns the cells of the tree for a box.
///
/// # Errors
/// Returns [`TooFine`] if there are more than `limit` cells.
pub fn cells<P: Point>(
    bounds: &Bounds<P>,
    sizing: &LipschitzSize<'_, P>,
    limit: u64,
) -> Result<(Cube<P>, Grown<()>), TooFine> {
    let cube = Cube::around(bounds);
    let grown = always(grow(&cube, sizing, &(), limit, &Uncounted(Sequential)))?;
    Ok((cube, grown))
}

/// Returns the candidates of a cell.
pub fn candidates<'a, P: Point>(
    cube: &Cube<P>,
    key: CellKey,
    count: u32,
    seed: u64,
    sizing: &'a LipschitzSize<'_, P>,
) -> impl Iterator<Item = (Name, Site<P>)> + use<'a, P> {
    let cell = cube.cell(key);
    (0..count).map(move |number| {
        let name = Name { cell: key, number };
        let at = name.place(&cell, seed);
        (name, Site { at, size: (sizing.at)(at) })
    })
}
