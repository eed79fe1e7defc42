//! Octrees (in the plane: quadtrees), built level by level.
//!
//! **Statement.** A cell of level `l` is one of the `2^(d l)` equal cubes of a root cube. A [`Rule`] decides about a
//! cell from the cell and the data inherited from its parent. Neighbours have no influence. A level is therefore one
//! round, and the result does not depend on the order of its cells.
//!
//! *Balance.* Let `g` be K-Lipschitz. Let a cell with centre `m` and side `s` be split iff `g(m) < k s`. If
//! `k >= 1.5 K sqrt(d)`, the levels of cells that touch differ by at most one, even if they touch only in a corner.
//!
//! *Proof.* Let C of side `s` be split, and let N of side `2s` touch C. Along each axis, their centres are at most
//! `s/2 + s` apart. So `g(m_N) <= g(m_C) + 1.5 K sqrt(d) s < k s + k s`, and N is split. Every cell of side `2s` that
//! touches C is therefore split, and the cells that touch the children of C are no larger than C. QED.
//!
//! **Source.** Mitchell and Vavasis (2000), who balance the tree afterwards. **Work and depth.** One evaluation of the
//! rule per cell. The depth is the number of levels times the depth of the rule.

use septet_geometry::cost::Cost;
use septet_geometry::evaluation::{Evaluation, Items, Made, Progress, Reader, Words};
use septet_geometry::point::Point;
use thiserror::Error;

use crate::bvh::Bounds;
use crate::executor::{Evaluator, Part};

/// The deepest level below the root. Positions have 30 bits.
pub const DEEPEST: u8 = 30;

/// The identity of a cell: its level and its position in that level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellKey {
    /// The level. The root has level 0.
    pub level: u8,
    /// The position along each axis, counted from the low corner of the root, below `2^level`. It is 0 along axes
    /// beyond the dimension.
    pub at: [u32; 3],
}

impl CellKey {
    /// The root.
    pub const ROOT: CellKey = CellKey { level: 0, at: [0; 3] };

    /// Returns child `i < 2^d`. Bit `k` selects the half along axis `k`.
    #[must_use]
    pub fn child<P: Point>(self, i: u32) -> CellKey {
        let half = |k: usize| if k < P::DIM { i >> k & 1 } else { 0 };
        CellKey { level: self.level + 1, at: [0, 1, 2].map(|k| 2 * self.at[k] + half(k)) }
    }
}

impl Words for CellKey {
    fn write(&self, words: &mut Vec<u64>) {
        let [x, y, z] = self.at.map(u64::from);
        words.extend([u64::from(self.level) << 32 | x, y << 32 | z]);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let (first, second) = (from.word(), from.word());
        let level = ((first >> 32) as u8).min(DEEPEST);
        CellKey { level, at: [first as u32, (second >> 32) as u32, second as u32] }
    }
}

/// The root cube of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube<P> {
    /// The low corner.
    pub low: P,
    /// The length of a side, which is a power of two.
    pub side: f64,
}

/// A cell with its geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<P> {
    /// The identity.
    pub key: CellKey,
    /// The centre.
    pub centre: P,
    /// The side.
    pub side: f64,
}

impl<P: Point> Cell<P> {
    /// Returns half the diagonal, the largest distance of a point of the cell from the centre.
    pub fn radius(&self) -> f64 {
        self.side * 0.5 * (P::DIM as f64).sqrt()
    }
}

impl<P: Point> Cube<P> {
    /// Returns the smallest cube that contains a box in its middle and whose side is a power of two.
    pub fn around(bounds: &Bounds<P>) -> Self {
        let extent = bounds.extent();
        let longest = (0..P::DIM).map(|i| extent.coord(i)).fold(f64::MIN_POSITIVE, f64::max);
        let below = f64::from_bits(longest.to_bits() >> 52 << 52);
        let side = if below == longest { below } else { 2.0 * below };
        let middle = (bounds.low + bounds.high) * 0.5;
        Cube { low: middle - P::splat(0.5 * side), side }
    }

    /// Returns the cell with this key.
    pub fn cell(&self, key: CellKey) -> Cell<P> {
        let side = self.side / (1u64 << key.level) as f64;
        let mut centre = self.low;
        for i in 0..P::DIM {
            centre.set_coord(i, self.low.coord(i) + (f64::from(key.at[i]) + 0.5) * side);
        }
        Cell { key, centre, side }
    }
}

/// The decision about a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Decision<Load, Leaf> {
    /// The cell is split, and its children inherit the load.
    Split(Load),
    /// The cell is a leaf.
    Keep(Leaf),
    /// The cell is a leaf without data, and the tree omits it.
    Drop,
}

/// The rule that decides about cells.
pub trait Rule<P: Point>: Sync {
    /// The data that children inherit.
    type Load: Words + Sync;
    /// The data of a leaf.
    type Leaf: Words;

    /// Decides about a cell, given the data inherited from its parent. `own` is the meter of the cell's lane.
    fn decide(
        &self,
        cell: &Cell<P>,
        inherited: &Self::Load,
        own: &mut Cost,
    ) -> Decision<Self::Load, Self::Leaf>;
}

/// The numbers of cells of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Level {
    /// Cells that were split.
    pub split: u64,
    /// Cells that were kept as leaves.
    pub kept: u64,
    /// Cells that were dropped.
    pub dropped: u64,
}

/// A complete tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Grown<Leaf> {
    /// The leaves, ordered by level, then by parent and child.
    pub leaves: Vec<(CellKey, Leaf)>,
    /// The numbers of cells per level. Each level is one round.
    pub levels: Vec<Level>,
}

/// Errors for trees that would be too fine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TooFine {
    /// The tree needs too many cells.
    #[error("the size function needs more than {limit} cells")]
    Cells {
        /// The limit.
        limit: u64,
    },
    /// The tree needs too many levels.
    #[error("the size function needs cells smaller than 2^-30 of the domain, near {at:?}")]
    Levels {
        /// A cell of the last level.
        at: CellKey,
    },
}

/// An item of the evaluation: a cell whose children it decides about, and the data that they inherit. Without a cell, it
/// decides about the root.
type Parent<Load> = (Option<CellKey>, Load);

/// The result of an item: the numbers of cells that were split and dropped, and the leaves.
type Decided<Leaf> = ([u32; 2], Vec<(CellKey, Leaf)>);

/// The growth of a tree, as a rule that a machine evaluates level by level. A cell of a level is a lane.
struct Growth<'a, P, R: Rule<P>>
where
    P: Point,
{
    cube: &'a Cube<P>,
    rule: &'a R,
    root: &'a R::Load,
    limit: u64,
}

impl<P: Point, R: Rule<P>> Evaluation for Growth<'_, P, R> {
    fn count(&self) -> u64 {
        1
    }

    fn first(&self, range: std::ops::Range<u64>) -> Items {
        let mut items = Items::default();
        for _ in range {
            items.push(|words| {
                None::<CellKey>.write(words);
                self.root.write(words);
            });
        }
        items
    }

    fn evaluate(&self, item: &[u64], made: &mut Made) {
        let (parent, load): Parent<R::Load> = Words::of(item);
        let cells = match parent {
            None => vec![CellKey::ROOT],
            Some(key) => (0..1 << P::DIM).map(|i| key.child::<P>(i)).collect(),
        };
        let (mut split, mut dropped, mut leaves) = (0u32, 0u32, Vec::new());
        for key in cells {
            match made.lane(|own| self.rule.decide(&self.cube.cell(key), &load, own)) {
                Decision::Split(load) => {
                    split += 1;
                    made.next.push(|words| (Some(key), load).write(words));
                }
                Decision::Keep(leaf) => leaves.push((key, leaf)),
                Decision::Drop => dropped += 1,
            }
        }
        made.results.push(|words| ([split, dropped], leaves).write(words));
    }

    fn stops(&self, progress: &Progress) -> bool {
        let cells = 1 + (progress.all_next << P::DIM);
        progress.levels > u32::from(DEEPEST) || cells > self.limit
    }
}

/// Builds a tree. The items of a level are the parents of its cells.
///
/// # Errors
/// Returns the error of the machine if it fails. The inner result is [`TooFine`] if there are more than `limit` cells.
pub fn grow<P: Point, R: Rule<P>, M: Evaluator<P>>(
    cube: &Cube<P>,
    rule: &R,
    root: &R::Load,
    limit: u64,
    machine: &M,
) -> Result<Result<Grown<R::Leaf>, TooFine>, M::Error> {
    let made = machine.evaluate(Part::Octree, &Growth { cube, rule, root, limit })?;
    if let Some(item) = made.rest.iter().next() {
        let at = <Option<CellKey>>::of(item).unwrap_or(CellKey::ROOT);
        let too_fine = if at.level == DEEPEST { TooFine::Levels { at } } else { TooFine::Cells { limit } };
        return Ok(Err(too_fine));
    }
    let mut grown = Grown { leaves: Vec::new(), levels: Vec::new() };
    for items in &made.levels {
        let mut level = Level::default();
        for item in items.iter() {
            let ([split, dropped], leaves): Decided<R::Leaf> = Words::of(item);
            level.split += u64::from(split);
            level.dropped += u64::from(dropped);
            level.kept += leaves.len() as u64;
            grown.leaves.extend(leaves);
        }
        grown.levels.push(level);
    }
    Ok(Ok(grown))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::{Sequential, Uncounted, always};
    use glam::{DVec2, DVec3};

    /// The rule that splits cells by comparison with a function.
    struct By<F>(F, f64);

    impl<P: Point, F: Fn(P) -> f64 + Sync> Rule<P> for By<F> {
        type Load = ();
        type Leaf = ();
        fn decide(&self, cell: &Cell<P>, (): &(), _own: &mut Cost) -> Decision<(), ()> {
            if (self.0)(cell.centre) < self.1 * cell.side { Decision::Split(()) } else { Decision::Keep(()) }
        }
    }

    /// Returns `true` if two cells touch.
    fn touch<P: Point>(cube: &Cube<P>, a: CellKey, b: CellKey) -> bool {
        let (a, b) = (cube.cell(a), cube.cell(b));
        let reach = 0.5 * (a.side + b.side);
        (0..P::DIM).all(|i| (a.centre.coord(i) - b.centre.coord(i)).abs() <= reach)
    }

    fn balanced<P: Point>(cube: &Cube<P>, leaves: &[(CellKey, ())]) -> bool {
        leaves.iter().enumerate().all(|(i, &(a, ()))| {
            leaves[i..].iter().all(|&(b, ())| a.level.abs_diff(b.level) < 2 || !touch(cube, a, b))
        })
    }

    #[test]
    fn trees_of_lipschitz_functions_are_balanced() {
        let cube = Cube { low: DVec2::ZERO, side: 1.0 };
        let near =
            |p: DVec2| 1e-4 + p.distance(DVec2::new(0.301, 0.777)).min(p.distance(DVec2::new(0.9, 0.1)));
        let grown =
            always(grow(&cube, &By(near, 1.5 * 2f64.sqrt()), &(), 1 << 20, &Uncounted(Sequential))).unwrap();
        assert!(balanced(&cube, &grown.leaves) && grown.levels.len() > 10);
        let area: f64 = grown.leaves.iter().map(|&(k, ())| cube.cell(k).side.powi(2)).sum();
        assert_eq!(area, 1.0);
        // With a smaller factor, the tree is not balanced.
        let grown = always(grow(&cube, &By(near, 0.8), &(), 1 << 20, &Uncounted(Sequential))).unwrap();
        assert!(!balanced(&cube, &grown.leaves));

        let cube = Cube { low: DVec3::splat(-1.0), side: 4.0 };
        let near = |p: DVec3| 0.1 + 0.5 * p.distance(DVec3::new(0.3, 0.8, 0.5));
        let grown =
            always(grow(&cube, &By(near, 0.75 * 3f64.sqrt()), &(), 1 << 20, &Uncounted(Sequential))).unwrap();
        assert!(balanced(&cube, &grown.leaves) && grown.levels.len() > 4);
    }

    #[test]
    fn limits_are_kept() {
        let cube = Cube { low: DVec2::ZERO, side: 1.0 };
        let even = By(|_: DVec2| 0.01, 1.0);
        assert_eq!(
            always(grow(&cube, &even, &(), 100, &Uncounted(Sequential))),
            Err(TooFine::Cells { limit: 100 })
        );
        let point = By(|p: DVec2| p.distance(DVec2::new(1.0 / 3.0, 0.5)), 1.0);
        assert!(matches!(
            always(grow(&cube, &point, &(), 1 << 20, &Uncounted(Sequential))),
            Err(TooFine::Levels { .. })
        ));
    }

    #[test]
    fn cubes_hold_their_boxes() {
        for (high, side) in [(4.0, 4.0), (4.5, 8.0), (0.3, 0.5)] {
            let bounds = Bounds { low: DVec2::new(-1.0, 0.0), high: DVec2::new(-1.0 + high, 0.1) };
            let cube = Cube::around(&bounds);
            assert_eq!(cube.side, side);
            assert!(cube.low.x <= -1.0 && cube.low.x + side >= bounds.high.x);
        }
        let key = CellKey::ROOT.child::<DVec3>(5).child::<DVec3>(3);
        assert_eq!(key, CellKey { level: 2, at: [3, 1, 2] });
        let cell = Cube { low: DVec3::ZERO, side: 4.0 }.cell(key);
        assert_eq!((cell.centre, cell.side), (DVec3::new(3.5, 1.5, 2.5), 1.0));
        assert_eq!(CellKey::ROOT.child::<DVec2>(3).at, [1, 1, 0]);
    }
}
