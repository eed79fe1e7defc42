//! The vertices, parts and patches that a recovery keeps.
//!
//! **Statement.** A *part* is an edge of the input between two vertices, without a vertex in between. A *patch* is a
//! connected set of coplanar walls of one input facet without parts between them. So two components, or the outside,
//! lie on the two sides of a patch. If walls of a facet are not coplanar, the edges between them count as parts.
//!
//! **Work and depth.** `O(m log m)`.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use septet_geometry::point::Point;
use septet_geometry::predicates::{Sign, orientation};

use crate::domain::Domain;
use crate::facet::wall_edges;
use crate::mesh::Carrier;
use crate::sides::Sets;
use crate::space::{Space, ascending};

/// An edge that the mesh keeps.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its ends.
    pub(super) ends: [u32; 2],
    /// The segment or facet of the domain that carries it.
    pub(super) carrier: Carrier,
    /// The patches at the edge, ascending.
    pub(super) patches: Vec<u32>,
}

/// A planar region of walls between parts.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// The facet of the domain.
    pub(super) facet: u32,
    /// The first wall.
    pub(super) wall: u32,
    /// The vertices of its walls.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The parts at its walls.
    pub(super) parts: Vec<u32>,
}

impl Patch {
    /// Returns a point and the unit normal of its largest triangle.
    pub(super) fn plane(&self, points: &[DVec3]) -> [DVec3; 2] {
        let normals = self.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            [a, (b - a).cross(c - a)]
        });
        let largest = normals.max_by(|m, n| m[1].length_squared().total_cmp(&n[1].length_squared()));
        let [at, normal] = largest.unwrap_or_default();
        [at, normal.normalize_or_zero()]
    }
}

/// The elements of a domain that a mesh keeps. Vertices have new numbers, corners first.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) points: Vec<DVec3>,
    pub(super) carriers: Vec<Carrier>,
    pub(super) parts: Vec<Part>,
    pub(super) patches: Vec<Patch>,
}

impl Layout {
    pub(super) fn new<P: Space>(domain: &Domain<P>) -> Self {
        let live: Vec<u32> = domain.facets.iter().flat_map(|f| f.walls.iter().copied()).collect();
        let mut facet_of = BTreeMap::new();
        for (f, facet) in (0u32..).zip(&domain.facets) {
            facet_of.extend(facet.walls.iter().map(|&w| (w, f)));
        }
        let mut segment_of = BTreeMap::new();
        for (s, segment) in (0u32..).zip(&domain.segments) {
            segment_of.extend(segment.chain.windows(2).map(|w| (ascending([w[0], w[1]]), s)));
        }
        let carriers = carriers(domain, &facet_of);
        let number: BTreeMap<u32, u32> = carriers.iter().map(|c| c.0).zip(0..).collect();
        let groups = Groups::new(domain, &live);
        let mut kept: BTreeMap<[u32; 2], Carrier> =
            segment_of.iter().map(|(&edge, &s)| (edge, Carrier::Segment(s))).collect();
        for (edge, walls) in groups.borders() {
            kept.entry(edge).or_insert(Carrier::Facet(facet_of[&walls[0]]));
        }
        let mut patches: Vec<Patch> = Vec::new();
        let mut patch_of: BTreeMap<u32, u32> = BTreeMap::new();
        for &wall in &live {
            let next = patches.len() as u32;
            let p = *patch_of.entry(groups.of[&wall]).or_insert(next);
            if p == next {
                let facet = facet_of[&wall];
                patches.push(Patch { facet, wall, triangles: Vec::new(), parts: Vec::new() });
            }
            let corners = three(domain.walls()[wall as usize].as_ref());
            patches[p as usize].triangles.push(corners.map(|v| number[&v]));
        }
        let mut parts = Vec::new();
        for (edge, carrier) in kept {
            let walls = groups.edges.get(&edge).map_or(&[][..], Vec::as_slice);
            let around: BTreeSet<u32> = walls.iter().map(|w| patch_of[&groups.of[w]]).collect();
            let part = parts.len() as u32;
            for &p in &around {
                patches[p as usize].parts.push(part);
            }
            let patches = around.into_iter().collect();
            parts.push(Part { ends: edge.map(|v| number[&v]), carrier, patches });
        }
        let at = |v: u32| space(domain.points()[v as usize]);
        Layout {
            points: carriers.iter().map(|c| at(c.0)).collect(),
            carriers: carriers.into_iter().map(|c| c.1).collect(),
            parts,
            patches,
        }
    }

    /// Returns the patches at each vertex, ascending.
    pub(super) fn planes(&self) -> Vec<Vec<u32>> {
        let mut planes: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for (p, patch) in (0u32..).zip(&self.patches) {
            for &v in patch.triangles.as_flattened() {
                if planes[v as usize].last() != Some(&p) {
                    planes[v as usize].push(p);
                }
            }
        }
        planes
    }
}

/// The walls, by patches.
struct Groups {
    /// The first wall of the patch of each wall.
    of: BTreeMap<u32, u32>,
    /// The walls at each edge.
    edges: BTreeMap<[u32; 2], Vec<u32>>,
    /// The edges of the input.
    stated: BTreeSet<[u32; 2]>,
}

impl Groups {
    fn new<P: Space>(domain: &Domain<P>, live: &[u32]) -> Self {
        let rows: Vec<P::Facet> = live.iter().map(|&w| domain.walls()[w as usize]).collect();
        let edges: BTreeMap<[u32; 2], Vec<u32>> = wall_edges::<P>(&rows)
            .into_iter()
            .map(|(edge, walls)| (edge, walls.into_iter().map(|i| live[i as usize]).collect()))
            .collect();
        let stated: BTreeSet<[u32; 2]> = domain.simplices.parts.iter().map(|p| ascending(p.ends)).collect();
        let mut sets = Sets::new(domain.walls().len());
        for (edge, walls) in edges.iter().filter(|(edge, _)| !stated.contains(*edge)) {
            if let [a, b] = walls[..] {
                let owner = |w: u32| domain.simplices.owner[w as usize];
                let apex = |w: u32| {
                    let row = three(domain.walls()[w as usize].as_ref());
                    row.into_iter().find(|v| !edge.contains(v)).unwrap_or(edge[0])
                };
                let at = [edge[0], edge[1], apex(a), apex(b)].map(|v| space(domain.points()[v as usize]));
                if owner(a) == owner(b) && orientation(&at) == Sign::Zero {
                    sets.join(a, b);
                }
            }
        }
        Groups { of: live.iter().map(|&w| (w, sets.find(w))).collect(), edges, stated }
    }

    /// Returns the edges that are not between two walls of one patch.
    fn borders(&self) -> impl Iterator<Item = ([u32; 2], &[u32])> {
        let inner = |walls: &[u32]| matches!(walls, [a, b] if self.of[a] == self.of[b]);
        self.edges
            .iter()
            .filter(move |(edge, walls)| self.stated.contains(*edge) || !inner(walls))
            .map(|(&edge, walls)| (edge, walls.as_slice()))
    }
}

/// Returns the vertices that the mesh keeps, with their carriers, corners first.
fn carriers<P: Space>(domain: &Domain<P>, facet_of: &BTreeMap<u32, u32>) -> Vec<(u32, Carrier)> {
    let mut found: Vec<(u32, Carrier)> =
        domain.corners.iter().copied().zip((0..).map(Carrier::Corner)).collect();
    let mut others: BTreeMap<u32, Carrier> = BTreeMap::new();
    for (s, segment) in (0u32..).zip(&domain.segments) {
        let inner = segment.chain.get(1..segment.chain.len() - 1).unwrap_or_default();
        others.extend(inner.iter().map(|&v| (v, Carrier::Segment(s))));
    }
    for (&wall, &facet) in facet_of {
        for &v in domain.walls()[wall as usize].as_ref() {
            others.entry(v).or_insert(Carrier::Facet(facet));
        }
    }
    others.retain(|v, _| domain.corners.binary_search(v).is_err());
    found.extend(others);
    found
}

pub(super) fn space<P: Point>(p: P) -> DVec3 {
    DVec3::new(p.coord(0), p.coord(1), if P::DIM == 3 { p.coord(2) } else { 0.0 })
}

pub(super) fn three(row: &[u32]) -> [u32; 3] {
    [0, 1, 2].map(|i| row.get(i).copied().unwrap_or(0))
}
