//! Separators that lack one part of the draw: the centrepoint, the conformal map, the great circle or the score.
//!
//! **Statement.** [`draw_ablated`] draws like [`super::draw()`], except for one part. The comparison of both shows the
//! effect of that part on balance and on crossed balls. A test of the separator theorem must fail for such separators.
//!
//! **Work and depth.** At most those of [`super::draw()`].

use rand_chacha::ChaCha8Rng;

use super::centrepoint::{has_room, pull_back, unit_vector};
use super::draw::{cut, draw_by};
use super::drawn::{DrawKind, Drawn, PlaneReason};
use super::key::DrawKey;
use super::surface::Separator;
use crate::cost::Cost;
use crate::point::{Point, Vector};

/// A part of the draw that is removed or replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ablation {
    /// Great circles pass through the centre of the lift, not through a centrepoint.
    NoCentrepoint,
    /// The normals of planes through the centrepoint are uniform. No conformal map corrects their distribution.
    NoMap,
    /// The first admissible great circle is used, whatever its score.
    NoScoring,
    /// Planes with random normals replace great circles. Each plane bisects the samples.
    RandomPlanes,
    /// Planes across the longest side of the box of the samples replace great circles ([`super::cut`]).
    MedianPlanes,
}

impl Ablation {
    /// All ablations.
    pub const ALL: [Ablation; 5] = [
        Ablation::NoCentrepoint,
        Ablation::NoMap,
        Ablation::NoScoring,
        Ablation::RandomPlanes,
        Ablation::MedianPlanes,
    ];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Ablation::NoCentrepoint => "no-centrepoint",
            Ablation::NoMap => "no-map",
            Ablation::NoScoring => "no-scoring",
            Ablation::RandomPlanes => "random-planes",
            Ablation::MedianPlanes => "median-planes",
        }
    }
}

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

/// The way in which the surfaces of a draw are made and compared.
#[derive(Clone, Copy)]
pub(super) enum Method<'a, P> {
    /// Great circles through the centrepoint, by their scores.
    Whole,
    /// As [`Method::Whole`], moved to the median of these samples.
    Bisecting(&'a [P]),
    /// As [`Method::Whole`], without one part.
    Without(Ablation),
}

/// The frame of the samples, and their centrepoint in the lift.
#[derive(Clone, Copy)]
pub(super) struct Centred<P: Point> {
    pub(super) origin: P,
    pub(super) unit: f64,
    pub(super) centre: P::Lifted,
}

impl<'a, P: Point> Method<'a, P> {
    /// Returns the samples whose median the surface is moved to, if it is moved.
    pub(super) fn bisected(self) -> Option<&'a [P]> {
        if let Method::Bisecting(all) = self { Some(all) } else { None }
    }

    /// Returns `true` if the method lacks this part of the draw.
    pub(super) fn lacks(self, part: Ablation) -> bool {
        matches!(self, Method::Without(ablation) if ablation == part)
    }

    /// Returns the kind of the surfaces.
    pub(super) fn kind(self) -> DrawKind {
        if self.lacks(Ablation::RandomPlanes) {
            DrawKind::Plane { why: PlaneReason::AskedFor }
        } else {
            DrawKind::Sphere
        }
    }

    /// Draws one surface. `local` contains the samples in local coordinates.
    pub(super) fn surface(
        self,
        at: Centred<P>,
        local: &[P],
        rng: &mut ChaCha8Rng,
        cost: &mut Cost,
    ) -> Option<Separator<P>> {
        let Centred { origin, unit, centre } = at;
        if self.lacks(Ablation::RandomPlanes) {
            let normal: P = unit_vector(rng, cost)?;
            let mut along = cost.map(local, |&y| normal.dot(y));
            cost.sort(&mut along, f64::total_cmp);
            let half = along.len() / 2;
            let middle = 0.5 * along[half.saturating_sub(1)] + 0.5 * along[half];
            return Separator::from_coefficients(origin, unit, 0.0, normal, -middle);
        }
        let normal: P::Lifted = unit_vector(rng, cost)?;
        if self.lacks(Ablation::NoMap) {
            return has_room(centre).then(|| unmapped(origin, unit, centre, normal)).flatten();
        }
        pull_back(origin, unit, centre, normal)
    }
}

/// Computes the surface whose lift lies in the plane `n . (p - z) = 0`. The normal `n` is not corrected for the
/// distance of `z` from the centre.
fn unmapped<P: Point>(origin: P, unit: f64, z: P::Lifted, n: P::Lifted) -> Option<Separator<P>> {
    let (vertical, constant) = (n.coord(P::DIM), -n.dot(z));
    let mut b = P::splat(0.0);
    for i in 0..P::DIM {
        b.set_coord(i, 2.0 * n.coord(i));
    }
    Separator::from_coefficients(origin, unit, vertical + constant, b, constant - vertical)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

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
        let b = drawn.expect("a plane").b;
        assert!((0..3).filter(|&i| b.coord(i).abs() > 0.05).count() >= 2, "{b}");
    }

    #[test]
    fn coincident_points_have_no_separator() {
        for ablation in Ablation::ALL {
            let points = [DVec2::ONE; 5];
            assert!(draw_ablated(ablation, key(1), 5, 10, &points, &mut Cost::default()).separator.is_none());
        }
    }
}
