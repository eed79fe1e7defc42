//! Polygons and lines of a map, and the domain that they describe.
//!
//! **Statement.** Equal points are joined, and edges are divided at the points on them. Edges that then coincide are one
//! segment, whose marker is the number of the first feature that has it. A polygon covers the points that an odd number
//! of its edges separates from the outside. A component is part of the domain if a polygon covers it, and then belongs
//! to the region of the first feature that does. Every other bounded component is a hole. Without polygons, every
//! bounded component is part of the domain.
//!
//! *Proof.* A constraint has a list of the polygons that have it an odd number of times. A path from the outside to a
//! cell changes the coverage at exactly the constraints that it crosses, so the coverage is constant in a component.
//! One path to each component finds it.
//!
//! Segments that cross are left to [`crate::check`], which refuses them.
//!
//! **Work and depth.** `O(m log m)`, and the visited boxes and constraints. Sequential.

use std::collections::BTreeMap;

use glam::DVec2;
use septet_geometry::point::lex_cmp;
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::{scale, scale_exponent};

use super::constrained::Constrained;
use crate::bvh::{Bounds, Bvh};
use crate::generate::{Alone, MeshMachine};
use crate::input::{DomainKind, Input, InputSegment, Region};
use crate::space::{ascending, on_segment};

/// A polygon: its feature, and its rings as lists of positions. A ring may repeat its first position at the end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polygon {
    /// The number of the feature, from 1.
    pub feature: u32,
    /// The outer ring and the holes.
    pub rings: Vec<Vec<u32>>,
}

/// Polygons, lines and points of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shapes {
    /// The positions. Equal positions may occur several times.
    pub points: Vec<DVec2>,
    /// The height of each position, or NaN if it has none.
    pub heights: Vec<f64>,
    /// The polygons.
    pub polygons: Vec<Polygon>,
    /// The lines with the numbers of their features.
    pub lines: Vec<(u32, Vec<u32>)>,
    /// The number of features.
    pub features: u32,
}

/// A segment between two vertices.
#[derive(Clone, Debug)]
struct Edge {
    /// The first feature that has it.
    feature: u32,
    /// The polygons that have it an odd number of times, ascending.
    polygons: Vec<u32>,
}

type Edges = BTreeMap<[u32; 2], Edge>;

impl Shapes {
    /// Appends a position and returns its number.
    pub fn push(&mut self, at: DVec2, height: Option<f64>) -> u32 {
        // Adding zero converts -0.0 to 0.0.
        self.points.push(at + DVec2::ZERO);
        self.heights.push(height.unwrap_or(f64::NAN));
        self.points.len() as u32 - 1
    }

    /// Returns the edges of all polygons and lines, as positions.
    pub fn edges(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let rings = self.polygons.iter().flat_map(|p| &p.rings).flat_map(|ring| closed(ring));
        rings.chain(self.lines.iter().flat_map(|(_, line)| open(line)))
    }

    /// Returns the first position of each group of equal positions, by position.
    pub fn first_of(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        let point = |v: u32| self.points[v as usize];
        order.sort_unstable_by(|&a, &b| lex_cmp(&point(a), &point(b)).then(a.cmp(&b)));
        let mut first = vec![0; order.len()];
        for group in order.chunk_by(|&a, &b| point(a) == point(b)) {
            for &v in group {
                first[v as usize] = group[0];
            }
        }
        first
    }

    /// Returns the domain that the shapes describe. The second value is `true` if features overlap.
    pub fn domain(&self) -> (Input<DVec2>, bool) {
        let first = self.first_of();
        let mut vertex = vec![u32::MAX; first.len()];
        let mut points = Vec::new();
        for (position, &leader) in first.iter().enumerate() {
            if leader as usize == position {
                vertex[position] = points.len() as u32;
                points.push(self.points[position]);
            }
        }
        let vertex: Vec<u32> = first.iter().map(|&leader| vertex[leader as usize]).collect();
        let edges = self.named_edges(&vertex);
        let mut input = Input::new(DomainKind::Complex, points);
        let Ok(exponent) = scale_exponent(&input.points) else {
            return (with_segments(input, &edges), false);
        };
        let scaled: Vec<DVec2> = input.points.iter().map(|&p| scale(p, exponent)).collect();
        let edges = divided(&scaled, edges);
        input = with_segments(input, &edges);
        let overlaps = self.cover(&mut input, scaled, &edges, exponent);
        (input, overlaps)
    }

    fn named_edges(&self, vertex: &[u32]) -> Edges {
        let mut edges = Edges::new();
        let mut add = |ends: [u32; 2], feature: u32, polygon: Option<u32>| {
            let ends = ascending(ends.map(|v| vertex[v as usize]));
            if ends[0] != ends[1] {
                merge(&mut edges, ends, feature, &polygon.into_iter().collect::<Vec<_>>());
            }
        };
        for (number, polygon) in (0u32..).zip(&self.polygons) {
            for edge in polygon.rings.iter().flat_map(|ring| closed(ring)) {
                add(edge, polygon.feature, Some(number));
            }
        }
        for (feature, line) in &self.lines {
            open(line).for_each(|edge| add(edge, *feature, None));
        }
        edges
    }

    /// Places a hole or a region in each bounded component. Returns whether features overlap.
    fn cover(&self, input: &mut Input<DVec2>, scaled: Vec<DVec2>, edges: &Edges, exponent: i32) -> bool {
        let delaunay = MeshMachine::<DVec2>::delaunay(&mut Alone { seed: 0 }, &scaled);
        let (Ok(delaunay), false) = (delaunay, self.polygons.is_empty()) else { return false };
        let mut made = Constrained::new(scaled, delaunay);
        if edges.keys().any(|&[a, b]| made.constrain(a, b).is_err()) {
            return false;
        }
        let mut overlaps = false;
        for component in components(&made, edges) {
            let mut features: Vec<u32> =
                component.polygons.iter().map(|&p| self.polygons[p as usize].feature).collect();
            features.sort_unstable();
            features.dedup();
            overlaps |= features.len() > 1;
            let Some(at) = component.inner.filter(|_| component.is_bounded) else { continue };
            let at = scale(at, -exponent);
            match features.first() {
                None => input.holes.push(at),
                Some(&feature) => {
                    input.regions.push(Region { at, attribute: f64::from(feature), limit: None });
                }
            }
        }
        input.holes.sort_by(lex_cmp);
        input.regions.sort_by(|a, b| a.attribute.total_cmp(&b.attribute).then(lex_cmp(&a.at, &b.at)));
        overlaps
    }
}

/// Returns the edges of a ring.
fn closed(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]])
}

/// Returns the edges of a line.
fn open(line: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    line.windows(2).map(|w| [w[0], w[1]])
}

/// Adds an edge. Polygons that have it twice cancel.
fn merge(edges: &mut Edges, ends: [u32; 2], feature: u32, polygons: &[u32]) {
    let edge = edges.entry(ends).or_insert(Edge { feature, polygons: Vec::new() });
    edge.feature = edge.feature.min(feature);
    edge.polygons = symmetric_difference(&edge.polygons, polygons);
}

/// Returns the members of exactly one of two ascending lists.
fn symmetric_difference(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = [a, b].concat();
    all.sort_unstable();
    all.chunk_by(|x, y| x == y).filter(|same| same.len() % 2 == 1).map(|same| same[0]).collect()
}

/// Divides edges at the points on them.
fn divided(points: &[DVec2], edges: Edges) -> Edges {
    let tree = Bvh::new(points.iter().map(|&p| Bounds::of([p])).collect());
    let mut parts = Edges::new();
    for (ends, edge) in edges {
        let [a, b] = ends.map(|v| points[v as usize]);
        let mut on = tree.meeting(&Bounds::of([a, b]));
        on.retain(|v| !ends.contains(v) && on_segment(a, b, points[*v as usize]));
        on.extend(ends);
        // The lexicographic order is the order along a line.
        on.sort_by(|&u, &v| lex_cmp(&points[u as usize], &points[v as usize]));
        for pair in on.windows(2) {
            merge(&mut parts, ascending([pair[0], pair[1]]), edge.feature, &edge.polygons);
        }
    }
    parts
}

fn with_segments(mut input: Input<DVec2>, edges: &Edges) -> Input<DVec2> {
    let segment = |(&ends, edge): (&[u32; 2], &Edge)| InputSegment { ends, marker: i64::from(edge.feature) };
    input.segments = edges.iter().map(segment).collect();
    input
}

/// A set of cells between constraints.
struct Component {
    /// The polygons that cover it, ascending.
    polygons: Vec<u32>,
    /// Whether constraints separate it from the outside of the hull.
    is_bounded: bool,
    /// A point strictly inside.
    inner: Option<DVec2>,
}

/// Returns the components with the polygons that cover them.
fn components(made: &Constrained, edges: &Edges) -> Vec<Component> {
    let count = made.cells().len() as u32;
    let crossing = |cell: u32, corner: usize| {
        let row = made.cells()[cell as usize];
        edges.get(&ascending([row[(corner + 1) % 3], row[(corner + 2) % 3]])).map_or(&[][..], |e| &e.polygons)
    };
    let mut seen = vec![false; count as usize];
    let mut found = Vec::new();
    // The cells at the hull are seen from the outside.
    let mut due: Vec<(u32, Vec<u32>)> = Vec::new();
    for (cell, corner) in (0..count).flat_map(|cell| [0, 1, 2].map(|corner| (cell, corner))) {
        if made.across(cell, corner).is_none() {
            let is_wall = made.is_constrained(cell, corner);
            due.push((cell, if is_wall { crossing(cell, corner).to_vec() } else { Vec::new() }));
        }
    }
    while let Some((seed, polygons)) = due.pop() {
        if std::mem::replace(&mut seen[seed as usize], true) {
            continue;
        }
        let (mut stack, mut is_bounded, mut members) = (vec![seed], true, Vec::new());
        while let Some(cell) = stack.pop() {
            members.push(cell);
            for corner in 0..3 {
                let is_wall = made.is_constrained(cell, corner);
                match made.across(cell, corner) {
                    None => is_bounded &= is_wall,
                    Some(other) if is_wall && !seen[other as usize] => {
                        due.push((other, symmetric_difference(&polygons, crossing(cell, corner))));
                    }
                    Some(other) if !is_wall && !std::mem::replace(&mut seen[other as usize], true) => {
                        stack.push(other);
                    }
                    Some(_) => {}
                }
            }
        }
        found.push(Component { polygons, is_bounded, inner: inner(made, members) });
    }
    found
}

/// Returns a point strictly inside one of the cells: the middle of the largest one that contains its rounded middle.
fn inner(made: &Constrained, mut cells: Vec<u32>) -> Option<DVec2> {
    let corners = |cell: u32| made.cells()[cell as usize].map(|v| made.points()[v as usize]);
    let area = |cell: u32| {
        let [a, b, c] = corners(cell);
        (b - a).perp_dot(c - a)
    };
    let middle = |cell: u32| {
        let [a, b, c] = corners(cell);
        let middle = a + ((b - a) + (c - a)) / 3.0;
        let is_inside =
            [[a, b], [b, c], [c, a]].iter().all(|&[p, q]| orientation(&[p, q, middle]) == Sign::Positive);
        is_inside.then_some(middle)
    };
    let largest = cells.iter().copied().max_by(|&a, &b| area(a).total_cmp(&area(b)))?;
    middle(largest).or_else(|| {
        cells.sort_by(|&a, &b| area(b).total_cmp(&area(a)));
        cells.into_iter().find_map(middle)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes(polygons: &[(u32, &[&[[f64; 2]]])]) -> Shapes {
        let mut shapes = Shapes { features: polygons.len() as u32, ..Shapes::default() };
        for (feature, rings) in polygons {
            let ring = |ring: &&[[f64; 2]]| ring.iter().map(|&p| shapes.push(p.into(), None)).collect();
            let rings = rings.iter().map(ring).collect();
            shapes.polygons.push(Polygon { feature: *feature, rings });
        }
        shapes
    }

    fn square(x: f64, y: f64, side: f64) -> [[f64; 2]; 5] {
        [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
    }

    /// The area of each region, by the number of the feature.
    fn areas(input: &Input<DVec2>) -> BTreeMap<u32, f64> {
        let domain = crate::check(input).unwrap();
        let mut areas = BTreeMap::new();
        for component in domain.components.iter().filter(|c| c.inside) {
            let feature = input.regions[component.region.unwrap() as usize].attribute as u32;
            *areas.entry(feature).or_default() += component.measure;
        }
        areas
    }

    #[test]
    fn holes_islands_and_neighbours() {
        // A square with a hole, in which lies an island of the same feature. The neighbour has a vertex on the common edge.
        let (input, overlaps) = shapes(&[
            (1, &[&square(0., 0., 8.), &square(2., 2., 4.)]),
            (1, &[&square(3., 3., 1.)]),
            (2, &[&[[8., 2.], [12., 2.], [8., 6.]]]),
        ])
        .domain();
        assert!(!overlaps);
        assert_eq!(areas(&input), BTreeMap::from([(1, 64.0 - 16.0 + 1.0), (2, 8.0)]));
        assert_eq!((input.holes.len(), input.regions.len()), (1, 3));
        let marker = |a: [f64; 2], b: [f64; 2]| {
            let at = |p: [f64; 2]| input.points.iter().position(|q| *q == DVec2::from(p)).unwrap() as u32;
            let ends = ascending([at(a), at(b)]);
            input.segments.iter().find(|s| s.ends == ends).map(|s| s.marker)
        };
        assert_eq!(marker([8., 2.], [8., 6.]), Some(1));
        assert_eq!(marker([8., 2.], [12., 2.]), Some(2));
        assert_eq!(marker([8., 0.], [8., 8.]), None);
    }

    #[test]
    fn gaps_between_polygons_are_holes() {
        let ring: Vec<(u32, [[f64; 2]; 5])> =
            [(0., 0.), (1., 0.), (2., 0.), (0., 1.), (2., 1.), (0., 2.), (1., 2.), (2., 2.)]
                .iter()
                .zip(1..)
                .map(|(&(x, y), i)| (i, square(x, y, 1.)))
                .collect();
        let rings: Vec<[&[[f64; 2]]; 1]> = ring.iter().map(|(_, s)| [&s[..]]).collect();
        let polygons: Vec<(u32, &[&[[f64; 2]]])> =
            ring.iter().zip(&rings).map(|((i, _), r)| (*i, &r[..])).collect();
        let (input, overlaps) = shapes(&polygons).domain();
        assert!(!overlaps);
        assert_eq!(areas(&input).values().sum::<f64>(), 8.0);
        assert_eq!(input.holes.len(), 1);
    }

    #[test]
    fn overlaps_belong_to_the_first_feature() {
        let (input, overlaps) = shapes(&[(1, &[&square(0., 0., 4.)]), (2, &[&square(1., 1., 2.)])]).domain();
        assert!(overlaps);
        assert_eq!(areas(&input), BTreeMap::from([(1, 16.0)]));
        // Polygons that cross are left to the check, which refuses them.
        let (input, _) = shapes(&[(1, &[&square(0., 0., 4.)]), (2, &[&square(2., 2., 4.)])]).domain();
        assert!(crate::check(&input).is_err());
    }
}
