//! How cells see the local feature size.
//!
//! **Statement.** A cell with centre m, side s and radius `r = s sqrt(d) / 2` is handed simplices that hold all
//! those no farther from m than `lfs(m)`, so it knows `lfs(m)` exactly. It hands down those no farther than
//! `lfs(m) + 2 r`. *That is enough:* for the centre m' of a cell inside, `|m m'| <= r`, so `lfs(m') <= lfs(m) + r`,
//! and what is that close to m' is no farther than `lfs(m) + 2 r` from m. With their distances from m it hands
//! down the two simplices that made `lfs(m)`: they bound `lfs(m')` by u at once, and only simplices within
//! `u + |m m'|` of m are looked at. Distances are rounded, so limits are raised by a part in 10^9.
//!
//! The cell is
//! - *kept*, with the cone of height `lfs(m) - (1+L) r` at m, if `(1+L) r <= loss * max(lfs(m), least)`;
//! - *dropped*, if that cone lies nowhere below the user's function; or nowhere below a cone that stands in any case,
//!   that of the middle y of one of the nearest simplices, of height `(1 - loss/2) lfs(y)`; or above another cone that
//!   the cell can see: `lfs(y) <= u` in a point y, and the cell's cone at m is above `u + L |m y|`. Such y lie on the
//!   way to the two simplices that make `lfs(m)`, and u is the distance of the farther one;
//! - else *split*.
//!
//! **Work and depth.** `O(k log k)` for a cell that looks at k simplices.

use super::cones::Cone;
use super::user::User;
use crate::distance::{Features, Search};
use crate::octree::{Cell, Rule, Verdict};
use crate::space::Space;

/// The rule.
pub(super) struct Local<'a, P: Space> {
    features: &'a Features<P>,
    slope: f64,
    loss: f64,
    user: &'a User<P>,
    /// For each simplex the cone at its middle that stands in any case; nothing if no cells are dropped (for a whole, balanced tree).
    middles: Vec<Cone<P>>,
}

/// What a cell hands down.
pub(super) struct Handed<P> {
    /// Its centre.
    centre: P,
    /// The two simplices that make it.
    pair: Option<[u32; 2]>,
    /// Distances from the centre and simplices, ascending.
    near: Vec<(f64, u32)>,
}

/// Simplices whose middles a cell looks at.
const LOOKS: usize = 16;

/// Limits of distances are raised by this factor.
const ROUNDING: f64 = 1.0 + 1e-9;

impl<'a, P: Space> Local<'a, P> {
    /// The rule for a slope, a loss and the user's function.
    pub fn new(features: &'a Features<P>, [slope, loss]: [f64; 2], user: &'a User<P>, drops: bool) -> Self {
        let middle = |i: u32| {
            let at = features.middle(i);
            Cone { at, size: (1.0 - 0.5 * loss) * features.local_size(at).radius }
        };
        let middles = if drops { (0..features.item_count()).map(middle).collect() } else { Vec::new() };
        Local { features, slope, loss, user, middles }
    }

    /// What the root is handed: everything.
    pub fn root(&self, centre: P) -> Handed<P> {
        let near = (0..self.features.item_count()).map(|i| (0.0, i)).collect();
        Handed { centre, pair: None, near }
    }

    /// A bound on lfs at `y` by two disjoint simplices.
    fn by_pair(&self, pair: [u32; 2], y: P) -> f64 {
        let d2 = pair.map(|i| self.features.dist2(i, y));
        d2[0].max(d2[1]).sqrt()
    }

    /// lfs at `m`, the two simplices that make it, and all that are no farther, ascending.
    fn size(&self, m: P, handed: &Handed<P>) -> (f64, Option<[u32; 2]>, Vec<(f64, u32)>) {
        let known = handed.pair.map_or(f64::INFINITY, |pair| self.by_pair(pair, m));
        let near = self.within(m, handed, known);
        let mut search = Search::default();
        let found = near.iter().find_map(|&(d, i)| Some((d, search.meet(self.features, i)?)));
        let (size, pair) = found.map_or((f64::INFINITY, None), |(d, pair)| (d, Some(pair)));
        (size, pair, near)
    }

    /// The cones that stand in any case.
    pub fn middles(&self) -> &[Cone<P>] {
        &self.middles
    }

    /// Is a cone above `m` nowhere below one that stands, or above `lfs(y) + L |m y|` for one of some points y? Those that cost
    /// least are asked first.
    fn is_above(&self, height: f64, m: P, pair: Option<[u32; 2]>, near: &[(f64, u32)]) -> bool {
        let Some(pair) = pair else { return false };
        let cone = |y: P, size: f64| size + self.slope * (y - m).norm2().sqrt();
        let mut looks = near.iter().take(LOOKS).map(|&(_, i)| self.middles[i as usize]);
        if looks.any(|c| height > cone(c.at, c.size)) {
            return true;
        }
        let ends = pair.map(|i| self.features.closest(i, m));
        let towards = [ends[1], (ends[0] + ends[1]) * 0.5];
        let mut steps = towards.into_iter().flat_map(|t| [1.0, 0.75, 0.5].map(|part| m + (t - m) * part));
        steps.any(|y| height > cone(y, self.by_pair(pair, y)))
    }

    /// The simplices within a distance.
    fn within(&self, m: P, handed: &Handed<P>, reach: f64) -> Vec<(f64, u32)> {
        let moved = (m - handed.centre).norm2().sqrt();
        let close = handed.near.iter().take_while(|n| n.0 <= (reach + moved) * ROUNDING);
        let all = close.map(|&(_, i)| (self.features.dist2(i, m).sqrt(), i));
        let mut near: Vec<(f64, u32)> = all.filter(|n| n.0 <= reach).collect();
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near
    }
}

impl<P: Space> Rule<P> for Local<'_, P> {
    type Load = Handed<P>;
    type Leaf = Cone<P>;

    fn judge(&self, cell: &Cell<P>, handed: &Handed<P>) -> Verdict<Handed<P>, Cone<P>> {
        let m = cell.centre;
        let (size, pair, near) = self.size(m, handed);
        let error = (1.0 + self.slope) * cell.radius();
        let cone = Cone { at: m, size: size - error };
        let drops = !self.middles.is_empty();
        if drops && (cone.size >= self.user.at(m) || self.is_above(cone.size, m, pair, &near)) {
            return Verdict::Drop;
        }
        if error <= self.loss * size.max(self.user.least) {
            return Verdict::Keep(cone);
        }
        let near = self.within(m, handed, (size + 2.0 * cell.radius()) * ROUNDING);
        Verdict::Split(Handed { centre: m, pair, near })
    }
}
