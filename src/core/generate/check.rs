//! Checks of requests and of numbers of points.

use super::request::{GenerateError, Request};
use super::shells;

/// Checks that the set of a request can be generated.
pub(super) fn request(request: &Request) -> Result<(), GenerateError> {
    let Request { kind, n, dimension, lipschitz, .. } = *request;
    if !(2..=6).contains(&dimension) {
        return Err(GenerateError::Dimension(dimension));
    }
    if dimension > 3 && !kind.is_of_any_dimension() {
        return Err(GenerateError::KindOfSpace { kind, dimension });
    }
    if let Some(constant) = lipschitz {
        if !kind.is_graded() {
            return Err(GenerateError::LipschitzUnused(kind));
        }
        if !(constant > 0.0 && constant < 1.0) {
            return Err(GenerateError::Lipschitz(constant));
        }
    }
    shells::check(request)?;
    let limit = kind.limit(dimension);
    if n > limit {
        return Err(GenerateError::TooMany { kind, n, limit });
    }
    Ok(())
}

/// Returns the note on a set that is not f-spaced and has another number of points than requested.
pub(super) fn count(request: &Request, made: u64) -> Option<String> {
    let Request { kind, n, .. } = *request;
    let rule = || format!("{made} points instead of {n}: {}", kind.count_rule());
    (!kind.is_spaced() && made != n).then(rule)
}
