//! The result of a draw: a surface with its estimates, or the reason why there is none.

use super::kinds::Separator;
use crate::point::Point;

/// The reason why a plane replaces the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneReason {
    /// The centrepoint lies on the lifted sphere: most samples coincide at the scale of the rest.
    CentreOnSphere,
    /// Every great circle left a side empty or violated the split bound on the samples.
    NoAdmissibleCircle,
    /// The caller requested a plane ([`super::cut`]).
    AskedFor,
}

/// The reason why there is no separator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoneReason {
    /// There are no samples.
    NoSamples,
    /// All samples have the same coordinates.
    Coincident,
}

/// The kind of surface that was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawKind {
    /// The preimage of a great circle, or a sphere concentric with one ([`super::draw_bisecting`]).
    Sphere,
    /// An axis-aligned plane.
    Plane {
        /// The reason why it is not a sphere.
        why: PlaneReason,
    },
    /// A cut of a Hilbert curve ([`super::cut_curve`]).
    Curve,
    /// No surface.
    None {
        /// The reason why there is no surface.
        why: NoneReason,
    },
}

/// The result of a draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn<P> {
    /// The surface, unless there are fewer than two distinct samples.
    pub separator: Option<Separator<P>>,
    /// Kind of the surface.
    pub kind: DrawKind,
    /// Score of the surface; lower is better: `estimated_ratio + SCORE_ALPHA * estimated_crossing`.
    pub score: f64,
    /// Fraction of the samples on the larger side.
    pub estimated_ratio: f64,
    /// Estimated fraction of the population whose nearest-neighbour balls (alpha 1) cross the surface.
    pub estimated_crossing: f64,
    /// Number of admissible great circles among those of a draw. In [`super::draw_bisecting`], circles that are admissible after
    /// they are moved also count.
    pub admissible: u32,
    /// Number of groups of samples whose mean replaced a Radon point.
    pub means: u32,
}

impl<P: Point> Drawn<P> {
    pub(super) fn none(why: NoneReason) -> Self {
        Drawn {
            separator: None,
            kind: DrawKind::None { why },
            score: 1.0,
            estimated_ratio: 1.0,
            estimated_crossing: 0.0,
            admissible: 0,
            means: 0,
        }
    }
}
