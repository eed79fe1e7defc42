//! Point sets to try things on: random, degenerate, clustered, and f-spaced with a known constant.
//!
//! A set is a function of (kind, number, dimension, seed, Lipschitz constant) and nothing else: no clock decides
//! anything, no number of threads, no library function beyond the square root. All kinds live in the unit square or
//! cube; the f-spaced ones are made on the machine (`spaced`).

mod draw;
mod faces;
mod kind;
mod search;
mod shapes;
mod sizing;
mod spaced;
pub mod unit;

use glam::{DVec2, DVec3};
pub use kind::{Kind, parse_sample};
use sizing::Sizing;
use thiserror::Error;
use unit::Unit;

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
    dimension: usize,
    sizing: Sizing,
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

/// Generates a set.
///
/// # Errors
///
/// Refuses dimensions other than 2 and 3, numbers of points above the kind's limit, and Lipschitz
/// constants that are out of range or that the kind has no use for.
pub fn generate(
    request: &Request,
    progress: &mut dyn FnMut(&str, u64, u64),
) -> Result<Generated, GenerateError> {
    check(request)?;
    match request.dimension {
        2 => typed::<DVec2>(request, Points::Plane, progress),
        _ => typed::<DVec3>(request, Points::Space, progress),
    }
}

fn check(request: &Request) -> Result<(), GenerateError> {
    let Request { kind, n, dimension, lipschitz, .. } = *request;
    if !(2..=3).contains(&dimension) {
        return Err(GenerateError::Dimension(dimension));
    }
    if let Some(constant) = lipschitz {
        if !kind.is_graded() {
            return Err(GenerateError::LipschitzUnused(kind));
        }
        if !(constant > 0.0 && constant < 1.0) {
            return Err(GenerateError::Lipschitz(constant));
        }
    }
    let limit = kind.limit(dimension);
    if n > limit {
        return Err(GenerateError::TooMany { kind, n, limit });
    }
    Ok(())
}

fn typed<P: Unit>(
    request: &Request,
    wrap: fn(Vec<P>) -> Points,
    progress: &mut Progress,
) -> Result<Generated, GenerateError> {
    let mut notes = Vec::new();
    let mut spacing = None;
    let spaced = request.kind.is_spaced();
    let points = if spaced {
        let found = search::spaced_set::<P>(request, progress)?;
        let sizing = found.sizing;
        spacing = Some(Spacing { lipschitz: sizing.slope, dimension: P::DIM, sizing });
        notes = found.notes;
        found.points
    } else {
        progress(request.kind.name(), 0, request.n);
        let points = shapes::points::<P>(request);
        progress(request.kind.name(), request.n, request.n);
        points
    };
    if !spaced && points.len() as u64 != request.n {
        let (made, asked) = (points.len(), request.n);
        notes.push(format!("{made} points, {asked} asked for: {}", request.kind.count_rule()));
    }
    Ok(Generated { points: wrap(points), spacing, requested: request.n, notes })
}

#[cfg(test)]
mod tests;
