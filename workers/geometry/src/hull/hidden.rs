//! Centres that are hidden by their candidates.
//!
//! **Statement.** Points with weights only ([`crate::site`]). Let the centre `p` have a link among some candidates, and let `q` be
//! another one. The following statements are equivalent, under the perturbation.
//! 1. `q` conflicts with every facet of the link, infinite ones included.
//! 2. `p` lies above the lower hull of the candidates and `q`, so it is hidden. It stays hidden if candidates are added.
//!
//! Then some finite facet `f` contains the ray from `p` away from `q` in its closed cone. The simplex of `q` and `f` is the
//! *cover* of `p`: it is not flat, it contains the position of `p`, and `p` lies strictly above it, also without the
//! perturbation.
//!
//! *Proof.* Let `h` be the heights, and let `l_f` be the linear function of a finite facet `f`, with `l_f(p) = h(p)`. Every
//! candidate `v` has `l_f(v) <= h(v)`.
//! - *2 implies 1.* `p = m q + sum m_i v_i` with weights that add up to 1 and `m h(q) + sum m_i h(v_i) < h(p)`. Here `m > 0`,
//!   because the candidates alone do not hide `p`. So `m l_f(q) = h(p) - sum m_i l_f(v_i) > m h(q)`, and `q` conflicts with `f`.
//!   Let `n` be the normal of an infinite facet, so that `n (v_i - p) <= 0`. Then `n (q - p) >= 0`. If it is 0, the finite
//!   neighbour decides, and it is in conflict.
//! - *1 implies 2.* If `p` had a link among all of them, each of its facets without `q` would be one of the old link that does not
//!   conflict. So all facets would contain `q`. But no sphere is the closed star of one of its vertices.
//! - *The cover.* The cone of rays from the lift of `p` contains the ray opposite to that of `q`, because with `q` it is all of
//!   the space above a hull facet or all of space. Its position lies in the closed cone of some finite facet `f`, so
//!   `p = m q + sum m_i v_i` over the vertices of `f`, with `m > 0`, and `m h(q) + sum m_i h(v_i) < h(p)`. The vertex `q` is on
//!   the side of `f` on which `p` is, so the simplex is not flat. If `p` lay on the simplex without the perturbation, some
//!   `v_i` with a positive weight would have a larger position, and the perturbed `p` would be below it ([`crate::site`]). QED.
//!
//! **Source.** None. An empty star in place of a cell that is searched for.
//!
//! **Work and depth.** One vector step over the facets of the link, for each hidden centre.

use super::builder::StarBuilder;
use super::candidate::candidate;
use super::corners::Corners;
use crate::point::{Point, Simplex};

impl<P: Point> StarBuilder<P> {
    /// Returns the cover of the centre as positions in the table, if the last [`StarBuilder::build`] or
    /// [`StarBuilder::extend`] found the centre hidden: a simplex of candidates that contains its position, strictly below it.
    pub fn cover(&self) -> Option<P::Cell> {
        self.cover
    }

    /// Empties the link of a centre that the candidate hides.
    #[cold]
    pub(super) fn hide(&mut self, q: u32) {
        let corners = Corners { centre: self.centre, points: &self.points };
        let opposite = self.link.live_cells().find(|&cell| corners.is_opposite(&self.link, cell, q));
        self.cover = opposite.map(|cell| {
            let mut cover = P::Cell::splat(candidate(&self.points, q).id);
            cover.as_mut()[1..].copy_from_slice(self.named(cell).as_ref());
            cover.as_mut().sort_unstable();
            cover
        });
        self.link.clear();
    }
}
