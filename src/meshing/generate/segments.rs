//! Points on segments.
//!
//! **Statement.** A one-dimensional generator runs on each segment:
//! 1. Each segment is halved until its parts are at most [`SIDE`] times the size at their middle. Each part has a
//!    constant number of candidates.
//! 2. A maximal independent set of them is taken, with the corners fixed.
//! 3. Midpoints of subsegments are added until no half of a subsegment is longer than the size at its midpoint.

use septet_geometry::cost::Cost;
use septet_geometry::evaluation::At;
use septet_geometry::point::dist2;

use super::balls::{Ball, Balls};
use super::generator::{CANDIDATES, Candidate, Generator, SIDE};
use super::machine::MeshMachine;
use super::subdivision::{Division, divided};
use crate::executor::{Part, evaluated, in_sequence};
use crate::mesh::Carrier;
use crate::octree::{CellKey, DEEPEST};
use crate::points::candidates::Name;
use crate::space::Space;

/// The vertices on every segment, in order.
pub(super) type Chains = Vec<Vec<u32>>;

/// A subsegment: its segment and its ends.
pub type Subsegment = (u32, [u32; 2]);

/// Returns the two halves of a part of a line.
pub(super) fn halves(line: u32, key: CellKey) -> Vec<(u32, CellKey)> {
    [0, 1].map(|i| (line, CellKey { level: key.level + 1, at: [2 * key.at[0] + i, 0, 0] })).to_vec()
}

/// Returns all subsegments with their segments.
pub(super) fn subsegments_of(chains: &Chains) -> Vec<Subsegment> {
    (0u32..).zip(chains).flat_map(|(s, c)| c.windows(2).map(move |w| (s, [w[0], w[1]]))).collect()
}

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Places the points of all segments.
    pub(super) fn segments(&mut self) -> Result<Chains, M::Error> {
        self.begin("segments");
        let candidates = self.segment_candidates()?;
        self.sample(candidates)?;
        loop {
            let chains = self.chains();
            let middles = self.coarse_subsegments(&chains)?;
            if self.complete(middles, false)? == 0 {
                self.subsegments = Balls::new(self.balls_of_subsegments(&chains));
                return Ok(chains);
            }
        }
    }

    /// Returns the middles of the subsegments that are too large.
    fn coarse_subsegments(&self, chains: &Chains) -> Result<Vec<Candidate<P>>, M::Error> {
        let all = subsegments_of(chains);
        let found = evaluated(&*self.machine, Part::Completion, &all, |(_, ends): Subsegment, own| {
            let [p, q] = ends.map(|v| self.vertices.points[v as usize]);
            let (middle, radius) = ((p + q) * 0.5, 0.5 * dist2(p, q).sqrt());
            let largest = ends.iter().map(|&v| self.vertices.sizes[v as usize]).fold(0.0, f64::max);
            let is_coarse =
                in_sequence(own, |visits| self.rules.is_too_large(middle, radius, largest, visits));
            is_coarse.then_some(At(middle))
        })?;
        let found =
            all.iter().zip(found).filter_map(|(&(s, _), found)| Some((found?.0, Carrier::Segment(s))));
        self.sized(found.collect())
    }

    pub(super) fn balls_of_subsegments(&self, chains: &Chains) -> Vec<Ball<P>> {
        let at = |v: u32| self.vertices.points[v as usize];
        let ball = |subsegment: &[u32]| {
            let (p, q) = (at(subsegment[0]), at(subsegment[1]));
            Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) }
        };
        chains.iter().flat_map(|chain| chain.windows(2).map(ball)).collect()
    }

    /// Returns the candidates of all segments.
    fn segment_candidates(&self) -> Result<Vec<Candidate<P>>, M::Error> {
        let ends = |s: u32| {
            let [a, b] = self.domain.segments[s as usize].ends().map(|v| self.domain.points()[v as usize]);
            (a, b - a)
        };
        let roots: Vec<(u32, CellKey)> =
            (0..self.domain.segments.len() as u32).map(|s| (s, CellKey::ROOT)).collect();
        let decide = |(s, key): (u32, CellKey), own: &mut Cost| {
            // A damaged message may name a segment that does not exist. The run then ends with an error.
            if s as usize >= self.domain.segments.len() {
                return Division::Drop;
            }
            let (a, along) = ends(s);
            let part = 1.0 / (1u64 << key.level) as f64;
            let middle = a + along * ((f64::from(key.at[0]) + 0.5) * part);
            let size = in_sequence(own, |visits| self.rules.size.at_counted(middle, visits));
            let is_long = SIDE * size < along.norm2().sqrt() * part && key.level < DEEPEST;
            if is_long { Division::Divide((s, key)) } else { Division::Leaf((s, key)) }
        };
        let leaves = divided(&*self.machine, (&roots, 2, u64::MAX), |&(s, key)| halves(s, key), decide)?;
        let mut leaves: Vec<(u32, CellKey)> = leaves.unwrap_or_default();
        leaves.sort_by_key(|&(s, _)| s);
        let places = evaluated(&*self.machine, Part::Candidates, &leaves, |(s, key): (u32, CellKey), _| {
            let (a, along) = ends(s);
            let part = 1.0 / (1u64 << key.level) as f64;
            let place = |number| {
                let unit = Name { cell: key, number }.unit(self.seed_of(s), 1);
                At(a + along * ((f64::from(key.at[0]) + unit) * part))
            };
            (0..CANDIDATES).map(place).collect::<Vec<At<P>>>()
        })?;
        let places = leaves.iter().zip(places);
        let found =
            places.flat_map(|(&(s, _), at)| at.into_iter().map(move |at| (at.0, Carrier::Segment(s))));
        self.sized(found.collect())
    }

    /// Returns the vertices of every segment, from its first corner to its last.
    pub(super) fn chains(&self) -> Chains {
        let corner = |v: u32| self.domain.corners.binary_search(&v).unwrap_or(usize::MAX) as u32;
        let mut chains: Vec<Vec<u32>> = vec![Vec::new(); self.domain.segments.len()];
        for (v, carrier) in (0u32..).zip(&self.vertices.carriers) {
            if let Carrier::Segment(s) = carrier {
                chains[*s as usize].push(v);
            }
        }
        for (chain, segment) in chains.iter_mut().zip(&self.domain.segments) {
            let [first, last] = segment.ends();
            let a = self.domain.points()[first as usize];
            let along = self.domain.points()[last as usize] - a;
            let place = |v: u32| (self.vertices.points[v as usize] - a).dot(along);
            chain.sort_by(|&v, &w| place(v).total_cmp(&place(w)).then(v.cmp(&w)));
            chain.insert(0, corner(first));
            chain.push(corner(last));
        }
        chains
    }
}
