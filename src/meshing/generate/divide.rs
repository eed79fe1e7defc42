//! The points that divide subsegments and subfacets.
//!
//! **Statement.**
//! 1. A subsegment with one end at a corner is divided at a distance from the corner that is a power of two. Other
//!    subsegments are divided in the middle. Subsegments at a corner therefore end on common spheres, whatever their
//!    angle, and no end lies in the ball of another subsegment (Ruppert's concentric shells).
//! 2. A subfacet is divided at its circumcentre. If the circumcentre lies behind a subsegment of the facet, or in the
//!    ball of any subsegment, that subsegment is divided instead.
//! 3. Suppose that the subsegment of rule 2 ends at a corner of the subfacet, and that the other two vertices of the
//!    subfacet lie on one shell around this corner. The subfacet is then divided on the shell, and the subsegment
//!    remains.
//!
//! *Why no other points are used.* If no point of a facet lies in the balls of its subsegments, the circumcentres of
//! its subfacets lie in the facet or in such a ball. Otherwise, a circumcentre may lie outside the facet, behind a
//! subsegment. A point inside the subfacet, such as its centroid, would lie in the ball of that subsegment, and
//! repeated divisions would approach the subsegment forever.
//!
//! *Why on the shell.* A ball through a corner meets a sphere around the corner in a cap. Such a subfacet therefore
//! has a witness iff some cap through its other two vertices contains no vertex of the shell, whatever the radius of
//! the shell. Its circumcentre lies in the balls of subsegments of its facet (if the angle is less than a right
//! angle), or of other subsegments at the corner. If these were divided, all subsegments at the corner would have to
//! be divided as well, and the same subfacet would recur at half the size, forever. Consider a subsegment from the
//! corner to a point on the shell or inside it. Its ball contains no point of the shell. Arcs are divided at powers
//! of two from a segment for the same reason as subsegments are divided at powers of two from a corner. Arcs shorter
//! than a 32nd of the radius are not created, because at that length, the obstacle lies nearer to the corner.
//!
//! **Source.** Ruppert (1995), section 5; Chew (1993).

use glam::DVec2;
use septet_geometry::point::dist2;

use super::balls::Ball;
use super::facets::{Plane, as_space, circumcircle, from_space};
use super::generator::{Candidate, Generator};
use super::machine::MeshMachine;
use super::missing::MissingParts;
use super::segments::{Chains, Subsegment, subsegments_of};
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Returns the points that divide the missing parts. The size of such a point is the radius of the subfacet, or a
    /// quarter of the length of the subsegment.
    pub(super) fn divided(
        &self,
        planes: &[Plane],
        chains: &Chains,
        missing: &MissingParts,
    ) -> Vec<Candidate<P>> {
        let all = subsegments_of(chains);
        let subsegments = missing.subsegments.iter().map(|&(s, subsegment)| self.halved(s, subsegment));
        let subfacets = missing.subfacets.iter().map(|&(f, t)| {
            let [a, b, c] = t.map(|v| self.vertices.points[v as usize]);
            let Ball { centre, radius2 } = circumcircle(a, b, c);
            let plane = &planes[f as usize];
            let behind = self.behind(f, plane, chains, [(a + b + c) / 3.0, centre]);
            let held = || self.subsegments.holding(centre).first().map(|&i| all[i as usize]);
            let met = behind.or_else(held);
            if let Some(site) =
                self.on_corner_shell(f, plane, t, centre, met.map(|(_, subsegment)| subsegment))
            {
                return (site, Carrier::Facet(f));
            }
            if let Some((s, subsegment)) = met {
                let site = self.on_shell(f, plane, chains, t, subsegment);
                return site.map_or_else(|| self.halved(s, subsegment), |site| (site, Carrier::Facet(f)));
            }
            let at = from_space(plane.lift(plane.of(as_space(centre))));
            (Site { at, size: radius2.sqrt() }, Carrier::Facet(f))
        });
        subsegments.chain(subfacets).collect()
    }

    /// Returns the point on the shell that divides a subfacet between a corner and its shell. `subsegment` ends at this
    /// corner and blocks the circumcentre.
    fn on_shell(
        &self,
        f: u32,
        plane: &Plane,
        chains: &Chains,
        t: [u32; 3],
        subsegment: [u32; 2],
    ) -> Option<Site<P>> {
        let at = |v: u32| self.vertices.points[v as usize];
        let flat = |v: u32| plane.of(as_space(at(v)));
        let carrier = |v: u32| self.vertices.carriers[v as usize];
        let on_segment = |v: u32| matches!(carrier(v), Carrier::Segment(_));
        let shared = |v: u32| subsegment.contains(&v) && matches!(carrier(v), Carrier::Corner(_));
        let i = t.iter().position(|&v| shared(v))?;
        let [v, a, b] = [t[i], t[(i + 1) % 3], t[(i + 2) % 3]];
        // Arcs are counted from the end that is shared with other facets.
        let (a, b) = if on_segment(a) || !on_segment(b) { (a, b) } else { (b, a) };
        let place = between(flat(a) - flat(v), flat(b) - flat(v), on_segment(a) != on_segment(b), SHORT)?;
        let x = from_space(plane.lift(flat(v) + place));
        let way = [(at(v) + at(a) + at(b)) / 3.0, x];
        let clear = plane.holds(plane.of(as_space(x)))
            && self.behind(f, plane, chains, way).is_none()
            && !self.subsegments.hold(x);
        clear.then(|| Site { at: x, size: 0.5 * dist2(x, at(a)).min(dist2(x, at(b))).sqrt() })
    }

    /// Returns the first subsegment of the facet's segments that a path in the plane of the facet crosses.
    fn behind(&self, f: u32, plane: &Plane, chains: &Chains, way: [P; 2]) -> Option<Subsegment> {
        let flat = |p: P| plane.of(as_space(p));
        let facet = &self.domain.facets[f as usize];
        let segments = facet.boundary.iter().chain(&facet.internal);
        let subsegments =
            segments.flat_map(|&s| chains[s as usize].windows(2).map(move |w| (s, [w[0], w[1]])));
        let way = way.map(flat);
        let crossed = subsegments.filter_map(|subsegment| {
            let ends = subsegment.1.map(|v| flat(self.vertices.points[v as usize]));
            Some((crossing(way, ends)?, subsegment))
        });
        crossed.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, subsegment)| subsegment)
    }

    /// Returns the point that divides a subsegment.
    pub(super) fn halved(&self, s: u32, [a, b]: [u32; 2]) -> Candidate<P> {
        let (p, q) = (self.vertices.points[a as usize], self.vertices.points[b as usize]);
        let length = dist2(p, q).sqrt();
        let is_corner = |v: u32| matches!(self.vertices.carriers[v as usize], Carrier::Corner(_));
        let t = match (is_corner(a), is_corner(b)) {
            (true, false) => shell(length),
            (false, true) => 1.0 - shell(length),
            _ => 0.5,
        };
        let at = p + (q - p) * t;
        (Site { at, size: 0.25 * length }, Carrier::Segment(s))
    }
}

/// Returns the parameter at which a path in the plane crosses a segment.
fn crossing([from, to]: [DVec2; 2], [p, q]: [DVec2; 2]) -> Option<f64> {
    let side = |x: DVec2| (q - p).perp_dot(x - p);
    let along = |x: DVec2| (to - from).perp_dot(x - from);
    let (s, t) = (side(from), side(to));
    ((s > 0.0) != (t > 0.0) && (along(p) > 0.0) != (along(q) > 0.0)).then(|| s / (s - t))
}

/// The relative difference up to which two distances from a corner belong to one shell.
pub(super) const SHELL: f64 = 1e-6;

/// The shortest chord that is divided, relative to the radius.
const SHORT: f64 = 1.0 / 32.0;

/// The cosine beyond which an angle counts as straight.
const STRAIGHT: f64 = -0.99;

/// Returns a point between two points on a circle around the origin, if they are less than a straight angle apart. By
/// default it is the middle of the arc. With `by_powers`, its chord from the first point, divided by the radius, is a
/// power of two.
pub(super) fn between(from: DVec2, to: DVec2, by_powers: bool, shortest: f64) -> Option<DVec2> {
    let (r, s) = (from.length(), to.length());
    if (r - s).abs() > SHELL * r || from.dot(to) <= STRAIGHT * r * r {
        return None;
    }
    let chord = (to - from).length() / r;
    if chord < shortest {
        return None;
    }
    if !by_powers {
        return Some((from + to).normalize() * r);
    }
    // On the unit circle, a chord c has the cosine 1 - c^2 / 2.
    let part = shell(chord) * chord;
    let cosine = 1.0 - 0.5 * part * part;
    let sine = (1.0 - cosine * cosine).sqrt();
    let left = from.perp_dot(to).signum();
    Some(from * cosine + from.perp() * (left * sine))
}

/// Returns the parameter that divides a subsegment at a corner: the power of two closest to half its length, relative
/// to the length.
fn shell(length: f64) -> f64 {
    let half = 0.5 * length;
    let below = power_below(half);
    let power = if half > below * std::f64::consts::SQRT_2 { 2.0 * below } else { below };
    power / length
}

/// Returns the largest power of two that is at most the positive number `x`.
pub(super) fn power_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() >> 52 << 52)
}
