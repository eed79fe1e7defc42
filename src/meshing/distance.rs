//! Distances to features, and the local feature size.
//!
//! **Statement.** `lfs(x)` is the radius of the smallest ball around `x` that meets two disjoint features (Ruppert
//! 1995). The search visits features in ascending order of distance. It ends at the first feature that is disjoint from
//! a previously visited feature. The distance of this last feature is `lfs(x)`. Neither the second nearest feature nor
//! the nearest feature disjoint from the nearest one would suffice. Near the middle of a short segment, for example,
//! the two features are its ends. `lfs` is positive and 1-Lipschitz.
//!
//! The distance of a facet is the smallest distance of one of its triangles.
//!
//! **Work and depth.** A query visits the features that meet the ball, and the boxes around them.
//!
//! Distances are rounded. Their relative error is a few units in the last place of the differences of coordinates.

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;

use crate::bvh::{Bounds, Bvh};
use crate::domain::{Domain, Feature};
use crate::space::Space;

/// A simplex of a feature, with one, two or three vertices.
#[derive(Clone, Copy, Debug)]
struct Item {
    /// The index of the feature.
    feature: u32,
    vertices: [u32; 3],
    len: usize,
    /// The index of the wall that equals the simplex, or `u32::MAX` for simplices without a known wall.
    wall: u32,
}

/// A feature found by a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The feature.
    pub feature: Feature,
    /// Its distance, in scaled coordinates.
    pub distance: f64,
}

/// The local feature size at a point, and the features that determine it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSize {
    /// The radius; infinite if no two features are disjoint.
    pub radius: f64,
    /// The two disjoint features, the nearer one first. `None` if the radius is infinite.
    pub features: Option<[Feature; 2]>,
}

/// The features of a domain, ready for queries.
#[derive(Clone, Debug)]
pub struct Features<P: Space> {
    /// All features: first corners, then segments, then facets.
    all: Vec<Feature>,
    /// The corners of each feature, in ascending order.
    corners: Vec<Vec<u32>>,
    items: Vec<Item>,
    shapes: Vec<Shape<P>>,
    tree: Bvh<P>,
    /// Whether these are all features of a domain.
    whole: bool,
}

/// A simplex given by its coordinates.
#[derive(Clone, Copy, Debug)]
struct Shape<P> {
    /// Its corners. The last corner fills unused entries.
    corners: [P; 3],
    len: usize,
    /// The centre and radius of a ball that contains it.
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

    /// Returns `true` if the simplex is certainly farther than a distance.
    fn is_beyond(&self, q: P, distance: f64) -> bool {
        let reach = (distance + self.radius) * ROUNDING;
        (q - self.centre).norm2() > reach * reach
    }
}

/// The factor by which [`Shape::is_beyond`] widens its comparisons because of rounding.
const ROUNDING: f64 = 1.0 + 1e-12;

/// Returns the simplices with their coordinates.
fn shapes<P: Point>(points: &[P], items: &[Item]) -> Vec<Shape<P>> {
    items.iter().map(|i| Shape::new(i.vertices.map(|v| points[v as usize]), i.len)).collect()
}

impl<P: Space> Features<P> {
    /// Collects all features of a domain. Joined facets and segments ([`crate::flats`]) count as their first member.
    pub fn new(domain: &Domain<P>) -> Self {
        let flats = &domain.flats;
        let leader = |feature: Feature| match feature {
            Feature::Corner(c) => (!flats.joints[c as usize]).then_some(feature),
            Feature::Segment(s) => flats.lines[s as usize].map(Feature::Segment),
            Feature::Facet(f) => Some(Feature::Facet(flats.flats[f as usize])),
        };
        let members: Vec<(Feature, Feature)> =
            domain.features().filter_map(|feature| Some((leader(feature)?, feature))).collect();
        let all: Vec<Feature> =
            members.iter().filter(|(leader, feature)| leader == feature).map(|m| m.0).collect();
        let number = |leader: Feature| all.binary_search(&leader).unwrap_or_default();
        let mut corners: Vec<Vec<u32>> = vec![Vec::new(); all.len()];
        for &(leader, feature) in &members {
            let kept = |v: &u32| domain.corners.binary_search(v).is_ok_and(|c| !flats.joints[c]);
            corners[number(leader)].extend(domain.corners_of(feature).iter().filter(|v| kept(v)));
        }
        for list in &mut corners {
            list.sort_unstable();
            list.dedup();
        }
        let mut items = Vec::new();
        for &(leader, feature) in &members {
            let feature_number = number(leader) as u32;
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

    /// Builds features from corners (lists of one vertex) and chains of edges (lists of several vertices). Two
    /// features are disjoint if they share no end.
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

    /// Returns `true` if these are all features of their domain.
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// Returns the number of simplices of all features.
    pub fn item_count(&self) -> u32 {
        self.items.len() as u32
    }

    /// Returns the index of the feature of a simplex.
    pub fn feature_of(&self, item: u32) -> u32 {
        self.items[item as usize].feature
    }

    /// Returns the feature with the given index.
    pub fn feature(&self, number: u32) -> Feature {
        self.all[number as usize]
    }

    /// Returns the wall that equals a simplex, if the simplex belongs to a facet.
    pub fn wall(&self, item: u32) -> Option<u32> {
        Some(self.items[item as usize].wall).filter(|&w| w != u32::MAX)
    }

    /// Returns `true` if two features, given by index, have no common point.
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

    /// Returns the point of a simplex closest to `q`, rounded.
    pub fn closest(&self, item: u32, q: P) -> P {
        let Shape { corners: [a, b, c], len, .. } = self.shapes[item as usize];
        match len {
            1 => a,
            2 => closest_on_segment(a, b, q),
            _ => closest_on_triangle(a, b, c, q),
        }
    }

    /// Returns `true` if the bounding ball of a simplex shows that the simplex is farther than a distance. The answer
    /// `false` is inconclusive.
    pub fn is_beyond(&self, item: u32, q: P, distance: f64) -> bool {
        self.shapes[item as usize].is_beyond(q, distance)
    }

    /// Returns the centroid of a simplex, rounded.
    pub fn middle(&self, item: u32) -> P {
        let Shape { corners, len, .. } = self.shapes[item as usize];
        corners[..len].iter().fold(P::splat(0.0), |sum, &c| sum + c) / len as f64
    }

    /// Returns the squared distance to a simplex.
    pub fn dist2(&self, item: u32, q: P) -> f64 {
        (q - self.closest(item, q)).norm2()
    }

    /// Returns the distance to one feature.
    pub fn distance(&self, feature: Feature, q: P) -> f64 {
        let own = (0..self.item_count()).filter(|&i| self.feature(self.feature_of(i)) == feature);
        own.map(|i| self.dist2(i, q)).min_by(f64::total_cmp).map_or(f64::INFINITY, f64::sqrt)
    }

    /// Visits each feature once, in ascending order of distance, until `visit` returns `false`.
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

    /// Returns the local feature size.
    pub fn local_size(&self, q: P) -> LocalSize {
        self.local_size_counted(q, &mut Sweep::default())
    }

    /// Returns [`Features::local_size`], and counts the visits of the tree.
    pub(crate) fn local_size_counted(&self, q: P, visits: &mut Sweep) -> LocalSize {
        let mut found = None;
        let mut search = Search::default();
        let dist2 = |i| self.dist2(i, q);
        self.tree.nearest_counted(q, visits, dist2, |i, d2| {
            found = search.meet(self, i).map(|pair| (pair, d2.sqrt()));
            found.is_none()
        });
        found.map_or(LocalSize { radius: f64::INFINITY, features: None }, |(pair, radius)| LocalSize {
            radius,
            features: Some(pair.map(|i| self.feature(self.feature_of(i)))),
        })
    }

    /// Returns the bounding box of all features.
    pub fn bounds(&self) -> Bounds<P> {
        self.tree.bounds()
    }
}

/// A search for two disjoint features. It visits simplices in ascending order of distance.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// The first visited simplex of each feature.
    met: Vec<u32>,
}

impl Search {
    /// Visits a simplex. If its feature is disjoint from a previously visited one, returns the first simplex of that
    /// feature, and this simplex.
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

/// Returns the point of a closed segment closest to `q`.
pub fn closest_on_segment<P: Point>(a: P, b: P, q: P) -> P {
    let (d, e) = (b - a, q - a);
    let t = (e.dot(d) / d.norm2()).clamp(0.0, 1.0);
    // Starting from the nearer end makes the result exact at the ends.
    if t <= 0.5 { a + d * t } else { b - d * (1.0 - t) }
}

/// Returns the point of a closed triangle closest to `q`.
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
    // In a thin triangle, x and y may have large errors. The foot computed from them still lies in the triangle, and
    // some point of an edge is almost as close as the closest point.
    if inside { nearer(best, foot) } else { best }
}

/// The squared sine of an angle below which a triangle counts as thin. Above it, x and y are accurate to 1e-12.
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
        /// No point of a fine grid in the triangle is nearer. The point found lies in the triangle, even if the
        /// triangle is thin.
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
            let side = |p: DVec3, r: DVec3| (r - p).cross(found - p).dot(normal) / normal.length_squared();
            for (p, r) in [(a, b), (b, c), (c, a)] {
                prop_assert!(side(p, r) >= -1e-6 && (found - p).dot(normal).abs() <= 1e-9 * normal.length());
            }
        }

        /// A simplex reported as beyond a distance is farther than that distance.
        #[test]
        fn is_beyond_is_certain(corners in [place(), place(), place()], len in 1usize..4, q in place(), far in 0.0..3.0f64) {
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
