//! Concentric shells: 24 points on each of `N/24` spheres whose radii grow by a constant ratio.
//!
//! The set needs sphere separators. A sphere about the origin cuts the balls of few shells. A plane through the middle
//! cuts the balls of a constant share of every shell.
//!
//! **Range.** Coordinates of a shell are multiples of the power of two that is 50 digits below its radius. The digits of
//! the whole set then span 52 more digits than its radii, and the 410 digits of exact signs hold [`DIGITS`] and these.

use septet_geometry::point::Point;

use super::draw::Draw;
use super::kind::Kind;
use super::request::{GenerateError, Request, SHELL_RATIO};

/// Points on each shell.
const PER_SHELL: u64 = 24;

/// The largest quotient of two radii is two to this power.
const DIGITS: i32 = 341;

/// Checks the ratio of a request, and the number of its shells.
pub(super) fn check(request: &Request) -> Result<(), GenerateError> {
    let Request { kind, n, ratio, .. } = *request;
    if kind != Kind::Shells {
        return if ratio.is_some() { Err(GenerateError::RatioUnused(kind)) } else { Ok(()) };
    }
    let ratio = ratio.unwrap_or(SHELL_RATIO);
    if !(ratio > 1.0 && ratio.is_finite()) {
        return Err(GenerateError::Ratio(ratio));
    }
    let limit = most_points(ratio, n);
    if n > limit {
        return Err(GenerateError::TooManyShells { n, ratio, limit });
    }
    Ok(())
}

/// Returns the largest number of points with this ratio, or `enough` if the number is larger.
pub(super) fn most_points(ratio: f64, enough: u64) -> u64 {
    let most = 2f64.powi(DIGITS);
    let (mut shells, mut quotient) = (0, ratio);
    while quotient <= most && PER_SHELL * shells < enough {
        shells += 1;
        quotient *= ratio;
    }
    (PER_SHELL * shells).max(PER_SHELL)
}

/// Generates the shells from the outermost to the innermost. The request must be checked.
pub(super) fn points<P: Point>(request: &Request, draw: &mut Draw) -> Vec<P> {
    let ratio = request.ratio.unwrap_or(SHELL_RATIO);
    let (mut points, mut radius) = (Vec::new(), 0.5);
    for _ in 0..(request.n + PER_SHELL / 2) / PER_SHELL {
        let unit = digit_below(radius);
        points.extend((0..PER_SHELL).map(|_| rounded(draw.direction::<P>() * (radius / unit)) * unit));
        radius /= ratio;
    }
    points
}

/// Returns the power of two that is 50 digits below the leading digit of a normal number.
fn digit_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() >> 52 << 52) / 2f64.powi(50)
}

fn rounded<P: Point>(mut p: P) -> P {
    for i in 0..P::DIM {
        p.set_coord(i, p.coord(i).round());
    }
    p
}
