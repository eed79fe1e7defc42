//! Adjacency of new cells: pairing the ridges on the boundary of a cavity.
//!
//! **Statement.** The boundary of a cavity is a closed oriented surface (in the plane, a closed curve). Two of its
//! facets that share a ridge traverse it in opposite directions. So if each facet is entered under its directed
//! ridges, its neighbours are found under the reversed ones. In the plane a ridge is one vertex. A fixed vertex 0
//! before or after this vertex also gives the ridge a direction.
//!
//! **Work.** One store and one load for each facet and ridge, if the boundary has fewer than [`SIDE`] vertices;
//! otherwise a sort of its ridges.

/// Number of boundary vertices for which the table has room, including the vertex 0.
const SIDE: usize = 64;

/// Pairs directed ridges. Reused for all cavities without clearing: a closed boundary reads only entries that it has
/// written.
#[derive(Clone, Debug)]
pub(super) struct Ridges {
    table: Box<[u32; SIDE * SIDE]>,
    /// For large boundaries: the ends of each ridge in ascending order, and the index of the ridge.
    sorted: Vec<(u32, u32, u32)>,
    /// For large boundaries: the code across each ridge.
    mates: Vec<u32>,
}

impl Default for Ridges {
    fn default() -> Self {
        Ridges { table: Box::new([0; SIDE * SIDE]), sorted: Vec::new(), mates: Vec::new() }
    }
}

/// Returns the directed ridge opposite vertex `i` of a facet with vertices `at`, of which the third is 0 in the
/// plane.
#[inline]
pub(super) fn ridge(at: [u32; 3], i: usize) -> (u32, u32) {
    (at[(i + 1) % 3], at[(i + 2) % 3])
}

#[inline]
fn position(from: u32, to: u32) -> usize {
    (from as usize % SIDE) * SIDE + to as usize % SIDE
}

impl Ridges {
    /// Returns `true` if the table has room for the vertices `0..vertices`.
    #[inline]
    pub(super) fn is_small(vertices: usize) -> bool {
        vertices <= SIDE
    }

    /// Stores a code under a directed ridge.
    #[inline]
    pub(super) fn enter(&mut self, (from, to): (u32, u32), code: u32) {
        self.table[position(from, to)] = code;
    }

    /// Returns the code stored under the reversed ridge.
    #[inline]
    pub(super) fn mate(&self, (from, to): (u32, u32)) -> u32 {
        self.table[position(to, from)]
    }

    /// Pairs the ridges of a boundary that is too large for the table. Facet `k` belongs to the cell `cells[k]`, and
    /// its ridge opposite vertex `i` has the index `4 k + i`.
    #[cold]
    pub(super) fn pair(&mut self, cells: &[u32], ridges: impl Iterator<Item = ((u32, u32), u32)>) {
        self.sorted.clear();
        self.sorted.extend(ridges.map(|((a, b), number)| (a.min(b), a.max(b), number)));
        self.sorted.sort_unstable();
        self.mates.clear();
        self.mates.resize(cells.len() << 2, 0);
        let code = |number: u32| cells[number as usize >> 2] << 2 | ((number & 3) + 1);
        for pair in self.sorted.chunks_exact(2) {
            self.mates[pair[0].2 as usize] = code(pair[1].2);
            self.mates[pair[1].2 as usize] = code(pair[0].2);
        }
    }

    /// Returns the code of the new cell across the ridge of facet `k` opposite vertex `i`. Requires an earlier call
    /// of [`Ridges::pair`].
    pub(super) fn paired(&self, k: usize, i: usize) -> u32 {
        self.mates[k << 2 | i]
    }
}
