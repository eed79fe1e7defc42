//! Corner shells, for corners at which divisions do not terminate.
//!
//! **Statement.** Let several facets meet at a corner within about ten degrees of each other, between segments more
//! than 90 degrees apart. The circumcentre of a triangle at the corner then lies in the ball of a subsegment that
//! ends at the corner. Subsegments are halved, and the triangles recur at half the size. Corners v whose triangles
//! are still missing after [`ENCLOSE_AFTER`] rounds are *enclosed*:
//! 1. A permanent radius is chosen, small enough that shells do not meet.
//! 2. Each segment at v receives a point on the shell, and points on facets inside the shell are removed.
//! 3. From then on, points that would be placed inside the shell, or would divide a subsegment inside it, are placed on
//!    the shell. Such a point lies in the facet, halfway between its two neighbours on the shell. If one neighbour is
//!    on a segment, its distance from that neighbour is a power of two, as in [`super::divide`]. If the two neighbours
//!    are too close to each other, the usual rules apply.
//!
//! *Why this terminates at the corner.* Inside the shell, v is the only vertex. Consider a ball that passes through v
//! and cuts a cap from the shell. If the cap contains no vertex, the ball contains no vertex except in the lens
//! between ball and cap beyond the shell. It remains to find arcs of the shell without vertices in their caps. This
//! is like the problem of planar segments that meet at small angles and are divided on circles around their ends
//! (Ruppert). Arcs without a common end have a positive distance, and the thickness of a lens is proportional to the
//! square of its arc. Subsegments inside the shell cause no further divisions: their balls touch the shell from
//! inside, at their ends.
//!
//! **Source.** Ruppert (1995), section 5; Murphy, Mount and Gable (2001); Cohen-Steiner, Colin de Verdiere and Yvinec
//! (2004).
//!
//! **Work and depth.** One pass over all vertices for each enclosed corner and for each point on a shell.

use glam::DVec2;
use septet_geometry::point::dist2;

use super::divide::{SHELL, between, power_below};
use super::facets::{Plane, as_space, from_space};
use super::generator::Generator;
use super::machine::MeshMachine;
use super::missing::MissingParts;
use super::segments::Chains;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// The number of rounds of division before corners are enclosed. Most divisions that terminate do so earlier, with
/// longer edges.
pub(super) const ENCLOSE_AFTER: u32 = 55;

/// The shortest chord that is divided on the shell of an enclosed corner, relative to the radius.
const SHORT: f64 = 1.0 / 4096.0;

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Returns the corners of missing subfacets that are not enclosed yet, ascending.
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
                    let site = self
                        .rules
                        .site(self.domain.simplices.frame.snapped(at + (to - at) * (radius / length)));
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

    /// Returns the radius of a shell: a power of two, at most the length of the subsegments at the corner. It is less
    /// than half the distance from other corners, from points of segments that do not end here, and from points on no
    /// feature of the corner.
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

    /// Returns the point on the shell of an enclosed corner that divides a subfacet. Such a point exists if the
    /// corner is a vertex of the subfacet, or if the circumcentre, or the subsegment that blocks it, lies inside the
    /// shell.
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

    /// Returns the two vertices of a facet on a shell that are next to a direction from the corner, one on either
    /// side. Each has a flag that is set if the vertex lies on a segment.
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

/// Returns the segments at a corner and the first vertex on each.
fn firsts(v: u32, chains: &Chains) -> Vec<(u32, u32)> {
    let mut found = Vec::new();
    for (s, chain) in (0u32..).zip(chains) {
        for (end, first) in [(chain[0], chain[1]), (chain[chain.len() - 1], chain[chain.len() - 2])] {
            found.extend((end == v).then_some((s, first)));
        }
    }
    found
}
