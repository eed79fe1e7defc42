//! The facets of a link as planes among inverted points, for the rounded test of a candidate.
//!
//! **Statement.** Inversion in the unit sphere around the centre maps spheres through the centre to planes, and their
//! interiors to the far sides. It maps infinity to the centre. So a candidate conflicts with a facet iff its inverse
//! image lies beyond the facet's plane. The link is the convex hull of the inverse images and the origin (Brown 1979).
//! A hull facet is a plane through the origin and needs no special case. Let `a, b, c` be the images of a facet. Let
//! `n = (b - a) x (c - a)` (in the plane, `b - a` rotated), and `g = n . a`. An image `k` lies beyond the facet iff
//! `n . k > g`.
//!
//! **Error bound.** Let `u = 2^-53`, `B = max(|a|, |b|)` and `C = max(|a|, |c|)`, with `a` as the base.
//! 1. Images have relative errors of at most `8 u`: a difference contributes 1, a squared length 5, and a reciprocal
//!    and a product 1 each.
//! 2. So `b - a` and `c - a` have lengths of at most `2 B` and `2 C`, and errors of at most `18 u B` and `18 u C`.
//! 3. The error of `n` is at most `84 u B C`, of which `12` is the rounding of the product.
//! 4. The error of `n . a` is at most `(84 + 32 + 12) u B C |a|`. The error of `n . k` has the same bound with `|k|`
//!    instead of `|a|`.
//! 5. Hence the sign of `n . k - g` is certain if its absolute value exceeds `136 u B C (|a| + |k|)`. This threshold
//!    covers the rounding of the bound and of its sum with `g`.
//!
//! In the plane all errors are smaller, and `C = 1`.
//!
//! Candidates are added in order of distance, so images have decreasing lengths. So no later image is longer than the
//! image of the latest candidate, whose length can replace `|k|`. The bound is then one number for each facet. With
//! the latest candidate as the base, it is proportional to the product of the facet's three lengths. It is therefore
//! small for facets with one near and two distant vertices. The first facets are created before some nearer
//! candidates are added. For these facets, the length of the longest image replaces `|k|`.
//!
//! **Reach.** If `|n| |k| < g - bound`, neither `k` nor a later image lies beyond the facet: it is *out of reach*. If
//! all facets are out of reach, the remaining candidates need no test. The *reach* of a facet is `(g - bound) / |n|`.
//! Its square is a product that cannot overflow in the range of [`crate::range`], and it is reduced by more than its
//! rounding.
//!
//! **Single precision first.** Let `v = 2^-24`. Round a normal and an image to single precision, and multiply them
//! there. Each term passes five roundings, so the error of the product is at most `5 v |n| |k|`. Rounding the threshold
//! adds a relative error of `v`. Since `|n| <= 4 B C`, a rounded product below `g - (136 u + 24 v) B C (|a| + |k|)`
//! implies an exact one below `g - 136 u B C (|a| + |k|)`. The facet is then clear of the candidate. Only the other
//! facets are tested in double precision.
//!
//! All values are multiplied by the power of two that scales the longest image to a length of about 1, so that nothing
//! overflows. Subnormal values in single precision lose less than `2^-144` in total, and the threshold is reduced by
//! `2^-140`. If a product is NaN, the facet is tested in double precision.
//!
//! **Weights** ([`crate::site`]). Let `s = |q - p|^2 - w_q + w_p` be the *power* of `q`. A conflict is a linear inequality
//! in `q - p` and `s`. If `s` is positive, the image of `q` is `(q - p) / s`, and all of the above holds. The image is not a
//! number if `s` is less than a quarter of the sum of `|q - p|^2` and `|w_q - w_p|`, or if `q` or `p` is an image of a periodic
//! box. Then every test of `q`, and of a facet with the vertex `q`, is undecided. Otherwise `s` has a relative error of at most
//! `21 u`: four times the 5 roundings of the sum, and one of its own. So images have relative errors of at most `24 u`, and the
//! bounds are multiplied by 4. Candidates are added by decreasing lengths of their images, those that are not numbers first.
//!
//! **Departures.** Eight facets are tested at a time, as arrays. The loop has no branches and uses vector registers.

#![expect(clippy::needless_bitwise_bool, reason = "a fold without branches becomes vector instructions")]
#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

use crate::point::Point;
use crate::simd::{Masks, each_bit, larger};

/// `136 u`.
const UNIT: f64 = 136.0 * (f64::EPSILON / 2.0);

/// The share of a power in the sum of its terms from which it is clearly positive.
const CLEAR: f64 = 0.25;

/// Factor by which the bounds grow for sites with weights.
const WEIGHTED: f64 = 4.0;

/// `24 v`.
const SINGLE: f64 = 24.0 * (f32::EPSILON as f64 / 2.0);

/// `2^-140`.
const SUBNORMAL: f64 = f64::from_bits((1023 - 140) << 52);

/// Factor that reduces the squared reach by more than 16 roundings.
const SURE: f64 = 1.0 - 32.0 * f64::EPSILON;

/// The image of a point under inversion in the unit sphere around the centre.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Image<P> {
    pub(super) at: P,
    /// Distance of the image from the centre.
    pub(super) length: f64,
}

/// The least length of an image, `2^-200`. Without weights, all images are longer, and no square of a reach overflows.
const SHORTEST: f64 = f64::from_bits((1023 - 200) << 52);

impl<P: Point> Image<P> {
    /// Computes the image of a point from its vector from the centre and its squared length.
    #[inline]
    pub(super) fn of(rel: P, length2: f64) -> Self {
        let inverse2 = 1.0 / length2;
        Image { at: rel * inverse2, length: inverse2.sqrt() }
    }

    /// Computes the image of a site from its vector from the centre, whose weight is the difference of weights. The image
    /// is not a number if the power is not clearly positive, if low parts are not zero, or if it is shorter than all images
    /// without weights ([`SHORTEST`]).
    #[inline]
    pub(super) fn of_site(rel: P, low: f64) -> Self {
        let (length2, drop) = (rel.norm2(), rel.weight());
        let power = length2 - drop;
        if low != 0.0 || power < CLEAR * (length2 + drop.abs()) {
            return Image { at: P::splat(f64::NAN), length: f64::NAN };
        }
        let inverse = 1.0 / power;
        let length = length2.sqrt() * inverse;
        if length < SHORTEST {
            return Image { at: P::splat(f64::NAN), length: f64::NAN };
        }
        Image { at: rel * inverse, length }
    }

    /// Returns the image of infinity, which is the centre.
    #[inline]
    pub(super) fn of_infinity() -> Self {
        Image { at: P::splat(0.0), length: 0.0 }
    }
}

/// Number of facets in one block.
const LANES: usize = 8;

type Lanes = [f32; LANES];

/// Eight facets in single precision.
#[derive(Clone, Copy, Debug)]
struct Block {
    normal: [Lanes; 3],
    /// An image is certainly not beyond the plane if its product with the normal is below this threshold. Infinite
    /// without a facet.
    low: Lanes,
}

const EMPTY: Block = Block { normal: [[0.0; LANES]; 3], low: [f32::INFINITY; LANES] };

/// A facet in double precision, for candidates that single precision leaves uncertain.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: [f64; 3],
    /// An image is certainly not beyond the plane if its product with the normal is below this threshold. Infinite
    /// without a facet.
    low: f64,
    /// An image is certainly beyond the plane if its product with the normal is above this threshold.
    high: f64,
}

const NO_PLANE: Plane = Plane { normal: [0.0; 3], low: f64::INFINITY, high: f64::INFINITY };

/// The side of a facet's plane on which a candidate lies, in rounded arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Conflict,
    Clear,
    Undecided,
    /// In conflict, and already in the cavity.
    InCavity,
}

/// The planes of all facets of a link, indexed by facet.
#[derive(Debug, Default)]
pub(super) struct Planes {
    masks: Masks,
    blocks: Vec<Block>,
    rows: Vec<Plane>,
    /// For each facet, the squared length below which images are certainly not beyond its plane.
    reach2: Vec<f64>,
    /// The power of two by which images are scaled in single precision, its square for normals and its cube for
    /// thresholds.
    scale: [f64; 3],
}

impl Planes {
    /// Removes all facets. `longest` is the length of the longest image of all.
    pub(super) fn clear(&mut self, longest: f64) {
        self.blocks.clear();
        self.rows.clear();
        self.reach2.clear();
        // The inverse power of two: its exponent is negated.
        let exponent = (longest.to_bits() >> 52) & 0x7ff;
        let scale = f64::from_bits((2046 - exponent.clamp(1, 2045)) << 52);
        self.scale = [scale, scale * scale, scale * scale * scale];
    }

    /// Makes room for `facets` facets, rounded up to whole blocks. Returns the number of facets that fit.
    pub(super) fn make_room(&mut self, facets: usize) -> usize {
        let blocks = facets.div_ceil(LANES);
        if blocks > self.blocks.len() {
            self.blocks.resize(blocks, EMPTY);
            self.rows.resize(blocks * LANES, NO_PLANE);
            self.reach2.resize(blocks * LANES, f64::INFINITY);
        }
        blocks * LANES
    }

    /// Removes a facet. Its index may be used again.
    pub(super) fn remove(&mut self, facet: u32) {
        self.blocks[facet as usize / LANES].low[facet as usize % LANES] = f32::INFINITY;
        self.rows[facet as usize].low = f64::INFINITY;
        self.reach2[facet as usize] = f64::INFINITY;
    }

    /// Enters a facet with these images, in positive order. `longest` bounds the lengths of later images.
    #[inline(always)]
    pub(super) fn set<P: Point>(&mut self, facet: u32, [a, b, c]: [&Image<P>; 3], longest: f64) {
        let facet = facet as usize;
        let normal = P::hull_normal(&[b.at - a.at, c.at - a.at][..P::DIM - 1]);
        let mut sizes = larger(a.length, b.length);
        if P::DIM == 3 {
            sizes *= larger(a.length, c.length);
        }
        // In the plane, the rotated vector points to the other side.
        let normal = if P::DIM == 3 { normal } else { normal * -1.0 };
        let unit = sizes * (a.length + longest);
        let bound = if P::IS_WEIGHTED { WEIGHTED * UNIT * unit } else { UNIT * unit };
        let height = normal.dot(a.at);
        if P::IS_WEIGHTED && height.is_nan() {
            self.set_unknown(facet);
            return;
        }
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

    /// Enters a facet with an image that is not a number, so that every test is undecided.
    #[cold]
    fn set_unknown(&mut self, facet: usize) {
        self.rows[facet] = Plane { normal: [0.0; 3], low: f64::NEG_INFINITY, high: f64::INFINITY };
        let block = &mut self.blocks[facet / LANES];
        for axis in &mut block.normal {
            axis[facet % LANES] = 0.0;
        }
        block.low[facet % LANES] = f32::NEG_INFINITY;
        self.reach2[facet] = 0.0;
    }

    /// Returns `true` if all facets are out of reach of images with a squared length of at most `length2`.
    #[inline]
    pub(super) fn are_out_of_reach(&self, length2: f64) -> bool {
        !self.reach2.iter().fold(false, |within, &reach2| within | (reach2 <= length2))
    }

    /// Returns the squared length below which images are certainly not beyond any plane.
    pub(super) fn least_reach2(&self) -> f64 {
        self.reach2.iter().fold(f64::INFINITY, |least, &reach2| least.min(reach2))
    }

    /// Calls `f` for every facet that is not certainly clear of a candidate, whose image is a number, with the candidate's
    /// side as far as it is known.
    #[inline(always)]
    pub(super) fn each_uncertain<P: Point>(&self, image: &P, mut f: impl FnMut(u32, Side)) {
        let mut at = [0.0; 3];
        for (i, x) in at[..P::DIM].iter_mut().enumerate() {
            *x = (image.coord(i) * self.scale[0]) as f32;
        }
        // Each iteration processes as many blocks as one 64-bit mask covers. One loop over its bits replaces a branch
        // for each block.
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

    /// Tests a candidate against a facet in double precision.
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
