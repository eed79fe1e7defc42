//! The facets of a link as planes among inverted points: the rounded test of a candidate.
//!
//! **Statement.** Inversion in the unit sphere around the centre takes the spheres through the centre to
//! planes, and their insides to the far sides; infinity goes to the centre itself. So the facets that a
//! candidate conflicts with are those that its inverse image lies beyond, and the link is the convex hull of
//! the inverse images and the origin (Brown 1979). A hull facet is a plane through the origin and no special
//! case. With the images `a, b, c` of a facet,
//! `n = (b - a) x (c - a)` (in the plane `b - a` turned) and `g = n . a`, an image `k` is beyond iff
//! `n . k > g`.
//!
//! **Error bound.** Images carry a relative error of at most `8 u` each, `u = 2^-53` (a difference 1, a squared
//! length 5, a reciprocal and a product 1 each). Let `a` be the base, `B = max(|a|, |b|)`, `C = max(|a|, |c|)`.
//! Then `b - a` and `c - a` are at most `2 B` and `2 C` long and wrong by `18 u B` and `18 u C`; `n` is wrong by
//! `84 u B C`, of which `12` is the rounding of the product; `n . a` by `(84 + 32 + 12) u B C |a|` and `n . k` by
//! as much with `|k|` for `|a|`. So the sign of `n . k - g` is certain beyond `136 u B C (|a| + |k|)`, which
//! covers the roundings of the bound itself and of `g` with the bound added. In the plane all is smaller, and
//! `C` is 1. Since candidates come in order of distance, images come in falling order of length, and the
//! longest to come, which is that of the latest candidate, can stand for `|k|`: the bound is one number for
//! each facet. With that candidate as the base it is in proportion to the product of the facet's three
//! lengths, which keeps it small for facets with one near and two far vertices. The first facets are made
//! before some nearer candidates come: there the longest image of all stands for `|k|`.
//!
//! If `|n| |k| < g - bound`, no candidate from `k` on is beyond: the facet is *out of reach*. When all are, the
//! rest of the candidates need not be looked at. The square of the reach is computed in products that cannot
//! overflow in the range that [`crate::range`] admits, and made smaller by more than its rounding.
//!
//! **In single precision first.** With `v = 2^-24`, a product of a normal and an image, both rounded to single
//! precision and multiplied there, passes five roundings a term: it is wrong by at most `5 v |n| |k|`, and the
//! threshold, when it is rounded, by `v` of itself. As `|n| <= 4 B C`, a rounded product below
//! `g - (136 u + 24 v) B C (|a| + |k|)` belongs to an exact one below `g - 136 u B C (|a| + |k|)`: the facet is clear.
//! Only the others are looked at in double precision. All is multiplied by the power of two that makes the longest
//! image about 1 long, so that nothing overflows; what falls among single precision's subnormals loses less than
//! `2^-144` altogether, and the threshold is lowered by `2^-140`. A product that is no number is looked at, too.
//!
//! **Departures.** Eight facets at a time, in columns: the loop has no branches and uses vector registers.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

use crate::point::Point;
use crate::simd::{Masks, each_bit, larger};

/// `136 u`.
const UNIT: f64 = 136.0 * (f64::EPSILON / 2.0);

/// `24 v`.
const SINGLE: f64 = 24.0 * (f32::EPSILON as f64 / 2.0);

/// `2^-140`.
const SUBNORMAL: f64 = f64::from_bits((1023 - 140) << 52);

/// What the squared reach loses to be certain: more than 16 roundings.
const SURE: f64 = 1.0 - 32.0 * f64::EPSILON;

/// The image of a point under inversion in the unit sphere around the centre.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Image<P> {
    pub(super) at: P,
    /// Its distance from the centre.
    pub(super) length: f64,
}

impl<P: Point> Image<P> {
    /// Of a point by its vector from the centre and the square of its length.
    #[inline]
    pub(super) fn of(rel: P, length2: f64) -> Self {
        let inverse2 = 1.0 / length2;
        Image { at: rel * inverse2, length: inverse2.sqrt() }
    }

    /// Of infinity: the centre.
    #[inline]
    pub(super) fn of_infinity() -> Self {
        Image { at: P::splat(0.0), length: 0.0 }
    }
}

/// Facets in one block.
const LANES: usize = 8;

type Lanes = [f32; LANES];

/// Eight facets in single precision.
#[derive(Clone, Copy, Debug)]
struct Block {
    normal: [Lanes; 3],
    /// Below this a product with the normal is certain not to be beyond the plane; infinite without a facet.
    low: Lanes,
}

const EMPTY: Block = Block { normal: [[0.0; LANES]; 3], low: [f32::INFINITY; LANES] };

/// A facet in double precision: asked only if single precision is not certain.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: [f64; 3],
    /// Below this a product with the normal is certain not to be beyond the plane; infinite without a facet.
    low: f64,
    /// Above this a product is certain to be beyond.
    high: f64,
}

const NO_PLANE: Plane = Plane { normal: [0.0; 3], low: f64::INFINITY, high: f64::INFINITY };

/// What rounded arithmetic says of a candidate and a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Conflict,
    Clear,
    Undecided,
    /// In conflict, and found on the way through the cavity.
    Dug,
}

/// The planes of all facets of a link, by the facets' numbers.
#[derive(Debug, Default)]
pub(super) struct Planes {
    masks: Masks,
    blocks: Vec<Block>,
    rows: Vec<Plane>,
    /// The squared length of the longest image from which on all are certain not to be beyond.
    reach2: Vec<f64>,
    /// The power of two, its square and its cube that images, normals and thresholds are multiplied by in single
    /// precision.
    scale: [f64; 3],
}

impl Planes {
    /// No facets. The longest image of all is this long.
    pub(super) fn clear(&mut self, longest: f64) {
        self.blocks.clear();
        self.rows.clear();
        self.reach2.clear();
        // The exponent turned round.
        let exponent = (longest.to_bits() >> 52) & 0x7ff;
        let scale = f64::from_bits((2046 - exponent.clamp(1, 2045)) << 52);
        self.scale = [scale, scale * scale, scale * scale * scale];
    }

    /// Makes room for facets of so many numbers, and for those that fill their last block; returns for how many.
    pub(super) fn make_room(&mut self, facets: usize) -> usize {
        let blocks = facets.div_ceil(LANES);
        if blocks > self.blocks.len() {
            self.blocks.resize(blocks, EMPTY);
            self.rows.resize(blocks * LANES, NO_PLANE);
            self.reach2.resize(blocks * LANES, f64::INFINITY);
        }
        blocks * LANES
    }

    /// No facet has this number, for the time being.
    pub(super) fn remove(&mut self, facet: u32) {
        self.blocks[facet as usize / LANES].low[facet as usize % LANES] = f32::INFINITY;
        self.rows[facet as usize].low = f64::INFINITY;
        self.reach2[facet as usize] = f64::INFINITY;
    }

    /// Enters a facet with these images, in positive order; `longest` bounds the lengths of those still to
    /// come.
    #[inline(always)]
    pub(super) fn set<P: Point>(&mut self, facet: u32, [a, b, c]: [&Image<P>; 3], longest: f64) {
        let facet = facet as usize;
        let normal = P::hull_normal(&[b.at - a.at, c.at - a.at][..P::DIM - 1]);
        let mut sizes = larger(a.length, b.length);
        if P::DIM == 3 {
            sizes *= larger(a.length, c.length);
        }
        // In the plane the turned vector points to the other side.
        let normal = if P::DIM == 3 { normal } else { normal * -1.0 };
        let unit = sizes * (a.length + longest);
        let bound = UNIT * unit;
        let height = normal.dot(a.at);
        let low = height - bound;
        let plane = &mut self.rows[facet];
        let block = &mut self.blocks[facet / LANES];
        let lane = facet % LANES;
        for axis in 0..P::DIM {
            plane.normal[axis] = normal.coord(axis);
            block.normal[axis][lane] = (normal.coord(axis) * self.scale[P::DIM - 2]) as f32;
        }
        (plane.low, plane.high) = (low, height + bound);
        block.low[lane] = ((low - SINGLE * unit) * self.scale[P::DIM - 1] - SUBNORMAL) as f32;
        self.reach2[facet] = if low > 0.0 { low / normal.norm2() * low * SURE } else { 0.0 };
    }

    /// Are all facets out of reach of images no longer than that with the squared length `length2`?
    #[inline]
    pub(super) fn are_out_of_reach(&self, length2: f64) -> bool {
        !self.reach2.iter().fold(false, |within, &reach2| within | (reach2 <= length2))
    }

    /// Calls `f` for every facet that a candidate is not certain to be clear of, with what is certain.
    #[inline(always)]
    pub(super) fn each_uncertain<P: Point>(&self, image: &P, mut f: impl FnMut(u32, Side)) {
        let mut at = [0.0; 3];
        for (i, x) in at[..P::DIM].iter_mut().enumerate() {
            *x = (image.coord(i) * self.scale[0]) as f32;
        }
        // As many blocks at a time as their facets have bits in one number: without a branch for each.
        for (k, blocks) in self.blocks.chunks(LANES).enumerate() {
            let mut uncertain = 0;
            for (shift, block) in (0u32..).step_by(LANES).zip(blocks) {
                let [x, y, z] = &block.normal;
                let product: Lanes = std::array::from_fn(|i| {
                    let planar = x[i] * at[0] + y[i] * at[1];
                    if P::DIM == 2 { planar } else { planar + z[i] * at[2] }
                });
                uncertain |= u64::from(self.masks.not_below(&product, &block.low)) << shift;
            }
            for lane in each_bit(uncertain) {
                let facet = k * LANES * LANES + lane;
                match self.side(facet, image) {
                    Side::Clear => {}
                    side => f(facet as u32, side),
                }
            }
        }
    }

    /// What double precision says of a candidate and a facet.
    #[inline]
    pub(super) fn side<P: Point>(&self, facet: usize, image: &P) -> Side {
        let Plane { normal, low, high } = &self.rows[facet];
        let planar = normal[0] * image.coord(0) + normal[1] * image.coord(1);
        let product = if P::DIM == 2 { planar } else { planar + normal[2] * image.coord(2) };
        if product < *low {
            Side::Clear
        } else if product > *high {
            Side::Conflict
        } else {
            Side::Undecided
        }
    }
}
