//! The storage of a triangulation: one record for each cell, with all data that a search reads.
//!
//! A record has the cell's vertices, its neighbours and its rounded circumsphere ([`super::sphere`]): 48 bytes in
//! space, 36 in the plane. A neighbour is a code `4 * cell + slot`, where `slot` is the slot of the opposite vertex in
//! the neighbour. The neighbour's facet towards this cell is therefore known without a search. Two bits of the sphere's
//! radius serve as marks, because its value does not need them. The sign bit marks a cell that is free or is being
//! removed. The last bit marks a cell that the exact predicates found not to conflict with the current point.

use bytemuck::{Pod, Zeroable};

use crate::complex::{INFINITE, NONE};
use crate::point::Simplex;

/// Mark of a cell that is free or is being removed.
pub(super) const REMOVED: u32 = 1 << 31;

/// Mark of a cell that the exact predicates found not to conflict with the current point.
pub(super) const CLEARED: u32 = 1;

/// The bits of the radius of a cell without a sphere: a NaN.
pub(super) const NO_SPHERE: u32 = 0x7fc0_0000;

/// A cell: its sphere, its neighbours and its vertices, each an array `S` of `DIM + 1` numbers. It has no other fields,
/// so rows can overwrite the storage ([`super::rows`]).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Cell<S>([S; 3]);

impl<S: Simplex> Cell<S> {
    /// Creates a cell without marks.
    #[inline]
    pub(super) fn new(sphere: S, neighbours: S, vertices: S) -> Self {
        Cell([sphere, neighbours, vertices])
    }

    /// Returns the coordinates of the centre and the radius, as bits of `f32`.
    #[inline]
    pub(super) fn sphere(&self) -> &S {
        &self.0[0]
    }

    /// Codes of the cells across the facets opposite the vertices.
    #[inline]
    pub(super) fn neighbours(&self) -> &S {
        &self.0[1]
    }

    #[inline]
    pub(super) fn neighbours_mut(&mut self) -> &mut S {
        &mut self.0[1]
    }

    /// Vertices in positive order.
    #[inline]
    pub(super) fn vertices(&self) -> &S {
        &self.0[2]
    }

    #[inline]
    pub(super) fn vertices_mut(&mut self) -> &mut S {
        &mut self.0[2]
    }

    /// Returns the bits of the radius, including the marks.
    #[inline]
    pub(super) fn radius(&self) -> u32 {
        self.sphere().as_ref()[S::LEN - 1]
    }

    #[inline]
    pub(super) fn radius_mut(&mut self) -> &mut u32 {
        &mut self.0[0].as_mut()[S::LEN - 1]
    }

    #[inline]
    pub(super) fn is_removed(&self) -> bool {
        self.radius() & REMOVED != 0
    }
}

/// The cells of a triangulation, including infinite ones, by index. The exterior is represented by the vertex
/// [`INFINITE`], so that every facet has two cells.
#[derive(Clone, Debug)]
pub struct Cells<S> {
    pub(super) slots: Vec<Cell<S>>,
    /// Slots without a cell; the last one is used first.
    pub(super) free: Vec<u32>,
    /// The cells created by the last insertion.
    pub(super) created: Vec<u32>,
}

impl<S: Simplex> Cells<S> {
    /// Creates an empty triangulation with room for `cells` cells.
    pub(super) fn with_capacity(cells: usize) -> Self {
        Cells { slots: Vec::with_capacity(cells), free: Vec::new(), created: Vec::new() }
    }

    /// Starts with one finite cell, which has index 0, and the infinite cells on its facets.
    pub(super) fn start(&mut self, cell: S) {
        let n = S::LEN;
        self.free.clear();
        self.created.clear();
        self.created.extend(0..=n as u32);
        self.slots.clear();
        self.slots.push(Cell::new(S::splat(NO_SPHERE), S::splat(NONE), cell));
        for i in 0..n {
            // Seen from outside, the facet opposite `i` has the reverse orientation: swap two other vertices.
            let mut vertices = cell;
            vertices.as_mut()[i] = INFINITE;
            let (a, b) = ((i + 1) % n, (i + 2) % n);
            vertices.as_mut().swap(a, b);
            self.slots.push(Cell::new(S::splat(NO_SPHERE), S::splat(NONE), vertices));
        }
        for i in 0..n {
            let outer = i as u32 + 1;
            self.join(0, i, outer, i);
            for j in 0..i {
                // The infinite cells `i + 1` and `j + 1` share infinity and every vertex except `i` and `j`.
                let (si, sj) =
                    (self.slot_of(outer, cell.as_ref()[j]), self.slot_of(j as u32 + 1, cell.as_ref()[i]));
                self.join(outer, si, j as u32 + 1, sj);
            }
        }
    }

    fn slot_of(&self, cell: u32, vertex: u32) -> usize {
        self.cell(cell).as_ref().iter().take_while(|&&v| v != vertex).count()
    }

    fn join(&mut self, a: u32, slot_a: usize, b: u32, slot_b: usize) {
        self.slots[a as usize].neighbours_mut().as_mut()[slot_a] = b << 2 | slot_b as u32;
        self.slots[b as usize].neighbours_mut().as_mut()[slot_b] = a << 2 | slot_a as u32;
    }

    /// Returns the bytes that were written.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.slots[..]) + size_of_val(&self.free[..]) + size_of_val(&self.created[..])
    }

    /// Returns the number of slots, including free ones. Every cell index is smaller.
    pub fn slots(&self) -> u32 {
        self.slots.len() as u32
    }

    /// Returns the number of cells, including infinite ones.
    pub fn len(&self) -> usize {
        self.slots.len() - self.free.len()
    }

    /// Returns `true` if there are no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns `true` if the slot holds a cell.
    #[inline]
    pub fn is_live(&self, cell: u32) -> bool {
        !self.slots[cell as usize].is_removed()
    }

    /// Returns the vertices of a cell.
    #[inline]
    pub fn cell(&self, cell: u32) -> &S {
        self.slots[cell as usize].vertices()
    }

    /// Returns the neighbours of a cell as codes `4 * cell + slot`, across the facets opposite its vertices.
    #[inline]
    pub fn neighbours(&self, cell: u32) -> &S {
        self.slots[cell as usize].neighbours()
    }

    /// Returns the neighbour across the facet opposite `slot`: the cell and the slot of its opposite vertex.
    #[inline]
    pub fn neighbour(&self, cell: u32, slot: usize) -> (u32, usize) {
        let code = self.neighbours(cell).as_ref()[slot];
        (code >> 2, (code & 3) as usize)
    }

    /// Returns the slot of infinity in a cell, if the cell is infinite.
    #[inline]
    pub fn infinite_slot(&self, cell: u32) -> Option<usize> {
        self.cell(cell).as_ref().iter().position(|&v| v == INFINITE)
    }

    /// Returns `true` if infinity is a vertex of the cell.
    #[inline]
    pub fn is_infinite(&self, cell: u32) -> bool {
        self.infinite_slot(cell).is_some()
    }

    /// Iterates over all cells in the order of their slots.
    pub fn live_cells(&self) -> impl Iterator<Item = u32> + '_ {
        (0u32..).zip(&self.slots).filter(|(_, cell)| !cell.is_removed()).map(|(number, _)| number)
    }

    /// Iterates over all cells in the order of their slots: index, vertices and neighbour codes.
    pub fn entries(&self) -> impl Iterator<Item = (u32, &S, &S)> + '_ {
        let live = (0u32..).zip(&self.slots).filter(|(_, cell)| !cell.is_removed());
        live.map(|(number, cell)| (number, cell.vertices(), cell.neighbours()))
    }

    /// Checks, for tests, that neighbours are mutual and share all vertices except one, and that no mark remains.
    ///
    /// # Errors
    ///
    /// Returns a description of the first inconsistent cell.
    pub fn check(&self) -> Result<(), String> {
        for cell in self.live_cells() {
            let radius = self.slots[cell as usize].radius();
            if radius & CLEARED != 0 {
                return Err(format!("cell {cell} is marked"));
            }
            for slot in 0..S::LEN {
                let (next, back) = self.neighbour(cell, slot);
                if !self.is_live(next) || self.neighbour(next, back) != (cell, slot) {
                    return Err(format!("cell {cell} slot {slot}: neighbour {next} is not mutual"));
                }
                if self.facet(cell, slot) != self.facet(next, back) {
                    return Err(format!("cells {cell} and {next} do not share a facet"));
                }
            }
        }
        Ok(())
    }

    fn facet(&self, cell: u32, slot: usize) -> Vec<u32> {
        let mut facet = self.cell(cell).as_ref().to_vec();
        facet.swap_remove(slot);
        facet.sort_unstable();
        facet
    }
}
