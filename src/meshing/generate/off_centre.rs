//! Centres that lie in the balls of pieces and triangles, lifted out of them.
//!
//! **Statement.** A centre c that lies in a ball cannot be placed. In its stead comes, if it keeps f from all vertices, the
//! place x straight above it, seen from the piece or triangle, where the ball ends; again if that lies in another ball,
//! [`LIFTS`] times at most. On facets the balls are those of pieces, in the volume those of triangles too. Where features
//! meet at less than 90 degrees the bounds are lost anyway, and centres are given up.
//!
//! *What it is good for.* Let f be 1 everywhere, let c lie at height h above a facet, far from its border, and let (m, r)
//! be the ball of the facet's triangle that holds the foot q of c: of the facet's balls it is the highest above q, where it
//! ends at `H^2 = r^2 - |m - q|^2 <= 1`. Some corner of the triangle is within `h^2 + H^2` of c, squared, as in the proof
//! of the bounds ([`super`]), so `R^2 <= h^2 + H^2`; and x is placed unless `R <= 1 + H - h`. At `H = 1` the two meet at
//! `h = 3/4`, for a smaller H lower. So when nothing is placed any more, `R <= 5/4`, and no Delaunay edge there is
//! longer than 5/4 of what the others may be. Without lifting it is `sqrt(2)`. So it is above a piece of a facet. Where
//! facets meet nothing better than `sqrt(2)` is proved.
//!
//! **Work and depth.** [`LIFTS`] queries of the balls a centre; a query of the lifted centres a vertex.

use septet_geometry::point::dist2;

use super::balls::Ball;
use super::facets::Subfacets;
use super::generator::Generator;
use super::machine::Machine;
use crate::points::conflicts::{Site, Sites};
use crate::space::Space;

/// How often a centre is lifted: once above a facet, and again where others are near.
const MOVES: usize = 4;

/// How far beyond a ball, squared and over its radius: more than rounding.
const BEYOND: f64 = 1.0 + 1e-9;

/// What the balls of pieces and triangles are the smallest ones of, in their order.
pub(super) struct Subfeatures<'a> {
    pub(super) subsegments: Vec<(u32, [u32; 2])>,
    pub(super) subfacets: &'a Subfacets,
}

impl<P: Space, M: Machine<P> + Sync> Generator<'_, P, M> {
    /// The place outside of all balls that a centre is lifted to.
    pub(super) fn off_centre(&self, centre: P, flats: &Subfeatures<'_>) -> Option<P> {
        let mut x = centre;
        let moves = if self.off_centres { MOVES } else { 0 };
        for _ in 0..moves {
            let Some((ball, foot)) = self.lowest(x, flats) else { break };
            let height = x - foot;
            let above = ball.radius2 * BEYOND - dist2(foot, ball.centre);
            x = foot + height * (above / height.norm2()).sqrt();
        }
        let finite = (0..P::DIM).all(|i| x.coord(i).is_finite());
        (finite && self.is_open(x)).then_some(x)
    }

    /// Those of the lifted centres that no vertex is in conflict with.
    pub(super) fn free(&self, off_centre: Vec<(Site<P>, bool)>) -> Vec<(Site<P>, bool)> {
        if off_centre.is_empty() {
            return off_centre;
        }
        let places: Vec<Site<P>> = off_centre.iter().map(|l| l.0).collect();
        let (near, vertices) = (Sites::new(&places), self.vertices.sites());
        let chunks: Vec<&[Site<P>]> = vertices.chunks(4096).collect();
        let conflicts = |chunk: &&[Site<P>]| chunk.iter().flat_map(|v| near.against(v)).collect::<Vec<u32>>();
        let mut free = vec![true; off_centre.len()];
        for conflict in self.machine.map(&chunks, conflicts).into_iter().flatten() {
            free[conflict as usize] = false;
        }
        off_centre.into_iter().zip(free).filter_map(|(l, free)| free.then_some(l)).collect()
    }

    /// Of the balls that hold the place the one of least power, and the foot of the place on its piece's line or triangle's
    /// plane.
    fn lowest(&self, x: P, flats: &Subfeatures<'_>) -> Option<(Ball<P>, P)> {
        let at = |v: u32| self.vertices.points[v as usize];
        let power = |ball: &Ball<P>| dist2(ball.centre, x) - ball.radius2;
        let of_subsegment = |i: u32| {
            let [p, q] = flats.subsegments[i as usize].1.map(at);
            let along = q - p;
            (self.subsegments.all()[i as usize], p + along * ((x - p).dot(along) / along.norm2()))
        };
        let of_subfacet = |i: u32| {
            let [a, b, c] = flats.subfacets[i as usize].1.map(at);
            let normal = P::hull_normal(&[b - a, c - a]);
            (self.subfacets.all()[i as usize], x - normal * ((x - a).dot(normal) / normal.norm2()))
        };
        let subsegments = self.subsegments.holding(x).into_iter().map(of_subsegment);
        let all = subsegments.chain(self.subfacets.holding(x).into_iter().map(of_subfacet));
        all.min_by(|a, b| power(&a.0).total_cmp(&power(&b.0)))
    }
}
