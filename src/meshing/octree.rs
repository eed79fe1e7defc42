//! Octrees (quadtrees in the plane), grown level by level.
//!
//! **Statement.** A cell of level `l` is one of the `2^(d l)` equal cubes of a root cube. What a cell does is
//! decided by a [`Rule`] from the cell and from what its parent hands down: one parent, no neighbours, so a
//! level is one round, and the outcome does not depend on the order within it.
//!
//! *Balance.* Let `g` be K-Lipschitz, and let a cell with centre `m` and side `s` be split iff `g(m) < k s`. If
//! `k >= 1.5 K sqrt(d)`, cells that touch (if only in a corner) differ by one level at most. *Proof.* Let C of side
//! `s` be split, N of side `2s` touch C. Along each axis their centres are at most `s/2 + s` apart, so
//! `g(m_N) <= g(m_C) + 1.5 K sqrt(d) s < k s + k s`: N is split. So every cell of side `2s` that touches C is
//! split; the cells that touch C's children are no larger than those of C's level.
//!
//! **Source.** Mitchell and Vavasis (2000), who balance afterwards. **Work and depth.** One call of the rule for
//! each cell; depth the number of levels times a rule's.

use septet_geometry::point::Point;
use thiserror::Error;

use crate::bvh::Bounds;
use crate::executor::Executor;

/// Levels below the root: positions have 30 bits.
pub const DEEPEST: u8 = 30;

/// A cell's identity: its level and its position among the cells of that level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// The root has level 0.
    pub level: u8,
    /// Counted from the low corner of the root, below `2^level`; 0 beyond the dimension.
    pub at: [u32; 3],
}

impl Key {
    /// The whole cube.
    pub const ROOT: Key = Key { level: 0, at: [0; 3] };

    /// Child `i < 2^d`: bit `k` says which half along axis `k`.
    #[must_use]
    pub fn child<P: Point>(self, i: u32) -> Key {
        let half = |k: usize| if k < P::DIM { i >> k & 1 } else { 0 };
        Key { level: self.level + 1, at: [0, 1, 2].map(|k| 2 * self.at[k] + half(k)) }
    }
}

/// The cube that a tree divides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube<P> {
    /// Its low corner.
    pub low: P,
    /// Its side, a power of two.
    pub side: f64,
}

/// A cell with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<P> {
    /// Which one.
    pub key: Key,
    /// Its centre.
    pub centre: P,
    /// Its side.
    pub side: f64,
}

impl<P: Point> Cell<P> {
    /// Half of the diagonal: no point of the cell is farther from the centre.
    pub fn radius(&self) -> f64 {
        self.side * 0.5 * (P::DIM as f64).sqrt()
    }
}

impl<P: Point> Cube<P> {
    /// The smallest cube with a power of two for a side that holds a box in its middle.
    pub fn around(bounds: &Bounds<P>) -> Self {
        let extent = bounds.extent();
        let longest = (0..P::DIM).map(|i| extent.coord(i)).fold(f64::MIN_POSITIVE, f64::max);
        let below = f64::from_bits(longest.to_bits() >> 52 << 52);
        let side = if below == longest { below } else { 2.0 * below };
        let middle = (bounds.low + bounds.high) * 0.5;
        Cube { low: middle - P::splat(0.5 * side), side }
    }

    /// The cell of a key.
    pub fn cell(&self, key: Key) -> Cell<P> {
        let side = self.side / (1u64 << key.level) as f64;
        let mut centre = self.low;
        for i in 0..P::DIM {
            centre.set_coord(i, self.low.coord(i) + (f64::from(key.at[i]) + 0.5) * side);
        }
        Cell { key, centre, side }
    }
}

/// What becomes of a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision<Load, Leaf> {
    /// It is divided, and hands this down.
    Split(Load),
    /// It stays.
    Keep(Leaf),
    /// It stays, and nobody needs to know.
    Drop,
}

/// How cells are judged.
pub trait Rule<P: Point>: Sync {
    /// What a cell hands down to its children.
    type Load: Send + Sync;
    /// What a cell that stays is kept with.
    type Leaf: Send;

    /// Judges a cell by what its parent hands down.
    fn decide(&self, cell: &Cell<P>, inherited: &Self::Load) -> Decision<Self::Load, Self::Leaf>;
}

/// How many cells a level has, by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Level {
    /// Divided.
    pub split: u64,
    /// Kept.
    pub kept: u64,
    /// Dropped.
    pub dropped: u64,
}

/// A tree that has been grown.
#[derive(Clone, Debug, PartialEq)]
pub struct Grown<Leaf> {
    /// The cells that were kept, by levels, and within a level in the order of the parents and children.
    pub leaves: Vec<(Key, Leaf)>,
    /// Counts by level: as many rounds.
    pub levels: Vec<Level>,
}

/// Why a tree was not grown to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TooFine {
    /// Too many cells.
    #[error("the size function needs more than {limit} cells: raise the minimum size or the memory limit")]
    Cells {
        /// The limit.
        limit: u64,
    },
    /// Too many levels.
    #[error(
        "the size function needs cells smaller than the domain over 2^30, near {at:?}: raise the minimum size"
    )]
    Levels {
        /// A cell of the last level.
        at: Key,
    },
}

/// Grows a tree. The parents of a level are mapped, each to its children's verdicts, and these taken in order.
///
/// # Errors
/// [`TooFine`], as soon as there are more than `limit` cells.
pub fn grow<P: Point, R: Rule<P>>(
    cube: &Cube<P>,
    rule: &R,
    root: &R::Load,
    limit: u64,
    executor: &impl Executor,
) -> Result<Grown<R::Leaf>, TooFine> {
    let mut grown = Grown { leaves: Vec::new(), levels: Vec::new() };
    let mut cells = 1;
    let first = rule.decide(&cube.cell(Key::ROOT), root);
    let mut split = grown.take([(Key::ROOT, first)]);
    while let Some(&(first, _)) = split.first() {
        if first.level == DEEPEST {
            return Err(TooFine::Levels { at: first });
        }
        cells += (split.len() as u64) << P::DIM;
        if cells > limit {
            return Err(TooFine::Cells { limit });
        }
        let decided = executor.map(&split, |(key, load)| {
            let children = (0..1 << P::DIM).map(|i| key.child::<P>(i));
            children.map(|child| (child, rule.decide(&cube.cell(child), load))).collect::<Vec<_>>()
        });
        split = grown.take(decided.into_iter().flatten());
    }
    Ok(grown)
}

impl<Leaf> Grown<Leaf> {
    /// Takes a level; what is to be divided comes back.
    fn take<Load>(
        &mut self,
        decided: impl IntoIterator<Item = (Key, Decision<Load, Leaf>)>,
    ) -> Vec<(Key, Load)> {
        let (mut split, mut level) = (Vec::new(), Level::default());
        for (key, decision) in decided {
            match decision {
                Decision::Split(load) => {
                    level.split += 1;
                    split.push((key, load));
                }
                Decision::Keep(leaf) => {
                    level.kept += 1;
                    self.leaves.push((key, leaf));
                }
                Decision::Drop => level.dropped += 1,
            }
        }
        self.levels.push(level);
        split
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::Sequential;
    use glam::{DVec2, DVec3};

    /// Splits by a function.
    struct By<F>(F, f64);

    impl<P: Point, F: Fn(P) -> f64 + Sync> Rule<P> for By<F> {
        type Load = ();
        type Leaf = ();
        fn decide(&self, cell: &Cell<P>, (): &()) -> Decision<(), ()> {
            if (self.0)(cell.centre) < self.1 * cell.side { Decision::Split(()) } else { Decision::Keep(()) }
        }
    }

    /// Do two cells touch?
    fn touch<P: Point>(cube: &Cube<P>, a: Key, b: Key) -> bool {
        let (a, b) = (cube.cell(a), cube.cell(b));
        let reach = 0.5 * (a.side + b.side);
        (0..P::DIM).all(|i| (a.centre.coord(i) - b.centre.coord(i)).abs() <= reach)
    }

    fn balanced<P: Point>(cube: &Cube<P>, leaves: &[(Key, ())]) -> bool {
        leaves.iter().enumerate().all(|(i, &(a, ()))| {
            leaves[i..].iter().all(|&(b, ())| a.level.abs_diff(b.level) < 2 || !touch(cube, a, b))
        })
    }

    #[test]
    fn trees_of_lipschitz_functions_are_balanced() {
        let cube = Cube { low: DVec2::ZERO, side: 1.0 };
        let near =
            |p: DVec2| 1e-4 + p.distance(DVec2::new(0.301, 0.777)).min(p.distance(DVec2::new(0.9, 0.1)));
        let grown = grow(&cube, &By(near, 1.5 * 2f64.sqrt()), &(), 1 << 20, &Sequential).unwrap();
        assert!(balanced(&cube, &grown.leaves) && grown.levels.len() > 10);
        let area: f64 = grown.leaves.iter().map(|&(k, ())| cube.cell(k).side.powi(2)).sum();
        assert_eq!(area, 1.0);
        // The bound is not there for nothing.
        let grown = grow(&cube, &By(near, 0.8), &(), 1 << 20, &Sequential).unwrap();
        assert!(!balanced(&cube, &grown.leaves));

        let cube = Cube { low: DVec3::splat(-1.0), side: 4.0 };
        let near = |p: DVec3| 0.1 + 0.5 * p.distance(DVec3::new(0.3, 0.8, 0.5));
        let grown = grow(&cube, &By(near, 0.75 * 3f64.sqrt()), &(), 1 << 20, &Sequential).unwrap();
        assert!(balanced(&cube, &grown.leaves) && grown.levels.len() > 4);
    }

    #[test]
    fn limits_are_kept() {
        let cube = Cube { low: DVec2::ZERO, side: 1.0 };
        let even = By(|_: DVec2| 0.01, 1.0);
        assert_eq!(grow(&cube, &even, &(), 100, &Sequential), Err(TooFine::Cells { limit: 100 }));
        let point = By(|p: DVec2| p.distance(DVec2::new(1.0 / 3.0, 0.5)), 1.0);
        assert!(matches!(grow(&cube, &point, &(), 1 << 20, &Sequential), Err(TooFine::Levels { .. })));
    }

    #[test]
    fn cubes_hold_their_boxes() {
        for (high, side) in [(4.0, 4.0), (4.5, 8.0), (0.3, 0.5)] {
            let bounds = Bounds { low: DVec2::new(-1.0, 0.0), high: DVec2::new(-1.0 + high, 0.1) };
            let cube = Cube::around(&bounds);
            assert_eq!(cube.side, side);
            assert!(cube.low.x <= -1.0 && cube.low.x + side >= bounds.high.x);
        }
        let key = Key::ROOT.child::<DVec3>(5).child::<DVec3>(3);
        assert_eq!(key, Key { level: 2, at: [3, 1, 2] });
        let cell = Cube { low: DVec3::ZERO, side: 4.0 }.cell(key);
        assert_eq!((cell.centre, cell.side), (DVec3::new(3.5, 1.5, 2.5), 1.0));
        assert_eq!(Key::ROOT.child::<DVec2>(3).at, [1, 1, 0]);
    }
}
