//! A mesh whose cells change.
//!
//! **Statement.** Every vertex has the list of its cells. The adjacency of cells follows from these lists, because a
//! few common vertices determine an edge or a face. A change replaces cells by others with the same boundary, except
//! where it also replaces faces on facets. Replaced cells keep their numbers, which are never used again.
//!
//! **Work and depth.** O(1) per change, because the cells around a vertex are few.

use std::collections::BTreeMap;

use septet_geometry::point::{Point, Simplex};

use super::change::{Change, NEW, sorted};
use super::shape::grade;
use crate::domain::Domain;
use crate::mesh::{Carrier, Edge, Face, Mesh, OUTSIDE};
use crate::space::{Space, ascending};

/// An entry of a replaced cell, and the last entry of a triangle.
pub(super) const NONE: u32 = u32::MAX;

/// A mesh in scaled coordinates.
pub(super) struct Editable<P: Space> {
    pub(super) points: Vec<P>,
    pub(super) sizes: Vec<f64>,
    pub(super) carriers: Vec<Carrier>,
    /// In the plane, the last entry is [`NONE`].
    pub(super) cells: Vec<[u32; 4]>,
    pub(super) regions: Vec<u32>,
    /// The least sine of each cell. Infinite for replaced cells.
    pub(super) sines: Vec<f64>,
    /// The round in which each cell was changed.
    pub(super) changed: Vec<u32>,
    /// For each cell, the number of levels of changes that failed since its surroundings last changed.
    pub(super) failed: Vec<u8>,
    stars: Vec<Vec<u32>>,
    /// Faces on facets, ascending, with their facets. Empty in the plane.
    pub(super) faces: BTreeMap<[u32; 3], u32>,
    /// Edges on segments, ascending, with their segments. Empty in the plane.
    pub(super) edges: BTreeMap<[u32; 2], u32>,
}

impl<P: Space> Editable<P> {
    /// Takes the cells of a mesh in scaled coordinates.
    pub(super) fn new(mesh: &Mesh<P>) -> Self {
        let row = |cell: &P::Cell| {
            let mut row = [NONE; 4];
            row[..=P::DIM].copy_from_slice(cell.as_ref());
            row
        };
        let cells: Vec<[u32; 4]> = mesh.cells.iter().map(row).collect();
        let mut stars = vec![Vec::new(); mesh.points.len()];
        for (c, row) in (0u32..).zip(&cells) {
            row[..=P::DIM].iter().for_each(|&v| stars[v as usize].push(c));
        }
        let corners = |f: &Face<P>| [0, 1, 2].map(|i| f.vertices.as_ref()[i]);
        let faces = mesh.faces.iter().filter(|_| P::DIM == 3).map(|f| (sorted(corners(f)), f.facet));
        let edges = mesh.edges.iter().map(|e| (ascending(e.vertices), e.segment));
        let (faces, edges) = (faces.collect(), edges.collect());
        let count = cells.len();
        let mut made = Editable {
            points: mesh.points.clone(),
            sizes: mesh.sizes.clone(),
            carriers: mesh.carriers.clone(),
            cells,
            regions: mesh.regions.clone(),
            sines: Vec::new(),
            changed: vec![0; count],
            failed: vec![0; count],
            stars,
            faces,
            edges,
        };
        made.sines = (0..count as u32).map(|c| grade(&made.corners(c)[..=P::DIM]).sine).collect();
        made
    }

    /// Returns the cells with a sine below the wanted one, the worst first.
    pub(super) fn bad(&self, wanted: f64) -> Vec<u32> {
        let mut bad: Vec<u32> =
            (0u32..).zip(&self.sines).filter(|&(_, &sine)| sine < wanted).map(|(c, _)| c).collect();
        bad.sort_by(|&a, &b| self.sines[a as usize].total_cmp(&self.sines[b as usize]).then(a.cmp(&b)));
        bad
    }

    /// Returns the total volume of the cells.
    pub(super) fn volume(&self) -> f64 {
        let cells = (0..self.cells.len() as u32).filter(|&c| self.cells[c as usize][0] != NONE);
        cells.map(|c| crate::quality::angles::measure(row_of(&self.corners(c)))).sum()
    }

    /// Returns the points of a cell.
    pub(super) fn corners(&self, cell: u32) -> [P; 4] {
        self.places(self.cells[cell as usize])
    }

    /// Returns the points of a row.
    pub(super) fn places(&self, row: [u32; 4]) -> [P; 4] {
        let mut corners = [P::default(); 4];
        for (corner, &v) in corners.iter_mut().zip(&row[..=P::DIM]) {
            *corner = self.points[v as usize];
        }
        corners
    }

    /// Returns the points of a face.
    pub(super) fn triangle(&self, face: [u32; 3]) -> [P; 3] {
        face.map(|v| self.points[v as usize])
    }

    /// Returns the cells around a vertex.
    pub(super) fn star(&self, v: u32) -> &[u32] {
        &self.stars[v as usize]
    }

    /// Returns the cells around an edge.
    pub(super) fn around(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        let [a, b] = if self.star(a).len() <= self.star(b).len() { [a, b] } else { [b, a] };
        self.star(a).iter().copied().filter(|&c| self.cells[c as usize].contains(&b)).collect()
    }

    /// Returns the other cell at a face of a cell.
    pub(super) fn across(&self, cell: u32, face: [u32; 3]) -> Option<u32> {
        let has = |c: &u32| *c != cell && face.iter().all(|v| self.cells[*c as usize].contains(v));
        // The tip of a cone can have thousands of cells.
        let fewest = face.into_iter().min_by_key(|&v| self.star(v).len())?;
        self.star(fewest).iter().copied().find(has)
    }

    /// Returns the listed faces around a vertex, ascending.
    pub(super) fn faces_at(&self, v: u32) -> Vec<([u32; 3], u32)> {
        let mut found = Vec::new();
        if self.carriers[v as usize] == Carrier::Volume {
            return found;
        }
        for &c in self.star(v) {
            let row = self.cells[c as usize];
            for skip in row.into_iter().filter(|&w| w != v) {
                let face = sorted(without(row, skip));
                found.extend(self.faces.get(&face).map(|&facet| (face, facet)));
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns `true` if an edge belongs to a listed face.
    fn is_on_boundary(&self, [a, b]: [u32; 2]) -> bool {
        self.faces_at(a).iter().any(|(face, _)| face.contains(&b))
    }

    /// Returns `true` if a change still fits: no cell of it was changed in this round.
    pub(super) fn fits(&self, change: &Change<P>, round: u32) -> bool {
        change.old.iter().all(|&c| self.changed[c as usize] != round)
            && change.fresh.is_none_or(|edge| !self.is_on_boundary(edge))
    }

    /// Applies a change that fits.
    pub(super) fn apply(&mut self, change: &Change<P>, round: u32) {
        let mut vertex = NEW;
        if let Some(placed) = change.placed {
            vertex = placed.vertex;
            if vertex == NEW {
                vertex = self.points.len() as u32;
                self.points.push(placed.at);
                self.sizes.push(placed.size);
                self.carriers.push(placed.carrier);
                self.stars.push(Vec::new());
            } else {
                self.points[vertex as usize] = placed.at;
                self.carriers[vertex as usize] = placed.carrier;
            }
        }
        let named = |v: u32| if v == NEW { vertex } else { v };
        let mut touched: Vec<u32> = Vec::new();
        if change.kind == super::change::Kind::Move {
            touched.extend(change.old.iter().flat_map(|&c| self.cells[c as usize]));
            for &c in &change.old {
                self.sines[c as usize] = grade(&self.corners(c)[..=P::DIM]).sine;
                self.changed[c as usize] = round;
            }
        } else {
            for &c in &change.old {
                touched.extend(self.cells[c as usize]);
                self.remove(c, round);
            }
            for &(row, region) in &change.new {
                self.add(row.map(named), region, round);
            }
            self.relist(change, named);
        }
        touched.sort_unstable();
        touched.dedup();
        // Changes at cells that share only a corner do not depend on each other, because it does not move.
        let can_move = |v: &u32| *v != NONE && !matches!(self.carriers[*v as usize], Carrier::Corner(_));
        for v in touched.into_iter().filter(can_move) {
            for &c in &self.stars[v as usize] {
                self.failed[c as usize] = 0;
            }
        }
    }

    fn remove(&mut self, cell: u32, round: u32) {
        for v in self.cells[cell as usize] {
            self.stars[v as usize].retain(|&c| c != cell);
        }
        self.cells[cell as usize] = [NONE; 4];
        self.sines[cell as usize] = f64::INFINITY;
        self.changed[cell as usize] = round;
    }

    fn add(&mut self, row: [u32; 4], region: u32, round: u32) {
        let cell = self.cells.len() as u32;
        self.cells.push(row);
        self.regions.push(region);
        self.sines.push(grade(&self.places(row)).sine);
        self.changed.push(round);
        self.failed.push(0);
        for v in row {
            self.stars[v as usize].push(cell);
        }
    }

    fn relist(&mut self, change: &Change<P>, named: impl Fn(u32) -> u32 + Copy) {
        for face in &change.lost_faces {
            self.faces.remove(face);
        }
        for &(face, facet) in &change.made_faces {
            self.faces.insert(sorted(face.map(named)), facet);
        }
        for edge in &change.lost_edges {
            self.edges.remove(edge);
        }
        for &(edge, segment) in &change.made_edges {
            self.edges.insert(ascending(edge.map(named)), segment);
        }
    }

    /// Writes the cells back to the mesh, in canonical order. Points that no cell uses are removed.
    pub(super) fn write(self, domain: &Domain<P>, mesh: &mut Mesh<P>) {
        let mut number = vec![NONE; self.points.len()];
        let kept = (0..self.points.len()).filter(|&v| P::DIM == 2 || !self.stars[v].is_empty());
        let kept: Vec<usize> = kept.collect();
        for (new, &old) in (0u32..).zip(&kept) {
            number[old] = new;
        }
        mesh.points = kept.iter().map(|&v| self.points[v]).collect();
        mesh.sizes = kept.iter().map(|&v| self.sizes[v]).collect();
        mesh.carriers = kept.iter().map(|&v| self.carriers[v]).collect();
        if P::DIM == 2 {
            return;
        }
        let renumbered = |v: u32| number[v as usize];
        let mut rows: Vec<(P::Cell, u32, u32)> = Vec::new();
        for (c, (row, &region)) in (0u32..).zip(self.cells.iter().zip(&self.regions)) {
            if row[0] != NONE {
                let mut cell = P::Cell::splat(0);
                cell.as_mut().copy_from_slice(&row.map(renumbered));
                rows.push((crate::generate::canonical::<P>(cell), region, c));
            }
        }
        rows.sort_unstable();
        let mut new = vec![OUTSIDE; self.cells.len()];
        for (i, row) in (0u32..).zip(&rows) {
            new[row.2 as usize] = i;
        }
        mesh.cells = rows.iter().map(|r| r.0).collect();
        mesh.regions = rows.iter().map(|r| r.1).collect();
        mesh.faces = self
            .faces
            .iter()
            .map(|(&face, &facet)| self.listed(face, facet, &number, &new, domain))
            .collect();
        mesh.faces.sort_unstable_by_key(|face| (face.facet, face.vertices));
        let edge = |(&vertices, &segment): (&[u32; 2], &u32)| Edge {
            vertices: ascending(vertices.map(renumbered)),
            segment,
            marker: domain.segments[segment as usize].marker,
        };
        mesh.edges = self.edges.iter().map(edge).collect();
        mesh.edges.sort_unstable_by_key(|edge| (edge.segment, edge.vertices));
    }

    /// Returns a face with its cells, in the new numbers.
    fn listed(&self, face: [u32; 3], facet: u32, number: &[u32], new: &[u32], domain: &Domain<P>) -> Face<P> {
        let has = |c: &u32| face.iter().all(|v| self.cells[*c as usize].contains(v));
        let mut around = self.star(face[0]).iter().copied().filter(has).map(|c| new[c as usize]);
        let mut cells = [around.next().unwrap_or(OUTSIDE), around.next().unwrap_or(OUTSIDE)];
        cells.sort_unstable();
        let mut vertices = P::Facet::splat(0);
        vertices.as_mut().copy_from_slice(&sorted(face.map(|v| number[v as usize])));
        Face { vertices, facet, marker: domain.facets[facet as usize].marker, cells }
    }
}

/// Returns the vertices of a row other than one of them.
pub(super) fn without(row: [u32; 4], skip: u32) -> [u32; 3] {
    let mut face = [NONE; 3];
    for (slot, v) in face.iter_mut().zip(row.into_iter().filter(|&v| v != skip)) {
        *slot = v;
    }
    face
}

/// Returns the corners of a cell of a mesh, whatever its dimension.
pub(super) fn row_of<P: Point>(row: &[P; 4]) -> &[P] {
    &row[..=P::DIM]
}
