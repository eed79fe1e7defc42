//! The link of a vertex: a closed simplicial complex with adjacency that is updated by cavities. It stores no
//! coordinates.
//!
//! **Statement.** This is the algorithm of Bowyer (1981) and Watson (1981), one dimension lower. When a point is added
//! to a local hull, the facets of the link in conflict with it form a disc (in the plane, a path), the *cavity*. They
//! are removed, and the point is connected to the cavity's boundary. Infinity is the vertex [`INFINITE`], so the
//! complex is always closed, and hull facets need no special case.
//!
//! **Work.** O(1) for each facet removed or created. The boundary of a cavity is a cycle of directed edges. Around the
//! new point, a facet is followed by the facet whose edge starts where its own edge ends. A table indexed by that
//! vertex finds the next facet. In the plane there are two new facets, which are neighbours.

use crate::point::Simplex;

/// The vertex at infinity.
pub const INFINITE: u32 = u32::MAX;

/// The neighbour code of a missing cell.
pub const NONE: u32 = u32::MAX;

/// Cells with two or three vertices, and a neighbour across the ridge opposite each vertex. A neighbour code is
/// `cell << 2 | slot`, where `slot` is the slot of the opposite vertex in the neighbour.
#[derive(Clone, Debug)]
pub struct Complex<S> {
    cells: Vec<Cell<S>>,
    free: Vec<u32>,
    /// The boundary of the last cavity. Entries behind the first `sides` are unused.
    boundary: Vec<BoundaryRidge>,
    /// Number of ridges on the boundary of the last cavity.
    sides: usize,
    created: Vec<u32>,
    /// For each vertex plus 1 (modulo 2^32), the new cell whose edge starts there. Never cleared: a closed boundary
    /// reads only entries that it has written.
    starts: Vec<u32>,
    /// A hash table of ridges, for [`Complex::load`]: the code of the first cell at each ridge, [`MATCHED`] after the
    /// second, and the ridge itself.
    codes: Vec<u32>,
    ridges: Vec<(u32, u32)>,
}

#[derive(Clone, Copy, Debug)]
struct Cell<S> {
    vertices: S,
    neighbours: S,
    is_live: bool,
}

/// A ridge on a cavity's boundary: the edge from `first` to `last`. In the plane, it is one vertex, which is both.
#[derive(Clone, Copy, Debug)]
struct BoundaryRidge {
    first: u32,
    last: u32,
    /// Slot of the opposite vertex in the removed cell.
    slot: u32,
    /// Code of the ridge in the cell outside.
    outer: u32,
}

impl BoundaryRidge {
    const NONE: BoundaryRidge = BoundaryRidge { first: NONE, last: NONE, slot: 0, outer: NONE };
}

impl<S: Simplex> Default for Complex<S> {
    fn default() -> Self {
        Complex {
            cells: Vec::new(),
            free: Vec::new(),
            boundary: Vec::new(),
            sides: 0,
            created: Vec::new(),
            starts: Vec::new(),
            codes: Vec::new(),
            ridges: Vec::new(),
        }
    }
}

impl<S: Simplex> Complex<S> {
    /// Removes all cells and keeps the storage.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.free.clear();
        self.created.clear();
    }

    /// Starts from one finite simplex: `cell`, in its given positive orientation, and the infinite cells on its
    /// facets. Of these `S::LEN + 1` cells, cell 0 is the finite one.
    pub fn start(&mut self, cell: S) {
        self.clear();
        let n = S::LEN;
        self.push(cell);
        for i in 0..n {
            // Seen from outside, the facet opposite `i` has the reverse orientation: swap two other vertices.
            let mut outer = cell;
            outer.as_mut()[i] = INFINITE;
            let (a, b) = other_two(i, n);
            outer.as_mut().swap(a, b);
            self.push(outer);
        }
        for i in 0..n {
            let outer = i as u32 + 1;
            let slot = self.slot_of(outer, INFINITE);
            self.join(0, i, outer, slot);
            for j in 0..i {
                // Infinite cells `i + 1` and `j + 1` share infinity and every vertex except `i` and `j`.
                let other = j as u32 + 1;
                let si = self.slot_of(outer, cell.as_ref()[j]);
                let sj = self.slot_of(other, cell.as_ref()[i]);
                self.join(outer, si, other, sj);
            }
        }
        self.created.extend(0..=n as u32);
    }

    /// Loads the cells of a closed complex, which must be oriented consistently. Each cell gets the slot of its
    /// position. Across a ridge, the neighbour has the ridge in reverse (in the plane, the neighbour starts where this
    /// cell ends). The first of the two cells enters the ridge in a table, and the second finds it there. Returns
    /// `false`, with an unusable complex, if some ridge has only one cell.
    pub fn load(&mut self, cells: &[S]) -> bool {
        self.clear();
        assert!(cells.len() < 1 << 30, "more than 2^30 cells in one complex");
        let neighbours = S::splat(NONE);
        self.cells.extend(cells.iter().map(|&vertices| Cell { vertices, neighbours, is_live: true }));
        // The table has at least as many slots as the cells have ridges, so at most half of its slots are in use.
        let places = (S::LEN * cells.len()).next_power_of_two();
        self.codes.clear();
        self.codes.resize(places, NONE);
        self.ridges.resize(places.max(self.ridges.len()), (NONE, NONE));
        let (codes, ridges) = (self.codes.as_mut_slice(), &mut self.ridges[..places]);
        let mut open = 0u32;
        for (number, cell) in (0u32..).zip(cells) {
            for slot in 0..S::LEN {
                let (first, last) = ridge(cell.as_ref(), slot);
                let code = number << 2 | slot as u32;
                let mut at = hash_of(first, last) & (places - 1);
                // A matched pair remains in its slot, so that entries behind it are found.
                while codes[at] != NONE && (ridges[at] != (last, first) || !may_match::<S>(codes[at], slot)) {
                    at = (at + 1) & (places - 1);
                }
                if codes[at] == NONE {
                    (codes[at], ridges[at]) = (code, (first, last));
                    open += 1;
                } else {
                    let other = std::mem::replace(&mut codes[at], MATCHED);
                    self.cells[number as usize].neighbours.as_mut()[slot] = other;
                    self.cells[(other >> 2) as usize].neighbours.as_mut()[(other & 3) as usize] = code;
                    open -= 1;
                }
            }
        }
        open == 0
    }

    /// Returns the number of cell slots, including unused ones.
    pub fn slots(&self) -> u32 {
        self.cells.len() as u32
    }

    /// Returns the number of live cells.
    pub fn len(&self) -> usize {
        self.cells.len() - self.free.len()
    }

    /// Returns `true` if there are no live cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns `true` if the slot holds a live cell.
    #[inline]
    pub fn is_live(&self, cell: u32) -> bool {
        self.cells[cell as usize].is_live
    }

    /// Returns the vertices of a cell.
    #[inline]
    pub fn cell(&self, cell: u32) -> &S {
        &self.cells[cell as usize].vertices
    }

    /// Returns the neighbour across the facet opposite `slot`: the cell and the slot of its opposite vertex.
    #[inline]
    pub fn neighbour(&self, cell: u32, slot: usize) -> (u32, usize) {
        let code = self.cells[cell as usize].neighbours.as_ref()[slot];
        (code >> 2, (code & 3) as usize)
    }

    /// Iterates over all live cells, in slot order.
    pub fn live_cells(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.slots()).filter(|&c| self.is_live(c))
    }

    /// Returns the cells created by the last [`Complex::replace`] or [`Complex::start`].
    pub fn created(&self) -> &[u32] {
        &self.created
    }

    /// Returns the slots without a cell.
    pub fn free(&self) -> &[u32] {
        &self.free
    }

    /// Adds `vertex`: removes the cells of `cavity`, a connected set, and connects the vertex to the boundary.
    /// `is_inside` returns `true` for cells of the cavity.
    #[inline]
    pub fn replace(&mut self, vertex: u32, cavity: &[u32], is_inside: impl Fn(u32) -> bool) {
        // A branch on boundary ridges would be unpredictable. Instead, each ridge is written, and the next one
        // overwrites an interior ridge.
        let room = S::LEN * cavity.len();
        if room > self.boundary.len() {
            self.boundary.resize(room, BoundaryRidge::NONE);
        }
        self.sides = 0;
        for &cell in cavity {
            let Cell { vertices, neighbours, .. } = self.cells[cell as usize];
            for (slot, &outer) in neighbours.as_ref().iter().enumerate() {
                let (first, last) = ridge(vertices.as_ref(), slot);
                self.boundary[self.sides] = BoundaryRidge { first, last, slot: slot as u32, outer };
                self.sides += usize::from(!is_inside(outer >> 2));
            }
        }
        self.allocate(cavity);
        if S::LEN == 2 { self.fill_path(vertex) } else { self.fill_disc(vertex) }
    }

    /// Assigns slots to the new cells: first those of the cavity, then free ones, then new ones.
    fn allocate(&mut self, cavity: &[u32]) {
        self.created.clear();
        let reused = cavity.len().min(self.sides);
        self.created.extend_from_slice(&cavity[..reused]);
        for &cell in &cavity[reused..] {
            self.cells[cell as usize].is_live = false;
            self.free.push(cell);
        }
        for _ in reused..self.sides {
            let cell = self.free.pop().unwrap_or_else(|| self.push(S::splat(NONE)));
            self.created.push(cell);
        }
    }

    fn fill_disc(&mut self, vertex: u32) {
        for (boundary, &new) in self.boundary[..self.sides].iter().zip(&self.created) {
            let start = boundary.first.wrapping_add(1) as usize;
            if start >= self.starts.len() {
                self.starts.resize(start + 64, NONE);
            }
            self.starts[start] = new;
        }
        for (boundary, &new) in self.boundary[..self.sides].iter().zip(&self.created) {
            let &BoundaryRidge { first, last, outer, .. } = boundary;
            // Around the new vertex, the next facet shares the ridge opposite the last vertex of this facet.
            let next = self.starts[last.wrapping_add(1) as usize];
            let own = &mut self.cells[new as usize];
            own.vertices.as_mut().copy_from_slice(&[vertex, first, last]);
            own.is_live = true;
            let neighbours = own.neighbours.as_mut();
            (neighbours[0], neighbours[1]) = (outer, next << 2 | 2);
            self.cells[next as usize].neighbours.as_mut()[2] = new << 2 | 1;
            self.cells[(outer >> 2) as usize].neighbours.as_mut()[(outer & 3) as usize] = new << 2;
        }
    }

    fn fill_path(&mut self, vertex: u32) {
        for k in 0..2 {
            let (boundary, new, other) = (self.boundary[k], self.created[k], self.created[1 - k]);
            let slot = boundary.slot as usize;
            let own = &mut self.cells[new as usize];
            own.is_live = true;
            let (cell, neighbours) = (own.vertices.as_mut(), own.neighbours.as_mut());
            (cell[slot], cell[1 - slot]) = (vertex, boundary.first);
            // In the other cell, the new vertex has the other slot, so the end of that cell has this slot.
            (neighbours[slot], neighbours[1 - slot]) = (boundary.outer, other << 2 | slot as u32);
            let outer = &mut self.cells[(boundary.outer >> 2) as usize];
            outer.neighbours.as_mut()[(boundary.outer & 3) as usize] = new << 2 | slot as u32;
        }
    }

    fn push(&mut self, vertices: S) -> u32 {
        let cell = self.cells.len() as u32;
        assert!(cell < (1 << 30), "more than 2^30 cells in one complex");
        self.cells.push(Cell { vertices, neighbours: S::splat(NONE), is_live: true });
        cell
    }

    fn slot_of(&self, cell: u32, vertex: u32) -> usize {
        let found = self.cell(cell).as_ref().iter().position(|&v| v == vertex);
        found.expect("the cell has the vertex")
    }

    #[inline]
    fn join(&mut self, a: u32, slot_a: usize, b: u32, slot_b: usize) {
        self.cells[a as usize].neighbours.as_mut()[slot_a] = b << 2 | slot_b as u32;
        self.cells[b as usize].neighbours.as_mut()[slot_b] = a << 2 | slot_a as u32;
    }

    /// Checks that neighbours are mutual and share all vertices except one. For tests. The orientation on the shared
    /// facet is not checked here.
    ///
    /// # Errors
    ///
    /// Returns a description of the first inconsistent cell.
    pub fn check(&self) -> Result<(), String> {
        for cell in self.live_cells() {
            for slot in 0..S::LEN {
                let (next, back) = self.neighbour(cell, slot);
                if !self.is_live(next) || self.neighbour(next, back) != (cell, slot) {
                    return Err(format!("cell {cell} slot {slot}: neighbour {next} is not mutual"));
                }
                let mut mine: Vec<u32> = self.cell(cell).as_ref().to_vec();
                let mut theirs: Vec<u32> = self.cell(next).as_ref().to_vec();
                mine.swap_remove(slot);
                theirs.swap_remove(back);
                mine.sort_unstable();
                theirs.sort_unstable();
                if mine != theirs {
                    return Err(format!("cells {cell} and {next} do not share a facet"));
                }
            }
        }
        Ok(())
    }
}

/// Returns the ridge of a cell opposite `slot`, in its cyclic order after the vertex at `slot`.
#[inline]
fn ridge(vertices: &[u32], slot: usize) -> (u32, u32) {
    match (vertices, slot) {
        (&[_, b], 0) => (b, b),
        (&[a, _], _) => (a, a),
        (&[_, b, c], 0) => (b, c),
        (&[a, _, c], 1) => (c, a),
        (&[a, b, ..], _) => (a, b),
        _ => (NONE, NONE),
    }
}

/// The table entry of a ridge whose two cells have been matched.
const MATCHED: u32 = NONE - 1;

/// Returns the hash of a ridge, equal for both directions.
#[inline]
fn hash_of(first: u32, last: u32) -> usize {
    let (low, high) = (u64::from(first.min(last)), u64::from(first.max(last)));
    ((high << 32 | low).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize
}

/// Returns `true` if a ridge with this code can match one opposite `slot`. In the plane, one cell ends where the other
/// starts.
#[inline]
fn may_match<S: Simplex>(code: u32, slot: usize) -> bool {
    code != MATCHED && (S::LEN > 2 || code & 3 != slot as u32)
}

/// Returns two positions whose exchange reverses the orientation of a cell without moving position `i`. In the plane
/// both move.
fn other_two(i: usize, n: usize) -> (usize, usize) {
    match (n, i) {
        (2, _) => (0, 1),
        (_, 0) => (1, 2),
        (_, 1) => (0, 2),
        _ => (0, 1),
    }
}
