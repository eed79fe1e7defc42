//! The planarity check and the triangulation of facets.
//!
//! **Statement.** A facet is planar iff every corner has orientation 0 with three corners that span a plane. The
//! triangulation is computed in the projection along an axis, which is exact. It includes the points and segments of
//! other elements that lie in the facet. Only the facet's polygons and holes decide which triangles are inside.
//!
//! **Work and depth.** See [`crate::planar`].

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::scale;

use crate::bvh::{Bounds, Bvh};
use crate::defect::{Defect, Element};
use crate::input::{DomainKind, Input};
use crate::planar::Planar;
use crate::simplices::{Outline, Simplices};
use crate::space::{Space, ascending, project, projection_axis};

/// The construction of walls in a dimension.
pub trait Triangulate: Space {
    /// Checks a facet by itself.
    fn outline(
        input: &Input<Self>,
        simplices: &Simplices<Self>,
        facet: u32,
        defects: &mut Vec<Defect>,
    ) -> Option<Outline>;

    /// Builds the walls of all facets.
    fn walls(
        input: &Input<Self>,
        simplices: &mut Simplices<Self>,
        tree: &Bvh<Self>,
        facets: &[Option<Outline>],
        defects: &mut Vec<Defect>,
    );
}

impl Triangulate for DVec2 {
    /// There are no facets in the plane. Polygons are loops of segments.
    fn outline(
        input: &Input<Self>,
        simplices: &Simplices<Self>,
        facet: u32,
        _: &mut Vec<Defect>,
    ) -> Option<Outline> {
        let loops = &input.facets[facet as usize].polygons;
        let loops = loops.iter().map(|l| simplices.represent(l)).collect::<Option<_>>()?;
        Some(Outline { loops, plane: None })
    }

    fn walls(
        _: &Input<Self>,
        simplices: &mut Simplices<Self>,
        _: &Bvh<Self>,
        _: &[Option<Outline>],
        _: &mut Vec<Defect>,
    ) {
        simplices.walls = simplices.parts.iter().map(|p| p.ends).collect();
        simplices.owner = (0..simplices.walls.len() as u32).collect();
    }
}

impl Triangulate for DVec3 {
    fn outline(
        input: &Input<Self>,
        simplices: &Simplices<Self>,
        facet: u32,
        defects: &mut Vec<Defect>,
    ) -> Option<Outline> {
        let stated = &input.facets[facet as usize].polygons;
        let loops: Vec<Vec<u32>> = stated.iter().map(|l| simplices.represent(l)).collect::<Option<_>>()?;
        let corners = loops.concat();
        if loops.iter().all(|l| l.len() < 3) && input.kind == DomainKind::Complex {
            return Some(segments_only(loops, simplices, facet, defects));
        }
        let p = |v: u32| simplices.points[v as usize];
        let Some(plane) = plane(&corners, simplices) else {
            let at = simplices.place(corners.first().copied()?);
            defects.push(Defect::Degenerate { element: Element::Facet(facet), at });
            return None;
        };
        let [a, b, c] = plane.map(p);
        let off: BTreeSet<u32> =
            corners.iter().copied().filter(|&v| orientation(&[a, b, c, p(v)]) != Sign::Zero).collect();
        for &point in &off {
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let distance = scale(DVec3::splat(normal.dot(p(point) - a).abs()), -simplices.frame.exponent).x;
            defects.push(Defect::NotPlanar { facet, point, distance, at: simplices.place(point) });
        }
        off.is_empty().then_some(Outline { loops, plane: Some(plane) })
    }

    fn walls(
        input: &Input<Self>,
        simplices: &mut Simplices<Self>,
        tree: &Bvh<Self>,
        facets: &[Option<Outline>],
        defects: &mut Vec<Defect>,
    ) {
        let mut parts_at: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        for part in &simplices.parts {
            for v in part.ends {
                parts_at.entry(v).or_default().push(part.ends);
            }
        }
        for (facet, outline) in facets.iter().enumerate() {
            let Some(Outline { loops, plane: Some(plane) }) = outline else { continue };
            let alone = loops.len() == 1 && loops[0].len() == 3;
            let triangles = if alone && (input.kind == DomainKind::Surface || bare(simplices, tree, *plane)) {
                vec![*plane]
            } else {
                let job = Job { input, simplices, tree, parts_at: &parts_at, facet: facet as u32 };
                job.triangulate(loops, *plane, defects)
            };
            simplices.owner.extend(triangles.iter().map(|_| facet as u32));
            simplices.walls.extend(triangles);
        }
    }
}

fn segments_only(
    loops: Vec<Vec<u32>>,
    simplices: &Simplices<DVec3>,
    facet: u32,
    defects: &mut Vec<Defect>,
) -> Outline {
    for l in loops.iter().filter(|l| l.len() == 2 && l[0] == l[1]) {
        defects.push(Defect::Degenerate { element: Element::Facet(facet), at: simplices.place(l[0]) });
    }
    Outline { loops, plane: None }
}

/// Returns three corners that are not collinear.
fn plane(corners: &[u32], simplices: &Simplices<DVec3>) -> Option<[u32; 3]> {
    let p = |v: u32| simplices.points[v as usize];
    let (&a, rest) = corners.split_first()?;
    let &b = rest.iter().find(|&&b| b != a)?;
    let &c = rest.iter().find(|&&c| !DVec3::collinear(p(a), p(b), p(c)))?;
    Some([a, b, c])
}

/// Returns `true` if the triangle contains no other point, either inside or on its edges.
fn bare(simplices: &Simplices<DVec3>, tree: &Bvh<DVec3>, t: [u32; 3]) -> bool {
    let corners = DVec3::corners(&simplices.points, &t);
    tree.meeting(&simplices.bounds(&t)).into_iter().all(|v| {
        t.contains(&simplices.same[v as usize]) || !DVec3::on_wall(&corners, simplices.points[v as usize])
    })
}

/// The triangulation of one facet.
struct Job<'a> {
    input: &'a Input<DVec3>,
    simplices: &'a Simplices<DVec3>,
    tree: &'a Bvh<DVec3>,
    parts_at: &'a BTreeMap<u32, Vec<[u32; 2]>>,
    facet: u32,
}

impl Job<'_> {
    fn triangulate(&self, loops: &[Vec<u32>], plane: [u32; 3], defects: &mut Vec<Defect>) -> Vec<[u32; 3]> {
        let p = |v: u32| self.simplices.points[v as usize];
        let [a, b, c] = plane.map(p);
        let Some(axis) = projection_axis(a, b, c) else { return Vec::new() };
        let bounds = self.simplices.bounds(&loops.concat());
        let flat = |v: u32| project(p(v), axis);
        // Points may lie in the plane outside the box of the facet. The box is therefore computed from the
        // projection.
        let mut planar = Planar::new(&Bounds::of([project(bounds.low, axis), project(bounds.high, axis)]));
        let mut vertices: BTreeMap<u32, u32> = BTreeMap::new();
        let mut near = self.tree.meeting(&bounds);
        near.retain(|&v| {
            self.simplices.same[v as usize] == v
                && (self.input.kind == DomainKind::Complex || loops.concat().contains(&v))
                && orientation(&[a, b, c, p(v)]) == Sign::Zero
        });
        for v in near {
            if let Some(inner) = planar.insert(flat(v)) {
                vertices.insert(v, inner);
            }
        }
        let own = Outline { loops: loops.to_vec(), plane: None };
        for [u, v] in own.edges() {
            let ends = vertices.get(&u).zip(vertices.get(&v));
            if ends.is_none_or(|(&u, &v)| planar.constrain(u, v).is_err()) {
                // Two edges of the facet cross. The later comparison of edges reports them.
                return Vec::new();
            }
        }
        planar.close();
        for (&u, &inner) in &vertices {
            for [_, v] in self.parts_at.get(&u).into_iter().flatten().filter(|e| e[0] == u) {
                if let Some(&other) = vertices.get(v) {
                    // A constraint that crosses another is rejected here. The later comparison of edges reports the
                    // crossing.
                    let _ = planar.constrain(inner, other);
                }
            }
        }
        self.inside(&planar, &vertices, axis, defects)
    }

    fn inside(
        &self,
        planar: &Planar,
        vertices: &BTreeMap<u32, u32>,
        axis: usize,
        defects: &mut Vec<Defect>,
    ) -> Vec<[u32; 3]> {
        let stated = &self.input.facets[self.facet as usize].holes;
        let holes: Vec<DVec2> =
            stated.iter().map(|&h| project(self.simplices.frame.inward(h), axis)).collect();
        let (triangles, misplaced) = planar.inside(&holes);
        for hole in misplaced {
            let at = self.simplices.at(self.simplices.frame.inward(stated[hole]));
            defects.push(Defect::FacetHole { facet: self.facet, hole: hole as u32, at });
        }
        let outer: BTreeMap<u32, u32> = vertices.iter().map(|(&v, &inner)| (inner, v)).collect();
        let named = triangles.into_iter().map(|t| t.map(|v| outer.get(&v).copied()));
        named.filter_map(|[a, b, c]| Some([a?, b?, c?])).collect()
    }
}

/// Returns the edges of walls with the walls that contain them, ascending.
pub fn wall_edges<P: Space>(walls: &[P::Facet]) -> BTreeMap<[u32; 2], Vec<u32>> {
    let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (i, wall) in walls.iter().enumerate() {
        for edge in P::edges(wall) {
            edges.entry(ascending(edge)).or_default().push(i as u32);
        }
    }
    edges
}
