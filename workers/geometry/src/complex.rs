//! A simplicial complex with adjacency, glued by cavities. It holds no coordinates.
//!
//! **Statement.** Bowyer (1981) and Watson (1981): when a vertex is added to a Delaunay complex, the
//! cells it conflicts with form a ball; they are removed, and the vertex is joined to the ball's
//! boundary. The same step, one dimension down, adds a point to the link of a vertex, which is how a
//! local hull (paper, Lemma 4.3) grows. So one structure serves both: cells of `N` vertices, `N = DIM`
//! for a link and `N = DIM + 1` for a triangulation. Outer space is the vertex [`INFINITE`], so that
//! the complex is always closed and a hull facet is no special case.
//!
//! **Work.** A cavity with `b` boundary facets costs O(b) expected. Adjacency among the new cells is
//! found by their ridges: a new cell's facet is the new vertex and a ridge of `N - 2` vertices, at most
//! two, which pack into one exact 64-bit key.

use crate::point::Simplex;

/// The vertex at infinity.
pub const INFINITE: u32 = u32::MAX;

/// No cell, as a neighbour code.
pub const NONE: u32 = u32::MAX;

/// Cells with `S::LEN` vertices and a neighbour across the facet opposite each vertex. Neighbour codes
/// are `cell << 2 | slot`, the slot being that of the opposite vertex in the neighbour.
#[derive(Clone, Debug)]
pub struct Complex<S> {
    vertices: Vec<S>,
    neighbours: Vec<S>,
    /// Per cell: an epoch mark of the last search, or `DEAD`.
    marks: Vec<u32>,
    free: Vec<u32>,
    epoch: u32,
    cavity: Vec<u32>,
    border: Vec<(u32, u8)>,
    created: Vec<u32>,
    ridges: RidgeTable,
}

const DEAD: u32 = u32::MAX;

impl<S: Simplex> Default for Complex<S> {
    fn default() -> Self {
        Complex {
            vertices: Vec::new(),
            neighbours: Vec::new(),
            marks: Vec::new(),
            free: Vec::new(),
            epoch: 0,
            cavity: Vec::new(),
            border: Vec::new(),
            created: Vec::new(),
            ridges: RidgeTable::default(),
        }
    }
}

impl<S: Simplex> Complex<S> {
    /// Empties the complex and keeps its storage.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.neighbours.clear();
        self.marks.clear();
        self.free.clear();
        self.epoch = 0;
    }

    /// Starts from one finite simplex: `cell` (in its given, positive orientation) and the infinite
    /// cells on its facets, `S::LEN + 1` cells in all. Cell 0 is the finite one.
    pub fn start(&mut self, cell: S) {
        self.clear();
        let n = S::LEN;
        self.push(cell);
        for i in 0..n {
            // Seen from outside the facet opposite i is reversed: swap two other vertices.
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
                // Infinite cells i+1 and j+1 share infinity and every vertex but i and j.
                let other = j as u32 + 1;
                let si = self.slot_of(outer, cell.as_ref()[j]);
                let sj = self.slot_of(other, cell.as_ref()[i]);
                self.join(outer, si, other, sj);
            }
        }
    }

    /// Number of cell slots, dead ones included.
    pub fn slots(&self) -> u32 {
        self.vertices.len() as u32
    }

    /// Number of live cells.
    pub fn len(&self) -> usize {
        self.vertices.len() - self.free.len()
    }

    /// Is there no live cell?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Is this slot in use?
    #[inline]
    pub fn is_live(&self, cell: u32) -> bool {
        self.marks[cell as usize] != DEAD
    }

    /// The vertices of a cell.
    #[inline]
    pub fn cell(&self, cell: u32) -> &S {
        &self.vertices[cell as usize]
    }

    /// The slot in which a cell holds infinity, if any.
    #[inline]
    pub fn infinite_slot(&self, cell: u32) -> Option<usize> {
        self.cell(cell).as_ref().iter().position(|&v| v == INFINITE)
    }

    /// The neighbour across the facet opposite `slot`: the cell and the slot of its opposite vertex.
    #[inline]
    pub fn neighbour(&self, cell: u32, slot: usize) -> (u32, usize) {
        let code = self.neighbours[cell as usize].as_ref()[slot];
        (code >> 2, (code & 3) as usize)
    }

    /// All live cells, in slot order.
    pub fn live_cells(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.slots()).filter(|&c| self.is_live(c))
    }

    /// The cells made by the last [`Complex::insert`].
    pub fn created(&self) -> &[u32] {
        &self.created
    }

    /// The cells removed by the last [`Complex::insert`] (their vertices are gone).
    pub fn removed(&self) -> &[u32] {
        &self.cavity
    }

    /// Adds `vertex`: digs the connected set of cells that `conflict` accepts, from `seed` (which must
    /// conflict), removes them and joins the vertex to the boundary. `conflict(self, cell)` must not
    /// change its mind. Returns the number of conflict tests made.
    pub fn insert<F>(&mut self, vertex: u32, seed: u32, mut conflict: F) -> usize
    where
        F: FnMut(&Self, u32) -> bool,
    {
        self.epoch += 2;
        let (inside, outside) = (self.epoch, self.epoch + 1);
        self.cavity.clear();
        self.border.clear();
        self.cavity.push(seed);
        self.marks[seed as usize] = inside;
        let mut tests = 0;
        let mut head = 0;
        while head < self.cavity.len() {
            let cell = self.cavity[head];
            head += 1;
            for slot in 0..S::LEN {
                let (next, _) = self.neighbour(cell, slot);
                let mark = self.marks[next as usize];
                if mark == inside {
                    continue;
                }
                if mark != outside {
                    tests += 1;
                    if conflict(self, next) {
                        self.marks[next as usize] = inside;
                        self.cavity.push(next);
                        continue;
                    }
                    self.marks[next as usize] = outside;
                }
                self.border.push((cell, slot as u8));
            }
        }
        self.fill(vertex);
        tests
    }

    /// Replaces the marked cavity by the cone from `vertex` over its border.
    fn fill(&mut self, vertex: u32) {
        let border = std::mem::take(&mut self.border);
        self.created.clear();
        self.ridges.reset(border.len() * (S::LEN - 1));
        for &(cell, slot) in &border {
            let slot = slot as usize;
            let (outer, outer_slot) = self.neighbour(cell, slot);
            let mut vertices = *self.cell(cell);
            vertices.as_mut()[slot] = vertex;
            let new = self.allocate(vertices);
            self.join(new, slot, outer, outer_slot);
            for j in (0..S::LEN).filter(|&j| j != slot) {
                let key = ridge_key(vertices.as_ref(), slot, j);
                if let Some(code) = self.ridges.match_or_insert(key, new << 2 | j as u32) {
                    self.join(new, j, code >> 2, (code & 3) as usize);
                }
            }
            self.created.push(new);
        }
        self.border = border;
        for &cell in &self.cavity {
            self.marks[cell as usize] = DEAD;
            self.free.push(cell);
        }
    }

    fn allocate(&mut self, vertices: S) -> u32 {
        match self.free.pop() {
            Some(cell) => {
                self.vertices[cell as usize] = vertices;
                self.marks[cell as usize] = 0;
                cell
            }
            None => self.push(vertices),
        }
    }

    fn push(&mut self, vertices: S) -> u32 {
        let cell = self.vertices.len() as u32;
        assert!(cell < (1 << 30), "more than 2^30 cells in one complex");
        self.vertices.push(vertices);
        self.neighbours.push(S::splat(NONE));
        self.marks.push(0);
        cell
    }

    fn slot_of(&self, cell: u32, vertex: u32) -> usize {
        let found = self.cell(cell).as_ref().iter().position(|&v| v == vertex);
        found.expect("the vertex stands in the cell")
    }

    #[inline]
    fn join(&mut self, a: u32, slot_a: usize, b: u32, slot_b: usize) {
        self.neighbours[a as usize].as_mut()[slot_a] = b << 2 | slot_b as u32;
        self.neighbours[b as usize].as_mut()[slot_b] = a << 2 | slot_a as u32;
    }

    /// Checks that neighbours are mutual and share all but one vertex, with opposite orientation on
    /// the shared facet left to the geometric checks. For tests.
    ///
    /// # Errors
    ///
    /// Names the first cell found wrong.
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

/// Two positions other than `i` among `n` (equal positions when `n` is 2: a swap that does nothing,
/// since a link of two vertices carries its orientation in the order itself).
fn other_two(i: usize, n: usize) -> (usize, usize) {
    match (n, i) {
        (2, _) => (0, 1),
        (_, 0) => (1, 2),
        (_, 1) => (0, 2),
        _ => (0, 1),
    }
}

/// The exact key of the ridge of `vertices` without positions `a` and `b`: at most two vertices.
#[inline]
fn ridge_key(vertices: &[u32], a: usize, b: usize) -> u64 {
    let (mut low, mut high) = (0u32, 0u32);
    for (i, &v) in vertices.iter().enumerate() {
        if i != a && i != b {
            if v >= low {
                (low, high) = (v, low);
            } else {
                high = v;
            }
        }
    }
    u64::from(low) << 32 | u64::from(high)
}

/// Pairs up equal keys: an open-addressing table that is emptied in O(1).
#[derive(Clone, Debug, Default)]
struct RidgeTable {
    slots: Vec<(u64, u32, u32)>,
    stamp: u32,
    mask: usize,
}

impl RidgeTable {
    fn reset(&mut self, entries: usize) {
        let wanted = (entries * 2).next_power_of_two().max(16);
        if wanted > self.slots.len() {
            self.slots = vec![(0, 0, 0); wanted];
            self.stamp = 0;
        } else if self.stamp == u32::MAX {
            self.slots.fill((0, 0, 0));
            self.stamp = 0;
        }
        self.stamp += 1;
        self.mask = wanted - 1;
    }

    /// The code stored under this key, or `None` after storing `code` (a key occurs exactly twice).
    #[inline]
    fn match_or_insert(&mut self, key: u64, code: u32) -> Option<u32> {
        let mut at = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize & self.mask;
        loop {
            let slot = &mut self.slots[at];
            if slot.1 != self.stamp {
                *slot = (key, self.stamp, code);
                return None;
            }
            if slot.0 == key {
                return Some(slot.2);
            }
            at = (at + 1) & self.mask;
        }
    }
}
