//! The part of a result that only runs in periodic boxes have.

use septet_workers::config::cores::sort_rows;

/// A vector of whole numbers of lengths of a box; 0 in the third place in the plane.
pub(crate) type Steps = [i32; 3];

/// A vertex of a cell: a row, and the number of lengths from its base site.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Vertex {
    pub(crate) row: u32,
    pub(crate) steps: Steps,
}

/// Number of bits of the steps along one axis.
const BITS: u32 = 8;

impl Vertex {
    /// Packs the vertex into a number with the same order. Steps are smaller than 128.
    pub(crate) fn pack(self) -> u64 {
        let steps =
            self.steps.iter().fold(0, |word, &steps| word << BITS | (steps + (1 << (BITS - 1))) as u64);
        u64::from(self.row) << 32 | steps
    }

    pub(crate) fn unpack(word: u64) -> Self {
        let mask = (1 << BITS) - 1;
        let along = |axis: u32| ((word >> (BITS * (2 - axis))) & mask) as i32 - (1 << (BITS - 1));
        Vertex { row: (word >> 32) as u32, steps: [along(0), along(1), along(2)] }
    }
}

/// Subtracts numbers of lengths.
pub(crate) fn difference(a: Steps, b: Steps) -> Steps {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// The cells of a periodic triangulation, and what they form.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PeriodicCells {
    /// Whether the triangulation is a simplicial complex: no site is joined to its own image, and no two sites are joined
    /// twice.
    pub is_simplicial: bool,
    /// The smallest number of boxes along each axis whose triangulation is a simplicial complex: by their product, then in
    /// lexicographic order. At most 3 along each axis; 1 along axes that are not periodic.
    pub sheets: Vec<u32>,
    /// Number of images of sites that the machine triangulated besides the sites.
    pub images: u64,
    /// Number of coordinates.
    space: usize,
    /// The packed vertices of all cells, in canonical order.
    packed: Vec<u64>,
    /// The numbers of lengths from each row to its base site. Empty if they are 0.
    steps: Vec<Steps>,
}

impl PeriodicCells {
    /// Collects packed cells.
    pub(crate) fn new(mut packed: Vec<u64>, steps: Vec<Steps>, space: usize) -> Self {
        sort_rows(&mut packed, space + 1);
        PeriodicCells { is_simplicial: false, sheets: Vec::new(), images: 0, space, packed, steps }
    }

    /// Returns the number of cells.
    pub fn count(&self) -> usize {
        self.packed.len() / (self.space + 1)
    }

    /// Returns the rows of the vertices of all cells, in canonical order.
    pub fn rows(&self) -> Vec<u64> {
        self.packed.iter().map(|&word| u64::from(Vertex::unpack(word).row)).collect()
    }

    /// Returns the offset of each vertex of the cells in canonical order: `space` whole numbers of lengths. The vertex lies
    /// at the point of its row plus the offset times the box. The first vertex of a cell has the offset 0.
    pub fn offsets(&self) -> Vec<i32> {
        let mut offsets = Vec::with_capacity(self.packed.len() * self.space);
        let own = |row: u32| self.steps.get(row as usize).copied().unwrap_or_default();
        for cell in self.packed.chunks_exact(self.space + 1) {
            let first = own(Vertex::unpack(cell[0]).row);
            for &word in cell {
                let Vertex { row, steps } = Vertex::unpack(word);
                let more = difference(own(row), first);
                offsets.extend((0..self.space).map(|axis| steps[axis] + more[axis]));
            }
        }
        offsets
    }
}
