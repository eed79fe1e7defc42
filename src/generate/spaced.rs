//! f-spaced sets with boundary: vertices, edges, faces, volume, each a maximal independent set.
//!
//! **Statement.** The paper, Section 5: oversample the domain, join samples closer than
//! `min(f(P), f(Q))` and take a maximal independent set; boundary first, lower dimensions fixed. The
//! set is f-spaced (Definition 5.2 read with `>=`). Random samples alone never make it maximal, so
//! each stage is *completed* ([`super::completion`]): in the end every ball that is empty of points
//! and centred in the domain has `R <= f(c) / (1 - 1e-9)`, hence radius-edge ratio at most
//! `1 / (1 - L)` there, and Delaunay edges `|uv| <= 2(1+L)/(1-L) min(nn_u, nn_v)`. At the boundary the
//! edge bound is measured, not proved: every set tried met it, so callers who multiply it by 1.25 have
//! that much to spare.
//!
//! **Work.** O(n) expected: about 10 candidates per `f^d`, each O(1), then the completion.
//!
//! **Departures.** Greedy choice in order of priority gives the set that parallel rounds with the same
//! priorities give. Priorities are (pass, random): a pass spreads about one candidate per `f^d`, so
//! only one pass is in memory. Points of a stage keep [`ZONE`] times f away from lower-dimensional
//! faces: the paper does not ask for it, and without it a point almost in the plane of a face makes a
//! flat cell of unbounded radius. Edges are divided evenly instead of at random: wide gaps
//! on two edges that meet leave no room for covering what lies between them.

use septet_geometry::incremental::IncrementalError;
use septet_geometry::point::Point;

use super::completion::{self, Facet};
use super::draw::{Draw, Purpose};
use super::sizing::{Sizing, Spaced};

/// Distance from lower-dimensional faces, in units of f.
pub(super) const ZONE: f64 = 0.6;

/// Candidates per `f^k` on faces of dimension `k`, by `k`; edges are divided evenly.
const PASSES: [u64; 4] = [0, 0, 15, 10];

/// A face of the unit square or cube, of any dimension: some axes free, the others at 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face<P> {
    /// The coordinates of the fixed axes; 0 in the free ones.
    pub base: P,
    /// Which axes are free.
    pub free: [bool; 3],
}

impl<P: Point> Face<P> {
    /// All faces of dimension `k`.
    pub fn all(k: usize) -> impl Iterator<Item = Face<P>> {
        (0..3usize.pow(P::DIM as u32)).filter_map(move |mut code| {
            let mut face = Face { base: P::default(), free: [false; 3] };
            for i in 0..P::DIM {
                face.free[i] = code % 3 == 2;
                face.base.set_coord(i, if code % 3 == 1 { 1.0 } else { 0.0 });
                code /= 3;
            }
            (face.dimension() == k).then_some(face)
        })
    }

    /// Number of free axes.
    pub fn dimension(&self) -> usize {
        self.free.iter().filter(|&&free| free).count()
    }

    /// The free axes.
    pub fn axes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..P::DIM).filter(|&i| self.free[i])
    }

    /// The point of the face with these coordinates along the free axes.
    pub fn embed<Q: Point>(&self, q: &Q) -> P {
        let mut p = self.base;
        for (j, i) in self.axes().enumerate() {
            p.set_coord(i, q.coord(j));
        }
        p
    }

    /// The coordinates along the free axes, if the point is on the face.
    pub fn project<Q: Point>(&self, p: &P) -> Option<Q> {
        let mut q = Q::default();
        let mut j = 0;
        for i in 0..P::DIM {
            if self.free[i] {
                q.set_coord(j, p.coord(i));
                j += 1;
            } else if p.coord(i) != self.base.coord(i) {
                return None;
            }
        }
        Some(q)
    }

    /// Is the point at least `ZONE * f` away from the faces that bound this one?
    pub fn is_clear(&self, p: &P, size: f64) -> bool {
        self.axes().all(|i| p.coord(i) >= ZONE * size && 1.0 - p.coord(i) >= ZONE * size)
    }

    /// Visits cubes that tile the face and whose sides are at most `bound(midpoint)`: midpoint and
    /// side.
    pub fn tile(&self, bound: impl Fn(&P) -> f64, mut visit: impl FnMut(P, f64)) {
        let axes: Vec<usize> = self.axes().collect();
        let mut whole = self.base;
        for &i in &axes {
            whole.set_coord(i, 0.5);
        }
        let mut stack = vec![(whole, 1.0)];
        while let Some((middle, side)) = stack.pop() {
            if side <= bound(&middle) || side < 1e-9 {
                visit(middle, side);
                continue;
            }
            for part in 0..1usize << axes.len() {
                let mut child = middle;
                for (bit, &i) in axes.iter().enumerate() {
                    let shift = if part >> bit & 1 == 0 { side / 4.0 } else { -side / 4.0 };
                    child.set_coord(i, middle.coord(i) + shift);
                }
                stack.push((child, side / 2.0));
            }
        }
    }
}

/// An f-spaced, completed set with boundary.
pub(super) fn build<P: Point>(
    sizing: Sizing,
    seed: u64,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<P>, IncrementalError> {
    let mut set = Spaced::new(sizing);
    for corner in Face::all(0) {
        set.offer(corner.base);
    }
    let mut facets = Vec::new();
    for (k, &passes) in PASSES.iter().enumerate().take(P::DIM + 1).skip(1) {
        completion::cap(&mut set, k, &facets);
        let mut draw = Draw::sub(seed, Purpose::Candidates, k as u64);
        for _ in 0..passes {
            pass(&mut set, k, &mut draw);
            progress(set.len() as u64);
        }
        facets = complete_stage(&mut set, k)?;
        progress(set.len() as u64);
    }
    Ok(set.points().collect())
}

/// One pass of candidates over all faces of dimension `k`, taken greedily in random order.
fn pass<P: Point>(set: &mut Spaced<P>, k: usize, draw: &mut Draw) {
    let sizing = *set.sizing();
    let mut candidates: Vec<(u64, P)> = Vec::new();
    for face in Face::<P>::all(k) {
        face.tile(
            |p| sizing.at(p),
            |middle, side| {
                let ratio = side / sizing.at(&middle);
                let mut expected = ratio;
                for _ in 1..k {
                    expected *= ratio;
                }
                // Below one candidate per cube on average: flip a coin.
                if draw.unit() < expected {
                    let mut p = middle;
                    for i in face.axes() {
                        p.set_coord(i, middle.coord(i) + (draw.unit() - 0.5) * side);
                    }
                    if face.is_clear(&p, sizing.at(&p)) {
                        candidates.push((draw.bits(), p));
                    }
                }
            },
        );
    }
    candidates.sort_unstable_by_key(|&(priority, _)| priority);
    for (_, p) in candidates {
        set.offer(p);
    }
}

/// Completes the stage `k` and returns its facets: segments of edges, triangles of faces.
fn complete_stage<P: Point>(set: &mut Spaced<P>, k: usize) -> Result<Vec<Facet<P>>, IncrementalError> {
    let mut facets = Vec::new();
    if k == P::DIM {
        completion::volume(set)?;
        return Ok(facets);
    }
    for face in Face::all(k) {
        if k == 1 {
            completion::edge(set, &face, &mut facets);
        } else {
            completion::face(set, &face, &mut facets)?;
        }
    }
    Ok(facets)
}
