//! Kinds of point sets: their names, their limits, and their notation on the command line.

use std::fmt;
use std::str::FromStr;

use super::request::{GenerateError, Request};

/// A kind of point set in the unit square or cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Independent and uniform.
    Uniform,
    /// A homogeneous Poisson process. The number of points is random with mean `n`.
    Poisson,
    /// Uniform in the ball (in the plane: the disc) of radius 1/2.
    Ball,
    /// Uniform on the sphere (in the plane: the circle) of radius 1/2, up to rounding.
    Sphere,
    /// The integer points `0..k` of every axis, divided by a power of two so that ties are exact. `k^d` points.
    Grid,
    /// The integer points with an even sum, divided by a power of two. In space this is the face-centred cubic lattice
    /// with `4 m^3` points. In the plane it is the centred square lattice with `2 m^2` points.
    Fcc,
    /// A grid of `k^d` cells with one point in the middle half of each cell.
    Jittered,
    /// Ten bell-shaped clusters far apart. Each is half as wide as the previous one.
    Clusters,
    /// Uniform in a slab of thickness 1/1000 along the last axis.
    Slab,
    /// Uniform within 1/1000 of random points of a slanted segment.
    Line,
    /// The points `(t, t^2, t^3)` for `t = 0..n`, each axis divided by a power of two. In space, every two of them are
    /// Delaunay neighbours.
    MomentCurve,
    /// 24 points on each of `N/24` spheres (in the plane: circles) about the origin, whose radii grow by a constant
    /// ratio to 1/2.
    Shells,
    /// f-spaced with boundary, where f is constant.
    WellSpaced,
    /// f-spaced with boundary, where f grows linearly with the distance from the centre.
    GradedPoint,
    /// f-spaced with boundary, where f grows linearly with the distance from the line through the centre along the last
    /// axis.
    GradedLine,
}

/// All kinds with their names, in the order of the help text.
const NAMES: [(Kind, &str); 15] = [
    (Kind::Uniform, "uniform"),
    (Kind::Poisson, "poisson"),
    (Kind::Ball, "ball"),
    (Kind::Sphere, "sphere"),
    (Kind::Grid, "grid"),
    (Kind::Fcc, "fcc"),
    (Kind::Jittered, "jittered"),
    (Kind::Clusters, "clusters"),
    (Kind::Slab, "slab"),
    (Kind::Line, "line"),
    (Kind::MomentCurve, "moment-curve"),
    (Kind::Shells, "shells"),
    (Kind::WellSpaced, "well-spaced"),
    (Kind::GradedPoint, "graded"),
    (Kind::GradedLine, "graded-line"),
];

/// Returns the names of all kinds, separated by commas.
pub(super) fn names() -> String {
    NAMES.map(|(_, name)| name).join(", ")
}

impl Kind {
    /// Returns every kind.
    pub fn all() -> impl Iterator<Item = Kind> {
        NAMES.into_iter().map(|(kind, _)| kind)
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// Returns `true` if the set is f-spaced.
    pub fn is_spaced(self) -> bool {
        matches!(self, Kind::WellSpaced | Kind::GradedPoint | Kind::GradedLine)
    }

    /// Returns `true` if the size function grows, so that a Lipschitz constant applies.
    pub fn is_graded(self) -> bool {
        matches!(self, Kind::GradedPoint | Kind::GradedLine)
    }

    /// Returns the largest number of points. Memory, exact coordinates or vertex indices limit it. The limit of
    /// [`Kind::Shells`] also depends on the ratio of radii ([`super::shells::most_points`]).
    pub(super) fn limit(self, dimension: usize) -> u64 {
        match (self, dimension) {
            // t^d must be a 53-bit integer.
            (Kind::MomentCurve, 2) => 1 << 26,
            (Kind::MomentCurve, _) => 1 << 17,
            (kind, _) if kind.is_spaced() => 1 << 25,
            _ => 1 << 31,
        }
    }

    /// Returns the reason why the number of points may differ from the request.
    pub(super) fn count_rule(self) -> &'static str {
        match self {
            Kind::Poisson => "the number of points of a Poisson process is random",
            Kind::Grid | Kind::Jittered => "rounded to a power of an integer side",
            Kind::Fcc => "rounded to an integer number of lattice cells per side",
            Kind::Shells => "rounded to 24 points per sphere",
            _ => "the number is the requested one, or within 5 % of it",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kind {
    type Err = GenerateError;

    fn from_str(name: &str) -> Result<Self, GenerateError> {
        let wanted = if name == "graded-point" { "graded" } else { name };
        let found = NAMES.iter().find(|(_, known)| *known == wanted);
        found.map(|(kind, _)| *kind).ok_or_else(|| GenerateError::UnknownKind { name: name.into() })
    }
}

/// Parses `KIND:N[,d=2][,seed=7][,lipschitz=0.25][,ratio=1.3]`. The defaults are dimension 3, seed 0 and the default
/// constants. `N` may have an exponent, as in `1e6`.
///
/// # Errors
///
/// Returns an error that names the part that cannot be parsed or the unknown kind. [`super::generate`] checks the
/// ranges.
pub fn parse_sample(spec: &str) -> Result<Request, GenerateError> {
    let fail = |reason: String| GenerateError::Spec { spec: spec.into(), reason };
    let (kind, rest) =
        spec.split_once(':').ok_or_else(|| fail("expected KIND:N, such as uniform:1000".into()))?;
    let kind = kind.trim().parse()?;
    let mut parts = rest.split(',').map(str::trim);
    let count = parts.next().unwrap_or_default();
    let n = parse_count(count)
        .ok_or_else(|| fail(format!("`{count}` is not a number of points, such as 1000 or 1e6")))?;
    let mut request = Request { kind, n, dimension: 3, seed: 0, lipschitz: None, ratio: None };
    for part in parts {
        let (key, value) =
            part.split_once('=').ok_or_else(|| fail(format!("expected KEY=VALUE instead of `{part}`")))?;
        let bad = || fail(format!("`{value}` is not a valid value for {key}"));
        match key {
            "d" => request.dimension = value.parse().map_err(|_| bad())?,
            "seed" => request.seed = value.parse().map_err(|_| bad())?,
            "lipschitz" => request.lipschitz = Some(value.parse().map_err(|_| bad())?),
            "ratio" => request.ratio = Some(value.parse().map_err(|_| bad())?),
            _ => return Err(fail(format!("unknown key `{key}`: expected d, seed, lipschitz or ratio"))),
        }
    }
    Ok(request)
}

/// Parses a whole number, optionally with an exponent.
fn parse_count(text: &str) -> Option<u64> {
    match text.split_once(['e', 'E']) {
        None => text.parse().ok(),
        Some((mantissa, exponent)) => {
            let power = 10u64.checked_pow(exponent.parse().ok()?)?;
            mantissa.parse::<u64>().ok()?.checked_mul(power)
        }
    }
}
