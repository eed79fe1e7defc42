//! What is beside a chord that is no edge of the boundary.
//!
//! **Statement.** The Voronoi cell of a chord is a polygon in its middle plane, in which the surface is a wedge of two rays
//! from about the chord's middle. The chord is an edge of the boundary iff the polygon has corners on both sides of it; if it has not,
//! both rays leave through one edge of the polygon, which is dual to a face (p, q, x) and crosses the surface
//! an even number of times. A vertex is due where the ray that is farther from x leaves, at s. If s lies in the ball of a chord it
//! cannot be placed; then *x is mirrored*: turned around the chord until it lies towards s. Its polygon's edge and that of x
//! are mirror images in the plane that halves the wedge, so that they meet in it, however narrow the wedge is. At a corner
//! the mirrored x has the same distance from the corner as x, as ridges have on a common shell.
//!
//! Where that fails, too, a chord is divided: that which s is too close to.

use septet_geometry::point::dist2;

use super::refine::{Candidate, Refinement};
use super::restricted::Face;
use super::ridges::Chord;
use crate::generate::machine::Machine;
use crate::mesh::Carrier;
use crate::points::conflicts::Site;
use crate::space::Space;

/// How far from the surface, over its distance from the chord, a mirrored vertex may be before it is put there.
const OFF: f64 = 0.2;

/// What is nearer to another vertex, over the same, adds nothing.
const NEAR: f64 = 0.3;

/// Squared radius of a face's ball over its chord's, above which s lies outside the chord's ball.
const OUTSIDE: f64 = 2.0;

impl<P: Space, M: Machine<P> + Sync> Refinement<'_, P, M> {
    /// The candidate that makes a chord an edge of the boundary.
    pub(super) fn for_chord(&self, chord: &Chord<P>, face: Option<&Face<P>>) -> Candidate<P> {
        let Some(face) = face else { return chord.candidate() };
        if !self.work.pieces.hold(face.place.at) {
            return self.on_surface(face);
        }
        if let Some(mirrored) = self.mirrored(chord, face) {
            return mirrored;
        }
        let outside = face.radius * face.radius > OUTSIDE * chord.ball.radius2;
        if outside { self.on_surface(face) } else { chord.candidate() }
    }

    /// The vertex of a face that is not the chord's, turned around the chord towards s.
    fn mirrored(&self, chord: &Chord<P>, face: &Face<P>) -> Option<Candidate<P>> {
        let points = &self.work.vertices.points;
        let [p, q] = chord.ends.map(|v| points[v as usize]);
        let x = face.vertices.into_iter().find(|v| !chord.ends.contains(v)).map(|v| points[v as usize])?;
        let axis = (q - p) / dist2(p, q).sqrt();
        let across = |y: P| {
            let along = axis * axis.dot(y - p);
            (p + along, y - p - along)
        };
        let (foot, away) = across(x);
        let (_, towards) = across(face.place.at);
        let (distance, length) = (away.norm2().sqrt(), towards.norm2().sqrt());
        let turned = foot + towards * (distance / length);
        let near = self.surface.nearest(turned)?;
        let within = |a: P, b: P, part: f64| dist2(a, b) <= part * part * distance * distance;
        if !within(near.at, turned, OFF)
            || points.iter().any(|&v| within(near.at, v, NEAR))
            || self.work.pieces.hold(near.at)
        {
            return None;
        }
        Some((Site { at: near.at, size: NEAR * distance }, Carrier::Facet(near.facet)))
    }
}
