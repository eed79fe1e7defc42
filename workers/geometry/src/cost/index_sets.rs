//! Sets and maps of small indices, in storage that is reused without clearing.

/// A set of indices. Starting a new set takes O(1) time.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// Number of the current set. An index belongs to this set if its mark equals this number.
    round: u32,
    /// The mark of each index, at the position `index + 1` (modulo 2^32).
    marks: Vec<u32>,
}

impl Marks {
    /// Creates an empty set for the indices below `indices`, and for [`u32::MAX`].
    pub fn new(indices: usize) -> Self {
        Marks { round: 0, marks: vec![0; indices + 1] }
    }

    /// Grows the storage, if necessary, for the indices below `indices` and [`u32::MAX`].
    pub fn make_room(&mut self, indices: usize) {
        if indices >= self.marks.len() {
            self.marks.resize(indices + 1, 0);
        }
    }

    /// Starts a new, empty set.
    pub fn clear(&mut self) {
        if self.round == u32::MAX {
            self.marks.fill(0);
            self.round = 0;
        }
        self.round += 1;
    }

    /// Returns `true` if the set contains the index.
    #[inline]
    pub fn contains(&self, index: u32) -> bool {
        self.marks[index.wrapping_add(1) as usize] == self.round
    }

    /// Inserts an index. Returns `true` if it was not in the set.
    #[inline]
    pub fn insert(&mut self, index: u32) -> bool {
        std::mem::replace(&mut self.marks[index.wrapping_add(1) as usize], self.round) != self.round
    }
}

/// A map from indices to their positions in a list of distinct indices.
#[derive(Clone, Debug, Default)]
pub struct Positions {
    pub(super) marks: Marks,
    positions: Vec<u32>,
}

impl Positions {
    /// Grows the storage, if necessary, for the indices below `indices` and [`u32::MAX`].
    pub fn make_room(&mut self, indices: usize) {
        self.marks.make_room(indices);
    }

    /// Maps each of some distinct indices to its position in the slice.
    pub(super) fn set(&mut self, distinct: &[u32]) {
        self.positions.resize(self.marks.marks.len(), 0);
        for (position, &index) in (0..).zip(distinct) {
            self.positions[index.wrapping_add(1) as usize] = position;
        }
    }

    /// Returns the position of an index that was passed to [`Positions::set`].
    pub(super) fn of(&self, index: u32) -> u32 {
        self.positions[index.wrapping_add(1) as usize]
    }
}
