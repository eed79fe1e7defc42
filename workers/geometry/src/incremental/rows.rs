//! Conversion of a triangulation to rows of vertices and neighbours of selected cells.
//!
//! **Statement.** Row `i` belongs to the `i`-th kept cell in the order of slots. Its neighbours are indices of rows, or
//! marks for cells without a row.
//!
//! **Work.** O(slots), in place.

use super::cells::Cell;
use super::triangulation::Incremental;
use crate::complex::NONE;
use crate::point::{Point, Simplex};

/// The set of kept cells: one bit for each slot.
#[derive(Clone, Debug, Default)]
pub struct KeptCells {
    /// One bit for each slot, set if its cell is kept.
    bits: Vec<u64>,
    /// One bit for each slot, set if its cell belongs to the exterior.
    outer: Vec<u64>,
}

impl KeptCells {
    /// Creates an empty set for `slots` slots.
    pub fn of(slots: u32) -> Self {
        let words = slots.div_ceil(u64::BITS) as usize;
        KeptCells { bits: vec![0; words], outer: vec![0; words] }
    }

    /// Adds the cell in a slot.
    #[inline]
    pub fn keep(&mut self, slot: u32) {
        let (word, bit) = word_and_bit(slot);
        self.bits[word] |= bit;
    }

    /// Adds the cell in slot `64 * word + i` for each bit `i` of `bits` that is set.
    #[inline]
    pub fn keep_word(&mut self, word: usize, bits: u64) {
        self.bits[word] |= bits;
    }

    /// Marks the cell in a slot as exterior.
    #[inline]
    pub fn mark_outer(&mut self, slot: u32) {
        let (word, bit) = word_and_bit(slot);
        self.outer[word] |= bit;
    }

    /// Returns the number of kept cells.
    pub fn len(&self) -> u32 {
        self.bits.iter().map(|bits| bits.count_ones()).sum()
    }

    /// Returns `true` if no cell is kept.
    pub fn is_empty(&self) -> bool {
        self.bits.iter().all(|&bits| bits == 0)
    }

    /// Calls `f` with the slots of all kept cells, in ascending order.
    #[inline]
    fn each_slot(&self, mut f: impl FnMut(usize)) {
        for (word, &bits) in self.bits.iter().enumerate() {
            let mut rest = bits;
            while rest != 0 {
                f(word * u64::BITS as usize + rest.trailing_zeros() as usize);
                rest &= rest - 1;
            }
        }
    }
}

/// Indices of kept cells, counted in the order of slots. The tables have only a few bits for each cell, so they fit in
/// the cache of a core.
struct RowIndices<'a> {
    kept: &'a KeptCells,
    /// For each word of which all cells are kept, the index of its first cell; [`NONE`] for other words.
    full: Vec<u32>,
    /// For each word, the number of kept cells before it.
    before: Vec<u32>,
    marks: [u32; 2],
}

impl<'a> RowIndices<'a> {
    fn of(kept: &'a KeptCells, marks: [u32; 2]) -> Self {
        let (mut full, mut before) =
            (Vec::with_capacity(kept.bits.len()), Vec::with_capacity(kept.bits.len()));
        let mut count = 0;
        for &bits in &kept.bits {
            full.push(if bits == u64::MAX { count } else { NONE });
            before.push(count);
            count += bits.count_ones();
        }
        RowIndices { kept, full, before, marks }
    }

    /// Returns the index of the cell in a slot. If the cell is not kept, returns a mark: the second if the cell is
    /// exterior, otherwise the first.
    #[inline]
    fn index(&self, slot: u32) -> u32 {
        let full = self.full[(slot / u64::BITS) as usize];
        if full == NONE { self.in_partial_word(slot) } else { full + slot % u64::BITS }
    }

    /// Computes [`RowIndices::index`] for a word of which not all cells are kept.
    #[inline]
    fn in_partial_word(&self, slot: u32) -> u32 {
        let (word, bit) = word_and_bit(slot);
        let bits = self.kept.bits[word];
        if bits & bit != 0 {
            self.before[word] + (bits & (bit - 1)).count_ones()
        } else {
            self.marks[usize::from(self.kept.outer[word] & bit != 0)]
        }
    }
}

/// The smallest mark of [`Incremental::into_rows`]. No cell index has this bit.
pub const FIRST_MARK: u32 = 1 << 31;

/// Returns the word of a slot's bit, and the bit as a mask.
#[inline]
fn word_and_bit(slot: u32) -> (usize, u64) {
    ((slot / u64::BITS) as usize, 1 << (slot % u64::BITS))
}

/// Applies `f` to all entries of a simplex.
#[inline]
fn converted<S: Simplex>(mut simplex: S, f: impl Fn(u32) -> u32) -> S {
    for entry in simplex.as_mut() {
        *entry = f(*entry);
    }
    simplex
}

impl<P: Point> Incremental<P> {
    /// Returns the storage of the cells.
    fn into_slots(self) -> Vec<Cell<P::Cell>> {
        self.cells.slots
    }

    /// Converts the storage to rows of `2 (DIM + 1)` numbers, one row for each kept cell in the order of slots. The
    /// first half of a row has the cell's vertices, converted by `vertex`. The second half has, for each vertex, the
    /// index of the cell across the opposite facet or one of two marks. The first mark denotes a cell that is not
    /// kept, the second an exterior cell. Marks are at least [`FIRST_MARK`], above all indices. Also returns the
    /// indices of the rows that have a mark.
    ///
    /// **Work.** O(cells), in place. Rows are shorter than cells, so every cell is read before it is overwritten.
    pub fn into_rows(
        self,
        kept: &KeptCells,
        marks: [u32; 2],
        vertex: impl Fn(u32) -> u32,
    ) -> (Vec<u32>, Vec<u32>) {
        debug_assert!(marks.iter().all(|&mark| mark >= FIRST_MARK), "a mark could be a number");
        let indices = RowIndices::of(kept, marks);
        let mut marked = Vec::new();
        // The storage as simplices: a cell has three, and a row has two.
        let mut simplices: Vec<P::Cell> = bytemuck::cast_vec(self.into_slots());
        let mut row = 0;
        kept.each_slot(|slot| {
            let first = 3 * slot;
            let cell: Cell<P::Cell> =
                bytemuck::cast([simplices[first], simplices[first + 1], simplices[first + 2]]);
            let neighbours = converted(*cell.neighbours(), |code| indices.index(code >> 2));
            simplices[2 * row] = converted(*cell.vertices(), &vertex);
            simplices[2 * row + 1] = neighbours;
            if neighbours.as_ref().iter().fold(0, |all, next| all | next) >= FIRST_MARK {
                marked.push(row as u32);
            }
            row += 1;
        });
        simplices.truncate(2 * row);
        simplices.shrink_to_fit();
        let words = bytemuck::cast_vec(simplices);
        (words, marked)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Incremental;
    use super::{KeptCells, RowIndices};
    use glam::DVec2;

    /// Covers words of which all, some or no cells are kept, and an incomplete word.
    #[test]
    fn indices_count_the_kept_cells_before() {
        let is_kept = |slot: u32| match slot / 64 {
            0 | 3 => true,
            1 => slot % 3 == 1,
            2 => false,
            4 => slot % 64 != 63,
            _ => slot.is_multiple_of(2),
        };
        let slots = 6 * 64 + 37;
        let mut kept = KeptCells::of(slots);
        kept.keep_word(0, u64::MAX);
        kept.keep_word(3, u64::MAX);
        for slot in (0..slots).rev() {
            if is_kept(slot) {
                if slot >= 4 * 64 || slot / 64 == 1 {
                    kept.keep(slot);
                }
            } else if slot % 5 == 0 {
                kept.mark_outer(slot);
            }
        }
        let marks = [u32::MAX - 1, u32::MAX];
        let indices = RowIndices::of(&kept, marks);
        let mut count = 0;
        for slot in 0..slots {
            let expected = if is_kept(slot) { count } else { marks[usize::from(slot % 5 == 0)] };
            assert_eq!(indices.index(slot), expected, "{slot}");
            count += u32::from(is_kept(slot));
        }
        assert_eq!((kept.len(), kept.is_empty()), (count, false));
        let mut all = Vec::new();
        kept.each_slot(|slot| all.push(slot as u32));
        assert_eq!(all, (0..slots).filter(|&slot| is_kept(slot)).collect::<Vec<_>>());
    }

    #[test]
    fn rows_keep_order_and_adjacency() {
        let points: Vec<DVec2> =
            (0..40u32).map(|i| DVec2::new(f64::from(i * 37 % 41), f64::from(i * i % 43))).collect();
        let delaunay = Incremental::new(points).unwrap();
        let complex = delaunay.complex();
        let mut kept = KeptCells::of(complex.slots());
        let mut expected = Vec::new();
        // One finite cell is omitted: a hole between the exterior and the rest.
        let without = complex.live_cells().filter(|&slot| !complex.is_infinite(slot)).nth(20).unwrap();
        for (slot, vertices, _) in complex.entries() {
            if complex.is_infinite(slot) {
                kept.mark_outer(slot);
            } else if slot != without {
                kept.keep(slot);
                expected.push(vertices.map(|v| v + 100));
            }
        }
        assert_eq!(kept.len() as usize, expected.len());
        for word in 0..complex.slots().div_ceil(u64::BITS) {
            let (live, passing) = delaunay.masks(word as usize, |vertices| vertices[0] % 3 == 0);
            for (i, slot) in (word * u64::BITS..).take(64).enumerate() {
                let is_live = slot < complex.slots() && complex.is_live(slot);
                assert_eq!(live >> i & 1 == 1, is_live);
                let passes = slot < complex.slots() && complex.cell(slot)[0].is_multiple_of(3);
                assert_eq!(passing >> i & 1 == 1, passes);
            }
        }
        let marks = [u32::MAX - 1, u32::MAX];
        let (rows, marked) = delaunay.clone().into_rows(&kept, marks, |v| v + 100);
        assert_eq!(rows.len(), 6 * expected.len());
        for (row, vertices) in rows.chunks_exact(6).zip(&expected) {
            assert_eq!(row[..3], vertices[..]);
        }
        let across = |mark: u32| rows.chunks_exact(6).flat_map(|r| &r[3..]).filter(|&&n| n == mark).count();
        let hull = complex.live_cells().filter(|&slot| complex.is_infinite(slot)).count();
        let open = (0..3).filter(|&i| complex.is_infinite(complex.neighbour(without, i).0)).count();
        assert_eq!((across(marks[0]), across(marks[1])), (3 - open, hull - open));
        let is_marked = |row: &[u32]| row[3..].iter().any(|&n| n >= marks[0]);
        let expected: Vec<u32> =
            (0..).zip(rows.chunks_exact(6)).filter(|(_, row)| is_marked(row)).map(|(at, _)| at).collect();
        assert_eq!(marked, expected);
        for (at, row) in (0u32..).zip(rows.chunks_exact(6)) {
            for &next in row[3..].iter().filter(|&&n| n < marks[0]) {
                let back = &rows[next as usize * 6..][..6];
                assert!(back[3..].contains(&at));
                assert_eq!(row[..3].iter().filter(|v| back[..3].contains(v)).count(), 2);
            }
        }
    }
}
