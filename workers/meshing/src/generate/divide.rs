//! Where pieces and triangles are divided.
//!
//! **Statement.** A piece that ends at one corner is divided at a distance from it that is a power of two, other pieces
//! in the middle: so pieces at a corner end on common spheres whatever their angle, and leave each other's ends outside
//! of their balls (Ruppert's concentric shells). A triangle is divided at the centre of its circle, unless that lies
//! behind a piece of the facet, or in the ball of any piece: then the piece is divided.
//!
//! *Why never at another place.* If no point of a facet lies in the balls of its pieces, the centres of its triangles lie in
//! the facet or in such a ball. If one does, a centre may lie beyond the border, with a piece between; a place
//! that is then chosen in the triangle itself, its middle say, comes closer and closer to the piece, whose ball it lies in, and there
//! is no end of it.
//!
//! **Source.** Ruppert (1995), section 5; Chew (1993).

use glam::DVec2;
use septet_geometry::point::dist2;

use super::balls::Ball;
use super::facets::{Plane, as_space, circumcircle, from_space};
use super::lacking::Lacking;
use super::machine::Machine;
use super::segments::{Chains, pieces_of};
use super::work::Work;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

impl<P: Space, M: Machine<P> + Sync> Work<'_, P, M> {
    /// Where what is missing is divided. The size of a site is the radius of the triangle, a quarter of a piece's length.
    pub(super) fn divided(
        &self,
        planes: &[Plane],
        chains: &Chains,
        lacking: &Lacking,
    ) -> Vec<(Site<P>, Carrier)> {
        let all = pieces_of(chains);
        let pieces = lacking.pieces.iter().map(|&(s, piece)| self.halved(s, piece));
        let triangles = lacking.triangles.iter().map(|&(f, t)| {
            let [a, b, c] = t.map(|v| self.vertices.points[v as usize]);
            let Ball { centre, radius2 } = circumcircle(a, b, c);
            let plane = &planes[f as usize];
            let behind = self.behind(f, plane, chains, [(a + b + c) / 3.0, centre]);
            let held = || self.pieces.holding(centre).first().map(|&i| all[i as usize]);
            if let Some((s, piece)) = behind.or_else(held) {
                return self.halved(s, piece);
            }
            let at = from_space(plane.lift(plane.of(as_space(centre))));
            (Site { at, size: radius2.sqrt() }, Carrier::Facet(f))
        });
        pieces.chain(triangles).collect()
    }

    /// The first piece of a facet's segments that a way in the facet's plane crosses.
    fn behind(&self, f: u32, plane: &Plane, chains: &Chains, way: [P; 2]) -> Option<(u32, [u32; 2])> {
        let flat = |p: P| plane.of(as_space(p));
        let facet = &self.domain.facets[f as usize];
        let segments = facet.boundary.iter().chain(&facet.internal);
        let pieces = segments.flat_map(|&s| chains[s as usize].windows(2).map(move |w| (s, [w[0], w[1]])));
        let way = way.map(flat);
        let crossed = pieces.filter_map(|piece| {
            let ends = piece.1.map(|v| flat(self.vertices.points[v as usize]));
            Some((crossing(way, ends)?, piece))
        });
        crossed.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, piece)| piece)
    }

    /// The place that divides a piece.
    pub(super) fn halved(&self, s: u32, [a, b]: [u32; 2]) -> (Site<P>, Carrier) {
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

/// Where a way of the plane crosses a segment, as a part of the way.
fn crossing([from, to]: [DVec2; 2], [p, q]: [DVec2; 2]) -> Option<f64> {
    let beside = |x: DVec2| (q - p).perp_dot(x - p);
    let along = |x: DVec2| (to - from).perp_dot(x - from);
    let (s, t) = (beside(from), beside(to));
    ((s > 0.0) != (t > 0.0) && (along(p) > 0.0) != (along(q) > 0.0)).then(|| s / (s - t))
}

/// Where a piece that begins at a corner is divided: at the power of two nearest to half of its length, as a part of it.
fn shell(length: f64) -> f64 {
    let half = 0.5 * length;
    let below = f64::from_bits(half.to_bits() >> 52 << 52);
    let power = if half > below * std::f64::consts::SQRT_2 { 2.0 * below } else { below };
    power / length
}
