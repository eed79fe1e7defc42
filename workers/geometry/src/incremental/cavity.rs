//! One insertion: finding the cavity of a point and replacing its cells.
//!
//! **Statement** (Bowyer 1981, Watson 1981). The cells in conflict with a point form the *cavity*, a connected set
//! whose boundary is a closed surface that is visible from the point. The new cells connect the point to the facets of
//! the boundary. A breadth-first search from one cell in conflict finds the cavity.
//!
//! **Work.** One comparison with a sphere for each cell of the cavity and each facet of its boundary, and one record
//! written for each facet.
//!
//! **Departures.** New cells use the slots of the cavity first. The exact predicates run only for cells that the
//! rounded spheres leave undecided, once for each such cell.

use super::cells::{CLEARED, Cell, NO_SPHERE, REMOVED};
use super::read::corners;
use super::ridges::Ridges;
use super::ridges::ridge;
use super::scratch::{Face, Scratch};
use super::sphere::Query;
use super::triangulation::Incremental;
use crate::complex::{INFINITE, NONE};
use crate::point::{Point, Simplex};
use crate::predicates::{conflicts_infinite, in_sphere};

/// Cavities of evenly distributed points have fewer cells. An insertion with a larger cavity is always kept.
const MANY: usize = 128;

/// The mark, in the incidence table, of a vertex that has an index on the current boundary.
const INDEXED: u32 = 1 << 31;

/// Returns the facet opposite `slot` of a positive cell, preceded by the neighbour code across this facet
/// ([`super::cells`]). A point inside the cell and the facet, in this order, form a positive cell.
#[inline]
fn facet<P: Point>(vertices: &P::Cell, slot: usize, code: u32) -> P::Cell {
    let from = match (P::DIM, slot) {
        (2, 0) => [1, 2, 0],
        (2, 1) => [2, 0, 0],
        (2, _) => [0, 1, 0],
        (_, 0) => [1, 2, 3],
        (_, 1) => [0, 3, 2],
        (_, 2) => [0, 1, 3],
        _ => [0, 2, 1],
    };
    let mut facet = P::Cell::splat(code);
    for (to, &slot) in facet.as_mut()[1..].iter_mut().zip(&from) {
        *to = vertices.as_ref()[slot];
    }
    facet
}

/// Returns `true` if `q` conflicts with a cell. Exact.
pub(super) fn conflicts<P: Point>(slots: &[Cell<P::Cell>], points: &[P], cell: u32, q: P) -> bool {
    let n = P::Cell::LEN;
    let vertices = slots[cell as usize].vertices();
    let this = corners(points, vertices);
    match vertices.as_ref().iter().position(|&v| v == INFINITE) {
        None => in_sphere(&this[..n], q),
        Some(slot) => {
            let inner = slots[cell as usize].neighbours().as_ref()[slot] >> 2;
            let finite = corners(points, slots[inner as usize].vertices());
            conflicts_infinite(&this[..n], slot, &finite[..n], q)
        }
    }
}

/// Decides a conflict that the spheres leave undecided. Marks a cell without a conflict, so that the cell is tested
/// exactly only once.
#[cold]
fn conflicts_once<P: Point>(
    slots: &mut [Cell<P::Cell>],
    points: &[P],
    cleared: &mut Vec<u32>,
    cell: u32,
    q: P,
) -> bool {
    if slots[cell as usize].radius() & CLEARED != 0 {
        return false;
    }
    let inside = conflicts(slots, points, cell, q);
    if !inside {
        *slots[cell as usize].radius_mut() |= CLEARED;
        cleared.push(cell);
    }
    inside
}

impl<P: Point> Incremental<P> {
    /// Returns `true` if `q` conflicts with a cell. Exact.
    pub(super) fn conflicts_with(&self, cell: u32, q: P) -> bool {
        conflicts(&self.cells.slots, &self.points, cell, q)
    }

    /// Inserts the vertex `vertex`, which conflicts with the cell `seed`, if the cavity has a vertex below `bound` or
    /// more than [`MANY`] cells. Returns `true` if it was inserted.
    pub(super) fn replace(&mut self, vertex: u32, query: &Query<P>, seed: u32, bound: u32) -> bool {
        let q = self.points[vertex as usize];
        self.find_cavity(q, query, seed);
        self.operations.cells.visit_all(self.scratch.cavity.items());
        self.operations.cells.visit_all(self.scratch.boundary.items());
        if bound != INFINITE && !self.keeps_insertion(bound) {
            self.last = seed;
            return false;
        }
        self.allocate();
        self.index_boundary();
        if P::IS_WEIGHTED {
            self.hide_inner_vertices();
        }
        self.invert_vertices(q);
        if Ridges::is_small(self.scratch.boundary_vertices.len) {
            self.fill_small(vertex, query);
        } else {
            self.fill_large(vertex, query);
        }
        self.set_incident(vertex);
        true
    }

    /// Returns `true` if the cavity has a vertex below `bound` or more than [`MANY`] cells. Otherwise restores the
    /// cells of the cavity.
    fn keeps_insertion(&mut self, bound: u32) -> bool {
        let (slots, cavity) = (&mut self.cells.slots[..], self.scratch.cavity.items());
        let has_one = |&cell: &u32| slots[cell as usize].vertices().as_ref().iter().any(|&v| v < bound);
        if cavity.len() > MANY || cavity.iter().any(has_one) {
            return true;
        }
        for &cell in cavity {
            *slots[cell as usize].radius_mut() &= !REMOVED;
        }
        false
    }

    /// Finds the cells in conflict with `q`, a connected set, and the boundary of this set. A branch on conflicts would
    /// be unpredictable, so each neighbour is written to both lists, and only the list to which it belongs grows.
    #[inline(never)]
    fn find_cavity(&mut self, q: P, query: &Query<P>, seed: u32) {
        let (slots, points) = (&mut self.cells.slots[..], &self.points[..]);
        let Scratch { cavity, boundary, cleared, .. } = &mut self.scratch;
        *slots[seed as usize].radius_mut() |= REMOVED;
        cavity.items[0] = seed;
        let (mut head, mut inner, mut outer) = (0, 1, 0);
        while head < inner {
            let inside_of = cavity.room(inner, P::Cell::LEN);
            let boundary_of = boundary.room(outer, P::Cell::LEN);
            let cell = inside_of[head];
            head += 1;
            let neighbours = *slots[cell as usize].neighbours();
            let mut open = 0;
            for slot in 0..P::Cell::LEN {
                let code = neighbours.as_ref()[slot];
                let next = &mut slots[(code >> 2) as usize];
                let power = query.power(next);
                let live = next.radius() >> 31 ^ 1;
                let inside = live & u32::from(power.is_inside());
                let outside = live & u32::from(power.is_outside());
                *next.radius_mut() |= inside << 31;
                inside_of[inner] = code >> 2;
                inner = inner.wrapping_add(inside as usize);
                boundary_of[outer] = (code, cell << 2 | slot as u32);
                outer = outer.wrapping_add(outside as usize);
                open |= (live ^ inside ^ outside) << slot;
            }
            while open != 0 {
                let slot = open.trailing_zeros();
                open &= open - 1;
                let code = neighbours.as_ref()[slot as usize];
                if conflicts_once(slots, points, cleared, code >> 2, q) {
                    *slots[(code >> 2) as usize].radius_mut() |= REMOVED;
                    inside_of[inner] = code >> 2;
                    inner += 1;
                } else {
                    boundary_of[outer] = (code, cell << 2 | slot);
                    outer += 1;
                }
            }
        }
        (cavity.len, boundary.len) = (inner, outer);
        for cell in cleared.drain(..) {
            *slots[cell as usize].radius_mut() &= !CLEARED;
        }
    }

    /// Assigns slots to the new cells: first those of the cavity, then free ones, then new ones.
    #[inline(never)]
    fn allocate(&mut self) {
        let Scratch { cavity, boundary, .. } = &self.scratch;
        let (cavity, boundary) = (cavity.items(), boundary.items());
        let cells = &mut self.cells;
        cells.created.clear();
        let reused = cavity.len().min(boundary.len());
        cells.created.extend_from_slice(&cavity[..reused]);
        cells.free.extend_from_slice(&cavity[reused..]);
        while cells.created.len() < boundary.len() {
            let Some(slot) = cells.free.pop() else { break };
            cells.created.push(slot);
        }
        let more = boundary.len() - cells.created.len();
        let slots = cells.slots.len();
        cells.created.extend((slots..slots + more).map(|slot| slot as u32));
        let [none, infinite] = [NONE, INFINITE].map(P::Cell::splat);
        let empty = Cell::new(P::Cell::splat(NO_SPHERE), none, infinite);
        cells.slots.resize(slots + more, empty);
    }

    /// Assigns indices to the vertices of the boundary, and stores the ridges.
    #[inline(never)]
    fn index_boundary(&mut self) {
        let Scratch { boundary, faces, boundary_vertices, ridges, .. } = &mut self.scratch;
        let incident = &mut self.incident[..];
        let slots = &self.cells.slots[..];
        let boundary = boundary.items();
        let faces_of = &mut faces.room(0, boundary.len())[..boundary.len()];
        let mut known = 1;
        let vertices_of = boundary_vertices.room(known, P::DIM * boundary.len());
        for ((&(inward, outward), &cell), face) in boundary.iter().zip(&self.cells.created).zip(faces_of) {
            let removed = slots[(outward >> 2) as usize].vertices();
            let vertices = facet::<P>(removed, outward as usize & 3, inward);
            let mut indices = [0; 3];
            for (index, &vertex) in indices.iter_mut().zip(&vertices.as_ref()[1..]) {
                let entry = &mut incident[vertex.wrapping_add(1) as usize];
                let is_new = *entry & INDEXED == 0;
                *index = if is_new { known as u32 } else { *entry & !INDEXED };
                *entry = INDEXED | *index;
                vertices_of[known] = (vertex, cell);
                known = known.wrapping_add(usize::from(is_new));
            }
            for i in 0..P::DIM {
                ridges.enter(ridge(indices, i), cell << 2 | (i as u32 + 1));
            }
            *face = Face { vertices, indices, cell };
        }
        (faces.len, boundary_vertices.len) = (boundary.len(), known);
    }

    /// Hides the vertices of the cavity that are not on its boundary: the new vertex is so heavy that they lie above the
    /// lower hull.
    fn hide_inner_vertices(&mut self) {
        for &cell in self.scratch.cavity.items() {
            for &vertex in self.cells.slots[cell as usize].vertices().as_ref() {
                let entry = &mut self.incident[vertex.wrapping_add(1) as usize];
                if *entry & INDEXED == 0 {
                    *entry = NONE;
                }
            }
        }
    }

    /// Inverts the vertices of the boundary around the new vertex.
    fn invert_vertices(&mut self, q: P) {
        let Scratch { around, boundary_vertices, .. } = &mut self.scratch;
        let (points, frame) = (&self.points[..], self.frame);
        around.clear();
        around.extend(boundary_vertices.items().iter().map(|&(vertex, _)| {
            let to = points.get(vertex as usize).copied().unwrap_or(P::splat(f64::NAN));
            frame.inverse(q, to)
        }));
    }

    /// Writes the new cells. `mate(k, i, ridge)` is the code across a ridge.
    #[expect(clippy::inline_always, reason = "one loop for each way of pairing")]
    #[inline(always)]
    fn fill(
        &mut self,
        vertex: u32,
        query: &Query<P>,
        mate: impl Fn(&Ridges, usize, usize, (u32, u32)) -> u32,
    ) {
        let Scratch { faces, around, ridges, .. } = &self.scratch;
        let (slots, around) = (&mut self.cells.slots[..], &around[..]);
        for (k, face) in faces.items().iter().enumerate() {
            let Face { mut vertices, indices, cell } = *face;
            let outer = vertices.as_ref()[0];
            vertices.as_mut()[0] = vertex;
            let mut neighbours = P::Cell::splat(outer);
            for i in 0..P::DIM {
                neighbours.as_mut()[i + 1] = mate(ridges, k, i, ridge(indices, i));
            }
            slots[(outer >> 2) as usize].neighbours_mut().as_mut()[(outer & 3) as usize] = cell << 2;
            let sphere = query.sphere(indices.map(|i| &around[i as usize]));
            slots[cell as usize] = Cell::new(sphere, neighbours, vertices);
        }
    }

    #[inline(never)]
    fn fill_small(&mut self, vertex: u32, query: &Query<P>) {
        self.fill(vertex, query, |ridges, _, _, ridge| ridges.mate(ridge));
    }

    #[cold]
    fn fill_large(&mut self, vertex: u32, query: &Query<P>) {
        let Scratch { faces, ridges, .. } = &mut self.scratch;
        let all = faces.items().iter().zip(0u32..).flat_map(|(face, k)| {
            let indices = face.indices;
            (0..P::DIM).map(move |i| (ridge(indices, i), k << 2 | i as u32))
        });
        ridges.pair(&self.cells.created, all);
        self.fill(vertex, query, |ridges, k, i, _| ridges.paired(k, i));
    }

    /// Stores a cell for the new vertex and for every vertex of the boundary.
    fn set_incident(&mut self, vertex: u32) {
        let first = self.cells.created[0];
        for &(vertex, cell) in &self.scratch.boundary_vertices.items()[1..] {
            self.incident[vertex.wrapping_add(1) as usize] = cell;
        }
        self.incident[vertex as usize + 1] = first;
        self.last = first;
    }
}
