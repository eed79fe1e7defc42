//! Off-centre points for circumcentres that lie in the balls of subsegments and subfacets.
//!
//! **Statement.** A circumcentre c in a ball cannot be inserted. The off-centre point x lies straight above c, as
//! seen from the subsegment or subfacet, on the boundary of the ball. If x lies in another ball, the step is
//! repeated, at most [`MOVES`] times. The point x is inserted if its distance from all vertices is at least f (the
//! size function). For facets, only the balls of subsegments count. For the volume, the balls of subfacets count as
//! well. If features meet at less than 90 degrees, the bounds do not hold anyway, and such circumcentres are skipped.
//!
//! *Benefit.* Let f be 1 everywhere. Let c lie at height h above a facet, far from the boundary of the facet. Let (m,
//! r) be the ball of the subfacet that contains the foot q of c. Among the balls of the facet, this ball is the
//! highest above q. Its height H there satisfies `H^2 = r^2 - |m - q|^2 <= 1`.
//! 1. Some corner of the subfacet has a squared distance of at most `h^2 + H^2` from c, as in the proof of the bounds
//!    ([`super`]). Therefore `R^2 <= h^2 + H^2`.
//! 2. The point x is inserted unless `R <= 1 + H - h`.
//! 3. For `H = 1`, the two bounds are equal at `h = 3/4`. For a smaller H, the value at which they are equal is
//!    lower.
//!
//! When no more points are inserted, `R <= 5/4` therefore holds, and no Delaunay edge there is longer than 5/4 times
//! the bound for other edges. Without off-centre points, the factor is `sqrt(2)`. The bound 5/4 also holds above a
//! subsegment of a facet. Near the common boundary of facets, only `sqrt(2)` is proved.
//!
//! **Work and depth.** Each circumcentre needs at most [`MOVES`] queries of the balls, and each vertex needs one query
//! of the off-centre points.

use septet_geometry::cost::Sweep;
use septet_geometry::point::dist2;

use super::balls::Ball;
use super::facets::Subfeatures;
use super::generator::{Candidate, Generator};
use super::machine::MeshMachine;
use crate::executor::{Part, evaluated, in_sequence};
use crate::points::conflicts::{Site, Sites};
use crate::space::Space;

/// The largest number of moves of a circumcentre: one above a facet, more if other features are near.
const MOVES: usize = 4;

/// The squared distance beyond which a point is outside a ball, relative to the squared radius. The margin exceeds the
/// rounding.
const BEYOND: f64 = 1.0 + 1e-9;

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Returns the off-centre point of a circumcentre, outside all balls.
    pub(super) fn off_centre(&self, centre: P, flats: &Subfeatures<'_>, visits: &mut Sweep) -> Option<P> {
        let mut x = centre;
        let moves = if self.off_centres { MOVES } else { 0 };
        for _ in 0..moves {
            let Some((ball, foot)) = self.lowest(x, flats, visits) else { break };
            let height = x - foot;
            let above = ball.radius2 * BEYOND - dist2(foot, ball.centre);
            x = foot + height * (above / height.norm2()).sqrt();
        }
        let finite = (0..P::DIM).all(|i| x.coord(i).is_finite());
        (finite && self.is_open(x, visits)).then_some(x)
    }

    /// Returns the off-centre points that do not conflict with a vertex.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    pub(super) fn free(&self, off_centre: Vec<Candidate<P>>) -> Result<Vec<Candidate<P>>, M::Error> {
        if off_centre.is_empty() {
            return Ok(off_centre);
        }
        let places: Vec<Site<P>> = off_centre.iter().map(|l| l.0).collect();
        let (near, vertices) = (Sites::new(&places), self.vertices.sites());
        let conflicts = evaluated(&*self.machine, Part::Conflicts, &vertices, |vertex: Site<P>, own| {
            in_sequence(own, |visits| near.against_counted(&vertex, visits))
        })?;
        let mut free = vec![true; off_centre.len()];
        for conflict in conflicts.into_iter().flatten() {
            free[conflict as usize] = false;
        }
        Ok(off_centre.into_iter().zip(free).filter_map(|(l, free)| free.then_some(l)).collect())
    }

    /// Returns the ball of least power among those that contain the point, and the foot of the point on the line of
    /// the subsegment or the plane of the subfacet.
    fn lowest(&self, x: P, flats: &Subfeatures<'_>, visits: &mut Sweep) -> Option<(Ball<P>, P)> {
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
        let subsegments = self.subsegments.holding_counted(x, visits).into_iter().map(of_subsegment);
        let subfacets = self.subfacets.holding_counted(x, visits).into_iter().map(of_subfacet);
        let all = subsegments.chain(subfacets);
        all.min_by(|a, b| power(&a.0).total_cmp(&power(&b.0)))
    }
}
