//! Corners at which divisions have no end, and the shells that end them.
//!
//! **Statement.** Where several facets meet at a corner within some ten degrees of each other, between segments more than 90 degrees
//! apart, the triangles at the corner come again and again, half as large: the centre of one lies in the ball of a piece that ends
//! there, so pieces are halved. Such a corner v, found by the triangles that are still lacking at it after [`UNENDING`] rounds, is *enclosed*: a radius
//! is chosen for good, so small that shells do not meet; all of its segments get a point on that shell, and points of facets within are taken away. From then on
//! what would be placed within, or would halve a piece within, is placed on the shell, in the facet, halfway between the
//! neighbours it has there (counted in powers of two from a segment on, as in [`super::divide`]); where those are too close
//! together for that, as elsewhere.
//!
//! *Why that ends at the corner.* With nothing but v within the shell, a ball through v and a cap of the shell holds no vertex if the cap
//! holds none, but for what lies in the lens between them beyond the shell. So what is left is to have arcs of the shell without vertices in
//! their caps: segments of a plane, so to speak, that meet at small angles, divided on circles around their ends (Ruppert). Arcs have a distance
//! where they have no common end; and lenses are as thin as the square of arcs. Pieces within the shell are never in the way: their balls touch
//! the shell from inside, at their ends.
//!
//! **Source.** Ruppert (1995), section 5; Murphy, Mount and Gable (2001); Cohen-Steiner, Colin de Verdiere and Yvinec (2004).
//!
//! **Work and depth.** A look at all vertices for every corner enclosed, and for each place on a shell.

use glam::DVec2;
use septet_geometry::point::dist2;

use super::divide::{SHELL, between, power_below};
use super::facets::{Plane, as_space, from_space};
use super::generator::Generator;
use super::machine::Machine;
use super::missing::MissingParts;
use super::segments::Chains;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// Rounds of division before corners are enclosed. What has an end has it before, mostly, with longer edges.
pub(super) const ENCLOSE_AFTER: u32 = 55;

/// The shortest chord over the radius that is divided on the shell of an enclosed corner.
const SHORT: f64 = 1.0 / 4096.0;

impl<P: Space, M: Machine<P> + Sync> Generator<'_, P, M> {
    /// The corners of lacking triangles that are not enclosed yet, ascending.
    pub(super) fn unresolved_corners(&self, missing: &MissingParts) -> Vec<u32> {
        let corners = missing.subfacets.iter().flat_map(|(_, t)| t).copied();
        let open = |v: &u32| {
            matches!(self.vertices.carriers[*v as usize], Carrier::Corner(_)) && !self.shells.contains_key(v)
        };
        let mut corners: Vec<u32> = corners.filter(open).collect();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// Encloses corners.
    pub(super) fn enclose(&mut self, corners: &[u32], chains: &Chains) {
        for &v in corners {
            let radius = self.shell_of(v, chains);
            self.shells.insert(v, radius);
            let at = self.vertices.points[v as usize];
            for (s, first) in firsts(v, chains) {
                let to = self.vertices.points[first as usize];
                let length = dist2(at, to).sqrt();
                if length > radius * (1.0 + SHELL) {
                    let site = self.rules.site(at + (to - at) * (radius / length));
                    self.vertices.push(site, Carrier::Segment(s));
                }
            }
        }
        let within = |x: P, carrier: &Carrier| {
            let holds = |(&v, &r): (&u32, &f64)| {
                dist2(self.vertices.points[v as usize], x) < (r * (1.0 - SHELL)).powi(2)
            };
            matches!(carrier, Carrier::Facet(_)) && self.shells.iter().any(holds)
        };
        let all = self.vertices.points.iter().zip(&self.vertices.carriers);
        let kept: Vec<bool> = all.map(|(&x, carrier)| !within(x, carrier)).collect();
        self.vertices.keep(&kept);
    }

    /// A power of two, less than half the distance from other corners, points of segments that do not end here and what is on no
    /// feature of the corner, and no more than the pieces there.
    fn shell_of(&self, v: u32, chains: &Chains) -> f64 {
        let at = self.vertices.points[v as usize];
        let carriers = &self.vertices.carriers;
        let own = firsts(v, chains);
        let apart = |w: &u32| match carriers[*w as usize] {
            Carrier::Corner(_) => *w != v,
            Carrier::Segment(s) => own.iter().all(|&(of, _)| of != s),
            _ => self.holders.common(carriers, &[v, *w]).is_empty(),
        };
        let others = (0..self.vertices.len() as u32)
            .filter(apart)
            .map(|w| dist2(at, self.vertices.points[w as usize]));
        let others = 0.49 * others.fold(f64::INFINITY, f64::min).sqrt();
        let subsegments = own.iter();
        let subsegments = subsegments
            .map(|&(_, w)| dist2(at, self.vertices.points[w as usize]))
            .fold(f64::INFINITY, f64::min);
        power_below(others.min(subsegments.sqrt() * (1.0 + SHELL)))
    }

    /// Where a triangle of a facet is divided on the shell of an enclosed corner, if the corner is one of its own, its centre lies
    /// within the shell, or the piece that is in the way of the centre does.
    pub(super) fn on_corner_shell(
        &self,
        f: u32,
        plane: &Plane,
        t: [u32; 3],
        centre: P,
        subsegment: Option<[u32; 2]>,
    ) -> Option<Site<P>> {
        let at = |v: u32| self.vertices.points[v as usize];
        let carriers = &self.vertices.carriers;
        let of_facet = |v: u32| self.holders.of(&carriers[v as usize]).binary_search(&f).is_ok();
        let concerns = |&(&v, &r): &(&u32, &f64)| {
            let subsegment = subsegment.is_some_and(|p| p.contains(&v));
            of_facet(v)
                && (t.contains(&v) || subsegment || dist2(at(v), centre) < (r * (1.0 + SHELL)).powi(2))
        };
        let (&v, &radius) = self.shells.iter().find(concerns)?;
        let from = plane.of(as_space(at(v)));
        let [a, b, c] = t.map(|w| plane.of(as_space(at(w))));
        let way = ((a + b + c) / 3.0 - from).normalize_or_zero();
        let sides = self.neighbours_on_shell(f, plane, from, way, radius);
        let place = match sides {
            [Some((a, true)), Some((b, false))] | [Some((b, false)), Some((a, true))] => {
                between(a, b, true, SHORT)?
            }
            [Some((a, _)), Some((b, _))] => between(a, b, false, SHORT)?,
            _ => way * radius,
        };
        if !plane.holds(from + place) {
            return None;
        }
        let gap = sides.into_iter().flatten().map(|(side, _)| (place - side).length());
        let size = 0.5 * gap.fold(radius, f64::min);
        Some(Site { at: from_space(plane.lift(from + place)), size })
    }

    /// The vertices of a facet on a shell that are next to a way on either side of it, seen from the corner, and whether they are on segments.
    fn neighbours_on_shell(
        &self,
        f: u32,
        plane: &Plane,
        from: DVec2,
        way: DVec2,
        radius: f64,
    ) -> [Option<(DVec2, bool)>; 2] {
        let mut sides: [Option<(DVec2, bool)>; 2] = [None; 2];
        for (&x, carrier) in self.vertices.points.iter().zip(&self.vertices.carriers) {
            if self.holders.of(carrier).binary_search(&f).is_err() {
                continue;
            }
            let to = plane.of(as_space(x)) - from;
            if (to.length() - radius).abs() > SHELL * radius {
                continue;
            }
            let side = &mut sides[usize::from(way.perp_dot(to) > 0.0)];
            if side.is_none_or(|(nearest, _)| way.dot(nearest) < way.dot(to)) {
                *side = Some((to, matches!(carrier, Carrier::Segment(_))));
            }
        }
        sides
    }
}

/// The segments at a corner and the first vertex on each.
fn firsts(v: u32, chains: &Chains) -> Vec<(u32, u32)> {
    let mut found = Vec::new();
    for (s, chain) in (0u32..).zip(chains) {
        for (end, first) in [(chain[0], chain[1]), (chain[chain.len() - 1], chain[chain.len() - 2])] {
            found.extend((end == v).then_some((s, first)));
        }
    }
    found
}
