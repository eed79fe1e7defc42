//! The ways in which the surfaces of a draw are made: all parts of the draw, or all but one.

use rand_chacha::ChaCha8Rng;

use super::centrepoint::{has_room, pull_back, unit_vector};
use super::drawn::{DrawKind, PlaneReason};
use super::surface::Quadric;
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
    ) -> Option<Quadric<P>> {
        let Centred { origin, unit, centre } = at;
        if self.lacks(Ablation::RandomPlanes) {
            let normal: P = unit_vector(rng, cost)?;
            let mut along = cost.map(local, |&y| normal.dot(y));
            cost.sort(&mut along, f64::total_cmp);
            let half = along.len() / 2;
            let middle = 0.5 * along[half.saturating_sub(1)] + 0.5 * along[half];
            return Quadric::from_coefficients(origin, unit, 0.0, normal, -middle);
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
fn unmapped<P: Point>(origin: P, unit: f64, z: P::Lifted, n: P::Lifted) -> Option<Quadric<P>> {
    let (vertical, constant) = (n.coord(P::DIM), -n.dot(z));
    let mut b = P::splat(0.0);
    for i in 0..P::DIM {
        b.set_coord(i, 2.0 * n.coord(i));
    }
    Quadric::from_coefficients(origin, unit, vertical + constant, b, constant - vertical)
}
