//! Cuts of a Hilbert curve: the baseline of codes that divide points into blocks along a space-filling curve.
//!
//! **Statement.** A cube is divided into `2^(d L)` cells, which a Hilbert curve visits in turn. A cut is a position on the
//! curve. The cells before it are interior, the others exterior. A point belongs to the cell that contains it, and a point
//! outside the cube to the nearest cell. If all cuts of a tree use one cube, the leaves are blocks of consecutive cells.
//!
//! **Ball test.** The path of a cut is the chain of nested octants that contain its cell. Each octant beside the path
//! lies wholly on one side, and the cell of the cut is exterior. So a box contains cells of a side iff it meets an octant
//! of this side, or, for the exterior side, the cell of the cut. The test is for the box of the ball. It may report a
//! crossing that does not exist, but never misses one: the index of a cell is a monotone function of the coordinate, and
//! the ends of the box are rounded outwards.
//!
//! **Source.** Curve: Hamilton and Rau-Chaplin, "Compact Hilbert indices" (2008). Partition: Warren and Salmon, "A parallel
//! hashed oct-tree n-body algorithm" (1993).
//!
//! **Work and depth.** O(L) operations for a test, charged as one like the test of a surface: `L` is at most
//! [`LEVELS_OF_PLANE`], the bits of a word.

use std::cmp::Ordering;

use super::surface::{Side, places};
use crate::curve::Orientation;
use crate::point::{Array, Point};

/// Number of levels of cells in the plane.
const LEVELS_OF_PLANE: u32 = 52;
/// Number of levels of cells in space.
const LEVELS_OF_SPACE: u32 = 34;
/// Number of bits of a position on the curve in one word of a message.
const BITS_OF_WORD: u32 = 52;
/// Largest absolute exponent of the side of a cube.
const MOST_EXPONENT: i32 = 512;

const fn levels<P: Point>() -> u32 {
    if P::DIM == 2 { LEVELS_OF_PLANE } else { LEVELS_OF_SPACE }
}

/// The cube that a Hilbert curve fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveCube<P> {
    low: P,
    /// A power of two.
    side: f64,
}

/// Indices of a cell along the axes.
type Cell = [u64; 3];

impl<P: Point> CurveCube<P> {
    /// Creates a cube around a box. Returns `None` if the box is a point, or exceeds the range of cubes.
    pub(super) fn around(low: P, high: P) -> Option<Self> {
        let extent = (0..P::DIM).map(|i| high.coord(i) - low.coord(i)).fold(0.0, f64::max);
        let exponent = (extent.to_bits() >> 52) as i32 - 1023 + 1;
        let fits = extent > 0.0 && extent.is_finite() && exponent.abs() <= MOST_EXPONENT;
        fits.then(|| CurveCube { low, side: f64::from_bits(((exponent + 1023) as u64) << 52) })
    }

    /// Returns the number of cells along one unit of length.
    fn scale(&self) -> f64 {
        (1u64 << levels::<P>()) as f64 / self.side
    }

    #[inline]
    fn cell(&self, x: P) -> Cell {
        let (scale, last) = (self.scale(), (1u64 << levels::<P>()) - 1);
        let mut cell = [0; 3];
        for (i, at) in cell.iter_mut().enumerate().take(P::DIM) {
            // The cast takes a negative number to 0.
            *at = (((x.coord(i) - self.low.coord(i)) * scale) as u64).min(last);
        }
        cell
    }

    /// Returns the position of a point on the curve.
    pub(super) fn position(&self, x: P) -> u128 {
        let (cell, mut position, mut orientation) = (self.cell(x), 0, Orientation::default());
        for level in (0..levels::<P>()).rev() {
            let (digit, inner) = orientation.enter(P::DIM, octant(&cell, level));
            (position, orientation) = (position << P::DIM | u128::from(digit), inner);
        }
        position
    }
}

/// Returns the octant of a cell on a level; bit `i` is that of axis `i`.
#[inline]
fn octant(cell: &Cell, level: u32) -> u8 {
    cell.iter().enumerate().fold(0, |octant, (i, at)| octant | ((at >> level & 1) as u8) << i)
}

/// A cut of a Hilbert curve. The cells before a position on the curve are interior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveCut<P> {
    cube: CurveCube<P>,
    /// The first exterior position, above 0.
    position: u128,
}

impl<P: Point> CurveCut<P> {
    /// Creates a cut between two positions on the curve, of which the first is smaller. Among all such cuts it has the
    /// shortest path.
    pub(super) fn between(cube: CurveCube<P>, before: u128, after: u128) -> Self {
        let shift = (before ^ after).max(1).ilog2();
        CurveCut { cube, position: after >> shift << shift }
    }

    /// Returns the cube of the curve.
    pub fn cube(&self) -> CurveCube<P> {
        self.cube
    }

    /// Returns the octant's position on the curve at a level of the path.
    #[inline]
    fn digit(&self, level: u32) -> u8 {
        (self.position >> (level * P::DIM as u32)) as u8 & ((1 << P::DIM) - 1)
    }

    /// Returns `true` if the cut is the start of its octant at a level of the path, so the whole octant is exterior.
    #[inline]
    fn ends_at(&self, level: u32) -> bool {
        self.position & ((1 << (level * P::DIM as u32)) - 1) == 0
    }

    /// Returns the side of a point.
    #[inline]
    pub fn side(&self, x: P) -> Side {
        let (cell, mut orientation) = (self.cube.cell(x), Orientation::default());
        for level in (0..levels::<P>()).rev() {
            let (digit, inner) = orientation.enter(P::DIM, octant(&cell, level));
            match digit.cmp(&self.digit(level)) {
                Ordering::Less => return Side::Interior,
                Ordering::Greater => return Side::Exterior,
                Ordering::Equal if self.ends_at(level) => return Side::Exterior,
                Ordering::Equal => orientation = inner,
            }
        }
        Side::Exterior
    }

    /// Returns `true` if the closed ball may contain a point of the given side. It also returns `true` if the radius is
    /// infinite or NaN. `radius` may be too small by 8 unit roundoffs, as for [`super::Separator::crosses`].
    pub fn reaches(&self, x: P, radius: f64, side: Side) -> bool {
        let (mut low, mut high) = (x, x);
        let wide = radius.max(0.0) * (1.0 + 8.0 * f64::EPSILON);
        for i in 0..P::DIM {
            low.set_coord(i, (x.coord(i) - wide).next_down());
            high.set_coord(i, (x.coord(i) + wide).next_up());
        }
        !radius.is_finite() || self.meets(side, self.cube.cell(low), self.cube.cell(high))
    }

    /// Returns `true` if the cells from `low` to `high` contain one of the given side.
    fn meets(&self, side: Side, mut low: Cell, mut high: Cell) -> bool {
        let wanted = if side == Side::Interior { Ordering::Less } else { Ordering::Greater };
        let mut orientation = Orientation::default();
        for level in (0..levels::<P>()).rev() {
            let (half, digit) = (1u64 << level, self.digit(level));
            let mut path = None;
            for octant in met_octants::<P>(half, &low, &high) {
                let (position, inner) = orientation.enter(P::DIM, octant);
                match position.cmp(&digit) {
                    Ordering::Equal => path = Some((octant, inner)),
                    other if other == wanted => return true,
                    _ => {}
                }
            }
            let Some((octant, inner)) = path else { return false };
            if self.ends_at(level) {
                break;
            }
            for i in 0..P::DIM {
                (low[i], high[i]) = if octant >> i & 1 == 1 {
                    (low[i].saturating_sub(half), high[i] - half)
                } else {
                    (low[i], high[i].min(half - 1))
                };
            }
            orientation = inner;
        }
        side == Side::Exterior
    }

    /// Returns the radius of a ball around `x` that does not reach the other side: nine tenths of the distance to it along
    /// the nearest axis. Returns 0 if [`CurveCut::reaches`] does not confirm the radius.
    pub fn clearance(&self, x: P) -> f64 {
        let other = self.side(x).opposite();
        // The difference of two indices may exceed the distance by up to one cell.
        let cells = self.distance(self.cube.cell(x), other).saturating_sub(1);
        let radius = 0.9 * cells as f64 / self.cube.scale();
        if self.reaches(x, radius, other) { 0.0 } else { radius }
    }

    /// Returns the distance of a cell from the nearest cell of the given side: the largest difference of indices.
    fn distance(&self, cell: Cell, side: Side) -> u64 {
        let wanted = if side == Side::Interior { Ordering::Less } else { Ordering::Greater };
        let (mut corner, mut nearest, mut orientation) = ([0u64; 3], u64::MAX, Orientation::default());
        for level in (0..levels::<P>()).rev() {
            let (half, digit, mut path) = (1u64 << level, self.digit(level), None);
            for octant in 0..1u8 << P::DIM {
                let start: Cell = std::array::from_fn(|i| corner[i] + u64::from(octant >> i & 1) * half);
                let away = distance_to_cube::<P>(&cell, &start, half);
                let (position, inner) = orientation.enter(P::DIM, octant);
                match position.cmp(&digit) {
                    Ordering::Equal => path = Some((start, inner, away)),
                    other if other == wanted => nearest = nearest.min(away),
                    _ => {}
                }
            }
            let Some((start, inner, away)) = path else { return nearest };
            if side == Side::Exterior && self.ends_at(level) {
                return nearest.min(away);
            }
            if away >= nearest || self.ends_at(level) {
                return nearest;
            }
            (corner, orientation) = (start, inner);
        }
        nearest
    }

    /// Encodes the cut in the words of a separator. The negative unit distinguishes it from a surface.
    pub(super) fn to_array(self) -> P::SeparatorWords {
        let n = places::<P>();
        let mut words = P::SeparatorWords::from_fn(|_| 0.0);
        let out = words.as_mut();
        for (i, word) in out.iter_mut().enumerate().take(P::DIM) {
            *word = self.cube.low.coord(i);
        }
        let mask = (1 << BITS_OF_WORD) - 1;
        out[n] = -self.cube.side;
        out[n + 1] = ((self.position >> BITS_OF_WORD) & mask) as f64;
        out[2 * n + 2] = (self.position & mask) as f64;
        words
    }

    /// Decodes [`CurveCut::to_array`]. Returns `None` unless the cube and the position are valid, and above three dimensions,
    /// where there is no curve.
    pub(super) fn from_array(words: &[f64]) -> Option<Self> {
        let n = places::<P>();
        if words.len() != 2 * n + 3 || P::DIM > 3 {
            return None;
        }
        let (low, side) = (P::from_coords(&words[..n]), -words[n]);
        let exponent = (side.to_bits() >> 52) as i32 - 1023;
        let power = side > 0.0 && side.to_bits().trailing_zeros() >= 52 && exponent.abs() <= MOST_EXPONENT;
        let whole = |word: f64| {
            let fits = (0.0..(1u64 << BITS_OF_WORD) as f64).contains(&word) && word.fract() == 0.0;
            fits.then_some(word as u128)
        };
        let position = whole(words[n + 1])? << BITS_OF_WORD | whole(words[2 * n + 2])?;
        let inside = position > 0 && position >> (levels::<P>() * P::DIM as u32) == 0;
        let finite = words.iter().all(|w| w.is_finite());
        (finite && power && inside).then_some(CurveCut { cube: CurveCube { low, side }, position })
    }
}

/// Returns the octants of a cube that a box of cells meets. The halves of the cube have `half` cells along an axis, and the
/// box is relative to the cube.
#[inline]
fn met_octants<P: Point>(half: u64, low: &Cell, high: &Cell) -> impl Iterator<Item = u8> {
    let (mut lower, mut upper) = (0u8, 0u8);
    for i in 0..P::DIM {
        lower |= u8::from(low[i] < half) << i;
        upper |= u8::from(high[i] >= half) << i;
    }
    let all = (1u8 << P::DIM) - 1;
    (0..=all).filter(move |octant| octant & !upper == 0 && !octant & all & !lower == 0)
}

/// Returns the distance of a cell from the nearest cell of a cube of cells.
fn distance_to_cube<P: Point>(cell: &Cell, start: &Cell, size: u64) -> u64 {
    let along = |i: usize| start[i].saturating_sub(cell[i]).max(cell[i].saturating_sub(start[i] + size - 1));
    (0..P::DIM).map(along).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::super::tests::{key, nasty, ratio, uniform};
    use super::super::{DrawKind, Separator, cut_curve, split_bound};
    use super::*;
    use crate::cost::Cost;

    /// Draws a cut from all points, below a cut of the given cube.
    fn cut_of<P: Point>(above: Option<CurveCube<P>>, points: &[P]) -> Separator<P> {
        cut_curve(key(1), above, points, &mut Cost::default()).separator.unwrap()
    }

    /// The side of a point tells whether its position is before the cut.
    fn sides_follow_positions<P: Point>() {
        let points = uniform::<P>(3000, 5);
        let Separator::Curve(cut) = cut_of(None, &points) else { panic!("no cut of a curve") };
        let before = |x: &P| cut.cube.position(*x) < cut.position;
        assert!(points.iter().all(|x| (cut.side(*x) == Side::Interior) == before(x)));
        assert_eq!(points.iter().filter(|x| before(x)).count(), 1500);
        // Points outside the cube belong to its nearest cell.
        let far = points.iter().map(|&x| (x - P::splat(0.5)) * 1e9);
        assert!(far.clone().all(|x| (cut.side(x) == Side::Interior) == before(&x)));
    }

    #[test]
    fn sides_follow_positions_in_both_dimensions() {
        sides_follow_positions::<DVec2>();
        sides_follow_positions::<DVec3>();
    }

    /// By brute force over all pairs: a ball that contains a point of the other side crosses; most of the others do not;
    /// and balls of the clearance never cross.
    fn crossings_are_found<P: Point>() {
        let points = uniform::<P>(400, 9);
        let (mut found, mut false_alarms, mut clear) = (0, 0, 0);
        for part in [&points[..], &points[..7], &points[100..140]] {
            let cut = cut_of(None, part);
            for &x in &points {
                let side = cut.side(x);
                for &z in &points {
                    let radius = crate::point::dist2(x, z).sqrt();
                    if cut.side(z) != side {
                        assert!(cut.crosses(x, radius) && cut.reaches(x, radius, side.opposite()));
                        found += 1;
                    }
                }
                let free = cut.clearance(x);
                assert!(free == 0.0 || !cut.crosses(x, free));
                assert!(
                    points.iter().all(|&z| cut.side(z) == side || crate::point::dist2(x, z) > free * free)
                );
                clear += usize::from(free > 0.0);
                false_alarms += usize::from(cut.crosses(x, 1e-6));
                assert!(
                    cut.crosses(x, f64::INFINITY) && cut.crosses(x, f64::NAN) && cut.reaches(x, 0.0, side)
                );
            }
        }
        assert!(found > 10_000 && clear > 1000 && false_alarms < 8, "{found} {clear} {false_alarms}");
    }

    #[test]
    fn crossings_are_found_in_both_dimensions() {
        crossings_are_found::<DVec2>();
        crossings_are_found::<DVec3>();
    }

    /// The cuts of one cube divide the points into blocks of consecutive cells.
    #[test]
    fn cuts_of_one_cube_are_nested() {
        let points = uniform::<DVec2>(1024, 2);
        let root = cut_of(None, &points);
        let inside: Vec<DVec2> = points.iter().copied().filter(|&x| root.side(x) == Side::Interior).collect();
        let below = cut_of(root.curve_cube(), &inside);
        assert_eq!(below.curve_cube(), root.curve_cube());
        assert!(points.iter().all(|&x| below.side(x) == Side::Exterior || root.side(x) == Side::Interior));
    }

    fn nasty_sets_are_cut<P: Point>() {
        for (name, points) in nasty::<P>() {
            let drawn = cut_curve(key(3), None, &points, &mut Cost::default());
            let Some(s) = drawn.separator else { panic!("{name}: {drawn:?}") };
            assert!((ratio(&s, &points) - drawn.estimated_ratio).abs() < 1e-12, "{name}");
            assert_eq!(Separator::from_array(s.to_array().as_ref()), Some(s), "{name}");
            assert!(drawn.kind != DrawKind::Curve || drawn.estimated_ratio <= split_bound::<P>(), "{name}");
        }
        let one = vec![P::splat(1.0); 9];
        assert_eq!(cut_curve(key(1), None, &one, &mut Cost::default()).separator, None);
        assert_eq!(cut_curve(key(1), None, &one[..0], &mut Cost::default()).separator, None);
    }

    /// Most points of a geometric progression share a cell of any cube around them. A plane halves them.
    #[test]
    fn crowded_cells_are_cut_by_planes() {
        let points: Vec<DVec3> = (0..=400).map(|k| DVec3::splat(2f64.powi(-k))).collect();
        let drawn = cut_curve(key(1), None, &points, &mut Cost::default());
        assert!(matches!(drawn.kind, DrawKind::Plane { .. }) && drawn.estimated_ratio < 0.51, "{drawn:?}");
    }

    #[test]
    fn nasty_sets_are_cut_in_both_dimensions() {
        nasty_sets_are_cut::<DVec2>();
        nasty_sets_are_cut::<DVec3>();
    }

    #[test]
    fn malformed_words_are_rejected() {
        let good = cut_of(None, &uniform::<DVec3>(50, 1)).to_array();
        assert!(Separator::<DVec3>::from_array(&good).is_some());
        for (slot, value) in
            [(3, -3.0), (3, -1e300), (0, f64::NAN), (4, 0.5), (4, -1.0), (8, 1e300), (4, 2e15)]
        {
            let mut bad = good;
            bad[slot] = value;
            assert_eq!(Separator::<DVec3>::from_array(&bad), None, "{slot} {value}");
        }
    }
}
