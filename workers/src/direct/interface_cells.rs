//! The cells of a subdomain triangulation that cross the interface.
//!
//! **Statement.** Let a cell have an owned vertex, and let its conflict region meet the other side of a separator of
//! the path. Then [`InterfaceCells::scan`] finds the cell, unless its circumball lies in the halo ball of each owned
//! vertex ([`crate::direct::ghost_layer`]). In that case every owned vertex was already sent to each worker whose
//! region the circumball meets.
//!
//! **Filters.** The diameter of a circumball bounds the distance from each vertex to every point of the ball. A cell is
//! skipped if this diameter is at most the clearance of an owned vertex
//! ([`Separator::clearance`](septet_geometry::separator::Separator::clearance)), or if it is at most a margin of each
//! owned vertex. For each other cell, the conflict region is rounded outwards and tested.
//!
//! **Work.** `O(n)`, in memory order. Each cell needs one comparison in single precision with the clearance of one of
//! its vertices. Each cell near the interface needs another comparison per vertex. A walk along the interface would
//! visit only `O(n^(1-1/d))` cells, but not in memory order.

use septet_geometry::conflict_region::ConflictRegion;
use septet_geometry::point::Point;
use septet_geometry::separator::Side;

use crate::direct::ghost_layer::Margin;
use crate::direct::subdomain_triangulation::SubdomainTriangulation;
use crate::state::bits::ones;
use crate::state::subdomain::Shared;
use crate::state::tree::Split;

/// A cell with an owned vertex whose conflict region crosses a separator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outgoing<P: Point> {
    /// The vertices, as local indices.
    pub(super) cell: P::Cell,
    /// The conflict region.
    pub(super) region: ConflictRegion<P>,
    /// Bit `i` is set if the cell may conflict with a point on the other side of path node `i`.
    pub(super) levels: u64,
    /// Bit `i` is set if vertex `i`, an owned point, must be sent to those sides.
    pub(super) sent: u8,
}

/// The search for outgoing cells.
pub(super) struct InterfaceCells<'a, P: Point> {
    path: &'a [Shared<P>],
    triangulation: &'a SubdomainTriangulation<P>,
    positions: &'a [P],
    /// The margin of each owned point.
    margins: &'a [Margin],
    /// For each owned point, the rounded radius up to which its cells cross no separator.
    limits: Vec<f32>,
    /// For each owned point and level, the radius of a ball that crosses no separator, [`NO_BALL`] or [`NOT_COMPUTED`].
    clearances: Vec<f64>,
}

/// A clearance that is not computed. Pages of zeros take no memory before they are used.
const NOT_COMPUTED: f64 = 0.0;

/// The clearance of a point around which every ball crosses the separator.
const NO_BALL: f64 = -1.0;

fn side_of(side: usize) -> Side {
    if side == 0 { Side::Interior } else { Side::Exterior }
}

/// Returns `true` if a conflict region may contain an owned point of the child on `side`.
pub(super) fn reaches<P: Point>(split: &Split<P>, region: &ConflictRegion<P>, side: usize) -> bool {
    let (low, high) = split.boxes()[side];
    region.meets(split.separator(), side_of(side), low, high)
}

impl<'a, P: Point> InterfaceCells<'a, P> {
    /// Prepares the search. The owned points come first in `positions`, and each has a margin.
    pub(super) fn new(
        path: &'a [Shared<P>],
        triangulation: &'a SubdomainTriangulation<P>,
        positions: &'a [P],
        margins: &'a [Margin],
    ) -> Self {
        let limits = margins.iter().map(|margin| triangulation.radius_within(margin.free)).collect();
        let clearances = vec![NOT_COMPUTED; path.len() * margins.len()];
        InterfaceCells { path, triangulation, positions, margins, limits, clearances }
    }

    /// Calls `found` with each outgoing cell, in the order of their slots.
    pub(super) fn scan(&mut self, mut found: impl FnMut(Outgoing<P>)) {
        for slot in 0..self.triangulation.slots() {
            let Some(v) = self.triangulation.owned_vertex(slot) else { continue };
            let across = 2.0 * self.triangulation.radius_bound(slot);
            if self.is_clear(slot, v) || self.outside_margins(across, self.triangulation.vertices(slot)) == 0
            {
                continue;
            }
            self.examine(slot, v).into_iter().for_each(&mut found);
        }
    }

    /// Returns `true` if the clearance of the owned vertex `v` shows that the circumball of the cell in `slot` crosses
    /// no separator. Returns `false` if the radius is NaN.
    #[inline]
    fn is_clear(&self, slot: u32, v: u32) -> bool {
        self.triangulation.rounded_radius(slot) <= self.limits[v as usize]
    }

    /// Tests the conflict region of a cell with the owned vertex `v`. Returns the cell if its vertices must be sent.
    fn examine(&mut self, slot: u32, v: u32) -> Option<Outgoing<P>> {
        let cell = self.triangulation.to_local(self.triangulation.vertices(slot));
        let region = self.triangulation.conflict_region(slot, &cell, self.positions);
        // This radius is more precise than the kernel's bound if the cell is far smaller than the subdomain.
        let across = match region {
            ConflictRegion::Ball { radius, .. } => 2.0 * radius,
            _ => f64::INFINITY,
        };
        if across <= self.margins[v as usize].free {
            return None;
        }
        let sent = self.outside_margins(across, &cell);
        if sent == 0 {
            return None;
        }
        let near = self.near_levels(across, v);
        let crossed = ones(near).filter(|&i| reaches(self.path[i].split(), &region, 1 - self.path[i].mine()));
        let levels = crossed.fold(0, |levels, i| levels | 1 << i);
        (levels != 0).then_some(Outgoing { cell, region, levels, sent })
    }

    /// Returns a mask of the owned vertices whose margins are both smaller than `across`, the diameter of the cell's
    /// circumball. The other owned vertices have been sent to every worker whose region the circumball meets.
    #[inline]
    fn outside_margins(&self, across: f64, cell: &P::Cell) -> u8 {
        let is_inside = |v: u32| {
            let margin = self.margins.get(v as usize);
            margin.is_none_or(|own| across <= own.sent || across <= own.free)
        };
        cell.as_ref().iter().enumerate().fold(0, |bits, (i, &v)| bits | u8::from(!is_inside(v)) << i)
    }

    /// Returns a mask of the levels whose separators may cross a ball that has diameter `across` and contains the
    /// owned vertex `v`.
    fn near_levels(&mut self, across: f64, v: u32) -> u64 {
        let levels = self.path.len();
        if levels == 1 {
            // The margin of `v` shows that the ball is near a separator, and there is only one separator.
            return 1;
        }
        let clearances = &mut self.clearances[v as usize * levels..][..levels];
        if clearances[0] == NOT_COMPUTED {
            let x = self.positions[v as usize];
            for (clear, shared) in clearances.iter_mut().zip(self.path) {
                let least = shared.split().separator().clearance(x);
                *clear = if least > 0.0 { least } else { NO_BALL };
            }
        }
        // A diameter of NaN is not below the clearance, so the level counts as near.
        let is_clear = |clear: f64| across < clear;
        clearances.iter().enumerate().fold(0, |near, (i, &clear)| near | u64::from(!is_clear(clear)) << i)
    }
}

#[cfg(test)]
pub(super) mod tests;
