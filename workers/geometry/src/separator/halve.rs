//! Moving a separator to the middle of a set.
//!
//! **Statement.** The surfaces `f = m` of a separator's function `f` are concentric spheres, or parallel planes. At the
//! median `m` of `f` over `s` points drawn at random from a set it leaves on either side half of the set, with a standard
//! deviation of `1 / (2 sqrt(s))` of it (a binomial quantile, whatever the distribution).
//!
//! **Why.** Where each worker triangulates its piece at once, the largest piece is what all wait for; the samples that a
//! separator is drawn from know the halves to 0.025 of the set only. With [`halving_target`] samples what waiting costs is
//! about what sending and looking at more of them would.
//!
//! **Departure.** A moved sphere is no great circle through the centrepoint: the theorem bounds neither its sides, which are
//! counted, nor the balls that it crosses, which are estimated as for any ([`super::draw()`]). So it is used only where
//! neither work nor depth is claimed.
//!
//! **Work.** O(samples).

use super::{SAMPLE_TARGET, Separator};
use crate::point::Point;

/// Samples to know the middle by: so many times the population to the power 2/3.
const SHARE: f64 = 4.0;

/// Expected number of samples that a subproblem of so many points is halved by.
pub fn halving_target(population: u64) -> u64 {
    let root = (population as f64).cbrt();
    SAMPLE_TARGET.max((SHARE * root * root) as u64)
}

/// The middle of some numbers, which are put in another order: that of the two next to it, or the one there is.
fn middle(values: &mut [f64]) -> Option<f64> {
    let half = values.len() / 2;
    let odd = values.len() % 2 == 1;
    let (below, &mut upper, _) =
        (half < values.len()).then(|| values.select_nth_unstable_by(half, f64::total_cmp))?;
    let lower = below.iter().copied().max_by(f64::total_cmp).filter(|_| !odd).unwrap_or(upper);
    Some(0.5 * lower + 0.5 * upper)
}

impl<P: Point> Separator<P> {
    /// The concentric sphere, or the parallel plane, that halves some points best; nothing if there is none after rounding.
    pub(super) fn moved_to_middle(&self, points: impl Iterator<Item = P>) -> Option<Self> {
        let mut values: Vec<f64> = points.map(|x| self.value(self.local(x))).collect();
        let middle = middle(&mut values)?;
        Self::from_coefficients(self.origin, self.unit, self.a, self.b, self.c - middle)
    }

    /// Points on the larger side.
    fn larger_side(&self, points: &[P]) -> usize {
        let inside = points.iter().filter(|&&x| self.value(self.local(x)) < 0.0).count();
        inside.max(points.len() - inside)
    }

    /// The same surface moved to the middle of points, in any order, or as it is if that halves them no worse.
    #[must_use]
    pub fn halving(self, points: &[P]) -> Self {
        let moved = self.moved_to_middle(points.iter().copied());
        moved.filter(|moved| moved.larger_side(points) < self.larger_side(points)).unwrap_or(self)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::super::tests::{key, nasty, ratio, uniform};
    use super::super::{DrawKey, DrawKind, Sampler, Separator, draw, draw_halves, split_bound};
    use super::{halving_target, middle};
    use crate::cost::Cost;
    use crate::point::Point;

    #[test]
    fn middles_are_medians() {
        assert_eq!(middle(&mut []), None);
        assert_eq!(middle(&mut [3.0]), Some(3.0));
        assert_eq!(middle(&mut [9.0, 1.0]), Some(5.0));
        assert_eq!(middle(&mut [4.0, -2.0, 8.0]), Some(4.0));
        assert_eq!(middle(&mut [7.0, 1.0, 5.0, 2.0]), Some(3.5));
        assert_eq!(middle(&mut [1.0, f64::INFINITY, 2.0, f64::INFINITY]), Some(f64::INFINITY));
    }

    /// Surfaces moved to the middle of a sample halve the set that it is of, and cross no more balls than those that are not.
    fn sets_are_halved<P: Point>() {
        let points = uniform::<P>(200_000, 3);
        let n = points.len() as u64;
        let (mut crossing, mut crossing_drawn) = (0, 0);
        for seed in 0..20 {
            let key = DrawKey { seed, node: 1, attempt: 0 };
            let few = Sampler::of(key, n);
            let many = Sampler::aiming(key, n, halving_target(n));
            assert!(points.iter().all(|&x| many.takes(x) || !few.takes(x)));
            let all: Vec<P> = points.iter().copied().filter(|&x| many.takes(x)).collect();
            let few: Vec<P> = all.iter().copied().filter(|&x| few.takes(x)).collect();
            assert!(all.len() > 13_000 && all.len() < 14_400, "{}", all.len());
            let drawn = draw_halves(key, n, &few, &mut Cost::default());
            assert!(drawn.halves && drawn.kind == DrawKind::Sphere);
            assert!(drawn.estimated_ratio < 0.51);
            let halves = drawn.separator.unwrap().halving(&all);
            // Four standard deviations.
            assert!(ratio(&halves, &points) < 0.5 + 2.0 / (all.len() as f64).sqrt());
            let mut turned = all.clone();
            turned.rotate_left(77);
            assert_eq!(drawn.separator.unwrap().halving(&turned), halves);
            let balls = || points.iter().map(|&x| (x, 0.01));
            let sum = |s: &Separator<P>| s.count_crossing(balls()).iter().sum::<u64>();
            crossing += sum(&halves);
            crossing_drawn += sum(&draw(key, n, &few, &mut Cost::default()).separator.unwrap());
        }
        assert!(crossing < crossing_drawn, "{crossing} and {crossing_drawn}");
    }

    #[test]
    fn sets_are_halved_in_both_dimensions() {
        sets_are_halved::<DVec2>();
        sets_are_halved::<DVec3>();
    }

    /// Whatever the set: sides that are good enough, none worse for being moved, and a separator that goes over the wire.
    fn nasty_sets_are_not_worse<P: Point>() {
        for (name, points) in nasty::<P>() {
            for seed in 0..20 {
                let drawn = draw_halves(key(seed), 1 << 20, &points, &mut Cost::default());
                let s = drawn.separator.unwrap();
                assert_eq!(ratio(&s, &points), drawn.estimated_ratio, "{name}");
                assert!(drawn.estimated_ratio <= split_bound::<P>(), "{name}");
                let moved = s.halving(&points);
                assert!(ratio(&moved, &points) <= ratio(&s, &points), "{name}");
                assert_eq!(Separator::from_array(&moved.to_array()), Some(moved), "{name}");
            }
        }
        let coincident = vec![P::splat(1.0); 9];
        assert!(draw_halves(key(1), 9, &coincident, &mut Cost::default()).separator.is_none());
        let plane = Separator::plane(0, 0.5);
        assert_eq!(plane.halving(&coincident), plane);
        assert_eq!(plane.halving(&[]), plane);
    }

    #[test]
    fn nasty_sets_are_not_worse_in_both_dimensions() {
        nasty_sets_are_not_worse::<DVec2>();
        nasty_sets_are_not_worse::<DVec3>();
    }

    #[test]
    fn targets_grow_with_the_population() {
        assert_eq!([0, 1, 400, 1000, 1_000_000].map(halving_target), [400, 400, 400, 400, 40_000]);
    }
}
