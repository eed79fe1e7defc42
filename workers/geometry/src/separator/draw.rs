//! Drawing a separator from the samples of a subproblem.
//!
//! **Statement.** [`draw`] returns a sphere that satisfies [`split_bound`] on the samples, if one of its random great circles
//! does. Otherwise it returns an axis-aligned plane. It returns no surface only if fewer than two samples are distinct.
//! The result is a function of the [`DrawKey`], the size of the population, the number of great circles and the set of
//! samples.
//!
//! **Estimator.** Let `q` be the fraction of sample balls that a surface crosses, where the ball of a sample extends to
//! its nearest other sample. Let there be `m` samples of `n` points with the same density. Then nearest-neighbour
//! distances of the points are `(m/n)^(1/d)` times those of the samples, and the crossing balls lie in a layer of that
//! relative thickness. Hence the crossing fraction of the population at `alpha` is about `alpha q (m/n)^(1/d)`, and the
//! number of crossing balls is `|B_O| ~ alpha q m^(1/d) n^(1-1/d)`.
//!
//! **Score.** The score of a surface is its larger side plus the crossing fraction at [`SCORE_ALPHA`], both as
//! fractions of the population. It estimates the size of the larger child with its separator set. Lower scores are
//! better, and ties go to the earlier draw.
//!
//! **Source.** Paper, Section 2; Miller, Teng, Thurston and Vavasis 1997 (see [`super`]).
//!
//! **Work and depth.** `O(m^2)` and `O(log m)` for `m` samples.
//!
//! **Departures.** See [`super`].

use super::centrepoint::{centrepoint, has_room, lift};
use super::curve_cut::{CurveCube, CurveCut};
use super::drawn::{DrawKind, Drawn, NoneReason, PlaneReason};
use super::key::DrawKey;
use super::kinds::Separator;
use super::method::{Ablation, Centred, Method};
use super::sampler::{SAMPLE_TARGET, Sampler};
use super::surface::Quadric;
use crate::coordinate_arrays::PairVisitor;
use crate::cost::Cost;
use crate::kd_blocks::KdBlocks;
use crate::point::{Point, Vector, dist2, lex_cmp};

/// Number of great circles in [`draw_bisecting`].
const BISECTING_TRIES: u32 = 30;
/// The samples cannot distinguish a larger side below this fraction from a half. It is one half plus two standard
/// deviations for [`SAMPLE_TARGET`] samples.
const ABOUT_HALF: f64 = 0.55;
/// The `alpha` for which scores estimate the separator set.
pub const SCORE_ALPHA: f64 = 2.5;

/// The first random stream of the permutations; great circles use the streams below it.
const SHUFFLE_STREAM: u64 = 1 << 32;

/// Returns the largest admissible fraction of samples on one side: `(d+1)/(d+2) + 0.05`.
pub fn split_bound<P: Point>() -> f64 {
    (P::DIM + 1) as f64 / (P::DIM + 2) as f64 + 0.05
}

/// Draws one separator from the samples of a subproblem of `population` points: the best of `tries` great circles. The
/// samples may be in any order. The depth is `O(log samples)` for any population.
pub fn draw<P: Point>(key: DrawKey, population: u64, tries: u32, samples: &[P], cost: &mut Cost) -> Drawn<P> {
    // The scans run over the samples, not over the items of the subproblem.
    let mut own = cost.nested();
    let drawn = draw_by(Method::Whole, key, population, tries, samples, &mut own);
    cost.then(own);
    drawn
}

/// Cuts by a plane instead of a sphere, as the baseline of [`draw`]. The plane is perpendicular to the longest side of
/// the bounding box of the samples, at their median, as in k-d trees (Friedman, Bentley and Finkel 1977). Cutting the
/// longest side avoids elongated boxes (Dickerson, Duncan and Goodrich 2000). Successive attempts for one subproblem
/// use the axes of the box in turn, the longest first.
///
/// The plane lies half-way between two neighbouring samples that differ in that coordinate and split the samples best.
/// A point on the plane is exterior, as for every plane. The plane is not scored, and no scoring is charged. The depth
/// is `O(log samples)`, and the work is `O(samples log samples)`.
pub fn cut<P: Point>(key: DrawKey, samples: &[P], cost: &mut Cost) -> Drawn<P> {
    let mut own = cost.nested();
    let drawn = cut_from(key, samples, &mut own);
    cost.then(own);
    drawn
}

fn cut_from<P: Point>(key: DrawKey, samples: &[P], cost: &mut Cost) -> Drawn<P> {
    match plane_across(key, samples, cost) {
        Ok((plane, larger)) => cut_at(plane.into(), larger, samples.len()),
        Err(why) => Drawn::none(why),
    }
}

/// Returns the plane of [`cut`], and the number of samples on its larger side.
fn plane_across<P: Point>(
    key: DrawKey,
    samples: &[P],
    cost: &mut Cost,
) -> Result<(Quadric<P>, usize), NoneReason> {
    if samples.is_empty() {
        return Err(NoneReason::NoSamples);
    }
    let axes = sorted_axes(samples, cost);
    let extents: Vec<f64> = axes.iter().map(|c| c[c.len() - 1] - c[0]).collect();
    let mut long: Vec<usize> = (0..P::DIM).filter(|&axis| extents[axis] > 0.0).collect();
    if long.is_empty() {
        return Err(NoneReason::Coincident);
    }
    cost.sort(&mut long, |&a, &b| extents[b].total_cmp(&extents[a]));
    let axis = long[key.attempt as usize % long.len()];
    cut_across(&axes[axis], axis, cost).ok_or(NoneReason::Coincident)
}

/// Returns the result of a cut that is not scored.
fn cut_at<P: Point>(separator: Separator<P>, larger: usize, samples: usize) -> Drawn<P> {
    let ratio = larger as f64 / samples as f64;
    let kind = match separator {
        Separator::Quadric(_) => DrawKind::Plane { why: PlaneReason::AskedFor },
        Separator::Curve(_) => DrawKind::Curve,
    };
    Drawn {
        separator: Some(separator),
        kind,
        score: ratio,
        estimated_ratio: ratio,
        estimated_crossing: 0.0,
        admissible: 0,
        means: 0,
    }
}

/// Cuts a Hilbert curve at the median of the samples ([`super::CurveCut`]), as a baseline of [`draw`]. The curve fills the
/// cube `above`, or else a cube around the samples whose side is the smallest power of two above their extent. If more
/// samples lie in one cell of the curve than one side may have ([`split_bound`]), a plane cuts them ([`cut`]).
///
/// The samples may be in any order. The depth is `O(log samples)`, and the work is `O(samples log samples)`.
pub fn cut_curve<P: Point>(
    key: DrawKey,
    above: Option<CurveCube<P>>,
    samples: &[P],
    cost: &mut Cost,
) -> Drawn<P> {
    let mut own = cost.nested();
    let drawn = cut_along(above, samples, &mut own).unwrap_or_else(|| cut_from(key, samples, &mut own));
    cost.then(own);
    drawn
}

/// Implements [`cut_curve`]. Returns `None` if too many samples lie in one cell.
fn cut_along<P: Point>(above: Option<CurveCube<P>>, samples: &[P], cost: &mut Cost) -> Option<Drawn<P>> {
    let first = *samples.first()?;
    let cube = above.or_else(|| {
        let (low, high) = cost.reduce(samples, (first, first), |(mut low, mut high), x| {
            for i in 0..P::DIM {
                low.set_coord(i, low.coord(i).min(x.coord(i)));
                high.set_coord(i, high.coord(i).max(x.coord(i)));
            }
            (low, high)
        });
        CurveCube::around(low, high)
    })?;
    let mut positions = cost.map(samples, |&x| cube.position(x));
    cost.sort(&mut positions, Ord::cmp);
    let Gap { before, larger } = most_balanced_gap(&positions, cost)?;
    if larger as f64 > split_bound::<P>() * samples.len() as f64 {
        return None;
    }
    let cut = CurveCut::between(cube, positions[before], positions[before + 1]);
    Some(cut_at(cut.into(), larger, samples.len()))
}

/// Draws a separator for a balanced bisection. Compared with [`draw`], it tries more great circles. Each circle is also
/// moved to the median of the [`SAMPLE_TARGET`] samples of a draw, and the best circle to the median of all samples. In each
/// case the surface with the lower score is used (`super::bisect`).
///
/// The samples may be in any order. The work is O(samples). The individual steps are not charged, because this function
/// claims no depth.
pub fn draw_bisecting<P: Point>(key: DrawKey, population: u64, samples: &[P], cost: &mut Cost) -> Drawn<P> {
    let few = draw_samples(key, population, samples);
    draw_by(Method::Bisecting(samples), key, population, BISECTING_TRIES, &few, cost)
}

/// Cuts as [`cut`] does, but moves the plane to the median of all samples.
pub fn cut_at_median<P: Point>(key: DrawKey, population: u64, samples: &[P], cost: &mut Cost) -> Drawn<P> {
    let mut few = draw_samples(key, population, samples);
    few.sort_unstable_by(lex_cmp);
    match plane_across(key, &few, cost) {
        Ok((plane, _)) => {
            let plane = plane.bisecting(samples);
            cut_at(plane.into(), plane.larger_side(samples), samples.len())
        }
        Err(why) => Drawn::none(why),
    }
}

/// Selects about [`SAMPLE_TARGET`] of the samples.
fn draw_samples<P: Point>(key: DrawKey, population: u64, samples: &[P]) -> Vec<P> {
    let sampler = Sampler::new(key, population, SAMPLE_TARGET);
    samples.iter().copied().filter(|&x| sampler.accepts(x)).collect()
}

/// Implements [`draw`] and its variants.
pub(super) fn draw_by<P: Point>(
    method: Method<'_, P>,
    key: DrawKey,
    population: u64,
    tries: u32,
    samples: &[P],
    cost: &mut Cost,
) -> Drawn<P> {
    let mut sorted = samples.to_vec();
    cost.sort(&mut sorted, lex_cmp);
    match (sorted.first(), sorted.last()) {
        (Some(first), Some(last)) if first == last => return Drawn::none(NoneReason::Coincident),
        (None, _) => return Drawn::none(NoneReason::NoSamples),
        _ => {}
    }
    let frame = Frame::of(&sorted, cost);
    let scorer = Scorer::of(&frame, sorted, population, cost);
    let lifted = cost.map(&scorer.local, |&y| lift(y));
    let (centre, means) = if method.lacks(Ablation::NoCentrepoint) {
        (P::Lifted::splat(0.0), 0)
    } else {
        centrepoint(&lifted, |copy| key.stream(SHUFFLE_STREAM + copy), cost)
    };
    let (at, all) = (Centred { origin: frame.origin, unit: frame.unit, centre }, method.bisected());
    let tries: Vec<u64> = (0..u64::from(tries)).collect();
    let scored = cost.map_nested(&tries, |&number, own| {
        let circle = method.surface(at, &scorer.local, &mut key.stream(number), own)?;
        let drawn = scorer.admit(circle, own);
        if all.is_some() { scorer.admit_bisecting(circle, drawn, own) } else { drawn }
    });
    let admissible = cost.reduce(&scored, 0, |count, s| count + u32::from(s.is_some()));
    let first = || scored.iter().flatten().next().copied();
    let best = if method.lacks(Ablation::NoScoring) { first() } else { lowest(&scored, cost) };
    let (best, kind) = if best.is_some() {
        (best, method.kind())
    } else {
        let why =
            if has_room(centre) { PlaneReason::NoAdmissibleCircle } else { PlaneReason::CentreOnSphere };
        (best_plane(&frame, &scorer, cost), DrawKind::Plane { why })
    };
    let Some(best) = best else { return Drawn::none(NoneReason::Coincident) };
    let best = all.map_or(best, |all| scorer.bisected(best, all, cost));
    Drawn {
        separator: Some(best.separator.into()),
        kind,
        score: best.score,
        estimated_ratio: best.ratio,
        estimated_crossing: best.crossing,
        admissible,
        means,
    }
}

/// Sorts the coordinates of each axis.
fn sorted_axes<P: Point>(samples: &[P], cost: &mut Cost) -> Vec<Vec<f64>> {
    let all_axes: Vec<usize> = (0..P::DIM).collect();
    cost.map_nested(&all_axes, |&axis, own| {
        let mut coords = own.map(samples, |p| p.coord(axis));
        own.sort(&mut coords, f64::total_cmp);
        coords
    })
}

/// Location and scale of the samples. The coordinates of the origin are the medians of the axes. The unit is the
/// inverse of the largest power of two that is at most the median distance from the origin.
struct Frame<P> {
    axes: Vec<Vec<f64>>,
    origin: P,
    unit: f64,
}

impl<P: Point> Frame<P> {
    fn of(sorted: &[P], cost: &mut Cost) -> Self {
        let axes = sorted_axes(sorted, cost);
        let mut origin = P::splat(0.0);
        for (axis, coords) in axes.iter().enumerate() {
            origin.set_coord(axis, coords[coords.len() / 2]);
        }
        // The distance is the largest coordinate difference; squares might exceed the range of floats.
        let distances = cost.map(sorted, |&p| {
            let d = p - origin;
            (0..P::DIM).fold(0.0, |largest: f64, i| largest.max(d.coord(i).abs()))
        });
        let mut distances = cost.pack(&distances, |&d| d > 0.0);
        cost.sort(&mut distances, f64::total_cmp);
        let typical = distances.get(distances.len() / 2).copied().unwrap_or(1.0);
        // Only the exponent is used, clamped so that the power of two and its inverse are normal numbers.
        let exponent = (typical.to_bits() >> 52).clamp(23, 2023);
        let unit = f64::from_bits((2046 - exponent) << 52);
        Frame { axes, origin, unit }
    }
}

/// A surface with its estimates.
#[derive(Clone, Copy, Debug)]
struct Scored<P> {
    separator: Quadric<P>,
    ratio: f64,
    crossing: f64,
    score: f64,
}

/// Squared distances of the samples to their nearest other samples. Coincident samples, at distance zero, do not bound
/// each other's balls.
struct NearestOthers<'a, P> {
    samples: &'a [P],
    /// Positions of the samples, block by block, so that consecutive samples are near each other.
    order: &'a [u32],
    squares: Vec<f64>,
    least: f64,
}

impl<P: Point> PairVisitor for NearestOthers<'_, P> {
    fn begin(&mut self, row: usize) -> f64 {
        let [this, before] = [row, row.saturating_sub(1)].map(|row| self.samples[self.order[row] as usize]);
        let square = dist2(this, before);
        self.least = if square > 0.0 { square } else { f64::INFINITY };
        self.least
    }

    fn visit(&mut self, _: usize, distance2: f64) -> f64 {
        if distance2 > 0.0 {
            self.least = distance2;
        }
        self.least
    }

    fn end(&mut self, row: usize) {
        self.squares[self.order[row] as usize] = self.least;
    }
}

/// Scores surfaces by the samples and their nearest-neighbour balls.
struct Scorer<P> {
    /// Samples in local coordinates.
    local: Vec<P>,
    balls: Vec<(P, f64)>,
    /// `(m/n)^(1/d)`.
    thinning: f64,
}

impl<P: Point> Scorer<P> {
    fn of(frame: &Frame<P>, sorted: Vec<P>, population: u64, cost: &mut Cost) -> Self {
        let local = cost.map(&sorted, |&x| (x - frame.origin) * frame.unit);
        let blocks = KdBlocks::of(&local);
        let squares = vec![f64::INFINITY; local.len()];
        let mut nearest = NearestOthers { samples: &local, order: blocks.order(), squares, least: 0.0 };
        cost.all_pairs_in_blocks(&blocks, &mut nearest);
        let zipped: Vec<(P, f64)> = sorted.into_iter().zip(nearest.squares).collect();
        let balls = cost.map(&zipped, |&(x, square)| (x, square.sqrt() / frame.unit));
        let fraction = balls.len() as f64 / (population as f64).max(balls.len() as f64);
        Scorer { local, balls, thinning: root(fraction, P::DIM, cost) }
    }

    fn score(&self, separator: Quadric<P>, cost: &mut Cost) -> Scored<P> {
        let m = self.balls.len();
        let mut seen = cost.sweep();
        let [inside, across] = separator.count_inside_and_crossing(seen.visit_all(&self.balls));
        cost.charge_sweep(seen);
        let ratio = inside.max(m - inside) as f64 / m as f64;
        let crossing = across as f64 / m as f64 * self.thinning;
        Scored { separator, ratio, crossing, score: ratio + SCORE_ALPHA * crossing }
    }

    /// Returns the score if both sides satisfy the split bound.
    fn admit(&self, separator: Quadric<P>, cost: &mut Cost) -> Option<Scored<P>> {
        let scored = self.score(separator, cost);
        (scored.ratio < 1.0 && scored.ratio <= split_bound::<P>()).then_some(scored)
    }

    /// Returns the surface if it is admissible, or the surface moved to the median of the samples, whichever scores
    /// less. Sides below [`ABOUT_HALF`] score equally, because the samples cannot distinguish halves from near halves.
    fn admit_bisecting(
        &self,
        circle: Quadric<P>,
        drawn: Option<Scored<P>>,
        cost: &mut Cost,
    ) -> Option<Scored<P>> {
        let moved = circle.moved_to_median(self.balls.iter().map(|ball| ball.0));
        let moved = moved.and_then(|moved| self.admit(moved, cost));
        let about = |s: Scored<P>| Scored { score: s.ratio.max(ABOUT_HALF) + SCORE_ALPHA * s.crossing, ..s };
        lowest(&[drawn.map(about), moved.map(about)], cost)
    }

    /// Returns the surface, or the surface moved to the median of all samples if it is then better balanced and scores
    /// less. The sides of both are counted over all samples.
    fn bisected(&self, best: Scored<P>, all: &[P], cost: &mut Cost) -> Scored<P> {
        let rescored = |scored: Scored<P>| {
            let ratio = scored.separator.larger_side(all) as f64 / all.len() as f64;
            Scored { ratio, score: ratio + SCORE_ALPHA * scored.crossing, ..scored }
        };
        let unmoved = rescored(best);
        let moved = best
            .separator
            .moved_to_median(all.iter().copied())
            .map(|moved| rescored(self.score(moved, cost)));
        let is_better = |moved: &Scored<P>| moved.ratio < unmoved.ratio && moved.score < unmoved.score;
        moved.filter(is_better).unwrap_or(unmoved)
    }
}

/// Computes `x^(1/d)` for normal `0 < x <= 1`, by the four basic operations. Newton's method starts from the power of
/// two above the root, which is less than 4 times too large. A fixed number of iterations therefore suffices.
pub(super) fn root(x: f64, d: usize, cost: &mut Cost) -> f64 {
    let degree = d as f64;
    let exponent = (x.to_bits() >> 52) as i64 - 1023;
    let above = (exponent.div_euclid(d as i64) + 1024) as u64;
    cost.sequential(8, f64::from_bits(above << 52), |t: f64, _| {
        let power = (1..d).fold(1.0, |p, _| p * t);
        ((degree - 1.0) * t + x / power) / degree
    })
}

/// Returns the surface with the lowest score, or the earliest one of equal score.
fn lowest<P: Point>(scored: &[Option<Scored<P>>], cost: &mut Cost) -> Option<Scored<P>> {
    cost.reduce(scored, None, |best: Option<Scored<P>>, next| match (best, next) {
        (Some(b), Some(n)) if n.score < b.score => Some(*n),
        (None, Some(n)) => Some(*n),
        _ => best,
    })
}

/// For each axis, finds the best balanced cut between two different neighbouring coordinates, and returns the cut with
/// the lowest score. Returns `None` if all samples coincide.
fn best_plane<P: Point>(frame: &Frame<P>, scorer: &Scorer<P>, cost: &mut Cost) -> Option<Scored<P>> {
    let all_axes: Vec<usize> = (0..P::DIM).collect();
    let cuts = cost.map_nested(&all_axes, |&axis, own| {
        let (plane, _) = cut_across(&frame.axes[axis], axis, own)?;
        Some(scorer.score(plane, own))
    });
    lowest(&cuts, cost)
}

/// Finds the best balanced cut of one axis, given its sorted coordinates. Also returns the number of coordinates on the
/// larger side. Returns `None` if all coordinates are equal.
fn cut_across<P: Point>(coords: &[f64], axis: usize, cost: &mut Cost) -> Option<(Quadric<P>, usize)> {
    let Gap { before, larger } = most_balanced_gap(coords, cost)?;
    Some((Quadric::between(axis, coords[before], coords[before + 1]), larger))
}

/// A gap between two neighbours of a sorted sequence.
#[derive(Clone, Copy)]
struct Gap {
    /// The place of the last item before the gap.
    before: usize,
    /// The number of items on the larger side.
    larger: usize,
}

/// Returns the first of the gaps between different neighbours that divide a sorted sequence best. Returns `None` if all
/// items are equal.
fn most_balanced_gap<T: PartialOrd>(sorted: &[T], cost: &mut Cost) -> Option<Gap> {
    let m = sorted.len();
    let gaps: Vec<(usize, &[T])> = sorted.windows(2).enumerate().collect();
    let balance = cost.map(&gaps, |(i, gap)| (gap[0] < gap[1]).then_some((i + 1).max(m - i - 1)));
    let zipped: Vec<(usize, Option<usize>)> = balance.into_iter().enumerate().collect();
    cost.reduce(&zipped, None, |best: Option<Gap>, &(before, larger)| match (best, larger) {
        (Some(gap), Some(larger)) if larger < gap.larger => Some(Gap { before, larger }),
        (None, Some(larger)) => Some(Gap { before, larger }),
        _ => best,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_accurate() {
        for k in 0..60 {
            let x = 1.0 / (1u64 << k) as f64 / 1.7;
            assert!((root(x, 2, &mut Cost::default()) / x.sqrt() - 1.0).abs() < 1e-14);
            assert!((root(x, 3, &mut Cost::default()) / x.cbrt() - 1.0).abs() < 1e-14);
        }
        assert_eq!(root(1.0, 3, &mut Cost::default()), 1.0);
    }
}
