//! Trees of cells on features and in the volume, built level by level.
//!
//! **Statement.** A rule decides about a cell: the cell is divided, is a leaf, or is dropped. It depends only on the cell, so
//! a level is one vector step, in which each cell is a lane. All trees of a stage grow together. The leaves are in the order
//! of levels, then of parents and children.
//!
//! **Source.** Section 5 of the paper. **Work and depth.** One decision per cell. The depth is the number of levels times the
//! depth of a decision.

use std::marker::PhantomData;
use std::ops::Range;

use septet_geometry::cost::Cost;
use septet_geometry::evaluation::{Evaluation, Items, Made, Progress, Words};
use septet_geometry::point::Point;

use crate::executor::{Evaluator, Part};

/// The decision about a cell.
pub(super) enum Division<C, L> {
    /// The cell is divided. Its children are those of this value.
    Divide(C),
    /// The cell is a leaf.
    Leaf(L),
    /// The cell is dropped.
    Drop,
}

/// A subdivision of cells: the rule, the children of a cell, and the largest number of leaves and open cells.
struct Subdivision<'a, C, L, D, F> {
    roots: &'a [C],
    decide: D,
    children: F,
    /// The largest number of children of a cell.
    fan: u64,
    most: u64,
    leaf: PhantomData<fn() -> L>,
}

impl<C, L, D, F> Evaluation for Subdivision<'_, C, L, D, F>
where
    C: Words + Sync,
    L: Words,
    D: Fn(C, &mut Cost) -> Division<C, L> + Sync,
    F: Fn(&C) -> Vec<C> + Sync,
{
    fn count(&self) -> u64 {
        self.roots.len() as u64
    }

    fn first(&self, range: Range<u64>) -> Items {
        let mut items = Items::default();
        for root in &self.roots[range.start as usize..range.end as usize] {
            items.push(|words| {
                false.write(words);
                root.write(words);
            });
        }
        items
    }

    fn evaluate(&self, item: &[u64], made: &mut Made) {
        let (is_parent, cell): (bool, C) = Words::of(item);
        let cells = if is_parent { (self.children)(&cell) } else { vec![cell] };
        for cell in cells {
            match made.lane(|own| (self.decide)(cell, own)) {
                Division::Divide(cell) => made.next.push(|words| (true, cell).write(words)),
                Division::Leaf(leaf) => made.results.push(|words| leaf.write(words)),
                Division::Drop => {}
            }
        }
    }

    fn stops(&self, progress: &Progress) -> bool {
        progress.results.saturating_add(self.fan.saturating_mul(progress.next)) > self.most
    }
}

/// Divides cells until none is divided. Returns the leaves, or `None` if there are more than `most` leaves and open cells.
/// A cell has at most `fan` children.
pub(super) fn divided<P: Point, M: Evaluator<P>, C: Words + Sync, L: Words>(
    machine: &M,
    (roots, fan, most): (&[C], u64, u64),
    children: impl Fn(&C) -> Vec<C> + Sync,
    decide: impl Fn(C, &mut Cost) -> Division<C, L> + Sync,
) -> Result<Option<Vec<L>>, M::Error> {
    if roots.is_empty() {
        return Ok(Some(Vec::new()));
    }
    let rule = Subdivision { roots, decide, children, fan, most, leaf: PhantomData };
    let made = machine.evaluate(Part::Octree, &rule)?;
    Ok(made.rest.is_empty().then(|| made.read()))
}
