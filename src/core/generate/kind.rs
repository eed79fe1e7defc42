//! Kinds of point sets: their names and their limits.

use std::fmt;

use crate::spec::Words;

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
    /// On a closed surface with limbs, up to a little noise, like a scan.
    Body,
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

words!(Kind {
    Uniform "uniform" "Independent and uniform",
    Poisson "poisson" "A homogeneous Poisson process",
    Ball "ball" "Uniform in a ball",
    Sphere "sphere" "Uniform on a sphere, up to rounding",
    Grid "grid" "An integer grid",
    Fcc "fcc" "A face-centred cubic lattice; in the plane, a centred square lattice",
    Jittered "jittered" "One point in the middle half of each cell of a grid",
    Clusters "clusters" "Ten bell-shaped clusters, each half as wide as the previous one",
    Slab "slab" "Uniform in a thin slab",
    Line "line" "Uniform near points of a slanted segment",
    Body "body" "On a closed surface with limbs and a little noise, like a scan",
    MomentCurve "moment-curve" "Points of the moment curve; in space, all of them are Delaunay neighbours",
    Shells "shells" "24 points on each of many concentric spheres",
    WellSpaced "well-spaced" "Vertices of a mesh whose size function is constant",
    GradedPoint "graded" "Vertices of a mesh whose sizes grow from a point",
    GradedLine "graded-line" "Vertices of a mesh whose sizes grow from a line",
});

/// Returns the names of all kinds, separated by commas.
pub(super) fn names() -> String {
    Kind::all().map(Kind::name).collect::<Vec<_>>().join(", ")
}

/// Returns the names of the kinds that exist in every dimension, separated by commas.
pub(super) fn names_of_any_dimension() -> String {
    Kind::all().filter(|kind| kind.is_of_any_dimension()).map(Kind::name).collect::<Vec<_>>().join(", ")
}

impl Kind {
    /// Returns every kind, in the order of the help text.
    pub fn all() -> impl Iterator<Item = Kind> {
        Kind::ALL.iter().copied()
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        Words::name(self)
    }

    /// Returns `true` if the set is f-spaced.
    pub fn is_spaced(self) -> bool {
        matches!(self, Kind::WellSpaced | Kind::GradedPoint | Kind::GradedLine)
    }

    /// Returns `true` if the kind exists above three dimensions.
    pub fn is_of_any_dimension(self) -> bool {
        match self {
            Kind::Uniform
            | Kind::Poisson
            | Kind::Ball
            | Kind::Sphere
            | Kind::Grid
            | Kind::Fcc
            | Kind::Jittered
            | Kind::Clusters
            | Kind::Slab
            | Kind::MomentCurve => true,
            Kind::Line
            | Kind::Body
            | Kind::Shells
            | Kind::WellSpaced
            | Kind::GradedPoint
            | Kind::GradedLine => false,
        }
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
            (Kind::MomentCurve, _) => 1 << (53 / dimension.max(2)).min(26),
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
            Kind::Uniform
            | Kind::Ball
            | Kind::Sphere
            | Kind::Clusters
            | Kind::Slab
            | Kind::Line
            | Kind::Body
            | Kind::MomentCurve
            | Kind::WellSpaced
            | Kind::GradedPoint
            | Kind::GradedLine => "the number is the requested one, or within 5 % of it",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
