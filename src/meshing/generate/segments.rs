//! Points on segments.
//!
//! **Statement.** A one-dimensional generator runs on each segment:
//! 1. Each segment is halved until its parts are at most [`SIDE`] times the size at their middle. Each part has a
//!    constant number of candidates.
//! 2. A maximal independent set of them is taken, with the corners fixed.
//! 3. Midpoints of subsegments are added until no half of a subsegment is longer than the size at its midpoint.

use septet_geometry::point::dist2;

use super::balls::{Ball, Balls};
use super::generator::{CANDIDATES, Candidate, Generator, SIDE};
use super::machine::MeshMachine;
use crate::mesh::Carrier;
use crate::octree::{CellKey, DEEPEST};
use crate::points::candidates::Name;
use crate::space::Space;

/// The vertices on every segment, in order.
pub(super) type Chains = Vec<Vec<u32>>;

/// A subsegment: its segment and its ends.
pub type Subsegment = (u32, [u32; 2]);

/// Returns all subsegments with their segments.
pub(super) fn subsegments_of(chains: &Chains) -> Vec<Subsegment> {
    (0u32..).zip(chains).flat_map(|(s, c)| c.windows(2).map(move |w| (s, [w[0], w[1]]))).collect()
}

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Places the points of all segments.
    pub(super) fn segments(&mut self) -> Result<Chains, M::Error> {
        self.begin("segments");
        let mut candidates = Vec::new();
        for s in 0..self.domain.segments.len() as u32 {
            self.candidates_on(s, &mut candidates);
        }
        self.sample(candidates)?;
        loop {
            let chains = self.chains();
            let mut middles = Vec::new();
            for (s, chain) in (0u32..).zip(&chains) {
                for subsegment in chain.windows(2) {
                    let [p, q] = [0, 1].map(|i| self.vertices.points[subsegment[i] as usize]);
                    let (middle, radius) = ((p + q) * 0.5, 0.5 * dist2(p, q).sqrt());
                    let largest =
                        subsegment.iter().map(|&v| self.vertices.sizes[v as usize]).fold(0.0, f64::max);
                    if self.rules.is_too_large(middle, radius, largest) {
                        middles.push((self.rules.site(middle), Carrier::Segment(s)));
                    }
                }
            }
            if self.complete(middles, false)? == 0 {
                self.subsegments = Balls::new(self.balls_of_subsegments(&chains));
                return Ok(chains);
            }
        }
    }

    pub(super) fn balls_of_subsegments(&self, chains: &Chains) -> Vec<Ball<P>> {
        let at = |v: u32| self.vertices.points[v as usize];
        let ball = |subsegment: &[u32]| {
            let (p, q) = (at(subsegment[0]), at(subsegment[1]));
            Ball { centre: (p + q) * 0.5, radius2: 0.25 * dist2(p, q) }
        };
        chains.iter().flat_map(|chain| chain.windows(2).map(ball)).collect()
    }

    fn candidates_on(&self, s: u32, out: &mut Vec<Candidate<P>>) {
        let [a, b] = self.domain.segments[s as usize].ends().map(|v| self.domain.points()[v as usize]);
        let (along, seed) = (b - a, self.seed_of(s));
        let length = along.norm2().sqrt();
        let mut cells = vec![CellKey::ROOT];
        while let Some(key) = cells.pop() {
            let part = 1.0 / (1u64 << key.level) as f64;
            let middle = (f64::from(key.at[0]) + 0.5) * part;
            if SIDE * (self.rules.size)(a + along * middle) < length * part && key.level < DEEPEST {
                let half = |i: u32| CellKey { level: key.level + 1, at: [2 * key.at[0] + i, 0, 0] };
                cells.extend([half(0), half(1)]);
                continue;
            }
            for number in 0..CANDIDATES {
                let t = (f64::from(key.at[0]) + Name { cell: key, number }.unit(seed, 1)) * part;
                out.push((self.rules.site(a + along * t), Carrier::Segment(s)));
            }
        }
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
