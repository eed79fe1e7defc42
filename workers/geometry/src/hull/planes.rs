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
//! **Departures.** Four facets at a time, in columns: the loop has no branches and uses vector registers.

use crate::point::Point;

/// `136 u`.
const UNIT: f64 = 136.0 * (f64::EPSILON / 2.0);

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
const LANES: usize = 4;

type Lanes = [f64; LANES];

/// Four facets.
#[derive(Clone, Copy, Debug)]
struct Block {
    normal: [Lanes; 3],
    /// Below this a product with the normal is certain not to be beyond the plane; infinite without a facet.
    low: Lanes,
}

const EMPTY: Block = Block { normal: [[0.0; LANES]; 3], low: [f64::INFINITY; LANES] };

/// What is asked only of facets that are not certain.
#[derive(Clone, Copy, Debug)]
struct Rest {
    /// Above this a product is certain to be beyond.
    high: f64,
    /// The squared length of the longest image from which on all are certain not to be beyond.
    reach2: f64,
}

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
    blocks: Vec<Block>,
    rest: Vec<Rest>,
}

impl Planes {
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.rest.clear();
    }

    /// No facet has this number, for the time being.
    pub(super) fn remove(&mut self, facet: u32) {
        self.blocks[facet as usize / LANES].low[facet as usize % LANES] = f64::INFINITY;
        self.rest[facet as usize].reach2 = f64::INFINITY;
    }

    /// Enters a facet with these images, in positive order; `longest` bounds the lengths of those still to
    /// come.
    #[inline]
    pub(super) fn set<P: Point>(&mut self, facet: u32, [a, b, c]: [&Image<P>; 3], longest: f64) {
        let facet = facet as usize;
        if facet >= self.rest.len() {
            let blocks = facet / LANES + 1;
            self.blocks.resize(blocks, EMPTY);
            self.rest.resize(blocks * LANES, Rest { high: f64::INFINITY, reach2: f64::INFINITY });
        }
        let normal = P::hull_normal(&[b.at - a.at, c.at - a.at][..P::DIM - 1]);
        let mut sizes = larger(a.length, b.length);
        if P::DIM == 3 {
            sizes *= larger(a.length, c.length);
        }
        // In the plane the turned vector points to the other side.
        let normal = if P::DIM == 3 { normal } else { normal * -1.0 };
        let bound = UNIT * sizes * (a.length + longest);
        let height = normal.dot(a.at);
        let low = height - bound;
        let block = &mut self.blocks[facet / LANES];
        for axis in 0..P::DIM {
            block.normal[axis][facet % LANES] = normal.coord(axis);
        }
        block.low[facet % LANES] = low;
        let reach2 = if low > 0.0 { low / normal.norm2() * low * SURE } else { 0.0 };
        self.rest[facet] = Rest { high: height + bound, reach2 };
    }

    /// Are all facets out of reach of images no longer than that with the squared length `length2`?
    #[inline]
    pub(super) fn are_out_of_reach(&self, length2: f64) -> bool {
        let mut within = 0u64;
        for rest in &self.rest {
            within |= u64::from(rest.reach2 <= length2);
        }
        within == 0
    }

    /// Calls `f` for every facet that a candidate is not certain to be clear of, with what is certain.
    #[inline]
    pub(super) fn each_uncertain<P: Point>(&self, image: &P, mut f: impl FnMut(u32, Side)) {
        let mut at = [0.0; 3];
        for (i, x) in at[..P::DIM].iter_mut().enumerate() {
            *x = image.coord(i);
        }
        for (k, block) in self.blocks.iter().enumerate() {
            let [x, y, z] = &block.normal;
            let product: Lanes = std::array::from_fn(|i| {
                let planar = x[i] * at[0] + y[i] * at[1];
                if P::DIM == 2 { planar } else { planar + z[i] * at[2] }
            });
            let uncertain = product.iter().zip(&block.low).fold(0, |any, (p, low)| any | u64::from(p >= low));
            if uncertain == 0 {
                continue;
            }
            for (lane, (product, &low)) in product.into_iter().zip(&block.low).enumerate() {
                if product >= low {
                    let facet = k * LANES + lane;
                    let beyond = product > self.rest[facet].high;
                    f(facet as u32, if beyond { Side::Conflict } else { Side::Undecided });
                }
            }
        }
    }
}

/// The larger of two numbers: one instruction.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
