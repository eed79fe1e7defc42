//! Balanced bisection: a separator moved to the median of a set.
//!
//! **Statement.** Let `f` be a separator's function. The surfaces `f = m` are concentric spheres or parallel planes.
//! Let `m` be the median of `f` over `s` points drawn at random from a set, and let no values of `f` tie. Then each
//! side has about half of the set. By the binomial distribution, the standard deviation of its fraction is
//! `1 / (2 sqrt(s))`.
//!
//! **Purpose.** If every worker triangulates its subdomain directly, all of them wait for the largest subdomain. The
//! samples from which a separator is drawn locate the median only to within 0.025 of the set. [`bisection_samples`]
//! gives the number of samples that minimises the sum of waiting time and sampling time, up to a largest number.
//!
//! **Departures.** A moved sphere no longer comes from a great circle through the centrepoint, so the separator
//! theorem does not apply. The sizes of its sides are counted, and the number of balls that it crosses is estimated
//! as for any other surface ([`super::draw_bisecting`]). A moved surface must score less than the original. Bisection
//! is used only if neither work nor depth is claimed. Bisection balances the work of two equal groups of workers.
//! Three workers get a half and two quarters, because the tree must not depend on the number of workers.
//!
//! **Work.** O(samples).

use super::draw::root;
use super::sampler::SAMPLE_TARGET;
use super::surface::Quadric;
use crate::cost::Cost;
use crate::point::Point;

/// Number of samples divided by `n^(2/3)`, for a population of `n` points. With `s` samples, the larger side has
/// `0.4 n / sqrt(s)` excess points on average. An excess point takes about 650 ns to triangulate, and a sample takes
/// about 20 ns to process. The total time is smallest near this factor.
const SHARE: f64 = 4.0;

/// The largest number of samples for a bisection. With this number, the larger side has 0.88 % more points than half of the
/// set on average. More samples would make the leader of a large group receive far more bytes than its members.
const MOST: u64 = 1 << 13;

/// Returns the expected number of samples for the bisection of a subproblem of `population` points. The number is the
/// same on every machine.
pub fn bisection_samples(population: u64) -> u64 {
    let n = population.max(1) as f64;
    let samples = (SHARE * n * root(1.0 / n, 3, &mut Cost::default())) as u64;
    samples.clamp(SAMPLE_TARGET, MOST)
}

/// Returns the two values around the median, which are equal if the number of values is odd. Reorders the values.
fn median_pair(values: &mut [f64]) -> Option<[f64; 2]> {
    let half = values.len() / 2;
    let odd = values.len() % 2 == 1;
    let (below, &mut upper, _) =
        (half < values.len()).then(|| values.select_nth_unstable_by(half, f64::total_cmp))?;
    let lower = below.iter().copied().max_by(f64::total_cmp).filter(|_| !odd).unwrap_or(upper);
    Some([lower, upper])
}

impl<P: Point> Quadric<P> {
    /// Returns the axis of a cut that [`Quadric::plane`] created.
    fn axis(&self) -> Option<usize> {
        let exact = self.a == 0.0 && self.c == 0.0 && self.unit == 1.0 && self.b.norm2() == 1.0;
        (0..P::DIM).find(|&i| exact && self.b.coord(i) == 1.0)
    }

    /// Returns the concentric sphere or parallel plane at the median of some points. If no values of `f` tie, the
    /// surface bisects the points. Returns `None` if the surface is degenerate after rounding.
    pub(super) fn moved_to_median(&self, points: impl Iterator<Item = P>) -> Option<Self> {
        if let Some(axis) = self.axis() {
            let [low, high] = median_pair(&mut points.map(|x| x.coord(axis)).collect::<Vec<f64>>())?;
            return Some(Quadric::between(axis, low, high));
        }
        let mut values: Vec<f64> = points.map(|x| self.value(self.local(x))).collect();
        let [low, high] = median_pair(&mut values)?;
        Self::from_coefficients(self.origin, self.unit, self.a, self.b, self.c - (0.5 * low + 0.5 * high))
    }

    /// Returns the number of points on the larger side.
    pub(super) fn larger_side(&self, points: &[P]) -> usize {
        let inside = points.iter().filter(|&&x| self.value(self.local(x)) < 0.0).count();
        inside.max(points.len() - inside)
    }

    /// Returns the surface moved to the median of the points, in any order, or the surface itself if moving does not
    /// improve the balance.
    pub(super) fn bisecting(self, points: &[P]) -> Self {
        let moved = self.moved_to_median(points.iter().copied());
        moved.filter(|moved| moved.larger_side(points) < self.larger_side(points)).unwrap_or(self)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::super::tests::{key, nasty, ratio, uniform};
    use super::super::{
        DrawKey, DrawKind, Quadric, SAMPLE_TARGET, Sampler, Separator, Side, cut_at_median, draw,
        draw_bisecting, split_bound,
    };
    use super::{bisection_samples, median_pair};
    use crate::cost::Cost;
    use crate::point::Point;

    #[test]
    fn medians_are_the_middle_values() {
        assert_eq!(median_pair(&mut []), None);
        assert_eq!(median_pair(&mut [3.0]), Some([3.0; 2]));
        assert_eq!(median_pair(&mut [9.0, 1.0]), Some([1.0, 9.0]));
        assert_eq!(median_pair(&mut [4.0, -2.0, 8.0]), Some([4.0; 2]));
        assert_eq!(median_pair(&mut [7.0, 1.0, 5.0, 2.0]), Some([2.0, 5.0]));
        assert_eq!(median_pair(&mut [1.0, f64::INFINITY, 2.0, f64::INFINITY]), Some([2.0, f64::INFINITY]));
    }

    /// Returns the points of a set that are samples of a draw.
    fn samples_of<P: Point>(key: DrawKey, points: &[P]) -> Vec<P> {
        let n = points.len() as u64;
        let many = Sampler::new(key, n, bisection_samples(n));
        points.iter().copied().filter(|&x| many.accepts(x)).collect()
    }

    /// Draws the separator of a set from its samples.
    fn separator_of<P: Point>(seed: u64, points: &[P]) -> Separator<P> {
        let key = DrawKey { seed, node: 1, attempt: 0 };
        let drawn = draw_bisecting(key, points.len() as u64, &samples_of(key, points), &mut Cost::default());
        drawn.separator.unwrap()
    }

    /// Separators bisect the set from which the samples come, and cross no more balls than separators of [`draw`].
    fn sets_are_bisected<P: Point>() {
        let points = uniform::<P>(200_000, 3);
        let n = points.len() as u64;
        let (mut crossing, mut crossing_drawn, mut worst_drawn) = (0, 0, 0.0f64);
        for seed in 0..20 {
            let key = DrawKey { seed, node: 1, attempt: 0 };
            let few = Sampler::new(key, n, SAMPLE_TARGET);
            let all = samples_of(key, &points);
            assert_eq!(
                points.iter().filter(|&&x| few.accepts(x)).count(),
                all.iter().filter(|&&x| few.accepts(x)).count()
            );
            assert!(all.len() > 7_800 && all.len() < 8_600, "{}", all.len());
            let halves = draw_bisecting(key, n, &all, &mut Cost::default());
            assert_eq!(halves.kind, DrawKind::Sphere);
            let s = halves.separator.unwrap();
            assert!((ratio(&s, &all) - halves.estimated_ratio).abs() < 1e-12);
            // Four standard deviations.
            assert!(ratio(&s, &points) < 0.5 + 2.0 / (all.len() as f64).sqrt());
            let planes = cut_at_median(key, n, &all, &mut Cost::default());
            assert!(ratio(&planes.separator.unwrap(), &points) < 0.5 + 2.0 / (all.len() as f64).sqrt());
            let mut turned = all.clone();
            turned.rotate_left(77);
            assert_eq!(draw_bisecting(key, n, &turned, &mut Cost::default()), halves);
            assert_eq!(cut_at_median(key, n, &turned, &mut Cost::default()), planes);
            let few: Vec<P> = all.iter().copied().filter(|&x| few.accepts(x)).collect();
            let drawn = draw(key, n, 10, &few, &mut Cost::default()).separator.unwrap();
            let sum =
                |s: &Separator<P>| s.count_crossing(points.iter().map(|&x| (x, 0.01))).iter().sum::<u64>();
            crossing += sum(&s);
            crossing_drawn += sum(&drawn);
            worst_drawn = worst_drawn.max(ratio(&drawn, &points));
        }
        assert!(crossing < crossing_drawn, "{crossing} and {crossing_drawn}");
        assert!(worst_drawn > 0.53, "{worst_drawn}: nothing to improve");
    }

    #[test]
    fn sets_are_bisected_in_both_dimensions() {
        sets_are_bisected::<DVec2>();
        sets_are_bisected::<DVec3>();
    }

    /// If a gap separates the points into near halves, the separator is not moved from the gap into a cluster.
    fn separators_stay_in_gaps<P: Point>() {
        let far = |x: P| x + P::splat(40.0);
        let points: Vec<P> = uniform::<P>(2000, 8)
            .into_iter()
            .enumerate()
            .map(|(i, x)| if i % 1000 < 499 { x } else { far(x) })
            .collect();
        let mut through = 0;
        for seed in 0..20 {
            let s = separator_of(seed, &points);
            through += usize::from((ratio(&s, &points) - 0.501).abs() < 1e-9);
        }
        assert!(through >= 14, "{through} of 20 go through the gap");
    }

    #[test]
    fn separators_stay_in_gaps_in_both_dimensions() {
        separators_stay_in_gaps::<DVec2>();
        separators_stay_in_gaps::<DVec3>();
    }

    /// For every set, the sides satisfy the bound and the separator can be encoded, whether all points are samples or
    /// only some.
    fn nasty_sets_are_split<P: Point>() {
        for (name, points) in nasty::<P>() {
            let n = points.len() as u64;
            // If only some points are samples, the sides of all are not bounded, but neither is empty.
            for (population, bound) in [(n, split_bound::<P>()), (4 * SAMPLE_TARGET, 1.0 - f64::EPSILON)] {
                let mut drawn_from_some = 0;
                for seed in 0..20 {
                    let drawn = draw_bisecting(key(seed), population, &points, &mut Cost::default());
                    let plane = cut_at_median(key(seed), population, &points, &mut Cost::default());
                    drawn_from_some += usize::from(drawn.separator.is_some());
                    for found in [drawn, plane] {
                        let Some(s) = found.separator else { continue };
                        assert!((ratio(&s, &points) - found.estimated_ratio).abs() < 1e-12, "{name}");
                        assert!(found.estimated_ratio <= bound, "{name}: {found:?}");
                        assert_eq!(Separator::from_array(s.to_array().as_ref()), Some(s), "{name}");
                    }
                }
                // A set of two or three points may have no samples.
                assert!(
                    drawn_from_some == 20 || points.len() < 100 && population > n,
                    "{name}: {drawn_from_some}"
                );
            }
        }
        let coincident = vec![P::splat(1.0); 9];
        assert!(draw_bisecting(key(1), 9, &coincident, &mut Cost::default()).separator.is_none());
        assert!(cut_at_median(key(1), 9, &coincident, &mut Cost::default()).separator.is_none());
        assert!(draw_bisecting::<P>(key(1), 9, &[], &mut Cost::default()).separator.is_none());
    }

    #[test]
    fn nasty_sets_are_split_in_both_dimensions() {
        nasty_sets_are_split::<DVec2>();
        nasty_sets_are_split::<DVec3>();
    }

    /// If most points nearly coincide, a plane replaces the sphere. It bisects the other points as accurately as the
    /// samples permit.
    #[test]
    fn fallback_planes_are_moved() {
        let points: Vec<DVec3> = uniform::<DVec3>(4000, 6)
            .into_iter()
            .map(|x| DVec3::new(x.x, 1e300 * x.y.powi(400), 0.0))
            .collect();
        let mut planes = 0;
        for seed in 0..20 {
            let s = separator_of(seed, &points);
            if s.is_sphere() {
                continue;
            }
            planes += 1;
            assert!(ratio(&s, &points) < 0.5 + 2.0 / (bisection_samples(4000) as f64).sqrt());
        }
        assert!(planes > 0);
    }

    /// A moved plane still cuts by exact comparison.
    #[test]
    fn moved_planes_cut_exactly() {
        let at = [1.0, 1.0 + f64::EPSILON, 1.0 + 2.0 * f64::EPSILON, 7e22];
        let points = at.map(|x| DVec2::new(0.25, x));
        let plane = Quadric::plane(1, 5e22).bisecting(&points);
        assert_eq!(plane, Quadric::plane(1, 1.0 + 2.0 * f64::EPSILON));
        assert_eq!(points.map(|x| plane.side(x) == Side::Interior), [true, true, false, false]);
        let equal = [DVec2::ONE; 3];
        assert_eq!(plane.bisecting(&equal), plane);
        assert_eq!(plane.bisecting(&[]), plane);
    }

    #[test]
    fn targets_grow_with_the_population() {
        let targets = [0, 1, 400, 1000, 8000, 64_000, 1_000_000, 1 << 36].map(bisection_samples);
        assert_eq!(targets, [400, 400, 400, 400, 1599, 6399, 1 << 13, 1 << 13]);
    }
}
