//! Which new cells are neighbours: the ridges of a cavity's border, paired.
//!
//! **Statement.** The border of a cavity is a closed oriented surface (in the plane: curve). Two of its
//! facets that share a ridge run through it in opposite directions; so if each facet enters itself
//! under its directed ridges, its neighbour is found under the reversed ones. In the plane a ridge is one
//! vertex; with a fixed vertex 0 before or after it, it is directed as well.
//!
//! **Work.** One store and one load for each facet and ridge, while a border has fewer than [`SIDE`]
//! vertices; else a sort of its ridges.

/// Vertices of a border that the table has room for, the vertex 0 included.
const SIDE: usize = 64;

/// Pairs directed ridges. Reused from cavity to cavity; nothing needs to be cleared, since a closed
/// border asks for nothing that it has not entered.
#[derive(Clone, Debug)]
pub(super) struct Ridges {
    table: Box<[u32; SIDE * SIDE]>,
    /// For large borders: ends in rising order, and the code.
    sorted: Vec<(u32, u32, u32)>,
    /// For large borders: the mate of each code.
    mates: Vec<u32>,
}

impl Default for Ridges {
    fn default() -> Self {
        Ridges { table: Box::new([0; SIDE * SIDE]), sorted: Vec::new(), mates: Vec::new() }
    }
}

/// The directed ridge of a facet with vertices `at` (the third is 0 in the plane), opposite vertex `i`.
#[inline]
pub(super) fn ridge(at: [u32; 3], i: usize) -> (u32, u32) {
    (at[(i + 1) % 3], at[(i + 2) % 3])
}

#[inline]
fn position(from: u32, to: u32) -> usize {
    (from as usize % SIDE) * SIDE + to as usize % SIDE
}

impl Ridges {
    /// Is there room in the table for vertices `0..vertices`?
    #[inline]
    pub(super) fn is_small(vertices: usize) -> bool {
        vertices <= SIDE
    }

    /// Enters a code under a directed ridge.
    #[inline]
    pub(super) fn enter(&mut self, (from, to): (u32, u32), code: u32) {
        self.table[position(from, to)] = code;
    }

    /// The code entered under the reversed ridge.
    #[inline]
    pub(super) fn mate(&self, (from, to): (u32, u32)) -> u32 {
        self.table[position(to, from)]
    }

    /// Pairs the ridges of a border too large for the table: each with its code, all below `codes`.
    #[cold]
    pub(super) fn pair(&mut self, codes: usize, ridges: impl Iterator<Item = ((u32, u32), u32)>) {
        self.sorted.clear();
        self.sorted.extend(ridges.map(|((a, b), code)| (a.min(b), a.max(b), code)));
        self.sorted.sort_unstable();
        self.mates.clear();
        self.mates.resize(codes, 0);
        for pair in self.sorted.chunks_exact(2) {
            self.mates[pair[0].2 as usize] = pair[1].2;
            self.mates[pair[1].2 as usize] = pair[0].2;
        }
    }

    /// The mate of a code that was paired.
    pub(super) fn paired(&self, code: u32) -> u32 {
        self.mates[code as usize]
    }
}
