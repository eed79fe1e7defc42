//! The faces that separate components, and the components on their sides.
//!
//! **Statement.** In space, the *primary* faces of a facet are its subfacets, the triangles of its planar Delaunay
//! triangulation. In the plane, the primary faces of a segment are its subsegments. If four points of a facet are
//! cocircular up to rounding, the triangulation of all vertices may contain the other diagonal. Faces that overlap an
//! absent primary face in the plane of the facet are then *substitutes*. The barrier consists of primary faces and
//! substitutes.
//!
//! A barrier face with an edge on a subsegment determines the component on either side. The domain gives the components
//! on the sides of the wall that meets the subsegment from the same side as the face. Face and wall traverse the
//! subsegment in the same or in opposite directions. This determines which side of the face corresponds to which side
//! of the wall.
//!
//! *Why the result does not depend on any order.*
//! - A segment on the boundary of a facet has one wall of the facet, so directions alone decide there.
//! - A segment inside a facet has two walls. Exact signs in the plane of the facet distinguish them.
//! - Exact signs also decide whether a face overlaps an absent primary face. Coordinates in a plane are a function of
//!   the point.
//! - Point indices are used only as names. Lookups sort them and account for the parity of the order.
//! - If several edges of a face are subsegments, the largest label applies.
//!
//! **Source.** Sides of walls: [`crate::sides`].
//!
//! **Work and depth.** `O(m log m)` for m faces whose vertices lie on facets, and one pass over all cells.

use std::collections::BTreeMap;

use glam::DVec2;
use septet_geometry::incremental::facet_without;
use septet_geometry::point::Simplex;
use septet_geometry::predicates::{Sign, orientation};

use super::cell_labels::CellLabels;
use super::facets::{Plane, Subfacets, as_space};
use super::generator::Generator;
use super::machine::{Delaunay, MeshMachine};
use super::segments::Chains;
use crate::domain::Domain;
use crate::mesh::Carrier;
use crate::space::{Space, ascending, project};

/// The triangulated features.
#[derive(Clone, Copy)]
pub(super) struct Own<'a> {
    pub(super) planes: &'a [Plane],
    pub(super) chains: &'a Chains,
    pub(super) subfacets: &'a Subfacets,
}

/// The labels on the positive and on the negative side of a face. `None` if unknown.
pub(super) type SideLabels = [Option<u32>; 2];

/// A face of the barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BarrierFace<F> {
    /// Its vertices, ascending.
    face: F,
    /// The facet. In the plane, the segment.
    pub(super) facet: u32,
    /// The labels, with sides relative to the ascending vertices.
    labels: SideLabels,
}

/// The faces that separate components.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Barrier<F> {
    /// The faces, ascending by their vertices.
    parts: Vec<BarrierFace<F>>,
}

impl<F: Simplex> Barrier<F> {
    /// Returns the parts that have the vertices of a face.
    pub(super) fn at(&self, face: &F) -> &[BarrierFace<F>] {
        let key = sorted(*face).0;
        let first = self.parts.partition_point(|p| p.face < key);
        let count = self.parts[first..].iter().take_while(|p| p.face == key).count();
        &self.parts[first..first + count]
    }
}

impl<F: Simplex> BarrierFace<F> {
    /// Returns the label on the side of a cell. The face of the cell has the order of [`facet_without`].
    pub(super) fn towards(&self, face: &F) -> Option<u32> {
        // (vertex, face..) is positive. Moving the vertex to the end takes as many exchanges as the face has
        // vertices.
        let negative = (F::LEN % 2 == 1) != sorted(*face).1;
        self.labels[usize::from(negative)]
    }
}

/// A wall at the first edge of a segment.
struct Rim {
    /// Whether the order of the wall traverses the segment forwards.
    along: bool,
    /// Whether the wall lies to the left of the segment when seen from the tip of the normal.
    left: bool,
    /// The labels on the positive and the negative side of the wall.
    labels: [u32; 2],
}

/// The subsegments, and the walls of facets at segments.
struct Rims {
    /// The ascending ends of each subsegment, its segment, and whether the order of the ends agrees with the
    /// direction of the segment.
    subsegments: Vec<([u32; 2], u32, bool)>,
    /// The walls by facet and segment.
    walls: BTreeMap<(u32, u32), Vec<Rim>>,
}

impl Rims {
    fn new<P: Space>(domain: &Domain<P>, own: Own<'_>) -> Self {
        let mut subsegments = Vec::new();
        for (s, chain) in (0u32..).zip(own.chains) {
            subsegments.extend(chain.windows(2).map(|w| (ascending([w[0], w[1]]), s, w[0] < w[1])));
        }
        subsegments.sort_unstable();
        let first = |s: &crate::domain::Segment| [s.chain[0], s.chain[1]];
        let segments: BTreeMap<[u32; 2], u32> =
            domain.segments.iter().map(|s| ascending(first(s))).zip(0..).collect();
        let mut walls: BTreeMap<(u32, u32), Vec<Rim>> = BTreeMap::new();
        for (f, facet) in (0u32..).zip(&domain.facets) {
            for &w in &facet.walls {
                let wall = domain.walls()[w as usize];
                let turns_left = is_left(domain, w, &own.planes[f as usize]);
                for edge in directed(wall.as_ref()) {
                    let Some(&s) = segments.get(&ascending(edge)) else { continue };
                    let along = edge == first(&domain.segments[s as usize]);
                    let rim = Rim { along, left: along == turns_left, labels: labels_of(domain, w) };
                    walls.entry((f, s)).or_default().push(rim);
                }
            }
        }
        Rims { subsegments, walls }
    }

    /// Returns the segment of which an edge is a subsegment, and whether the edge has its direction.
    fn subsegment(&self, edge: [u32; 2]) -> Option<(u32, bool)> {
        let key = ascending(edge);
        let i = self.subsegments.binary_search_by_key(&key, |p| p.0).ok()?;
        Some((self.subsegments[i].1, self.subsegments[i].2 == (key == edge)))
    }

    /// Returns the labels of a triangle of a facet, which follow from its edges that are subsegments. `turn` is the
    /// orientation of its vertices in the plane.
    fn labels(&self, f: u32, triangle: &[u32; 3], turn: Sign) -> SideLabels {
        let mut found = [None; 2];
        for edge in directed(triangle) {
            let Some((s, along)) = self.subsegment(edge) else { continue };
            let left = along == (turn == Sign::Positive);
            let rim = match self.walls.get(&(f, s)).map(Vec::as_slice) {
                Some([rim]) => Some(rim),
                Some(several) if turn != Sign::Zero => several.iter().find(|r| r.left == left),
                _ => None,
            };
            if let Some(rim) = rim {
                let [p, n] = if rim.along == along { [0, 1] } else { [1, 0] };
                found = [found[0].max(Some(rim.labels[p])), found[1].max(Some(rim.labels[n]))];
            }
        }
        found
    }
}

impl<P: Space, M: MeshMachine<P> + Sync> Generator<'_, P, M> {
    /// Builds the barrier of a triangulation in which no subsegment and no subfacet is missing.
    pub(super) fn barrier(&self, own: Own<'_>, delaunay: &Delaunay<P::Cell>) -> Barrier<P::Facet> {
        let parts = if P::DIM == 2 { self.subsegment_parts(own.chains) } else { self.subfacet_parts(own) };
        let mut barrier = Barrier { parts };
        barrier.parts.sort_unstable();
        if P::DIM == 3 {
            let substitutes = self.substitutes(own, delaunay, &barrier);
            if !substitutes.is_empty() {
                barrier.parts.extend(substitutes);
                barrier.parts.sort_unstable();
                barrier.parts.dedup();
            }
        }
        barrier
    }

    /// In the plane, returns the subsegments as parts.
    fn subsegment_parts(&self, chains: &Chains) -> Vec<BarrierFace<P::Facet>> {
        let edges = self.domain.walls().iter().map(|w| ascending([w.as_ref()[0], w.as_ref()[1]]));
        let walls: BTreeMap<[u32; 2], u32> = edges.zip(0..).collect();
        let mut parts = Vec::new();
        for ((s, chain), segment) in (0u32..).zip(chains).zip(&self.domain.segments) {
            let first = [segment.chain[0], segment.chain[1]];
            let labels = walls.get(&ascending(first)).map(|&w| {
                let along = self.domain.walls()[w as usize].as_ref() == first;
                let [p, n] = labels_of(self.domain, w);
                if along { [p, n] } else { [n, p] }
            });
            for subsegment in chain.windows(2) {
                let [p, n] = if subsegment[0] < subsegment[1] { [0, 1] } else { [1, 0] };
                let face = row_of::<P>(&ascending([subsegment[0], subsegment[1]]));
                parts.push(BarrierFace {
                    face,
                    facet: s,
                    labels: [labels.map(|l| l[p]), labels.map(|l| l[n])],
                });
            }
        }
        parts
    }

    /// Returns the subfacets of all facets as parts.
    fn subfacet_parts(&self, own: Own<'_>) -> Vec<BarrierFace<P::Facet>> {
        let rims = Rims::new(self.domain, own);
        own.subfacets.iter().map(|&(f, t)| self.part(&rims, own, f, t)).collect()
    }

    fn part(&self, rims: &Rims, own: Own<'_>, f: u32, mut triangle: [u32; 3]) -> BarrierFace<P::Facet> {
        triangle.sort_unstable();
        let turn = orientation(&self.in_plane(&own.planes[f as usize], &triangle));
        BarrierFace { face: row_of::<P>(&triangle), facet: f, labels: rims.labels(f, &triangle, turn) }
    }

    fn in_plane(&self, plane: &Plane, triangle: &[u32; 3]) -> [DVec2; 3] {
        triangle.map(|v| plane.of(as_space(self.vertices.points[v as usize])))
    }

    /// Returns the faces of the triangulation that replace absent subfacets.
    fn substitutes(
        &self,
        own: Own<'_>,
        delaunay: &Delaunay<P::Cell>,
        barrier: &Barrier<P::Facet>,
    ) -> Vec<BarrierFace<P::Facet>> {
        let mut present = vec![false; barrier.parts.len()];
        self.each_carried(delaunay, |face| {
            if let Ok(i) = barrier.parts.binary_search_by_key(&face, |p| p.face) {
                present[i] = true;
            }
        });
        let mut absent: BTreeMap<u32, Vec<[DVec2; 3]>> = BTreeMap::new();
        for (part, _) in barrier.parts.iter().zip(&present).filter(|(_, present)| !**present) {
            let corners = self.in_plane(&own.planes[part.facet as usize], &three(part.face.as_ref()));
            absent.entry(part.facet).or_default().push(corners);
        }
        let mut found = Vec::new();
        if absent.is_empty() {
            return found;
        }
        let rims = Rims::new(self.domain, own);
        self.each_carried(delaunay, |face| {
            if !barrier.at(&face).is_empty() {
                return;
            }
            for f in self.holders.common(&self.vertices.carriers, face.as_ref()) {
                let triangle = three(face.as_ref());
                let at = self.in_plane(&own.planes[f as usize], &triangle);
                if absent.get(&f).is_some_and(|all| all.iter().any(|t| overlap(t, &at))) {
                    found.push(self.part(&rims, own, f, triangle));
                }
            }
        });
        found
    }

    /// Visits the faces without a vertex in the volume, with ascending vertices. Most faces are visited twice.
    fn each_carried(&self, delaunay: &Delaunay<P::Cell>, mut visit: impl FnMut(P::Facet)) {
        let in_volume = |v: &&u32| self.vertices.carriers[**v as usize] == Carrier::Volume;
        for cell in &delaunay.cells {
            let inner = cell.as_ref().iter().filter(in_volume).count();
            if inner > 1 {
                continue;
            }
            for v in cell.as_ref().iter().filter(|v| inner == 0 || in_volume(v)) {
                visit(sorted(facet_without::<P>(cell, *v)).0);
            }
        }
    }
}

/// Returns the labels on the positive and the negative side of a wall.
fn labels_of<P: Space>(domain: &Domain<P>, wall: u32) -> [u32; 2] {
    let inside = |c: u32| domain.components[c as usize].inside;
    domain.sides.components_at(wall).map(|c| if inside(c) { c } else { CellLabels::OUT })
}

/// Returns `true` if a wall turns left when seen from the tip of the normal. The test is exact, in a projection along
/// an axis.
fn is_left<P: Space>(domain: &Domain<P>, wall: u32, plane: &Plane) -> bool {
    let normal = plane.normal();
    let steep = |i: &usize, j: &usize| normal[*i].abs().total_cmp(&normal[*j].abs());
    let axis = (0..3).max_by(steep).unwrap_or(2);
    let corners = three(domain.walls()[wall as usize].as_ref());
    let at = corners.map(|v| project(as_space(domain.points()[v as usize]), axis));
    (orientation(&at) == Sign::Positive) == (normal[axis] > 0.0)
}

/// Returns `true` if the interiors of two triangles in the plane meet. The test is exact.
fn overlap(s: &[DVec2; 3], t: &[DVec2; 3]) -> bool {
    let (of_s, of_t) = (orientation(s), orientation(t));
    let parted = |a: &[DVec2; 3], turn: Sign, b: &[DVec2; 3]| {
        (0..3).any(|i| b.iter().all(|&q| orientation(&[a[i], a[(i + 1) % 3], q]) != turn))
    };
    of_s != Sign::Zero && of_t != Sign::Zero && !parted(s, of_s, t) && !parted(t, of_t, s)
}

/// Returns the edges of a triangle, directed along its boundary.
fn directed(triangle: &[u32]) -> [[u32; 2]; 3] {
    [0, 1, 2].map(|i| [triangle[i], triangle[(i + 1) % 3]])
}

/// Sorts the vertices. Also returns whether the permutation was odd.
fn sorted<F: Simplex>(face: F) -> (F, bool) {
    let row = face.as_ref();
    let inversions = (0..row.len()).map(|i| row[i + 1..].iter().filter(|&&w| w < row[i]).count());
    let odd = inversions.sum::<usize>() % 2 == 1;
    let mut face = face;
    face.as_mut().sort_unstable();
    (face, odd)
}

fn row_of<P: Space>(vertices: &[u32]) -> P::Facet {
    let mut row = P::Facet::splat(u32::MAX);
    row.as_mut().copy_from_slice(vertices);
    row
}

fn three(row: &[u32]) -> [u32; 3] {
    [row[0], row[1], row[2]]
}
