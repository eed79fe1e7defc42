//! How cells see the local feature size.
//!
//! **Statement.** A cell with centre m, side s and radius `r = s sqrt(d) / 2` is handed simplices that hold all
//! those no farther from m than `lfs(m)`, so it knows `lfs(m)` exactly. It hands down those no farther than
//! `lfs(m) + 2 r`. *That is enough:* for the centre m' of a cell inside, `|m m'| <= r`, so `lfs(m') <= lfs(m) + r`,
//! and what is that close to m' is no farther than `lfs(m) + 2 r` from m. With their distances from m it hands
//! down the two simplices that made `lfs(m)`: they bound `lfs(m')` by u at once, and only simplices within
//! `u + |m m'|` of m are looked at. Distances are rounded, so limits are raised by a part in 10^9.
//!
//! A cell is *clear* if no simplex is closer to m than r. It then lies on one side of everything, and so do the cells
//! inside it: m is located once, by the nearest simplex if that is a wall alone, by a line if not.
//!
//! The cell is
//! - *kept*, with the cone of height `lfs(m) - (1+L) r` at m, if `(1+L) r <= loss * max(lfs(m), least)`;
//! - *dropped*, if that cone lies nowhere below the user's function; or nowhere below a cone that stands in any case,
//!   that of the middle y of one of the nearest simplices, of height `(1 - loss/2) lfs(y)`; or above another cone that
//!   the cell can see: `lfs(y) <= u` in a point y, and the cell's cone at m is above `u + L |m y|`. Such y lie on the
//!   way to the two simplices that make `lfs(m)`, and u is the distance of the farther one. Where cells are left out, y is
//!   on a simplex, or the cell lies inside of the domain and no simplex is closer to m than y;
//! - *left out*, if all walls are among the simplices, and the cell is clear and lies outside of the domain;
//! - else *split*.
//!
//! **Work and depth.** `O(k log k)` for a cell that looks at k simplices.

use super::cones::Cone;
use super::user::User;
use crate::distance::{Features, Search};
use crate::domain::Domain;
use crate::executor::Executor;
use crate::octree::{Cell, Decision, Rule};
use crate::space::Space;

/// What the rule is about.
#[derive(Clone, Copy)]
pub(super) struct Terms<'a, P: Space> {
    /// Whose local feature size.
    pub features: &'a Features<P>,
    /// The domain, if all its walls are among the features.
    pub domain: Option<&'a Domain<P>>,
    /// The user's function.
    pub user: &'a User<P>,
    /// L.
    pub slope: f64,
    /// How far g may stay below f*.
    pub loss: f64,
    /// Are cells dropped or left out? If not, the tree is whole and balanced.
    pub drops: bool,
}

/// The rule.
pub(super) struct Local<'a, P: Space> {
    terms: Terms<'a, P>,
    /// For each simplex the cone at its middle that stands in any case; nothing if no cells are dropped.
    middles: Vec<Cone<P>>,
}

/// What a cell hands down.
pub(super) struct Inherited<P> {
    /// Its centre.
    centre: P,
    /// The two simplices that make it.
    pair: Option<[u32; 2]>,
    /// Distances from the centre and simplices, ascending.
    near: Vec<(f64, u32)>,
    /// Does it lie inside of the domain for certain?
    inside: bool,
}

/// What a cell knows about its centre.
struct Known {
    /// lfs there.
    size: f64,
    /// The two simplices that make it.
    pair: Option<[u32; 2]>,
    /// All that are no farther, ascending.
    near: Vec<(f64, u32)>,
}

/// Simplices whose middles a cell looks at.
const MIDDLES: usize = 16;

/// Limits of distances are raised by this factor.
const ROUNDING: f64 = 1.0 + 1e-9;

impl<'a, P: Space> Local<'a, P> {
    /// The rule.
    pub fn new(terms: Terms<'a, P>, executor: &impl Executor) -> Self {
        let middle = |&i: &u32| {
            let at = terms.features.middle(i);
            Cone { at, size: (1.0 - 0.5 * terms.loss) * terms.features.local_size(at).radius }
        };
        let items: Vec<u32> =
            if terms.drops { (0..terms.features.item_count()).collect() } else { Vec::new() };
        let middles = executor.map(&items, middle);
        Local { terms, middles }
    }

    /// What the root is handed: everything.
    pub fn root(&self, centre: P) -> Inherited<P> {
        let near = (0..self.terms.features.item_count()).map(|i| (0.0, i)).collect();
        Inherited { centre, pair: None, near, inside: false }
    }

    /// The cones that stand in any case.
    pub fn middles(&self) -> &[Cone<P>] {
        &self.middles
    }

    /// A bound on lfs at `y` by two disjoint simplices.
    fn by_pair(&self, pair: [u32; 2], y: P) -> f64 {
        let d2 = pair.map(|i| self.terms.features.dist2(i, y));
        d2[0].max(d2[1]).sqrt()
    }

    /// What `m` knows.
    fn know(&self, m: P, inherited: &Inherited<P>) -> Known {
        let bound = inherited.pair.map_or(f64::INFINITY, |pair| self.by_pair(pair, m));
        let near = self.within(m, inherited, bound);
        let mut search = Search::default();
        let found = near.iter().find_map(|&(d, i)| Some((d, search.meet(self.terms.features, i)?)));
        let (size, pair) = found.map_or((f64::INFINITY, None), |(d, pair)| (d, Some(pair)));
        Known { size, pair, near }
    }

    /// The simplices within a distance.
    fn within(&self, m: P, inherited: &Inherited<P>, reach: f64) -> Vec<(f64, u32)> {
        let features = self.terms.features;
        let moved = (m - inherited.centre).norm2().sqrt();
        let mut near = Vec::with_capacity(inherited.near.len().min(64));
        for &(_, i) in inherited.near.iter().take_while(|n| n.0 <= (reach + moved) * ROUNDING) {
            if !features.is_beyond(i, m, reach) {
                let distance = features.dist2(i, m).sqrt();
                if distance <= reach {
                    near.push((distance, i));
                }
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near
    }

    /// Is a cone above `m` nowhere below one that stands?
    fn is_above_fixed(&self, height: f64, m: P, near: &[(f64, u32)]) -> bool {
        let mut nearest = near.iter().take(MIDDLES).map(|&(_, i)| self.middles[i as usize]);
        nearest.any(|c| height > c.size + self.terms.slope * (c.at - m).norm2().sqrt())
    }

    /// Is a cone above `m` above `lfs(y) + L |m y|` for one of some points y?
    fn is_above(&self, height: f64, m: P, known: &Known, inside: bool) -> bool {
        let Some(pair) = known.pair else { return false };
        let (features, slope) = (self.terms.features, self.terms.slope);
        let below = |y: P| height > self.by_pair(pair, y) + slope * (y - m).norm2().sqrt();
        let ends = pair.map(|i| features.closest(i, m));
        if below(ends[1]) {
            return true;
        }
        let free = match self.terms.domain {
            None => f64::INFINITY,
            Some(_) if inside => known.near.first().map_or(f64::INFINITY, |n| n.0),
            Some(_) => 0.0,
        };
        let towards = [ends[1], (ends[0] + ends[1]) * 0.5];
        let mut steps = towards.into_iter().flat_map(|t| [1.0, 0.75, 0.5].map(|part| m + (t - m) * part));
        steps.any(|y| (y - m).norm2() * ROUNDING < free * free && below(y))
    }

    /// Does a cell lie inside of the domain for certain (yes), outside (no), or is it not clear?
    fn side(&self, cell: &Cell<P>, inherited: &Inherited<P>, near: &[(f64, u32)]) -> Option<bool> {
        let domain = self.terms.domain?;
        if inherited.inside {
            return Some(true);
        }
        let &(nearest, item) = near.first().filter(|n| n.0 > cell.radius() * ROUNDING)?;
        let alone = near.get(1).is_none_or(|n| n.0 > nearest * ROUNDING);
        match self.terms.features.wall(item) {
            Some(wall) if alone => Some(domain.is_inside_by(wall, cell.centre)),
            _ => Some(domain.is_inside(cell.centre)),
        }
    }
}

impl<P: Space> Rule<P> for Local<'_, P> {
    type Load = Inherited<P>;
    type Leaf = Cone<P>;

    fn decide(&self, cell: &Cell<P>, inherited: &Inherited<P>) -> Decision<Inherited<P>, Cone<P>> {
        let Terms { user, slope, loss, drops, .. } = self.terms;
        let m = cell.centre;
        let known = self.know(m, inherited);
        let error = (1.0 + slope) * cell.radius();
        let cone = Cone { at: m, size: known.size - error };
        let mut inside = false;
        if drops {
            if cone.size >= user.at(m) || self.is_above_fixed(cone.size, m, &known.near) {
                return Decision::Drop;
            }
            let side = self.side(cell, inherited, &known.near);
            inside = side == Some(true);
            if side == Some(false) || self.is_above(cone.size, m, &known, inside) {
                return Decision::Drop;
            }
        }
        if error <= loss * known.size.max(user.least) {
            return Decision::Keep(cone);
        }
        let near = self.within(m, inherited, (known.size + 2.0 * cell.radius()) * ROUNDING);
        Decision::Split(Inherited { centre: m, pair: known.pair, near, inside })
    }
}
