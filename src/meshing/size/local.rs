//! The rule that evaluates the local feature size in the cells of the tree.
//!
//! **Statement.** Let a cell have the centre m, the side s and the radius `r = s sqrt(d) / 2`. It inherits a set of
//! simplices that contains all simplices no farther from m than `lfs(m)`. This set suffices to compute `lfs(m)`
//! exactly. Its children inherit the simplices no farther than `lfs(m) + 2 r`.
//!
//! *This set suffices.* The centre m' of a child satisfies `|m m'| <= r`, so `lfs(m') <= lfs(m) + r`. If a simplex
//! has at most this distance from m', its distance from m is at most `lfs(m) + 2 r`.
//!
//! The children also inherit the distances from m and the two simplices that determine `lfs(m)`. These two give an
//! upper bound u of `lfs(m')`, and only simplices within `u + |m m'|` of m need to be tested. Distances are rounded, so
//! limits are increased by a factor of 1 + 10^-9.
//!
//! A cell is *clear* if no simplex is closer to m than r. The cell and its descendants then lie on one side of every
//! feature, so m is located only once. If the nearest simplex is unique and a wall, it determines the location.
//! Otherwise, a line does.
//!
//! The first of the following rules that applies decides about a cell:
//! - It is *dropped* if its cone, of height `lfs(m) - (1+L) r` at m, is nowhere below one of these:
//!   - the user's function;
//!   - a cone that is always present: at the middle y of one of the nearest simplices, of height `(1 - loss/2) lfs(y)`;
//!   - another cone that is visible from the cell. There is a point y with `lfs(y) <= u`, and the height of the cell's
//!     cone at m exceeds `u + L |m y|`. Such points y lie on the paths to the two simplices that determine `lfs(m)`,
//!     and u is the distance of the farther one. If cells are omitted, one of two further conditions must hold: y lies
//!     on a simplex, or the cell lies inside the domain and no simplex is closer to m than y.
//! - It is *omitted* if all walls are among the simplices, and the cell is clear and lies outside the domain.
//! - It is *kept* with its cone if `(1+L) r <= loss * max(lfs(m), least)`.
//! - Otherwise, it is *split*.
//!
//! **Work and depth.** `O(k log k)` for a cell that tests k simplices.

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::evaluation::{At, Reader, Words};

use super::cones::Cone;
use super::user::User;
use crate::distance::{Features, Search};
use crate::domain::Domain;
use crate::executor::{Evaluator, Part, evaluated, in_sequence};
use crate::octree::{Cell, Decision, Rule};
use crate::space::Space;

/// The parameters of the rule.
#[derive(Clone, Copy)]
pub(super) struct Terms<'a, P: Space> {
    /// The features that determine the local feature size.
    pub features: &'a Features<P>,
    /// The domain, if all its walls are among the features.
    pub domain: Option<&'a Domain<P>>,
    /// The user's function.
    pub user: &'a User<P>,
    /// L.
    pub slope: f64,
    /// The largest loss of g relative to f*.
    pub loss: f64,
    /// Whether cells are dropped or omitted. If not, the tree is complete and balanced.
    pub drops: bool,
}

/// The rule.
pub(super) struct Local<'a, P: Space> {
    terms: Terms<'a, P>,
    /// The cone at the middle of each simplex, which is always present. Empty if no cells are dropped.
    middles: Vec<Cone<P>>,
}

/// The data that children inherit from a cell.
pub(super) struct Inherited<P> {
    /// The centre of the cell.
    centre: P,
    /// The two simplices that determine lfs at the centre.
    pair: Option<[u32; 2]>,
    /// Simplices with their distances from the centre, ascending.
    near: Vec<(f64, u32)>,
    /// Whether the cell certainly lies inside the domain.
    inside: bool,
}

impl<P: Space> Words for Inherited<P> {
    fn write(&self, words: &mut Vec<u64>) {
        (At(self.centre), self.pair, self.inside).write(words);
        self.near.write(words);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let (At(centre), pair, inside) = Words::read(from);
        Inherited { centre, pair, near: Words::read(from), inside }
    }
}

/// The local feature size at the centre of a cell.
struct Known {
    /// lfs at the centre.
    size: f64,
    /// The two simplices that determine it.
    pair: Option<[u32; 2]>,
    /// All simplices within the distance lfs, ascending.
    near: Vec<(f64, u32)>,
}

/// The number of nearest simplices whose cones are compared.
const MIDDLES: usize = 16;

/// The factor by which limits of distances are increased.
const ROUNDING: f64 = 1.0 + 1e-9;

impl<'a, P: Space> Local<'a, P> {
    /// Creates the rule.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    pub fn new<M: Evaluator<P>>(terms: Terms<'a, P>, machine: &M) -> Result<Self, M::Error> {
        let middle = |i: u32, own: &mut Cost| {
            let at = terms.features.middle(i);
            let local = in_sequence(own, |visits| terms.features.local_size_counted(at, visits));
            Cone { at, size: (1.0 - 0.5 * terms.loss) * local.radius }
        };
        let items: Vec<u32> =
            if terms.drops { (0..terms.features.item_count()).collect() } else { Vec::new() };
        let middles = evaluated(machine, Part::Sizes, &items, middle)?;
        Ok(Local { terms, middles })
    }

    /// Returns the data of the root: all simplices.
    pub fn root(&self, centre: P) -> Inherited<P> {
        let near = (0..self.terms.features.item_count()).map(|i| (0.0, i)).collect();
        Inherited { centre, pair: None, near, inside: false }
    }

    /// Returns the cones that are always present.
    pub fn middles(&self) -> &[Cone<P>] {
        &self.middles
    }

    /// Returns an upper bound of lfs at `y`, from two disjoint simplices.
    fn by_pair(&self, pair: [u32; 2], y: P) -> f64 {
        let d2 = pair.map(|i| self.terms.features.dist2(i, y));
        d2[0].max(d2[1]).sqrt()
    }

    /// Computes the local feature size at `m`.
    fn know(&self, m: P, inherited: &Inherited<P>, own: &mut Cost) -> Known {
        let bound = inherited.pair.map_or(f64::INFINITY, |pair| self.by_pair(pair, m));
        let near = self.within(m, inherited, bound, own);
        let mut search = Search::default();
        let mut met = own.sweep();
        let found = near.iter().find_map(|&(d, i)| {
            met.visit();
            Some((d, search.meet(self.terms.features, i)?))
        });
        own.charge_sequence(met);
        let (size, pair) = found.map_or((f64::INFINITY, None), |(d, pair)| (d, Some(pair)));
        Known { size, pair, near }
    }

    /// Returns the simplices within a distance: a vector step over the inherited simplices, and a sort.
    fn within(&self, m: P, inherited: &Inherited<P>, reach: f64, own: &mut Cost) -> Vec<(f64, u32)> {
        let features = self.terms.features;
        let moved = (m - inherited.centre).norm2().sqrt();
        let mut near = Vec::with_capacity(inherited.near.len().min(64));
        let mut tested = own.sweep();
        for &(_, i) in inherited.near.iter().take_while(|n| n.0 <= (reach + moved) * ROUNDING) {
            tested.visit();
            if !features.is_beyond(i, m, reach) {
                let distance = features.dist2(i, m).sqrt();
                if distance <= reach {
                    near.push((distance, i));
                }
            }
        }
        own.charge_sweep(tested);
        let mut sorted = own.sweep();
        sorted.visit_all(&near);
        own.charge_sort(sorted);
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near
    }

    /// Returns `true` if a cone at `m` is nowhere below a cone that is always present.
    fn is_above_fixed(&self, height: f64, m: P, near: &[(f64, u32)], visits: &mut Sweep) -> bool {
        let nearest = visits.visit_all(&near[..near.len().min(MIDDLES)]);
        let mut nearest = nearest.iter().map(|&(_, i)| self.middles[i as usize]);
        nearest.any(|c| height > c.size + self.terms.slope * (c.at - m).norm2().sqrt())
    }

    /// Returns `true` if a cone at `m` lies above `lfs(y) + L |m y|` for one of several points y.
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

    /// Returns whether a cell certainly lies inside or outside the domain, or `None` if it is not clear.
    fn side(
        &self,
        cell: &Cell<P>,
        inherited: &Inherited<P>,
        near: &[(f64, u32)],
        visits: &mut Sweep,
    ) -> Option<bool> {
        let domain = self.terms.domain?;
        if inherited.inside {
            return Some(true);
        }
        let &(nearest, item) = near.first().filter(|n| n.0 > cell.radius() * ROUNDING)?;
        let alone = near.get(1).is_none_or(|n| n.0 > nearest * ROUNDING);
        match self.terms.features.wall(item) {
            Some(wall) if alone => Some(domain.is_inside_by(wall, cell.centre)),
            _ => Some(domain.is_inside_counted(cell.centre, visits)),
        }
    }
}

impl<P: Space> Rule<P> for Local<'_, P> {
    type Load = Inherited<P>;
    type Leaf = Cone<P>;

    fn decide(
        &self,
        cell: &Cell<P>,
        inherited: &Inherited<P>,
        own: &mut Cost,
    ) -> Decision<Inherited<P>, Cone<P>> {
        let Terms { features, user, slope, loss, drops, .. } = self.terms;
        // A damaged message may name a simplex that does not exist. The run then ends with an error.
        let named = inherited.near.iter().map(|&(_, i)| i).chain(inherited.pair.into_iter().flatten());
        if named.max().is_some_and(|i| i >= features.item_count()) {
            return Decision::Drop;
        }
        let m = cell.centre;
        let known = self.know(m, inherited, own);
        let error = (1.0 + slope) * cell.radius();
        let cone = Cone { at: m, size: known.size - error };
        let mut inside = false;
        if drops {
            let is_above = in_sequence(own, |visits| {
                cone.size >= user.at_counted(m, visits)
                    || self.is_above_fixed(cone.size, m, &known.near, visits)
            });
            if is_above {
                return Decision::Drop;
            }
            let side = in_sequence(own, |visits| self.side(cell, inherited, &known.near, visits));
            inside = side == Some(true);
            if side == Some(false) || self.is_above(cone.size, m, &known, inside) {
                return Decision::Drop;
            }
        }
        if error <= loss * known.size.max(user.least) {
            return Decision::Keep(cone);
        }
        let near = self.within(m, inherited, (known.size + 2.0 * cell.radius()) * ROUNDING, own);
        Decision::Split(Inherited { centre: m, pair: known.pair, near, inside })
    }
}
