//! The reasons why generation refuses a domain.
//!
//! **Statement.** A domain is *too coarse* if the local feature size at a corner, or at the middle of a segment, is below
//! [`FINEST`] steps of the grid of its coordinates ([`crate::frame`]). Parts of features that are missing at the end
//! are missing because of
//! 1. *rounding*, if recovery divided a part down to the rounding of coordinates;
//! 2. *small angles*, if one of the features meets another feature at less than [`SMALL`] degrees;
//! 3. *rounds*, otherwise: recovery did not end within its limit.
//!
//! **Work and depth.** One local feature size for each corner and segment; one test for each pair of features that meet.

use super::error::{Missing, Reason};
use crate::distance::Features;
use crate::domain::{Domain, Feature};
use crate::frame::FINEST;
use crate::space::Space;

/// The angle in degrees below which recovery may not end.
const SMALL: f64 = 60.0;

/// A domain whose coordinates are too coarse for its features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarse {
    /// The feature with the smallest local feature size.
    pub feature: Feature,
    /// The local feature size there, in the unit of the file.
    pub size: f64,
    /// The step between adjacent coordinates, in the unit of the file.
    pub step: f64,
}

impl Coarse {
    /// Returns the smallest feature of a domain if the coordinates are too coarse for it. Ask before sizes are
    /// computed, because a tree of such sizes may need very many cells.
    pub fn of<P: Space>(domain: &Domain<P>, features: &Features<P>) -> Option<Self> {
        let frame = &domain.simplices.frame;
        if !frame.is_translated() {
            return None;
        }
        let at = |v: u32| domain.points()[v as usize];
        let corners = (0u32..).zip(&domain.corners).map(|(c, &v)| (Feature::Corner(c), at(v)));
        let middles = (0u32..).zip(&domain.segments).map(|(s, segment)| {
            let [a, b] = segment.ends();
            (Feature::Segment(s), (at(a) + at(b)) * 0.5)
        });
        let sizes = corners.chain(middles).map(|(feature, x)| (features.local_size(x).radius, feature));
        let (size, feature) = sizes.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        let is_coarse = size < FINEST * frame.grid();
        is_coarse.then(|| Coarse { feature, size: frame.length(size), step: frame.length(frame.grid()) })
    }
}

impl Missing {
    /// Names the missing features of a domain, and why they are missing.
    pub(crate) fn of<P: Space>(domain: &Domain<P>, features: Vec<(Feature, u32)>, is_rounded: bool) -> Self {
        let named = |f: &Feature| features.binary_search_by_key(f, |&(f, _)| f).is_ok();
        let reason = if is_rounded {
            Reason::Rounding
        } else if domain.small_angles(SMALL).iter().any(|small| small.features.iter().any(named)) {
            Reason::Angles
        } else {
            Reason::Rounds
        };
        Missing { features, reason }
    }
}
