//! Rows of different lengths in two arrays.

/// Rows of different lengths: row `i` is `indices[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Ragged {
    /// The position of the first entry of each row, and the number of all entries.
    pub offsets: Vec<u64>,
    /// The entries of all rows.
    pub indices: Vec<u32>,
}

impl Default for Ragged {
    fn default() -> Self {
        Ragged { offsets: vec![0], indices: Vec::new() }
    }
}

impl Ragged {
    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns a row.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn row(&self, at: usize) -> &[u32] {
        &self.indices[self.offsets[at] as usize..self.offsets[at + 1] as usize]
    }

    /// Appends a row.
    pub(crate) fn push(&mut self, row: &[u32]) {
        self.indices.extend_from_slice(row);
        self.offsets.push(self.indices.len() as u64);
    }

    /// Appends the rows of another list.
    pub(crate) fn append(&mut self, other: &Ragged) {
        let base = self.indices.len() as u64;
        self.indices.extend_from_slice(&other.indices);
        self.offsets.extend(other.offsets[1..].iter().map(|end| base + end));
    }
}
