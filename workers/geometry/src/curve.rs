//! The Hilbert curve in the plane and in space, as tables of its orientations.
//!
//! **Statement.** An orientation has an entry corner `e` and an axis `d`. In this orientation, octant `l` (one bit for
//! each axis) has a position `w` on the curve. To obtain `w`, rotate the bits of `l ^ e` right by `d + 1`, then take the
//! inverse Gray code. Inside that octant, the curve has the entry corner `e ^ r` and the axis `d + turn(w) + 1`, where `r`
//! is `entry(w)` rotated left by `d + 1`.
//!
//! **Source.** Hamilton and Rau-Chaplin, "Compact Hilbert indices" (2008).
//!
//! **Work.** O(1) for each level.

/// Number of orientations, rounded up to a power of two. In space there are 8 entry corners and 3 axes.
pub(crate) const STATES: usize = 32;

/// For each orientation and two levels of octants, the position on the curve plus 64 times the orientation there.
pub(crate) static TWO_PLANE: [u16; STATES * 64] = two_levels(2);
/// As [`TWO_PLANE`], in space.
pub(crate) static TWO_SPACE: [u16; STATES * 64] = two_levels(3);

static ONE_PLANE: [u8; STATES * 8] = orientations(2);
static ONE_SPACE: [u8; STATES * 8] = orientations(3);

/// An orientation of the curve in a cell of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Orientation(u8);

impl Orientation {
    /// Returns the position of an octant on the curve, and the orientation inside the octant. Bit `i` of the octant is set
    /// in the upper half of axis `i`.
    #[inline]
    pub(crate) fn enter(self, dimension: usize, octant: u8) -> (u8, Orientation) {
        let table = if dimension == 2 { &ONE_PLANE } else { &ONE_SPACE };
        let step = table[usize::from(self.0 << 3 | octant & 7) % (STATES * 8)];
        (step & 7, Orientation(step >> 3))
    }
}

const fn two_levels(n: u32) -> [u16; STATES * 64] {
    let (one, mut table) = (orientations(n), [0; STATES * 64]);
    let mut state = 0;
    while state < n << n {
        let mut octants = 0;
        while octants < 1 << (2 * n) {
            let outer = one[(state << 3 | octants >> n) as usize] as u16;
            let inner = one[(outer & !7) as usize | (octants & ((1 << n) - 1)) as usize] as u16;
            table[(state << 6 | octants) as usize] = inner >> 3 << 6 | (outer & 7) << n | inner & 7;
            octants += 1;
        }
        state += 1;
    }
    table
}

/// Returns, for each orientation and octant, the position on the curve plus 8 times the orientation there.
const fn orientations(n: u32) -> [u8; STATES * 8] {
    let mut table = [0; STATES * 8];
    let mut state = 0;
    while state < n << n {
        let (entry, axis) = (state % (1 << n), state >> n);
        let mut octant = 0;
        while octant < 1 << n {
            let position = gray_inverse(n, rotated(n, octant ^ entry, n - (axis + 1) % n));
            let first = if position == 0 { 0 } else { gray((position - 1) & !1) };
            let inner = entry ^ rotated(n, first, axis + 1);
            let along = (axis + along_axis(n, position) + 1) % n;
            table[(state << 3 | octant) as usize] = ((along << n | inner) << 3 | position) as u8;
            octant += 1;
        }
        state += 1;
    }
    table
}

const fn gray(x: u32) -> u32 {
    x ^ x >> 1
}

const fn gray_inverse(n: u32, x: u32) -> u32 {
    let mut position = x;
    let mut shift = 1;
    while shift < n {
        position ^= x >> shift;
        shift += 1;
    }
    position
}

/// Rotates the `n` bits of `x` left by `by`.
const fn rotated(n: u32, x: u32, by: u32) -> u32 {
    let by = by % n;
    (x << by | x >> (n - by)) & ((1 << n) - 1)
}

/// Returns the axis along which the curve runs inside the octant at this position.
const fn along_axis(n: u32, position: u32) -> u32 {
    if position == 0 {
        0
    } else if position.is_multiple_of(2) {
        (position - 1).trailing_ones() % n
    } else {
        position.trailing_ones() % n
    }
}
