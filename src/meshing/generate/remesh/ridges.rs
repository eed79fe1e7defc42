//! Points on ridges.
//!
//! **Statement.** The one-dimensional generator for segments runs along each ridge, by arc length. It then adds the
//! midpoints (by arc length) of parts whose chord is too long, or whose chord is too far from the ridge at its
//! midpoint.

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::evaluation::At;
use septet_geometry::point::dist2;

use super::chord::Chord;
use super::refinement::Refinement;
use crate::bvh::{Bounds, Bvh};
use crate::executor::{Part, evaluated, in_sequence};
use crate::generate::GenerationError;
use crate::generate::balls::{Ball, Balls};
use crate::generate::generator::{CANDIDATES, Candidate};
use crate::generate::machine::MeshMachine;
use crate::generate::segments::halves;
use crate::generate::subdivision::{self, Division};
use crate::mesh::Carrier;
use crate::octree::{CellKey, DEEPEST};
use crate::points::candidates::Name;
use crate::space::Space;

impl<P: Space, M: MeshMachine<P> + Sync> Refinement<'_, P, M> {
    /// Places the corners and the points of all ridges.
    pub(super) fn ridges(&mut self) -> Result<(), GenerationError<M::Error>> {
        let corners = self.features.corners.iter().copied();
        self.generator.place_corners(corners).map_err(GenerationError::Machine)?;
        self.generator.begin("segments");
        let candidates = self.ridge_candidates().map_err(GenerationError::Machine)?;
        self.generator.sample(candidates).map_err(GenerationError::Machine)?;
        loop {
            self.make_chords();
            let candidates = self.coarse_chords().map_err(GenerationError::Machine)?;
            if candidates.is_empty() {
                return Ok(());
            }
            self.insert(candidates)?;
        }
    }

    /// Returns candidates for the chords that are too long or too far from their ridges.
    fn coarse_chords(&self) -> Result<Vec<Candidate<P>>, M::Error> {
        let numbers: Vec<u32> = (0..self.chords.len() as u32).collect();
        let coarse = evaluated(&*self.generator.machine, Part::Completion, &numbers, |c: u32, own| {
            in_sequence(own, |visits| self.is_coarse(&self.chords[c as usize], visits))
        })?;
        let faults = self.chords.iter().zip(coarse).filter(|(_, coarse)| *coarse);
        Ok(faults.map(|(chord, _)| chord.candidate()).collect())
    }

    /// Returns `true` if a chord is too long, or its midpoint is too far from the midpoint of its part of the ridge.
    fn is_coarse(&self, chord: &Chord<P>, visits: &mut Sweep) -> bool {
        let radius = chord.ball.radius2.sqrt();
        let sizes = chord.ends.map(|v| self.generator.vertices.sizes[v as usize]);
        let distance = self.distance_at(chord.middle, visits);
        self.generator.rules.is_too_large(chord.middle, radius, sizes[0].max(sizes[1]), visits)
            || dist2(chord.middle, chord.ball.centre) > distance * distance
    }

    /// Returns the candidates of all ridges.
    fn ridge_candidates(&self) -> Result<Vec<Candidate<P>>, M::Error> {
        let generator = &self.generator;
        let place = |(r, key): (u32, CellKey), unit: f64| {
            let ridge = &self.features.ridges[r as usize];
            let part = ridge.length() / (1u64 << key.level) as f64;
            (ridge.at(generator.domain, (f64::from(key.at[0]) + unit) * part), part)
        };
        let roots: Vec<(u32, CellKey)> =
            (0..self.features.ridges.len() as u32).map(|r| (r, CellKey::ROOT)).collect();
        let decide = |cell: (u32, CellKey), own: &mut Cost| {
            // A damaged message may name a ridge that does not exist. The run then ends with an error.
            if cell.0 as usize >= self.features.ridges.len() {
                return Division::Drop;
            }
            let ((middle, _), part) = place(cell, 0.5);
            let size = in_sequence(own, |visits| generator.rules.size.at_counted(middle, visits));
            let is_long = size < part && cell.1.level < DEEPEST;
            if is_long { Division::Divide(cell) } else { Division::Leaf(cell) }
        };
        let machine = &*generator.machine;
        let leaves =
            subdivision::divided(machine, (&roots, 2, u64::MAX), |&(r, key)| halves(r, key), decide)?;
        let mut leaves: Vec<(u32, CellKey)> = leaves.unwrap_or_default();
        leaves.sort_by_key(|&(r, _)| r);
        let found = evaluated(machine, Part::Candidates, &leaves, |(r, key): (u32, CellKey), _| {
            let seed = generator.seed_of(r);
            let one = |number| {
                let ((at, segment), _) = place((r, key), Name { cell: key, number }.unit(seed, 1));
                (At(at), segment)
            };
            (0..CANDIDATES).map(one).collect::<Vec<(At<P>, u32)>>()
        })?;
        let found = found.into_iter().flatten().map(|(at, segment)| (at.0, Carrier::Segment(segment)));
        generator.sized(found.collect())
    }

    /// Rebuilds the chords of the vertices on ridges, and their balls.
    pub(super) fn make_chords(&mut self) {
        let mut on: Vec<Vec<(f64, u32)>> = vec![Vec::new(); self.features.ridges.len()];
        let vertices = &self.generator.vertices;
        for (v, carrier) in (0u32..).zip(&vertices.carriers) {
            if let Carrier::Segment(s) = carrier
                && let Some((r, i)) = self.ridge_of[*s as usize]
            {
                let ridge = &self.features.ridges[r as usize];
                let start = self.generator.domain.points()[ridge.vertices[i as usize] as usize];
                let along = ridge.lengths[i as usize] + dist2(start, vertices.points[v as usize]).sqrt();
                on[r as usize].push((along, v));
            }
        }
        let mut chords = Vec::new();
        for (ridge, on) in self.features.ridges.iter().zip(&mut on) {
            let corner = |v: u32| {
                let c = self.generator.domain.corners.binary_search(&v).unwrap_or(usize::MAX) as u32;
                self.features.corners.binary_search(&c).unwrap_or(usize::MAX) as u32
            };
            on.push((0.0, corner(ridge.vertices[0])));
            on.push((ridge.length(), corner(ridge.vertices[ridge.vertices.len() - 1])));
            on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for pair in on.windows(2) {
                let ends = [pair[0].1, pair[1].1];
                let [p, q] = ends.map(|v| vertices.points[v as usize]);
                let (middle, segment) =
                    ridge.at(self.generator.domain, divided([pair[0].0, pair[1].0], ridge.length()));
                let ball = Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) };
                chords.push(Chord { ends, middle, segment, ball });
            }
        }
        let points = &self.generator.vertices.points;
        let bounds = |c: &Chord<P>| Bounds::of(c.ends.map(|v| points[v as usize]));
        self.chord_tree = Bvh::new(chords.iter().map(bounds).collect());
        self.generator.subsegments = Balls::new(chords.iter().map(|c| c.ball).collect());
        self.at_corners = vec![Vec::new(); self.features.corners.len()];
        for (c, chord) in (0u32..).zip(&chords) {
            // Corners are the first vertices.
            for v in chord.ends {
                if let Some(at) = self.at_corners.get_mut(v as usize) {
                    at.push(c);
                }
            }
        }
        self.chords = chords;
    }
}

/// Returns the arc length at which a part of a ridge of the given length is divided. It lies in the middle third.
fn divided([from, to]: [f64; 2], length: f64) -> f64 {
    let half = 0.5 * (to - from);
    // The exponent gives the largest power of two that is at most `half`. The closer of this power and its double is
    // used.
    let below = f64::from_bits(half.to_bits() & (0x7ff << 52));
    let shell = if half > 1.5 * below { 2.0 * below } else { below };
    match (from == 0.0, to == length) {
        (true, false) => shell,
        (false, true) => length - shell,
        _ => from + half,
    }
}
