//! The recovery of parts: a part that is not an edge of the triangulation is divided.
//!
//! **Statement.** A subsegment that is missing has a vertex in its diametral ball. It is divided at the distance of
//! such a vertex from its nearer end, or in the middle. At an end where parts meet at less than 60 degrees, it is
//! divided at the distance of that vertex from this end, or at a power of two. Points on parts at such an end then have
//! equal distances from it, and do not encroach on each other's subsegments.
//!
//! *Exchanges.* Many edges are missing because points are nearly cospherical. In the first attempt, a missing edge that
//! passes through one face replaces the two cells at this face by three (a flip 2-3). Edges of the input that are present
//! then stay when points are inserted. The cells need not be Delaunay, so the recovery of facets may fail. The second
//! attempt has no exchanges.
//!
//! **Source.** Si and Gaertner (2005); Ruppert (1995), Shewchuk (2002) for powers of two.
//!
//! **Departure.** The vertex is the one among the neighbours of both ends that sees the subsegment at the largest angle.
//! The number of points is limited, because the argument for termination does not cover this choice.
//!
//! **Work and depth.** One search in the stars of both ends for each subsegment that is examined, and one insertion for
//! each point.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec3;

use super::cells::{Cells, edges_of};
use super::layout::Part;
use super::points::Points;
use crate::space::ascending;

/// The number of directions among which two always form an angle below 60 degrees.
const MANY: usize = 13;

/// The shortest subsegment relative to the largest coordinate. The rounded points of a shorter one could coincide.
const SHORTEST: f64 = 1e-13;

/// When recovery stops.
#[derive(Clone, Copy)]
pub(super) struct Limit<'a> {
    /// The largest number of points.
    pub(super) points: usize,
    /// Returns `true` if the caller has cancelled.
    pub(super) is_cancelled: &'a dyn Fn() -> bool,
}

/// A part of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sub {
    pub(super) part: u32,
    pub(super) ends: [u32; 2],
    /// The parameters of its ends along the part.
    t: [f64; 2],
}

/// The subsegments of all parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Subsegments {
    all: Vec<Sub>,
    /// The current subsegments by their ascending ends.
    of: BTreeMap<[u32; 2], u32>,
    /// Whether parts meet at less than 60 degrees at each input vertex.
    acute: Vec<bool>,
    shortest: f64,
    /// Whether edges are recovered by exchanges of cells, and are kept when points are inserted.
    exchanges: bool,
}

impl Subsegments {
    pub(super) fn new(points: &Points, parts: &[Part], exchanges: bool) -> Self {
        let largest = points.at.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let acute = acute(&points.at, parts.iter().map(|p| p.ends));
        let shortest = SHORTEST * largest;
        let mut made = Subsegments { acute, shortest, exchanges, ..Subsegments::default() };
        for (part, row) in (0u32..).zip(parts) {
            made.push(Sub { part, ends: row.ends, t: [0.0, 1.0] });
        }
        made
    }

    fn push(&mut self, sub: Sub) -> u32 {
        let id = self.all.len() as u32;
        self.of.insert(ascending(sub.ends), id);
        self.all.push(sub);
        id
    }

    /// Returns `true` if an edge is a subsegment.
    pub(super) fn has(&self, edge: [u32; 2]) -> bool {
        self.of.contains_key(&ascending(edge))
    }

    /// Returns the vertices on each part, in order.
    pub(super) fn chains(&self, parts: usize) -> Vec<Vec<u32>> {
        let mut subs: Vec<&Sub> = self.of.values().map(|&i| &self.all[i as usize]).collect();
        subs.sort_by(|a, b| a.part.cmp(&b.part).then(a.t[0].total_cmp(&b.t[0])));
        let mut chains: Vec<Vec<u32>> = vec![Vec::new(); parts];
        for sub in subs {
            let chain = &mut chains[sub.part as usize];
            if chain.is_empty() {
                chain.push(sub.ends[0]);
            }
            chain.push(sub.ends[1]);
        }
        chains
    }

    /// Divides subsegments until all are edges of the triangulation.
    ///
    /// # Errors
    /// Returns the part that needs too many or too close points.
    pub(super) fn recover(
        &mut self,
        (points, cells): (&mut Points, &mut Cells),
        parts: &[Part],
        limit: Limit<'_>,
    ) -> Result<(), u32> {
        let mut queue: VecDeque<u32> = self.of.values().copied().collect();
        let mut tries = 0;
        while let Some(id) = queue.pop_front() {
            let sub = self.all[id as usize];
            if self.of.get(&ascending(sub.ends)) != Some(&id) || cells.with(&sub.ends).is_some() {
                continue;
            }
            if self.exchanges && cells.flip(points, sub.ends) {
                continue;
            }
            // All edges that exchanges recover come before the first point.
            if self.exchanges && tries < queue.len() {
                tries += 1;
                queue.push_back(id);
                continue;
            }
            tries = 0;
            let t = self.place(points, cells, &sub);
            if points.len() >= limit.points || (limit.is_cancelled)() {
                return Err(sub.part);
            }
            self.divide((points, cells), parts, id, t, &mut queue)?;
        }
        Ok(())
    }

    /// Divides the subsegment with these ends in its middle, and restores all others.
    ///
    /// # Errors
    /// Returns the part that needs too many or too close points.
    pub(super) fn halve(
        &mut self,
        (points, cells): (&mut Points, &mut Cells),
        parts: &[Part],
        edge: [u32; 2],
        limit: Limit<'_>,
    ) -> Result<(), u32> {
        let Some(&id) = self.of.get(&ascending(edge)) else { return Ok(()) };
        let sub = self.all[id as usize];
        let t = sub.t[0] + 0.5 * (sub.t[1] - sub.t[0]);
        self.divide((&mut *points, &mut *cells), parts, id, t, &mut VecDeque::new())?;
        self.recover((points, cells), parts, limit)
    }

    fn divide(
        &mut self,
        (points, cells): (&mut Points, &mut Cells),
        parts: &[Part],
        id: u32,
        t: f64,
        queue: &mut VecDeque<u32>,
    ) -> Result<(), u32> {
        let sub = self.all[id as usize];
        let length = points.at[sub.ends[0] as usize].distance(points.at[sub.ends[1] as usize]);
        if !(sub.t[0] < t && t < sub.t[1]) || length <= 2.0 * self.shortest {
            return Err(sub.part);
        }
        let part = &parts[sub.part as usize];
        let v = points.add(part.ends, t, part.patches.clone());
        self.of.remove(&ascending(sub.ends));
        let keeps = |edge: [u32; 2]| self.exchanges && self.of.contains_key(&edge);
        let gone = cells.insert(points, sub.ends[0], v, keeps).ok_or(sub.part)?;
        for (ends, t) in [([sub.ends[0], v], [sub.t[0], t]), ([v, sub.ends[1]], [t, sub.t[1]])] {
            queue.push_back(self.push(Sub { part: sub.part, ends, t }));
        }
        let mut lost: Vec<u32> =
            gone.iter().flat_map(edges_of).filter_map(|edge| self.of.get(&edge).copied()).collect();
        lost.sort_unstable();
        lost.dedup();
        queue.extend(lost);
        Ok(())
    }

    /// Returns the parameter at which a missing subsegment is divided.
    fn place(&self, points: &Points, cells: &Cells, sub: &Sub) -> f64 {
        let [a, b] = sub.ends.map(|v| points.at[v as usize]);
        let length = a.distance(b);
        let near = reference(points, cells, sub.ends);
        let is_acute = |i: usize| sub.ends[i] < self.acute.len() as u32 && self.acute[sub.ends[i] as usize];
        let from = |end: DVec3| near.map(|p| p.distance(end));
        let at_shell = |end: DVec3| {
            let at = from(end).filter(|d| (0.05 * length..0.8 * length).contains(d));
            at.unwrap_or_else(|| shell(length))
        };
        let along = match [is_acute(0), is_acute(1)] {
            [true, false] => at_shell(a),
            [false, true] => length - at_shell(b),
            _ => match (from(a), from(b)) {
                (Some(d), _) if d < 0.5 * length => d,
                (_, Some(d)) if d < 0.5 * length => length - d,
                _ => 0.5 * length,
            },
        };
        sub.t[0] + (sub.t[1] - sub.t[0]) * (along / length).clamp(0.05, 0.95)
    }
}

/// Returns the power of two between one and two thirds of a length.
pub(super) fn shell(length: f64) -> f64 {
    let exponent = (length / 3.0).to_bits() & (0x7ff << 52);
    2.0 * f64::from_bits(exponent)
}

/// Returns the neighbour of the two ends that sees the edge at the largest angle, if that is above 90 degrees.
fn reference(points: &Points, cells: &Cells, ends: [u32; 2]) -> Option<DVec3> {
    let [a, b] = ends.map(|v| points.at[v as usize]);
    let mut best: Option<(f64, DVec3)> = None;
    let mut near = cells.neighbours(ends[0]);
    near.append(&mut cells.neighbours(ends[1]));
    for v in near.into_iter().filter(|v| !ends.contains(v)) {
        let p = points.at[v as usize];
        let (s, t) = (a - p, b - p);
        let product = s.dot(t);
        // The square of the cosine, which is negative.
        let cosine2 = product * product / (s.length_squared() * t.length_squared());
        if product < 0.0 && best.is_none_or(|(most, _)| cosine2 > most) {
            best = Some((cosine2, p));
        }
    }
    best.map(|(_, p)| p)
}

/// Returns whether edges meet at less than 60 degrees at each point.
pub(super) fn acute(points: &[DVec3], edges: impl Iterator<Item = [u32; 2]>) -> Vec<bool> {
    let mut at: Vec<Vec<DVec3>> = vec![Vec::new(); points.len()];
    for ends in edges {
        let [a, b] = ends.map(|v| points[v as usize]);
        let along = (b - a).normalize_or_zero();
        at[ends[0] as usize].push(along);
        at[ends[1] as usize].push(-along);
    }
    let is_acute = |all: &Vec<DVec3>| {
        all.len() >= MANY || all.iter().enumerate().any(|(i, d)| all[..i].iter().any(|e| d.dot(*e) > 0.5))
    };
    at.iter().map(is_acute).collect()
}
