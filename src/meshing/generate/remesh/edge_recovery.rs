//! What is beside a chord that is no edge of the boundary.
//!
//! **Statement.** The Voronoi cell of a chord is a polygon in its middle plane, in which the surface is a wedge of two rays
//! from about the chord's middle. The chord is an edge of the boundary iff the polygon has corners on both sides of it; if it has not,
//! both rays leave through one edge of the polygon, which is dual to a face (p, q, x) and crosses the surface
//! an even number of times. A vertex is due where the ray that is farther from x leaves, at s. If s lies in the ball of a chord it
//! cannot be placed; then *x is mirrored*: turned around the chord until it lies towards s. Its polygon's edge and that of x
//! are mirror images in the plane that halves the wedge, so that they meet in it, however narrow the wedge is. At a corner
//! the mirrored x has about the same distance from the corner as x, as ridges have on a common shell.
//!
//! At a corner s may lie in the ball of a chord there because nothing but chords ends at the corner, and facets are wide. If all
//! chords at it are equally long, the cells there are those over the triangles of their ends on a sphere, the *shell*, inside or outside by
//! the centres of their circles, whatever its radius; were the chords divided, all would be the same again at half the size. So the
//! surface is sampled on the shell, where the corner sees s; that is outside of the chords' balls.
//!
//! Where that fails, too, a chord is divided. At a corner that is not the chord itself but those that are longer than the shortest
//! one there, if there are any: of chords of different lengths the centres of cells at the corner may be anywhere, and were
//! all divided at once they would be as different again.

use septet_geometry::point::dist2;

use super::chord::Chord;
use super::refinement::{Candidate, Refinement};
use super::restricted::Face;
use crate::generate::machine::Machine;
use crate::mesh::Carrier;
use crate::octree::Key;
use crate::points::candidates::Name;
use crate::points::conflicts::Site;
use crate::space::Space;

/// How far from the surface, over its distance from the chord, a mirrored vertex may be before it is put there.
const OFF: f64 = 0.2;

/// What is nearer to another vertex, over the same, adds nothing.
const NEAR: f64 = 0.3;

/// How much nearer to the chord than x a mirrored vertex may be, at random: two pairs that are mirror images of each other are
/// corners of a flat cell.
const NEARER: f64 = 0.05;

/// Squared radius of a face's ball over its chord's, above which s lies outside the chord's ball.
const OUTSIDE: f64 = 2.0;

/// The shortest chord of a shell, over its radius.
const SHORT: f64 = 1.0 / 32.0;

/// Chords at a corner that are longer than this many times the shortest one there are divided first.
const LEVEL: f64 = 1.25;

impl<P: Space, M: Machine<P> + Sync> Refinement<'_, P, M> {
    /// The candidates that make a chord an edge of the boundary.
    pub(super) fn for_chord(&self, chord: &Chord<P>, face: Option<&Face<P>>) -> Vec<Candidate<P>> {
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

    /// The middles of the chords that are longer than the shortest one at a corner of a chord; if there are none (or no corner), its
    /// own.
    fn level(&self, chord: &Chord<P>) -> Vec<Candidate<P>> {
        let longer = chord.ends.into_iter().filter_map(|v| self.at_corners.get(v as usize)).flat_map(|at| {
            let radius2 = |c: &u32| self.chords[*c as usize].ball.radius2;
            let least = at.iter().map(radius2).fold(f64::INFINITY, f64::min);
            at.iter().filter(move |c| radius2(c) > LEVEL * LEVEL * least)
        });
        let found: Vec<Candidate<P>> = longer.map(|&c| self.chords[c as usize].candidate()).collect();
        if found.is_empty() { vec![chord.candidate()] } else { found }
    }

    /// The place of the surface at which a corner of a chord sees s, as far from the corner as the chord's other end.
    fn on_shell(&self, chord: &Chord<P>, face: &Face<P>) -> Option<Candidate<P>> {
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

    /// The vertex of a face that is not the chord's, turned around the chord towards s.
    fn mirrored(&self, chord: &Chord<P>, face: &Face<P>) -> Option<Candidate<P>> {
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
        let unit = Name { cell: Key::ROOT, number: apex }.unit(self.generator.rules.seed, 1);
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
