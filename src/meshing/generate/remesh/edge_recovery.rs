//! Recovery of ridge chords that are not edges of the boundary.
//!
//! **Statement.** The Voronoi cell of a chord with the ends p and q is a polygon in its bisecting plane. There, the
//! surface is a wedge of two rays that start near the midpoint of the chord. The chord is an edge of the boundary iff
//! the polygon has corners on both sides of the wedge. Otherwise both rays leave through one edge of the polygon.
//! This edge is dual to a face (p, q, x) and crosses the surface an even number of times. The following candidates
//! recover the chord. The first one that applies is used:
//! 1. *Insertion.* The point s at which the ray farther from x leaves the polygon. It must not lie in the ball of a
//!    chord.
//! 2. *Mirroring.* The vertex x, rotated around the chord to the side of s. The polygon edges of x and its mirror image
//!    are symmetric about the plane that bisects the wedge. They therefore meet in this plane, however narrow the wedge
//!    is. At a corner, the mirror image is about as far from the corner as x, just as the points of ridges lie on a
//!    common shell.
//! 3. *Shell.* At a corner, s may lie in the ball of a chord, because facets are wide and only chords end at the
//!    corner. If all chords at the corner are equally long, the cells there correspond to the triangles of their ends
//!    on a sphere, the *shell*. The circumcentres of these triangles decide whether the cells are inside, whatever the
//!    radius. Dividing the chords would reproduce the same configuration at half the size. The surface is therefore
//!    sampled on the shell, in the direction of s from the corner. The sampled point lies outside the balls of the
//!    chords.
//! 4. *Division.* A chord is divided. At a corner, the chords longer than the shortest one there are divided first, if
//!    there are any. If chords have different lengths, the circumcentres at the corner may be anywhere. Dividing all
//!    chords at once would preserve the differences.

use septet_geometry::point::dist2;

use super::chord::Chord;
use super::refinement::Refinement;
use super::restricted::RestrictedFace;
use crate::generate::generator::Candidate;
use crate::generate::machine::MeshMachine;
use crate::mesh::Carrier;
use crate::octree::CellKey;
use crate::points::candidates::Name;
use crate::points::conflicts::Site;
use crate::space::Space;

/// The largest distance from the surface at which a mirrored vertex is projected to the surface, relative to its
/// distance from the chord.
const OFF: f64 = 0.2;

/// The distance from another vertex below which a candidate is useless, relative to the distance from the chord.
const NEAR: f64 = 0.3;

/// The largest random reduction of the distance of a mirrored vertex from the chord, relative to the distance of x.
/// Without it, two pairs that are exact mirror images of each other would form a flat cell.
const NEARER: f64 = 0.05;

/// The squared radius of the ball of a face above which s lies outside the ball of the chord, relative to the squared
/// radius of that ball.
const OUTSIDE: f64 = 2.0;

/// The shortest chord of a shell, relative to its radius.
const SHORT: f64 = 1.0 / 32.0;

/// Chords at a corner that are longer than the shortest chord by this factor are divided first.
const LEVEL: f64 = 1.25;

impl<P: Space, M: MeshMachine<P> + Sync> Refinement<'_, P, M> {
    /// Returns the candidates that turn a chord into an edge of the boundary.
    pub(super) fn for_chord(&self, chord: &Chord<P>, face: Option<&RestrictedFace<P>>) -> Vec<Candidate<P>> {
        let Some(face) = face else { return self.level(chord) };
        if !self.generator.subsegments.hold(face.place.at) {
            return vec![self.on_surface(face)];
        }
        if let Some(mirrored) = self.mirrored(chord, face) {
            return vec![mirrored];
        }
        if let Some(site) = self.on_shell(chord, face) {
            return vec![site];
        }
        let outside = face.radius * face.radius > OUTSIDE * chord.ball.radius2;
        if outside { vec![self.on_surface(face)] } else { self.level(chord) }
    }

    /// Returns the midpoints of the chords that are longer than the shortest one at a corner of the given chord. If
    /// there are none, returns the midpoint of the chord itself.
    fn level(&self, chord: &Chord<P>) -> Vec<Candidate<P>> {
        let longer = chord.ends.into_iter().filter_map(|v| self.at_corners.get(v as usize)).flat_map(|at| {
            let radius2 = |c: &u32| self.chords[*c as usize].ball.radius2;
            let least = at.iter().map(radius2).fold(f64::INFINITY, f64::min);
            at.iter().filter(move |c| radius2(c) > LEVEL * LEVEL * least)
        });
        let found: Vec<Candidate<P>> = longer.map(|&c| self.chords[c as usize].candidate()).collect();
        if found.is_empty() { vec![chord.candidate()] } else { found }
    }

    /// Returns the point of the surface in the direction of s from a corner of the chord, as far from the corner as the
    /// other end.
    fn on_shell(&self, chord: &Chord<P>, face: &RestrictedFace<P>) -> Option<Candidate<P>> {
        let v = chord.ends.into_iter().find(|&v| self.at_corners.len() > v as usize)?;
        let points = &self.generator.vertices.points;
        let (corner, radius) = (points[v as usize], 2.0 * chord.ball.radius2.sqrt());
        let towards = face.place.at - corner;
        let seen = corner + towards * (radius / towards.norm2().sqrt());
        let near = self.surface.nearest(seen)?;
        let within = |p: P, part: f64| dist2(p, near.at) <= part * part * radius * radius;
        let is_free = within(seen, SHORT) && !points.iter().any(|&p| within(p, SHORT));
        (is_free && !self.generator.subsegments.hold(near.at))
            .then_some((Site { at: near.at, size: 0.25 * radius }, Carrier::Facet(near.facet)))
    }

    /// Returns the vertex of a face opposite the chord, rotated around the chord to the side of s.
    fn mirrored(&self, chord: &Chord<P>, face: &RestrictedFace<P>) -> Option<Candidate<P>> {
        let points = &self.generator.vertices.points;
        let [p, q] = chord.ends.map(|v| points[v as usize]);
        let apex = face.vertices.into_iter().find(|v| !chord.ends.contains(v))?;
        let x = points[apex as usize];
        let axis = (q - p) / dist2(p, q).sqrt();
        let across = |y: P| {
            let along = axis * axis.dot(y - p);
            (p + along, y - p - along)
        };
        let (foot, away) = across(x);
        let (_, towards) = across(face.place.at);
        let (distance, length) = (away.norm2().sqrt(), towards.norm2().sqrt());
        let unit = Name { cell: CellKey::ROOT, number: apex }.unit(self.generator.rules.seed, 1);
        let turned = foot + towards * (distance / length * (1.0 - NEARER * unit));
        let near = self.surface.nearest(turned)?;
        let within = |a: P, b: P, part: f64| dist2(a, b) <= part * part * distance * distance;
        if !within(near.at, turned, OFF)
            || points.iter().any(|&v| within(near.at, v, NEAR))
            || self.generator.subsegments.hold(near.at)
        {
            return None;
        }
        Some((Site { at: near.at, size: NEAR * distance }, Carrier::Facet(near.facet)))
    }
}
