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
    /// The number of the feature.
    feature: u32,
    vertices: [u32; 3],
    len: usize,
    /// The wall that it is; `u32::MAX` if it is none, or not known as one.
    wall: u32,
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
pub struct Features<P: Space> {
    /// All features in order: corners, segments, facets.
    all: Vec<Feature>,
    /// The corners of each, ascending.
    corners: Vec<Vec<u32>>,
    items: Vec<Item>,
    shapes: Vec<Shape<P>>,
    tree: Bvh<P>,
    /// Are these all features of a domain?
    whole: bool,
}

/// A simplex by its coordinates.
#[derive(Clone, Copy, Debug)]
struct Shape<P> {
    /// Its corners; beyond their number the last one again.
    corners: [P; 3],
    len: usize,
    /// A ball that holds it.
    centre: P,
    radius: f64,
}

impl<P: Point> Shape<P> {
    fn new(corners: [P; 3], len: usize) -> Self {
        let box_of = Bounds::of(corners);
        let centre = box_of.low * 0.5 + box_of.high * 0.5;
        let reach2 = corners.iter().map(|&c| (c - centre).norm2()).fold(0.0, f64::max);
        Shape { corners, len, centre, radius: reach2.sqrt() * ROUNDING }
    }

    /// Is it farther than a distance for certain?
    fn is_beyond(&self, q: P, distance: f64) -> bool {
        let reach = (distance + self.radius) * ROUNDING;
        (q - self.centre).norm2() > reach * reach
    }
}

/// What is said to be beyond a distance is beyond it by this factor, so that rounding does not matter.
const ROUNDING: f64 = 1.0 + 1e-12;

/// The simplices by their coordinates.
fn shapes<P: Point>(points: &[P], items: &[Item]) -> Vec<Shape<P>> {
    items.iter().map(|i| Shape::new(i.vertices.map(|v| points[v as usize]), i.len)).collect()
}

impl<P: Space> Features<P> {
    /// All features.
    pub fn new(domain: &Domain<P>) -> Self {
        let all: Vec<Feature> = domain.features().collect();
        let corners = all.iter().map(|&f| domain.corners_of(f)).collect();
        let mut items = Vec::new();
        for (i, &feature) in all.iter().enumerate() {
            let feature_number = i as u32;
            match feature {
                Feature::Corner(c) => {
                    let vertices = [domain.corners[c as usize]; 3];
                    items.push(Item { feature: feature_number, vertices, len: 1, wall: u32::MAX });
                }
                Feature::Segment(s) => {
                    let [a, b] = domain.segments[s as usize].ends();
                    items.push(Item { feature: feature_number, vertices: [a, b, b], len: 2, wall: u32::MAX });
                }
                Feature::Facet(f) => items.extend(domain.facets[f as usize].walls.iter().map(|&wall| {
                    let corners = domain.walls()[wall as usize];
                    let mut vertices = [0; 3];
                    vertices[..P::DIM].copy_from_slice(corners.as_ref());
                    Item { feature: feature_number, vertices, len: 3, wall }
                })),
            }
        }
        let tree = Bvh::new(items.iter().map(|i| domain.simplices.bounds(&i.vertices[..i.len])).collect());
        Features { shapes: shapes(domain.points(), &items), all, corners, items, tree, whole: true }
    }

    /// Corners (one vertex) and chains of edges (more), each with its name. Two are disjoint if they share no end.
    pub fn of_chains(domain: &Domain<P>, chains: Vec<(Feature, Vec<u32>)>) -> Self {
        let (mut all, mut corners, mut items) = (Vec::new(), Vec::new(), Vec::new());
        for (number, (feature, chain)) in (0u32..).zip(chains) {
            let mut ends = vec![chain[0], chain[chain.len() - 1]];
            ends.sort_unstable();
            ends.dedup();
            let item = |vertices: [u32; 3], len| Item { feature: number, vertices, len, wall: u32::MAX };
            if chain.len() == 1 {
                items.push(item([chain[0]; 3], 1));
            }
            items.extend(chain.windows(2).map(|e| item([e[0], e[1], e[1]], 2)));
            all.push(feature);
            corners.push(ends);
        }
        let tree = Bvh::new(items.iter().map(|i| domain.simplices.bounds(&i.vertices[..i.len])).collect());
        Features { shapes: shapes(domain.points(), &items), all, corners, items, tree, whole: false }
    }

    /// Are these all features of the domain that they were made of?
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// How many simplices the features are made of.
    pub fn item_count(&self) -> u32 {
        self.items.len() as u32
    }

    /// The number of the feature that a simplex belongs to.
    pub fn feature_of(&self, item: u32) -> u32 {
        self.items[item as usize].feature
    }

    /// The feature of a number.
    pub fn feature(&self, number: u32) -> Feature {
        self.all[number as usize]
    }

    /// The wall that a simplex is, if it is one of a facet's.
    pub fn wall(&self, item: u32) -> Option<u32> {
        Some(self.items[item as usize].wall).filter(|&w| w != u32::MAX)
    }

    /// Have two features, by their numbers, no point in common?
    pub fn are_disjoint(&self, a: u32, b: u32) -> bool {
        let (mut few, mut many) = (&self.corners[a as usize][..], &self.corners[b as usize][..]);
        if few.len() > many.len() {
            std::mem::swap(&mut few, &mut many);
        }
        if many.len() <= 4 {
            return !few.iter().any(|v| many.contains(v));
        }
        few.iter().all(|v| many.binary_search(v).is_err())
    }

    /// The point of a simplex closest to `q`, rounded.
    pub fn closest(&self, item: u32, q: P) -> P {
        let Shape { corners: [a, b, c], len, .. } = self.shapes[item as usize];
        match len {
            1 => a,
            2 => closest_on_segment(a, b, q),
            _ => closest_on_triangle(a, b, c, q),
        }
    }

    /// Is a simplex farther than a distance for certain? A test by its ball; "no" says nothing.
    pub fn is_beyond(&self, item: u32, q: P, distance: f64) -> bool {
        self.shapes[item as usize].is_beyond(q, distance)
    }

    /// The middle of a simplex: the mean of its vertices, rounded.
    pub fn middle(&self, item: u32) -> P {
        let Shape { corners, len, .. } = self.shapes[item as usize];
        corners[..len].iter().fold(P::splat(0.0), |sum, &c| sum + c) / len as f64
    }

    /// The squared distance to a simplex.
    pub fn dist2(&self, item: u32, q: P) -> f64 {
        (q - self.closest(item, q)).norm2()
    }

    /// The distance to one feature.
    pub fn distance(&self, feature: Feature, q: P) -> f64 {
        let own = (0..self.item_count()).filter(|&i| self.feature(self.feature_of(i)) == feature);
        own.map(|i| self.dist2(i, q)).min_by(f64::total_cmp).map_or(f64::INFINITY, f64::sqrt)
    }

    /// Visits features from the nearest on, each once, until `visit` answers `false`.
    pub fn nearest(&self, q: P, mut visit: impl FnMut(Met) -> bool) {
        let mut seen = Vec::new();
        let dist2 = |i| self.dist2(i, q);
        self.tree.nearest(q, dist2, |i, d2| {
            let number = self.feature_of(i);
            if seen.contains(&number) {
                return true;
            }
            seen.push(number);
            visit(Met { feature: self.feature(number), distance: d2.sqrt() })
        });
    }

    /// The local feature size.
    pub fn local_size(&self, q: P) -> LocalSize {
        let mut found = None;
        let mut search = Search::default();
        let dist2 = |i| self.dist2(i, q);
        self.tree.nearest(q, dist2, |i, d2| {
            found = search.meet(self, i).map(|pair| (pair, d2.sqrt()));
            found.is_none()
        });
        found.map_or(LocalSize { radius: f64::INFINITY, features: None }, |(pair, radius)| LocalSize {
            radius,
            features: Some(pair.map(|i| self.feature(self.feature_of(i)))),
        })
    }

    /// The box of all features.
    pub fn bounds(&self) -> Bounds<P> {
        self.tree.bounds()
    }
}

/// The search for two disjoint features among simplices that are met in the order of their distance.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// The first simplex of each feature met.
    met: Vec<u32>,
}

impl Search {
    /// Meets a simplex; answers with the first one met whose feature is disjoint from its, and it.
    pub fn meet<P: Space>(&mut self, features: &Features<P>, item: u32) -> Option<[u32; 2]> {
        let number = features.feature_of(item);
        if self.met.iter().any(|&i| features.feature_of(i) == number) {
            return None;
        }
        let first = self.met.iter().copied().find(|&i| features.are_disjoint(features.feature_of(i), number));
        self.met.push(item);
        first.map(|first| [first, item])
    }
}

/// The point of a closed segment closest to `q`.
pub fn closest_on_segment<P: Point>(a: P, b: P, q: P) -> P {
    let (d, e) = (b - a, q - a);
    let t = (e.dot(d) / d.norm2()).clamp(0.0, 1.0);
    // From the nearer end, so that an end is met exactly.
    if t <= 0.5 { a + d * t } else { b - d * (1.0 - t) }
}

/// The point of a closed triangle closest to `q`.
pub fn closest_on_triangle<P: Point>(a: P, b: P, c: P, q: P) -> P {
    let (u, v, e) = (b - a, c - a, q - a);
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let det = uu * vv - uv * uv;
    let (eu, ev) = (e.dot(u), e.dot(v));
    let (x, y) = ((eu * vv - ev * uv) / det, (ev * uu - eu * uv) / det);
    let inside = x >= 0.0 && y >= 0.0 && x + y <= 1.0;
    let foot = a + u * x + v * y;
    if inside && det > THIN * uu * vv {
        return foot;
    }
    let nearer = |p: P, r: P| if (q - r).norm2() < (q - p).norm2() { r } else { p };
    let edges = [(b, c), (c, a)].map(|(s, t)| closest_on_segment(s, t, q));
    let best = edges.into_iter().fold(closest_on_segment(a, b, q), nearer);
    // Of a thin triangle x and y can be far off; what they name is in the triangle all the same, and the edges
    // are close.
    if inside { nearer(best, foot) } else { best }
}

/// The squared sine below which an angle of a triangle is taken for thin: above, x and y are good to 1e-12.
const THIN: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    fn place() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(DVec3::from)
    }

    proptest! {
        /// No point of a fine grid in the triangle is nearer, and the point found is one of the triangle, thin ones too.
        #[test]
        fn the_closest_point_of_a_triangle(
            corners in [place(), place(), place()], q in place(), flat in prop::option::of(1e-9..1e-2f64),
        ) {
            let [a, b, mut c] = corners;
            if let Some(flat) = flat {
                c = a + (b - a) * 0.3 + (c - a) * flat;
            }
            let found = closest_on_triangle(a, b, c, q);
            let distance = found.distance(q);
            let inner = (0..=40).flat_map(|i| (0..=40 - i).map(move |j| [i, j].map(|k| f64::from(k) / 40.0)));
            for [s, t] in inner {
                let there = a + (b - a) * s + (c - a) * t;
                prop_assert!(distance <= there.distance(q) + 1e-11);
            }
            let normal = (b - a).cross(c - a);
            let beside = |p: DVec3, r: DVec3| (r - p).cross(found - p).dot(normal) / normal.length_squared();
            for (p, r) in [(a, b), (b, c), (c, a)] {
                prop_assert!(beside(p, r) >= -1e-6 && (found - p).dot(normal).abs() <= 1e-9 * normal.length());
            }
        }

        /// What is said to be beyond a distance is.
        #[test]
        fn beyond_is_beyond(corners in [place(), place(), place()], len in 1usize..4, q in place(), far in 0.0..3.0f64) {
            let mut corners = corners;
            let last = corners[len - 1];
            corners[len - 1..].fill(last);
            let shape = Shape::new(corners, len);
            let [a, b, c] = corners;
            let closest = if len == 3 { closest_on_triangle(a, b, c, q) } else { closest_on_segment(a, b, q) };
            prop_assert!(len == 1 || !shape.is_beyond(q, far) || closest.distance(q) > far);
            prop_assert!(len > 1 || !shape.is_beyond(q, far) || a.distance(q) > far);
        }
    }
}
