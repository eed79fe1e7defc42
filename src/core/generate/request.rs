//! What is asked of a generator, and what it gives or refuses.

use glam::{DVec2, DVec3};
use thiserror::Error;

use super::kind::{self, Kind};
use super::sizing::Sizing;
use crate::model::Points;

/// What to generate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The kind of set.
    pub kind: Kind,
    /// Number of points asked for; see [`Kind`] for what the kinds make of it.
    pub n: u64,
    /// 2 or 3.
    pub dimension: usize,
    /// The seed of all draws.
    pub seed: u64,
    /// The Lipschitz constant of the graded kinds, between 0 and 1; 0.25 if not given.
    pub lipschitz: Option<f64>,
}

/// The guarantee of an f-spaced set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// The Lipschitz constant of the size function; 0 for constant size.
    pub lipschitz: f64,
    pub(super) dimension: usize,
    pub(super) sizing: Sizing,
}

impl Spacing {
    /// The size function at a place; in the plane its third coordinate does not count.
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
    /// For f-spaced sets, the constant of f.
    pub spacing: Option<Spacing>,
    /// The number asked for.
    pub requested: u64,
    /// What a reader of the report should know, one sentence each.
    pub notes: Vec<String>,
}

/// Why a set could not be generated.
#[derive(Debug, Error)]
pub enum GenerateError {
    /// No such kind.
    #[error("unknown kind of point set `{name}`; known kinds: {}", kind::names())]
    UnknownKind {
        /// As given.
        name: String,
    },
    /// Neither 2 nor 3.
    #[error("dimension {0} is not supported: 2 or 3")]
    Dimension(usize),
    /// Outside the open interval from 0 to 1.
    #[error("lipschitz = {0} is not between 0 and 1 (both excluded)")]
    Lipschitz(f64),
    /// A constant for a kind that has none.
    #[error("`{0}` takes no lipschitz constant: only graded kinds do")]
    LipschitzUnused(Kind),
    /// More points than the kind can have.
    #[error("{n} points are too many for `{kind}`: at most {limit}")]
    TooMany {
        /// The kind.
        kind: Kind,
        /// Points asked for.
        n: u64,
        /// The largest number allowed.
        limit: u64,
    },
    /// A sample specification that cannot be read.
    #[error("cannot read the sample `{spec}`: {reason}")]
    Spec {
        /// As given.
        spec: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The machine that makes an f-spaced set failed.
    #[error("an f-spaced set could not be made")]
    Machine(#[from] crate::Error),
    /// An f-spaced set could not be completed.
    #[error("an f-spaced set could not be completed: {reason}; this is a fault of septet")]
    Incomplete {
        /// What went wrong.
        reason: String,
    },
}

/// Reports progress: what is being done, how much of it is done, and how much there is.
pub type Progress<'a> = dyn FnMut(&str, u64, u64) + 'a;
