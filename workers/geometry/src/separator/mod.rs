//! Sphere separators: the surface that splits a point set, its exact side rule and its one-sided crossing test.
//! [`draw()`] finds one from samples.
//!
//! **Statement.** For every `k`-ply system of `n` balls in `R^d` there is a sphere `S` with at most `(d+1)/(d+2) n`
//! centres on either side that crosses `O(k^(1/d) n^(1-1/d))` balls. It can be drawn at random:
//!
//! 1. Lift the centres stereographically to the unit sphere of `R^(d+1)`.
//! 2. Apply a conformal map that moves a centrepoint of the lifted points to the centre of the sphere.
//! 3. Draw a random great circle. With constant probability its preimage is such a sphere `S`.
//!
//! **Source.** Miller, Teng, Thurston and Vavasis, "Separators for sphere-packings and nearest neighbor graphs", J. ACM
//! 44, 1997. Approximate centrepoints come from iterated Radon points: Clarkson, Eppstein, Miller, Sturtivant and Teng,
//! "Approximating center points with iterative Radon points", 1996.
//!
//! **Work and depth.** A draw from `m` samples: work `O(m^2)` and depth `O(log m)`, for any size of the population (`m`
//! is at most a constant, [`node_samples`]). A side test or a crossing test: `O(1)`.
//!
//! **Departures.**
//! - The frame of the samples has their coordinatewise median as its origin. Its unit is the largest power of two that
//!   is at most their median distance from the origin. If the frame used mean and extent instead, a few distant points
//!   would move all others close to one point of the lift. Nothing depends on the scale of the input.
//! - The conformal map is never applied to points. The great circles of the mapped sphere correspond to the planes
//!   through the centrepoint `z` of the lift. The circle with unit normal `n` is `w . (p - z) = 0` with
//!   `w = s n + (n . z) z / (1 + s)` and `s = sqrt(1 - |z|^2)`. This formula combines the rotation of `z` to an axis
//!   with the dilation by `sqrt((1-r)/(1+r))`, where `r = |z|`.
//! - The balance and the number of crossed balls vary from circle to circle, so several great circles are drawn
//!   and scored on the samples. A circle that violates [`split_bound`] on the samples is discarded.
//! - If the caller needs only a balanced bisection, circles may be moved away from the centrepoint
//!   ([`draw_bisecting`]).
//! - If no circle is admissible, an axis-aligned plane cuts the samples by exact comparison. This happens if the
//!   centrepoint lies on the sphere, for example because most samples coincide at the scale of the others.

#![expect(clippy::inline_always, reason = "functions that are not inlined do not use the widest registers")]

mod ablation;
mod bisect;
mod centrepoint;
mod curve_cut;
mod draw;
mod drawn;
mod key;
mod kinds;
mod method;
mod sampler;
mod surface;

pub use ablation::draw_ablated;
pub use bisect::bisection_samples;
pub use curve_cut::{CurveCube, CurveCut};
pub use draw::{SCORE_ALPHA, cut, cut_at_median, cut_curve, draw, draw_bisecting, split_bound};
pub use drawn::{DrawKind, Drawn, NoneReason, PlaneReason};
pub use key::DrawKey;
pub use kinds::Separator;
pub use method::Ablation;
pub use sampler::{LEAST_SAMPLES, MOST_SAMPLES, SAMPLE_TARGET, Sampler, node_samples};
pub use surface::{Quadric, Side, Surface};

#[cfg(test)]
mod tests;
