//! Candidates: a constant number in each cell of a tree over the size function.
//!
//! **Statement.** A cell of side `s` and centre m is split iff `f(m) < k s`, with `k = max(1, 1.5 L) sqrt(d)`. So the
//! tree is balanced ([`crate::octree`]), and a leaf's diagonal is at most `f(m)` and, below the root, more than
//! `f(m) / (2 max(1, 1.5 L) + L / 2)`. A candidate is named by its cell and its number, and its place in the cell
//! is a hash of seed and name.
//!
//! **Work and depth.** One evaluation of f for each cell and candidate; as many rounds as levels.

use septet_geometry::hash::finalise;
use septet_geometry::point::Point;

use super::conflicts::Site;
use crate::bvh::Bounds;
use crate::executor::Sequential;
use crate::octree::{Cell, Cube, Decision, Grown, Key, Rule, TooFine, grow};

/// A candidate's identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name {
    /// The cell that made it.
    pub cell: Key,
    /// Counted from 0 in the cell.
    pub number: u32,
}

/// A number of 64 bits that depends on every bit of its arguments.
fn mixed(x: u64, y: u64) -> u64 {
    finalise(x ^ y.wrapping_add(0x9e37_79b9_7f4a_7c15))
}

impl Name {
    /// A hash of seed, purpose and name.
    fn hash(self, seed: u64, purpose: u64) -> u64 {
        let [x, y, z] = self.cell.at.map(u64::from);
        let words = [purpose, u64::from(self.cell.level), x, y, z, u64::from(self.number)];
        words.into_iter().fold(mixed(seed, 0), mixed)
    }

    /// What decides between candidates: the smaller one goes first. Equal hashes are decided by the names.
    pub fn priority(self, seed: u64) -> (u64, Name) {
        (self.hash(seed, 0), self)
    }

    /// A number between 0 and 1 for each purpose.
    pub fn unit(self, seed: u64, purpose: u64) -> f64 {
        (self.hash(seed, purpose) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Where it lies in its cell.
    pub fn place<P: Point>(self, cell: &Cell<P>, seed: u64) -> P {
        let mut place = cell.centre;
        for i in 0..P::DIM {
            let unit = self.unit(seed, 1 + i as u64);
            place.set_coord(i, cell.centre.coord(i) + (unit - 0.5) * cell.side);
        }
        place
    }
}

/// A size function, to be asked for its Lipschitz constant and for values.
pub struct Sizing<'a, P> {
    /// The Lipschitz constant.
    pub lipschitz: f64,
    /// The function.
    pub at: &'a (dyn Fn(P) -> f64 + Sync),
}

impl<P: Point> Rule<P> for Sizing<'_, P> {
    type Load = ();
    type Leaf = ();

    fn decide(&self, cell: &Cell<P>, (): &()) -> Decision<(), ()> {
        let k = (1.5 * self.lipschitz).max(1.0) * (P::DIM as f64).sqrt();
        if (self.at)(cell.centre) < k * cell.side { Decision::Split(()) } else { Decision::Keep(()) }
    }
}

/// The cells of a box.
///
/// # Errors
/// [`TooFine`], if there are more than `limit`.
pub fn cells<P: Point>(
    bounds: &Bounds<P>,
    sizing: &Sizing<'_, P>,
    limit: u64,
) -> Result<(Cube<P>, Grown<()>), TooFine> {
    let cube = Cube::around(bounds);
    let grown = grow(&cube, sizing, &(), limit, &Sequential)?;
    Ok((cube, grown))
}

/// The candidates of a cell.
pub fn candidates<'a, P: Point>(
    cube: &Cube<P>,
    key: Key,
    count: u32,
    seed: u64,
    sizing: &'a Sizing<'_, P>,
) -> impl Iterator<Item = (Name, Site<P>)> + use<'a, P> {
    let cell = cube.cell(key);
    (0..count).map(move |number| {
        let name = Name { cell: key, number };
        let at = name.place(&cell, seed);
        (name, Site { at, size: (sizing.at)(at) })
    })
}
