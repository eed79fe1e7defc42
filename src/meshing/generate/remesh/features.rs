//! What is kept of a surface: ridges and their corners.
//!
//! **Statement.** A *ridge* is a chain of segments whose facets turn by more than the feature angle. It ends at corners:
//! where other than two such segments meet, where the chain turns by more than the angle at once, or where it runs
//! at more than the angle (at most 90 degrees) to its first segment. So a closed chain has at least three corners,
//! no ridge comes back to itself, and the local feature size of ridges and corners knows how they bend.

use std::collections::BTreeMap;

use crate::angles::cosine;
use crate::distance::Features;
use crate::domain::{Domain, Feature};
use crate::space::Space;

/// A chain of segments between two corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// Positions in [`Domain::segments`], in order.
    pub segments: Vec<u32>,
    /// Vertices of the domain along the ridge, one more than segments.
    pub vertices: Vec<u32>,
    /// Arc length up to each vertex, in scaled coordinates.
    pub lengths: Vec<f64>,
}

/// Ridges and corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceFeatures {
    /// Positions in [`Domain::corners`], ascending.
    pub corners: Vec<u32>,
    /// The ridges.
    pub ridges: Vec<Ridge>,
}

impl Ridge {
    /// From the first corner to the last.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The place at an arc length, and the segment that it lies on.
    pub fn at<P: Space>(&self, domain: &Domain<P>, along: f64) -> (P, u32) {
        let last = self.segments.len() - 1;
        let i = self.lengths[1..=last].partition_point(|&l| l <= along);
        let [a, b] = [i, i + 1].map(|k| domain.points()[self.vertices[k] as usize]);
        let t = (along - self.lengths[i]) / (self.lengths[i + 1] - self.lengths[i]);
        (a + (b - a) * t.clamp(0.0, 1.0), self.segments[i])
    }
}

impl SurfaceFeatures {
    /// What a surface keeps at a feature angle in degrees.
    pub fn new<P: Space>(domain: &Domain<P>, feature_angle: f64) -> Self {
        let mut chains = Chains::new(domain, feature_angle);
        let starts: Vec<u32> = chains.at.keys().copied().filter(|&v| chains.is_corner(v)).collect();
        let mut found: Vec<Vec<u32>> = starts.iter().flat_map(|&v| chains.from(v)).collect();
        // What is left are loops without a corner.
        let others: Vec<u32> = chains.at.keys().copied().collect();
        found.extend(others.iter().flat_map(|&v| chains.from(v)));
        let ridges: Vec<Ridge> = found.iter().flat_map(|chain| chains.cut(chain)).collect();
        let ends = ridges.iter().flat_map(|r| [r.vertices[0], r.vertices[r.vertices.len() - 1]]);
        let mut corners: Vec<u32> =
            ends.filter_map(|v| domain.corners.binary_search(&v).ok().map(|c| c as u32)).collect();
        corners.sort_unstable();
        corners.dedup();
        SurfaceFeatures { corners, ridges }
    }

    /// What is kept as features for the local feature size: a ridge is one of them.
    pub fn distance_features<P: Space>(&self, domain: &Domain<P>) -> Features<P> {
        let corners = self.corners.iter().map(|&c| (Feature::Corner(c), vec![domain.corners[c as usize]]));
        let ridges = self.ridges.iter().map(|r| (Feature::Segment(r.segments[0]), r.vertices.clone()));
        Features::of_chains(domain, corners.chain(ridges).collect())
    }
}

/// The segments that are ridges, by the vertices at their ends.
struct Chains<'a, P: Space> {
    domain: &'a Domain<P>,
    at: BTreeMap<u32, Vec<u32>>,
    used: Vec<bool>,
    /// Cosines of the angle, and of what a ridge may bend altogether.
    limits: [f64; 2],
}

impl<'a, P: Space> Chains<'a, P> {
    fn new(domain: &'a Domain<P>, feature_angle: f64) -> Self {
        let mut at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for s in domain.ridges(feature_angle) {
            domain.segments[s as usize].ends().into_iter().for_each(|v| at.entry(v).or_default().push(s));
        }
        let limits = [feature_angle, feature_angle.clamp(30.0, 90.0)].map(|a| a.to_radians().cos());
        Chains { domain, at, used: vec![false; domain.segments.len()], limits }
    }

    fn is_corner(&self, v: u32) -> bool {
        match self.at[&v][..] {
            [a, b] => -self.domain.plane_angle(a, b, v) < self.limits[0],
            _ => true,
        }
    }

    /// The chains that start at a vertex and were not found before, as segments.
    fn from(&mut self, start: u32) -> Vec<Vec<u32>> {
        let mut found = Vec::new();
        for first in self.at[&start].clone() {
            let (mut v, mut next, mut chain) = (start, Some(first), Vec::new());
            while let Some(s) = next.filter(|&s| !self.used[s as usize]) {
                self.used[s as usize] = true;
                chain.push(s);
                let [a, b] = self.domain.segments[s as usize].ends();
                v = if a == v { b } else { a };
                let ends = v == start || self.is_corner(v);
                next = self.at[&v].iter().copied().find(|&t| t != s).filter(|_| !ends);
            }
            if !chain.is_empty() {
                // The walk begins at `start` whichever way its first segment is stored.
                chain.insert(0, start);
                found.push(chain);
            }
        }
        found
    }

    /// Cuts a chain (its first vertex, then segments) where it has bent too far.
    fn cut(&self, chain: &[u32]) -> Vec<Ridge> {
        let at = |v: u32| self.domain.points()[v as usize];
        let (mut v, mut ridges, mut first) = (chain[0], Vec::new(), P::default());
        for &s in &chain[1..] {
            let [a, b] = self.domain.segments[s as usize].ends();
            let to = if a == v { b } else { a };
            let along = at(to) - at(v);
            if ridges.is_empty() || cosine(first, along) < self.limits[1] {
                first = along;
                ridges.push(Ridge { segments: Vec::new(), vertices: vec![v], lengths: vec![0.0] });
            }
            if let Some(ridge) = ridges.last_mut() {
                let length = ridge.length() + along.norm2().sqrt();
                ridge.segments.push(s);
                ridge.vertices.push(to);
                ridge.lengths.push(length);
            }
            v = to;
        }
        ridges
    }
}
