//! The cells that reach out of a piece, found by a walk.
//!
//! **Statement.** Let `S` be a separator of the path, `U` its side that is not the piece's, and `T` the triangulation of
//! the piece's points. The cells of `T` that a point of `U` would undo hang together by facets, and one of them is
//! infinite or, where `U` is a ball, holds the ball's centre.
//!
//! *Proof.* The cells in conflict with a point are connected by facets (Bowyer 1981, Watson 1981) and among them is one
//! that holds it in its open ball, or beyond the hull in its open half-space: the cell that holds it. `U` is a ball, a
//! half-space, or the outside of a ball: connected, and in two or more dimensions still connected without the finitely
//! many vertices. Along a path in `U` the open balls that hold its points follow each other with overlaps, and two that
//! share a point belong to two cells of that point's conflict. So all are connected with those of any one point of `U`:
//! the centre, or a point far outside of the hull, where infinite cells are in conflict. QED.
//!
//! The walk goes on where [`Separator::reaches`](septet_geometry::separator::Separator::reaches) does not exclude that
//! the ball has a point of `U`. What it excludes is clear of `S` by more than all rounding, so also a point whose rounded
//! side is wrong is connected with `U` by cells that are walked on. Infinite cells hang together and are all walked on.
//! If a centre's cell is excluded (by rounding of the centre), every cell is looked at instead.
//!
//! **Work.** O(1) for each cell that reaches out, and a walk to each centre: `O(n^(1-1/d))` for well-spaced points.

use septet_geometry::ball::Reach;
use septet_geometry::point::Point;
use septet_geometry::separator::{Side, Surface};

use crate::piece::{Piece, is_ordinary};
use crate::tree::{Shared, Split};
use crate::worker::Worker;

/// A cell that reaches out: its vertices by local numbers, and a bit for each place on the path, set where the cell
/// may conflict with a point of the other side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outgoing<S> {
    pub(crate) cell: S,
    pub(crate) levels: u64,
}

/// What the cells of a piece look out to.
pub(crate) struct Border<'a, P: Point> {
    path: &'a [Shared<P>],
    piece: &'a Piece<P>,
    positions: &'a [P],
    home: u32,
    /// For each home point and separator a radius within which no ball crosses, or -1; 0 until asked for.
    pub(crate) clear: Vec<f64>,
}

/// Cells that reach out and are not ordinary.
#[derive(Debug, Default)]
pub(crate) struct Unusual {
    /// Their slots.
    pub(crate) slots: Vec<u32>,
    /// For each home point where those of its star reach: bits as in [`Outgoing`].
    pub(crate) levels: Vec<u64>,
}

impl Unusual {
    /// None, of so many home points.
    fn of(home: u32) -> Self {
        Unusual { slots: Vec::new(), levels: vec![0; home as usize] }
    }
}

fn side_of(side: usize) -> Side {
    if side == 0 { Side::Interior } else { Side::Exterior }
}

/// May it hold a point of that child?
pub(crate) fn reaches<P: Point>(split: &Split<P>, reach: &Reach<P>, side: usize) -> bool {
    let (low, high) = split.boxes[side];
    reach.meets(&split.separator, side_of(side), low, high)
}

impl<P: Point> Worker<P> {
    /// What the cells of the piece look out to, if there is a piece and another one. `clear` is empty, or what the border
    /// knew before.
    pub(crate) fn border(&self, mut clear: Vec<f64>) -> Option<Border<'_, P>> {
        let piece = self.stars.piece().filter(|_| !self.path.is_empty())?;
        let home = self.table.home;
        if clear.is_empty() {
            // Pages of zeros that nobody asks for cost nothing.
            clear = vec![0.0; self.path.len() * home as usize];
        }
        Some(Border { path: &self.path, piece, positions: &self.table.positions, home, clear })
    }
}

impl<P: Point> Border<'_, P> {
    /// The cells that reach out and have a vertex at home: those that are ordinary, and the others.
    pub(crate) fn survey(&mut self) -> (Vec<Outgoing<P::Cell>>, Unusual) {
        let (piece, path) = (self.piece, self.path);
        let (mut ordinary, mut unusual) = (Vec::new(), Unusual::of(self.home));
        let walked = centres(path).is_some_and(|centres| {
            piece.walk(&centres, |slot, cell| self.look(slot, cell, &mut ordinary, &mut unusual))
        });
        if !walked {
            (ordinary, unusual) = (Vec::new(), Unusual::of(self.home));
            piece.each_cell(|slot, cell| {
                self.look(slot, cell, &mut ordinary, &mut unusual);
            });
        }
        (ordinary, unusual)
    }

    /// Notes a cell if it reaches out. Does the walk go on there?
    fn look(
        &mut self,
        slot: u32,
        cell: &P::Cell,
        ordinary: &mut Vec<Outgoing<P::Cell>>,
        unusual: &mut Unusual,
    ) -> bool {
        let mut levels = self.near(slot, cell);
        if let Some(Reach::Ball { centre, radius }) = self.piece.ball(slot) {
            levels = self.filter(levels, |s| s.split.separator.reaches(centre, radius, side_of(1 - s.mine)));
        }
        if levels == 0 {
            return false;
        }
        if cell.as_ref().iter().any(|&v| v < self.home) {
            let reach = self.piece.reach(slot, cell, self.positions);
            let levels = self.reached(&reach, levels);
            if levels == 0 {
            } else if is_ordinary(&reach, cell, self.positions) {
                ordinary.push(Outgoing { cell: *cell, levels });
            } else {
                unusual.slots.push(slot);
                for &v in cell.as_ref().iter().filter(|&&v| v < self.home) {
                    unusual.levels[v as usize] |= levels;
                }
            }
        }
        true
    }

    /// A cell with a vertex at home as it goes out, if it reaches out to where the unusual ones of its vertices did.
    pub(crate) fn outgoing(
        &mut self,
        slot: u32,
        cell: &P::Cell,
        unusual: &Unusual,
    ) -> Option<Outgoing<P::Cell>> {
        let levels = cell.as_ref().iter().filter_map(|&v| unusual.levels.get(v as usize));
        let levels = levels.fold(0, |all, levels| all | levels);
        if levels == 0 {
            return None;
        }
        let near = levels & self.near(slot, cell);
        if near == 0 {
            return None;
        }
        let levels = self.reached(&self.piece.reach(slot, cell, self.positions), near);
        (levels != 0).then_some(Outgoing { cell: *cell, levels })
    }

    /// The places on the path whose separators the cell's ball may cross, by its distance from one vertex at home.
    fn near(&mut self, slot: u32, cell: &P::Cell) -> u64 {
        let all = u64::MAX >> (64 - self.path.len());
        let Some(&v) = cell.as_ref().iter().find(|&&v| v < self.home) else { return all };
        let clear = &mut self.clear[v as usize * self.path.len()..][..self.path.len()];
        if clear[0] == 0.0 {
            let x = self.positions[v as usize];
            for (clear, shared) in clear.iter_mut().zip(self.path) {
                let least = shared.split.separator.clearance(x);
                *clear = if least > 0.0 { least } else { -1.0 };
            }
        }
        // All of the ball is within twice its radius of the vertex. What is not a number is not less.
        let across = 2.0 * self.piece.radius_bound(slot);
        let is_clear = |clear: f64| across < clear;
        clear.iter().enumerate().fold(0, |near, (i, &clear)| near | u64::from(!is_clear(clear)) << i)
    }

    /// Those of some places on the path where what holds a cell's conflicts may hold a point of the other side.
    fn reached(&self, reach: &Reach<P>, levels: u64) -> u64 {
        self.filter(levels, |s| reaches(&s.split, reach, 1 - s.mine))
    }

    fn filter(&self, levels: u64, keep: impl Fn(&Shared<P>) -> bool) -> u64 {
        let kept = ones(levels).filter(|&i| keep(&self.path[i]));
        kept.fold(0, |kept, i| kept | 1 << i)
    }
}

/// The places of the bits that are set.
pub(crate) fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let next = (bits != 0).then(|| bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(next)
    })
}

/// The centres of the other sides that are balls. None if one of them is beyond the range of floats.
fn centres<P: Point>(path: &[Shared<P>]) -> Option<Vec<P>> {
    let mut centres = Vec::new();
    for shared in path {
        let separator = &shared.split.separator;
        match separator.surface() {
            Some(Surface::Sphere { centre, ball_is_interior, .. }) => {
                if ball_is_interior == (shared.mine == 1) {
                    centres.push(centre);
                }
            }
            Some(Surface::Plane { .. }) if !separator.is_sphere() => {}
            _ => return None,
        }
    }
    Some(centres)
}

#[cfg(test)]
mod tests;
