//! Separators that lack one part of the draw: the centrepoint, the conformal map, the great circle or the score.
//!
//! **Statement.** [`draw_ablated`] draws like [`super::draw()`], except for one part. The comparison of both shows the
//! effect of that part on balance and on crossed balls. A test of the separator theorem must fail for such separators.
//!
//! **Work and depth.** At most those of [`super::draw()`].

use super::draw::{cut, draw_by};
use super::drawn::Drawn;
use super::key::DrawKey;
use super::method::{Ablation, Method};
use crate::cost::Cost;
use crate::point::Point;

/// Draws one separator from the samples of a subproblem of `population` points, by the best of `tries` surfaces, without
/// one part of the draw.
pub fn draw_ablated<P: Point>(
    ablation: Ablation,
    key: DrawKey,
    population: u64,
    tries: u32,
    samples: &[P],
    cost: &mut Cost,
) -> Drawn<P> {
    if ablation == Ablation::MedianPlanes {
        return cut(key, samples, cost);
    }
    let mut own = cost.nested();
    let drawn = draw_by(Method::Without(ablation), key, population, tries, samples, &mut own);
    cost.then(own);
    drawn
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::super::drawn::DrawKind;
    use super::super::tests::{key, ratio, uniform};
    use super::super::{draw, split_bound};
    use super::*;

    /// All ablations split uniform points and are admissible. Each yields other surfaces than the draw.
    fn ablations_split<P: Point>() {
        let points = uniform::<P>(400, 3);
        for ablation in Ablation::ALL {
            let mut others = 0;
            for seed in 0..20 {
                let found = draw_ablated(ablation, key(seed), 400, 10, &points, &mut Cost::default());
                let separator = found.separator.expect("points in general position");
                let is_planar = [Ablation::RandomPlanes, Ablation::MedianPlanes].contains(&ablation);
                assert_eq!(matches!(found.kind, DrawKind::Plane { .. }), is_planar, "{ablation:?}");
                assert_eq!(separator.is_sphere(), !is_planar, "{ablation:?}");
                assert!(ratio(&separator, &points) <= split_bound::<P>(), "{ablation:?}");
                if is_planar {
                    assert!(ratio(&separator, &points) < 0.51, "{ablation:?} bisects");
                }
                let whole = draw(key(seed), 400, 10, &points, &mut Cost::default());
                others += usize::from(whole.separator != found.separator);
                assert!(ablation != Ablation::NoScoring || found.score >= whole.score);
            }
            assert!(others >= 10, "{ablation:?}: {others} of 20 are different");
        }
    }

    #[test]
    fn ablations_split_in_both_dimensions() {
        ablations_split::<DVec2>();
        ablations_split::<DVec3>();
    }

    #[test]
    fn random_planes_are_not_parallel_to_an_axis() {
        let points = uniform::<DVec3>(400, 3);
        let drawn =
            draw_ablated(Ablation::RandomPlanes, key(1), 400, 10, &points, &mut Cost::default()).separator;
        let words = drawn.expect("a plane").to_array();
        assert!(words[5..8].iter().filter(|b| b.abs() > 0.05).count() >= 2, "{words:?}");
    }

    #[test]
    fn coincident_points_have_no_separator() {
        for ablation in Ablation::ALL {
            let points = [DVec2::ONE; 5];
            assert!(draw_ablated(ablation, key(1), 5, 10, &points, &mut Cost::default()).separator.is_none());
        }
    }
}
