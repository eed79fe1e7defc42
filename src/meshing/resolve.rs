//! The conversion of polygons to simplices. The result is a complex whose elements meet in common vertices, or a list
//! of defects.
//!
//! **Statement.** Edges are divided at the points on them. Each facet is triangulated with all points and segments that
//! lie in it. If the input is a valid complex, the result is simplicial. [`crate::contact`] decides whether it is. In
//! the plane, the walls are the subsegments. [`crate::contact`] checks the result.
//!
//! Elements with a defect are omitted from later steps, so that they do not cause other defects. Points with the same
//! coordinates are identified.
//!
//! **Work and depth.** `O(m log m)`, plus the visited boxes, sequential. A facet of `k` points needs `O(k^2)`.

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::point::lex_cmp;
use septet_geometry::range::{all_finite, scale_exponent};

use crate::bvh::{Bounds, Bvh};
use crate::defect::{Defect, Element};
use crate::facet::Triangulate;
use crate::frame::Frame;
use crate::input::{DomainKind, Input};
pub use crate::simplices::{Outline, Part, Simplices};
use crate::space::{Space, ascending, on_segment};

/// The state of the conversion.
struct Resolver<'a, P: Space> {
    input: &'a Input<P>,
    out: Simplices<P>,
    tree: Bvh<P>,
    defects: Vec<Defect>,
}

/// Returns the simplices of an input, and the defects of single elements. The simplices are `None` if coordinates are
/// out of range or there are no elements.
pub fn resolve<P: Triangulate>(input: &Input<P>) -> (Option<Simplices<P>>, Vec<Defect>) {
    if input.segments.is_empty() && input.facets.is_empty() {
        return (None, vec![Defect::Empty]);
    }
    let all =
        [input.points.as_slice(), &input.holes, &input.regions.iter().map(|r| r.at).collect::<Vec<_>>()];
    let all = all.concat();
    let frame = all_finite(&all).map(|()| frame_of(input));
    let centred = |frame: &Frame<P>| all.iter().map(|&p| frame.inward(p)).collect::<Vec<_>>();
    let frame = frame.and_then(|frame| Ok(frame.scaled(scale_exponent(&centred(&frame))?)));
    let frame = match frame {
        Ok(frame) => frame,
        Err(error) => return (None, vec![Defect::Range(error.to_string())]),
    };
    // Adding zero converts -0.0 to 0.0.
    let points: Vec<P> = input.points.iter().map(|&p| frame.inward(p) + P::splat(0.0)).collect();
    let tree = Bvh::new(points.iter().map(|&p| Bounds::of([p])).collect());
    let same = (0..points.len() as u32).collect();
    let out = Simplices { points, frame, same, parts: vec![], walls: vec![], owner: vec![] };
    let mut resolver = Resolver { input, out, tree, defects: Vec::new() };
    resolver.join_duplicates();
    resolver.indices();
    let facets: Vec<Option<Outline>> = (0..input.facets.len() as u32)
        .map(|f| P::outline(input, &resolver.out, f, &mut resolver.defects))
        .collect();
    resolver.divide(&facets);
    let Resolver { mut out, tree, mut defects, .. } = resolver;
    P::walls(input, &mut out, &tree, &facets, &mut defects);
    (Some(out), defects)
}

/// Returns the points that elements of the input name.
fn used<P: Space>(input: &Input<P>) -> BTreeSet<u32> {
    let facets = input.facets.iter().flat_map(|f| f.polygons.iter().flatten().copied());
    facets.chain(input.segments.iter().flat_map(|s| s.ends)).collect()
}

/// Returns the translation of an input with finite coordinates. Unused points of a surface have no part in it.
fn frame_of<P: Space>(input: &Input<P>) -> Frame<P> {
    let all = |v: &u32| input.points.get(*v as usize).copied();
    match input.kind {
        DomainKind::Surface => Frame::around(used(input).iter().filter_map(all)),
        DomainKind::Complex => Frame::around(input.points.iter().copied()),
    }
}

impl<P: Space> Resolver<'_, P> {
    fn p(&self, v: u32) -> P {
        self.out.points[v as usize]
    }

    fn used(&self) -> BTreeSet<u32> {
        used(self.input)
    }

    fn join_duplicates(&mut self) {
        let used = self.used();
        let surface = self.input.kind == DomainKind::Surface;
        let mut order: Vec<u32> = (0..self.out.points.len() as u32).collect();
        order.retain(|v| !surface || used.contains(v));
        order.sort_by(|&a, &b| lex_cmp(&self.p(a), &self.p(b)).then(a.cmp(&b)));
        let groups: Vec<Vec<u32>> = order
            .chunk_by(|&a, &b| self.p(a) == self.p(b))
            .filter(|g| g.len() > 1)
            .map(<[u32]>::to_vec)
            .collect();
        for points in groups {
            for &v in &points {
                self.out.same[v as usize] = points[0];
            }
            let at = self.out.place(points[0]);
            self.defects.push(Defect::Duplicate { points, at });
        }
    }

    /// Reports every reference to a point that does not exist.
    fn indices(&mut self) {
        let count = self.out.points.len() as u64;
        let segments = self.input.segments.iter().map(|s| (Element::Segment(s.ends), s.ends.to_vec()));
        let facets = self.input.facets.iter().enumerate();
        let facets = facets.map(|(i, f)| (Element::Facet(i as u32), f.polygons.concat()));
        for (element, named) in segments.chain(facets) {
            let missing = named.into_iter().map(u64::from).filter(|&n| n >= count);
            self.defects.extend(missing.map(|named| Defect::NoSuchPoint { element, named, count }));
        }
    }

    /// Divides all edges at the points on them. In a surface, reports such points.
    fn divide(&mut self, facets: &[Option<Outline>]) {
        let mut edges: BTreeMap<[u32; 2], i64> = BTreeMap::new();
        for (segment, listed) in self.input.segments.iter().map(|s| (s, s.ends)) {
            let Some(ends) = self.out.represent(&listed) else { continue };
            if ends[0] == ends[1] {
                let at = self.out.place(ends[0]);
                self.defects.push(Defect::Degenerate { element: Element::Segment(listed), at });
                continue;
            }
            let ends = ascending([ends[0], ends[1]]);
            if P::DIM == 2 && edges.contains_key(&ends) {
                let element = Element::Segment(ascending(listed));
                self.defects
                    .push(Defect::Doubled { elements: [element, element], at: self.out.middle(ends) });
            }
            edges.entry(ends).or_insert(segment.marker);
        }
        for edge in facets.iter().flatten().flat_map(Outline::edges) {
            edges.entry(ascending(edge)).or_insert(0);
        }
        let used = self.used();
        let mut parts: BTreeMap<[u32; 2], Part> = BTreeMap::new();
        for (&edge, &marker) in &edges {
            let on = self.on_edge(edge, &used);
            if self.input.kind == DomainKind::Surface {
                for &v in &on {
                    let elements = [Element::Point(v), Element::Segment(edge)];
                    self.defects.push(Defect::Intersect { elements, at: self.out.place(v) });
                }
            }
            let chain: Vec<u32> = [edge[0]].into_iter().chain(on).chain([edge[1]]).collect();
            for pair in chain.windows(2) {
                let ends = ascending([pair[0], pair[1]]);
                let part = parts.entry(ends).or_insert(Part { ends, of: Vec::new(), marker: 0 });
                part.of.push(edge);
                part.marker = if part.marker == 0 { marker } else { part.marker };
            }
        }
        self.out.parts = parts.into_values().collect();
        if P::DIM == 2 {
            self.overlaps();
        }
    }

    /// In the plane, reports segments that overlap.
    fn overlaps(&mut self) {
        let pairs: BTreeSet<[[u32; 2]; 2]> =
            self.out.parts.iter().flat_map(|p| p.of.windows(2).map(|w| [w[0], w[1]])).collect();
        for [a, b] in pairs {
            let at = self.out.middle(if self.covers(a, b) { b } else { a });
            self.defects.push(Defect::Doubled { elements: [Element::Segment(a), Element::Segment(b)], at });
        }
    }

    fn covers(&self, a: [u32; 2], b: [u32; 2]) -> bool {
        b.iter().all(|&v| on_segment(self.p(a[0]), self.p(a[1]), self.p(v)))
    }

    /// Returns the points strictly between the ends of an edge, in order.
    fn on_edge(&self, [a, b]: [u32; 2], used: &BTreeSet<u32>) -> Vec<u32> {
        let surface = self.input.kind == DomainKind::Surface;
        let mut on = self.tree.meeting(&self.out.bounds(&[a, b]));
        on.retain(|&v| {
            self.out.same[v as usize] == v
                && v != a
                && v != b
                && (!surface || used.contains(&v))
                && on_segment(self.p(a), self.p(b), self.p(v))
        });
        // Along the longest axis of the edge, one coordinate determines the order.
        let d = self.p(b) - self.p(a);
        let axis = (1..P::DIM).fold(0, |k, i| if d.coord(i).abs() > d.coord(k).abs() { i } else { k });
        on.sort_by(|&u, &v| self.p(u).coord(axis).total_cmp(&self.p(v).coord(axis)));
        if d.coord(axis) < 0.0 {
            on.reverse();
        }
        on
    }
}
