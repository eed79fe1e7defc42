//! The cells that reach out of a piece.
//!
//! **Statement.** A cell may conflict with a point on the other side of a separator only if its closed ball (beyond the
//! hull its half-space) crosses it ([`septet_geometry::conflict_region`]). A cell whose ball lies in the halos of all its vertices at
//! home tells nothing new ([`crate::direct::ghost_layer`]); nor does one whose ball, which is within twice its radius of each vertex,
//! is clear of the separator by that ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)). What is
//! left is looked at exactly, rounded outwards.
//!
//! **Work.** O(n): for every cell one comparison, in single precision, with what one of its vertices is clear by; one more a
//! vertex for those near the border; all in the order of memory. A walk along the border is O(n^(1-1/d)) but goes from cell to
//! cell in no order.

use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::point::Point;
use septet_geometry::separator::Side;

use crate::direct::ghost_layer::Margin;
use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::state::bits::ones;
use crate::state::subdomain::Shared;
use crate::state::tree::Split;

/// A cell that reaches out: its vertices by local numbers; a bit for each place on the path, set where the cell may
/// conflict with a point of the other side; and a bit for each vertex, set where it must be sent there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outgoing<S> {
    pub(crate) cell: S,
    pub(crate) levels: u64,
    pub(crate) sent: u8,
}

/// What the cells of a piece look out to.
pub(crate) struct InterfaceCells<'a, P: Point> {
    path: &'a [Shared<P>],
    piece: &'a SubdomainTriangulation<P>,
    positions: &'a [P],
    /// For each home point how far around it nothing more has to be told.
    margins: &'a [Margin],
    /// For each home point a rounded radius up to which its cells are clear of all separators.
    limits: Vec<f32>,
    /// For each home point and separator a radius within which no ball crosses, or -1; 0 until asked for.
    clear: Vec<f64>,
}

fn side_of(side: usize) -> Side {
    if side == 0 { Side::Interior } else { Side::Exterior }
}

/// May it hold a point of that child?
pub(crate) fn reaches<P: Point>(split: &Split<P>, reach: &ConflictRegion<P>, side: usize) -> bool {
    let (low, high) = split.boxes()[side];
    reach.meets(split.separator(), side_of(side), low, high)
}

impl<'a, P: Point> InterfaceCells<'a, P> {
    /// Of a piece whose home points come first, with a margin each.
    pub(crate) fn of(
        path: &'a [Shared<P>],
        piece: &'a SubdomainTriangulation<P>,
        positions: &'a [P],
        margins: &'a [Margin],
    ) -> Self {
        let limits = margins.iter().map(|margin| piece.radius_within(margin.free)).collect();
        // Pages of zeros that nobody asks for cost nothing.
        let clear = vec![0.0; path.len() * margins.len()];
        InterfaceCells { path, piece, positions, margins, limits, clear }
    }

    /// The cells that reach out beyond the halo of a vertex at home.
    pub(crate) fn scan(&mut self) -> Vec<Outgoing<P::Cell>> {
        let mut found = Vec::new();
        for slot in 0..self.piece.slots() {
            let Some(v) = self.piece.owned_vertex(slot) else { continue };
            if self.is_clear(slot, v) || self.beyond(self.across(slot), self.piece.vertices(slot)) == 0 {
                continue;
            }
            self.note(slot, v, &mut found);
        }
        found
    }

    /// Is a cell, by a vertex of it at home, clear of all separators? What is not a number is not.
    #[inline]
    fn is_clear(&self, slot: u32, v: u32) -> bool {
        self.piece.rounded_radius(slot) <= self.limits[v as usize]
    }

    /// All of a cell's ball is within that of each vertex.
    #[inline]
    fn across(&self, slot: u32) -> f64 {
        2.0 * self.piece.radius_bound(slot)
    }

    /// Notes a cell, which has a vertex at home, if it reaches out.
    fn note(&mut self, slot: u32, v: u32, found: &mut Vec<Outgoing<P::Cell>>) {
        let cell = self.piece.local(self.piece.vertices(slot));
        let reach = self.piece.reach(slot, &cell, self.positions);
        // The bound of the radius says little of cells far smaller than the piece.
        let across = match reach {
            ConflictRegion::Ball { radius, .. } => 2.0 * radius,
            _ => f64::INFINITY,
        };
        if across <= self.margins[v as usize].free {
            return;
        }
        let sent = self.beyond(across, &cell);
        if sent == 0 {
            return;
        }
        let near = self.near(across, v);
        let levels = self.filter(near, |s| reaches(s.split(), &reach, 1 - s.mine()));
        if levels != 0 {
            found.push(Outgoing { cell, levels, sent });
        }
    }

    /// The vertices at home whose halo does not hold all balls that are so far across, a bit for each: the others have been
    /// sent to all that such a ball meets.
    #[inline]
    fn beyond(&self, across: f64, cell: &P::Cell) -> u8 {
        let is_in = |v: u32| {
            let margin = self.margins.get(v as usize);
            margin.is_none_or(|own| across <= own.sent || across <= own.free)
        };
        cell.as_ref().iter().enumerate().fold(0, |sent, (i, &v)| sent | u8::from(!is_in(v)) << i)
    }

    /// The places on the path whose separators something so far across may cross, by its distance from a vertex at home that
    /// it holds.
    fn near(&mut self, across: f64, v: u32) -> u64 {
        let levels = self.path.len();
        if levels == 1 {
            // It is not clear of all, and there is no other.
            return 1;
        }
        let clear = &mut self.clear[v as usize * levels..][..levels];
        if clear[0] == 0.0 {
            let x = self.positions[v as usize];
            for (clear, shared) in clear.iter_mut().zip(self.path) {
                let least = shared.split().separator().clearance(x);
                *clear = if least > 0.0 { least } else { -1.0 };
            }
        }
        // What is not a number is not less.
        let is_clear = |clear: f64| across < clear;
        clear.iter().enumerate().fold(0, |near, (i, &clear)| near | u64::from(!is_clear(clear)) << i)
    }

    /// Those of some places on the path that `keep` says yes of.
    fn filter(&self, levels: u64, keep: impl Fn(&Shared<P>) -> bool) -> u64 {
        let kept = ones(levels).filter(|&i| keep(&self.path[i]));
        kept.fold(0, |kept, i| kept | 1 << i)
    }
}

#[cfg(test)]
pub(crate) mod tests;
