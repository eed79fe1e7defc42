//! Point sets for experiments: random, degenerate, clustered, and f-spaced with a known constant.
//!
//! A set is a function of (kind, number, dimension, seed, Lipschitz constant, ratio). It does not depend on a clock, on
//! the number of threads, or on any library function except the square root. All kinds lie in the unit cube of their dimension,
//! except shells, which lie around the origin. The machine generates the f-spaced kinds (`spaced`).

mod bodies;
mod check;
mod draw;
mod faces;
mod kind;
mod notation;
mod request;
mod rows;
mod search;
mod shapes;
mod shells;
mod sizing;
mod spaced;
pub mod unit;

use glam::{DVec2, DVec3};
pub use kind::Kind;
pub use notation::parse_sample;
pub use request::{
    GRADED_LIPSCHITZ, GenerateError, GenerateProgress, Generated, Request, SHELL_RATIO, Spacing,
};
pub use rows::SeparateRows;
use unit::Unit;

use crate::model::{HigherPoints, Points};
use septet_geometry::point::Point;

/// Generates a set.
///
/// # Errors
///
/// Fails if the dimension is not between 2 and 6, if the kind does not exist in it, or if the number of points is above the limit of the kind. Also fails
/// if the Lipschitz constant or the ratio is out of range, or if the kind does not use one.
pub fn generate(
    request: &Request,
    progress: &mut dyn FnMut(&str, u64, u64),
) -> Result<Generated, GenerateError> {
    check::request(request)?;
    match request.dimension {
        2 => typed::<DVec2>(request, Points::Plane, progress),
        3 => typed::<DVec3>(request, Points::Space, progress),
        4 => Ok(unspaced(request, |points| Points::Higher(HigherPoints::Four(points)), progress)),
        5 => Ok(unspaced(request, |points| Points::Higher(HigherPoints::Five(points)), progress)),
        _ => Ok(unspaced(request, |points| Points::Higher(HigherPoints::Six(points)), progress)),
    }
}

/// Generates a set that is not f-spaced.
fn unspaced<P: Point>(
    request: &Request,
    wrap: fn(Vec<P>) -> Points,
    progress: &mut GenerateProgress,
) -> Generated {
    progress(request.kind.name(), 0, request.n);
    let points = shapes::points::<P>(request);
    progress(request.kind.name(), request.n, request.n);
    let notes = check::count(request, points.len() as u64).into_iter().collect();
    Generated { points: wrap(points), spacing: None, requested: request.n, notes }
}

fn typed<P: Unit>(
    request: &Request,
    wrap: fn(Vec<P>) -> Points,
    progress: &mut GenerateProgress,
) -> Result<Generated, GenerateError> {
    if !request.kind.is_spaced() {
        return Ok(unspaced(request, wrap, progress));
    }
    let set = search::spaced_set::<P>(request, progress)?;
    let (points, sizing, mut notes) = (set.points, set.sizing, set.notes);
    notes.extend(check::count(request, points.len() as u64));
    let spacing = Some(Spacing { lipschitz: sizing.slope, dimension: P::DIM, sizing });
    Ok(Generated { points: wrap(points), spacing, requested: request.n, notes })
}

#[cfg(test)]
mod tests;
