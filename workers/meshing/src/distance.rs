//! Distances to features, and the local feature size.
//!
//! **Statement.** `lfs(x)` is the radius of the smallest ball around `x` that meets two disjoint features (Ruppert
//! 1995). Features are met in the order of their distance; the first that is disjoint from one met before it ends
//! the search, and its distance is `lfs(x)`. (It is not the second nearest of all, nor the nearest that is disjoint
//! from the nearest: near the middle of a short segment the two are its ends.) `lfs` is positive and 1-Lipschitz.
//!
//! A facet's distance is the least one of its triangles.
//!
//! **Work and depth.** A query meets the features inside the ball and their boxes.
//!
//! Distances are rounded (relative error of a few units in the last place of the coordinates' differences).

use septet_geometry::point::Point;

use crate::bvh::{Bounds, Bvh};
use crate::domain::{Domain, Feature};
use crate::space::Space;

/// A simplex that belongs to a feature: one, two or three vertices.
#[derive(Clone, Copy, Debug)]
struct Item {
    feature: Feature,
    vertices: [u32; 3],
    len: usize,
}

/// A feature met at a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The feature.
    pub feature: Feature,
    /// The distance, in scaled coordinates.
    pub distance: f64,
}

/// What the local feature size at a point is, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSize {
    /// The radius; infinite if no two features are disjoint.
    pub radius: f64,
    /// The two disjoint features, the nearer one first.
    pub features: Option<[Feature; 2]>,
}

/// The features of a domain, ready for queries.
#[derive(Clone, Debug)]
pub struct Features<'a, P: Space> {
    domain: &'a Domain<P>,
    items: Vec<Item>,
    tree: Bvh<P>,
}

impl<'a, P: Space> Features<'a, P> {
    /// All features.
    pub fn new(domain: &'a Domain<P>) -> Self {
        let mut items = Vec::new();
        for feature in domain.features() {
            match feature {
                Feature::Corner(c) => {
                    items.push(Item { feature, vertices: [domain.corners[c as usize]; 3], len: 1 });
                }
                Feature::Segment(s) => {
                    let [a, b] = domain.segments[s as usize].ends();
                    items.push(Item { feature, vertices: [a, b, b], len: 2 });
                }
                Feature::Facet(f) => items.extend(domain.facets[f as usize].walls.iter().map(|&wall| {
                    let wall = domain.walls()[wall as usize];
                    let mut vertices = [0; 3];
                    vertices[..P::DIM].copy_from_slice(wall.as_ref());
                    Item { feature, vertices, len: 3 }
                })),
            }
        }
        let corners = |i: &Item| i.vertices[..i.len].to_vec();
        let tree = Bvh::new(items.iter().map(|i| domain.simplices.bounds(&corners(i))).collect());
        Features { domain, items, tree }
    }

    fn item_dist2(&self, item: &Item, q: P) -> f64 {
        let [a, b, c] = item.vertices.map(|v| self.domain.points()[v as usize]);
        match item.len {
            1 => (q - a).norm2(),
            2 => segment_dist2(a, b, q),
            _ => triangle_dist2(a, b, c, q),
        }
    }

    /// The distance to one feature.
    pub fn distance(&self, feature: Feature, q: P) -> f64 {
        let own = self.items.iter().filter(|i| i.feature == feature);
        own.map(|i| self.item_dist2(i, q)).min_by(f64::total_cmp).map_or(f64::INFINITY, f64::sqrt)
    }

    /// Visits features from the nearest on, each once, until `visit` answers `false`.
    pub fn nearest(&self, q: P, mut visit: impl FnMut(Met) -> bool) {
        let mut seen = Vec::new();
        self.tree.nearest(
            q,
            |i| self.item_dist2(&self.items[i as usize], q),
            |i, d2| {
                let feature = self.items[i as usize].feature;
                if seen.contains(&feature) {
                    return true;
                }
                seen.push(feature);
                visit(Met { feature, distance: d2.sqrt() })
            },
        );
    }

    /// The local feature size.
    pub fn local_size(&self, q: P) -> LocalSize {
        let mut met: Vec<Feature> = Vec::new();
        let mut size = LocalSize { radius: f64::INFINITY, features: None };
        self.nearest(q, |Met { feature, distance }| {
            if let Some(&first) = met.iter().find(|&&f| self.domain.are_disjoint(f, feature)) {
                size = LocalSize { radius: distance, features: Some([first, feature]) };
                return false;
            }
            met.push(feature);
            true
        });
        size
    }

    /// The box of all features.
    pub fn bounds(&self) -> Bounds<P> {
        self.tree.bounds()
    }
}

/// Squared distance to a closed segment.
pub fn segment_dist2<P: Point>(a: P, b: P, q: P) -> f64 {
    let (d, e) = (b - a, q - a);
    let t = (e.dot(d) / d.norm2()).clamp(0.0, 1.0);
    (e - d * t).norm2()
}

/// Squared distance to a closed triangle.
pub fn triangle_dist2<P: Point>(a: P, b: P, c: P, q: P) -> f64 {
    let (u, v, e) = (b - a, c - a, q - a);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let det = uu * vv - uv * uv;
    let (eu, ev) = (e.dot(u), e.dot(v));
    let (x, y) = ((eu * vv - ev * uv) / det, (ev * uu - eu * uv) / det);
    let edges = segment_dist2(a, b, q).min(segment_dist2(b, c, q)).min(segment_dist2(c, a, q));
    // Of a thin triangle x and y can be far off; what they name is in the triangle all the same, and the edges
    // are close.
    if x >= 0.0 && y >= 0.0 && x + y <= 1.0 { edges.min((e - u * x - v * y).norm2()) } else { edges }
}
