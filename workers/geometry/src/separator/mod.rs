//! Sphere separators: the surface that splits a point set, its exact side rule and its one-sided
//! crossing test; [`draw()`] finds one from samples.
//!
//! **Statement.** For every `k`-ply system of `n` balls in `R^d` there is a sphere `S` with at most
//! `(d+1)/(d+2) n` centres on either side that crosses `O(k^(1/d) n^(1-1/d))` balls; the great circle
//! drawn at random on the unit sphere of `R^(d+1)`, after a conformal map that takes a centrepoint of
//! the stereographic lift to the centre, is such a sphere with a constant probability (Miller, Teng,
//! Thurston and Vavasis, "Separators for sphere-packings and nearest neighbor graphs", J. ACM 44, 1997).
//! Approximate centrepoints come from iterated Radon points (Clarkson, Eppstein, Miller, Sturtivant and
//! Teng, "Approximating center points with iterative Radon points", 1996).
//!
//! **Work and depth** of a draw from `m` samples: `O(m^2)` and `O(log m)`, whatever the size of the
//! population (`m` is about [`SAMPLE_TARGET`]); of a side or a crossing test: `O(1)`.
//!
//! **Departures.**
//! - Samples are put into a frame whose origin is their coordinatewise median and whose unit is the
//!   power of two below the median distance from it (not mean and extent), so that a few far points do
//!   not flatten all others into one point of the lift, and nothing depends on the scale of the input.
//! - The conformal map is never applied to points. All great circles of the mapped sphere are planes
//!   through the centrepoint `z` of the lift: the circle with unit normal `n` is `w . (p - z) = 0`
//!   with `w = s n + (n . z) z / (1 + s)`, `s = sqrt(1 - |z|^2)`, which is the rotation of `z` to an
//!   axis and the dilation by `sqrt((1-r)/(1+r))`, multiplied out.
//! - Several great circles are tried and scored on the samples ([`TRIES`]), since balance and size
//!   of one circle vary; a circle that misses [`split_bound`] on the samples is dropped.
//! - Where only halves are asked for, circles are moved off the centrepoint ([`draw_bisecting`]).
//! - Where no circle is admissible (the centrepoint lies on the sphere, as for samples that coincide
//!   at the scale of the others), an axis-aligned plane cuts the samples by exact comparison.

#![expect(clippy::inline_always, reason = "what is not inlined does not use the widest registers")]

mod bisect;
mod centrepoint;
mod draw;
mod surface;

pub use bisect::bisection_samples;
pub use draw::{
    DrawKey, DrawKind, Drawn, NoneReason, PlaneReason, SAMPLE_TARGET, SCORE_ALPHA, Sampler, TRIES, cut,
    cut_at_median, draw, draw_bisecting, is_sample, split_bound,
};
pub use surface::{SEPARATOR_WORDS, Separator, Side, Surface};

#[cfg(test)]
mod tests;
