//! The request for a set, its result, and its errors.

use glam::{DVec2, DVec3};
use thiserror::Error;

use super::kind::{self, Kind};
use super::sizing::Sizing;
use crate::model::Points;
use crate::remedy::Remedy;

/// The default Lipschitz constant of the graded kinds.
pub const GRADED_LIPSCHITZ: f64 = 0.25;

/// The default ratio of consecutive radii of [`Kind::Shells`].
pub const SHELL_RATIO: f64 = 1.3;

/// The request for a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The kind of set.
    pub kind: Kind,
    /// The number of points requested. [`Kind`] documents how the kinds round it.
    pub n: u64,
    /// 2 to 6.
    pub dimension: usize,
    /// The seed of all draws.
    pub seed: u64,
    /// The Lipschitz constant of the graded kinds, between 0 and 1. The default is [`GRADED_LIPSCHITZ`].
    pub lipschitz: Option<f64>,
    /// The ratio of consecutive radii of [`Kind::Shells`], above 1. The default is [`SHELL_RATIO`].
    pub ratio: Option<f64>,
}

/// The guarantee of an f-spaced set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// The Lipschitz constant of the size function. It is 0 if the size is constant.
    pub lipschitz: f64,
    pub(super) dimension: usize,
    pub(super) sizing: Sizing,
}

impl Spacing {
    /// Evaluates the size function at a point. In the plane, the third coordinate is ignored.
    pub fn size(&self, [x, y, z]: [f64; 3]) -> f64 {
        match self.dimension {
            2 => self.sizing.at(&DVec2::new(x, y)),
            _ => self.sizing.at(&DVec3::new(x, y, z)),
        }
    }
}

/// A generated set.
#[derive(Clone, Debug, PartialEq)]
pub struct Generated {
    /// The points.
    pub points: Points,
    /// The spacing of an f-spaced set. `None` for other kinds.
    pub spacing: Option<Spacing>,
    /// The number of points requested.
    pub requested: u64,
    /// Notes for the reader of the report, one sentence each.
    pub notes: Vec<String>,
}

/// Errors of the generation of a set.
#[derive(Debug, Error)]
pub enum GenerateError {
    /// The kind is unknown.
    #[error("unknown kind of point set `{name}`")]
    UnknownKind {
        /// The name as given.
        name: String,
    },
    /// The dimension is not between 2 and 6.
    #[error("dimension {0} is not supported: 2 to 6")]
    Dimension(usize),
    /// The kind exists in the plane and in space only.
    #[error("`{kind}` exists in dimensions 2 and 3, not in dimension {dimension}")]
    KindOfSpace {
        /// The kind.
        kind: Kind,
        /// The dimension requested.
        dimension: usize,
    },
    /// The constant is outside the open interval from 0 to 1.
    #[error("lipschitz = {0} is not between 0 and 1 (both excluded)")]
    Lipschitz(f64),
    /// The kind has no Lipschitz constant.
    #[error("`{0}` does not use a lipschitz constant: only graded kinds do")]
    LipschitzUnused(Kind),
    /// The ratio of radii is not a finite number above 1.
    #[error("ratio = {0} is not a finite number above 1")]
    Ratio(f64),
    /// The kind has no ratio of radii.
    #[error("`{0}` does not use a ratio: only shells do")]
    RatioUnused(Kind),
    /// The radii of that many shells exceed the range in which signs are exact.
    #[error(
        "{n} points on shells of ratio {ratio} exceed the range of exact coordinates: at most {limit} points"
    )]
    TooManyShells {
        /// The number of points requested.
        n: u64,
        /// The ratio of consecutive radii.
        ratio: f64,
        /// The largest number of points with this ratio.
        limit: u64,
    },
    /// The kind cannot have that many points.
    #[error("{n} points are too many for `{kind}`: at most {limit}")]
    TooMany {
        /// The kind.
        kind: Kind,
        /// The number of points requested.
        n: u64,
        /// The largest number allowed.
        limit: u64,
    },
    /// The specification of a sample cannot be parsed.
    #[error("cannot read the sample `{spec}`: {reason}")]
    Spec {
        /// The specification as given.
        spec: String,
        /// The reason.
        reason: String,
    },
    /// The machine that generates an f-spaced set failed.
    #[error("the generation of an f-spaced set failed")]
    Machine(#[from] crate::Error),
    /// The generation of an f-spaced set did not finish.
    #[error("the generation of an f-spaced set did not finish: {reason}")]
    Incomplete {
        /// The failure.
        reason: String,
    },
}

impl GenerateError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(match self {
            Self::UnknownKind { .. } => Remedy::of("use one of ").and(kind::names()),
            Self::KindOfSpace { .. } => Remedy::of("use one of ").and(kind::names_of_any_dimension()),
            Self::TooManyShells { .. } => Remedy::of("reduce the number of points or the ratio"),
            Self::TooMany { .. } => Remedy::of("reduce the number of points"),
            Self::Machine(error) => return error.remedy(),
            Self::Incomplete { .. } => Remedy::REPORT,
            Self::Dimension(_)
            | Self::Lipschitz(_)
            | Self::LipschitzUnused(_)
            | Self::Ratio(_)
            | Self::RatioUnused(_)
            | Self::Spec { .. } => return None,
        })
    }
}

/// A callback for progress. Its arguments are the name of the step, the amount done, and the total amount.
pub type GenerateProgress<'a> = dyn FnMut(&str, u64, u64) + 'a;
