//! Candidates for cells that are too large.
//!
//! **Statement.** A cell inside with a circumradius above f at its centre is divided: at the point s of the widest surface
//! ball that contains its centre, otherwise at the midpoint of a chord whose ball contains it, otherwise at the centre.
//!
//! **Source.** The order of Shewchuk (1998). **Work and depth.** One lane per cell, with queries of both trees of balls.

use septet_geometry::cost::Sweep;
use septet_geometry::evaluation::{Reader, Words};
use septet_geometry::point::dist2;

use super::refine::ball;
use super::refinement::Refinement;
use super::restricted::Restricted;
use crate::executor::{Part, evaluated, in_sequence};
use crate::generate::balls::Balls;
use crate::generate::generator::Candidate;
use crate::generate::machine::MeshMachine;
use crate::mesh::Carrier;
use crate::space::Space;

/// The point that divides a cell that is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Replacement {
    /// The point s of a face.
    Face(u32),
    /// The midpoint of a chord.
    Chord(u32),
    /// The centre of the cell.
    Centre,
}

impl Words for Replacement {
    fn write(&self, words: &mut Vec<u64>) {
        words.extend(match *self {
            Replacement::Face(f) => [0, u64::from(f)],
            Replacement::Chord(c) => [1, u64::from(c)],
            Replacement::Centre => [2, 0],
        });
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let (kind, number): (u64, u32) = Words::read(from);
        match kind {
            0 => Replacement::Face(number),
            1 => Replacement::Chord(number),
            _ => Replacement::Centre,
        }
    }
}

impl<P: Space, M: MeshMachine<P> + Sync> Refinement<'_, P, M> {
    /// Returns candidates for the cells inside that are too large.
    pub(super) fn large_cells(&self, made: &Restricted<P>) -> Result<Vec<Candidate<P>>, M::Error> {
        let balls = Balls::new(made.faces.iter().map(ball).collect());
        let inside: Vec<u32> =
            (0..made.delaunay.cells.len() as u32).filter(|&i| made.labels.is_inside(i)).collect();
        let machine = &*self.generator.machine;
        let found = evaluated(machine, Part::Completion, &inside, |i: u32, own| {
            in_sequence(own, |visits| self.remedy_of(made, &balls, i, visits))
        })?;
        let found: Vec<(u32, Replacement)> =
            inside.into_iter().zip(found).filter_map(|(i, remedy)| Some((i, remedy?))).collect();
        let centres = found.iter().filter(|(_, remedy)| *remedy == Replacement::Centre);
        let centres = centres.map(|&(i, _)| (made.centres[i as usize], Carrier::Volume)).collect();
        let mut centres = self.generator.sized(centres)?.into_iter();
        let candidate = |(_, remedy): (u32, Replacement)| match remedy {
            Replacement::Face(f) => Some(self.on_surface(&made.faces[f as usize])),
            Replacement::Chord(c) => Some(self.chords[c as usize].candidate()),
            Replacement::Centre => centres.next(),
        };
        Ok(found.into_iter().filter_map(candidate).collect())
    }

    /// Returns the point that divides a cell, if the cell is too large.
    fn remedy_of(
        &self,
        made: &Restricted<P>,
        balls: &Balls<P>,
        i: u32,
        visits: &mut Sweep,
    ) -> Option<Replacement> {
        let (cell, centre) = (&made.delaunay.cells[i as usize], made.centres[i as usize]);
        let vertices = &self.generator.vertices;
        let largest = cell.as_ref().iter().map(|&v| vertices.sizes[v as usize]).fold(0.0, f64::max);
        // The smallest vertex is used, so that the result does not depend on the order that a machine returns.
        let first = cell.as_ref().iter().copied().min().unwrap_or_default();
        let radius = dist2(centre, vertices.points[first as usize]).sqrt();
        if !self.generator.rules.is_too_large(centre, radius, largest, visits) {
            return None;
        }
        let face = |f: &u32| &made.faces[*f as usize];
        let held = balls.holding_counted(centre, visits).into_iter();
        let widest = held.max_by(|a, b| {
            face(a).radius.total_cmp(&face(b).radius).then(face(b).vertices.cmp(&face(a).vertices))
        });
        if let Some(face) = widest {
            return Some(Replacement::Face(face));
        }
        let chords = self.generator.subsegments.holding_counted(centre, visits);
        Some(chords.first().map_or(Replacement::Centre, |&c| Replacement::Chord(c)))
    }
}
