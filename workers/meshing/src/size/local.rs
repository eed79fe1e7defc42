//! How cells see the local feature size.
//!
//! **Statement.** A cell with centre m, side s and radius `r = s sqrt(d) / 2` is handed simplices that hold all
//! those no farther from m than `lfs(m)`, so it knows `lfs(m)` exactly. It hands down those no farther than
//! `lfs(m) + 2 r`. *That is enough:* for the centre m' of a cell inside, `|m m'| <= r`, so `lfs(m') <= lfs(m) + r`,
//! and what is that close to m' is no farther than `lfs(m) + 2 r` from m. Distances are rounded, so the limit is
//! raised by a part in 10^9.
//!
//! The cell is
//! - *kept*, with the cone of height `lfs(m) - (1+L) r` at m, if `(1+L) r <= loss * max(lfs(m), least)`;
//! - *dropped*, if that cone lies nowhere below the user's function, or above another cone that the cell can see:
//!   two disjoint features are no farther than u from a point y, so `lfs(y) <= u`, and the cell's cone at m is above
//!   `u + L |m y|`;
//! - else *split*.
//!
//! **Work and depth.** `O(k log k)` for a cell that is handed k simplices.

use super::cones::Cone;
use super::user::User;
use crate::distance::{Features, Search};
use crate::octree::{Cell, Rule, Verdict};
use crate::space::Space;

/// The rule.
pub(super) struct Local<'a, P: Space> {
    pub features: &'a Features<P>,
    pub slope: f64,
    pub loss: f64,
    pub user: &'a User<P>,
    /// Are cells dropped? (For a whole, balanced tree they are not.)
    pub drops: bool,
}

/// What a cell knows.
struct Known {
    /// Squared distances and simplices, ascending.
    near: Vec<(f64, u32)>,
    /// The local feature size and the two simplices that make it.
    size: f64,
    pair: Option<[u32; 2]>,
}

impl<P: Space> Local<'_, P> {
    fn know(&self, m: P, handed: &[u32]) -> Known {
        let mut near: Vec<(f64, u32)> = handed.iter().map(|&i| (self.features.dist2(i, m), i)).collect();
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut search = Search::default();
        let found = near.iter().find_map(|&(d2, i)| Some((d2, search.meet(self.features, i)?)));
        let size = found.map_or(f64::INFINITY, |(d2, _)| d2.sqrt());
        Known { near, size, pair: found.map(|(_, pair)| pair) }
    }

    /// A bound on `lfs(y) + L |m y|` for some points y.
    fn seen(&self, m: P, known: &Known) -> f64 {
        let Some(pair) = known.pair else { return f64::INFINITY };
        let ends = pair.map(|i| self.features.closest(i, m));
        let towards = [ends[1], (ends[0] + ends[1]) * 0.5];
        let steps = towards.iter().flat_map(|&t| [0.5, 0.75, 1.0].map(|part| m + (t - m) * part));
        let value = |y: P| {
            let size = pair.map(|i| self.features.dist2(i, y));
            size[0].max(size[1]).sqrt() + self.slope * (y - m).norm2().sqrt()
        };
        steps.map(value).fold(f64::INFINITY, f64::min)
    }
}

impl<P: Space> Rule<P> for Local<'_, P> {
    type Load = Vec<u32>;
    type Leaf = Cone<P>;

    fn judge(&self, cell: &Cell<P>, handed: &Vec<u32>) -> Verdict<Vec<u32>, Cone<P>> {
        let m = cell.centre;
        let known = self.know(m, handed);
        let error = (1.0 + self.slope) * cell.radius();
        let cone = Cone { at: m, size: known.size - error };
        if self.drops && (cone.size >= self.user.at(m) || cone.size > self.seen(m, &known)) {
            return Verdict::Drop;
        }
        if error <= self.loss * known.size.max(self.user.least) {
            return Verdict::Keep(cone);
        }
        let reach = (known.size + 2.0 * cell.radius()) * (1.0 + 1e-9);
        let handed = known.near.into_iter().take_while(|&(d2, _)| d2 <= reach * reach);
        Verdict::Split(handed.map(|(_, i)| i).collect())
    }
}
