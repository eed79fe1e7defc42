//! The features of a surface that remeshing keeps: ridges and their corners.
//!
//! **Statement.** A *ridge* is a chain of segments whose facets turn by more than the feature angle. A chain ends at
//! corners. A corner is a vertex at which
//! 1. the number of such segments is not two,
//! 2. the chain turns there by more than the feature angle, or
//! 3. the angle between the next segment and the first segment since the last corner exceeds the feature angle,
//!    clamped to 30 to 90 degrees.
//!
//! A closed chain therefore has at least three corners, and no ridge returns to itself. The local feature size of
//! ridges and corners reflects their bends.

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
    /// The vertices of the domain along the ridge, one more than the segments.
    pub vertices: Vec<u32>,
    /// The arc length up to each vertex, in scaled coordinates.
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
    /// Returns the length from the first corner to the last.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Returns the point at an arc length, and the segment on which it lies.
    pub fn at<P: Space>(&self, domain: &Domain<P>, along: f64) -> (P, u32) {
        let last = self.segments.len() - 1;
        let i = self.lengths[1..=last].partition_point(|&l| l <= along);
        let [a, b] = [i, i + 1].map(|k| domain.points()[self.vertices[k] as usize]);
        let t = (along - self.lengths[i]) / (self.lengths[i + 1] - self.lengths[i]);
        (a + (b - a) * t.clamp(0.0, 1.0), self.segments[i])
    }
}

impl SurfaceFeatures {
    /// Finds the features of a surface for a feature angle in degrees.
    pub fn new<P: Space>(domain: &Domain<P>, feature_angle: f64) -> Self {
        let mut chains = Chains::new(domain, feature_angle);
        let starts: Vec<u32> = chains.at.keys().copied().filter(|&v| chains.is_corner(v)).collect();
        let mut found: Vec<Vec<u32>> = starts.iter().flat_map(|&v| chains.from(v)).collect();
        // The remaining segments form loops without a corner.
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

    /// Returns the features that determine the local feature size. Each ridge is one feature.
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
    /// Cosines of the feature angle, and of the largest total bend of a ridge.
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

    /// Returns the unused chains that start at a vertex, each as its start followed by its segments.
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
                // The walk begins at `start` regardless of the stored direction of its first segment.
                chain.insert(0, start);
                found.push(chain);
            }
        }
        found
    }

    /// Cuts a chain (its first vertex, then segments) where its total bend is too large.
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
