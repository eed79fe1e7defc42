//! The sizes that a user asks for.
//!
//! **Statement.** A size everywhere, sizes at points (of a field, or the vertices of a background mesh), and
//! singularities, towards which the size falls to a value of their own: the largest L-Lipschitz function that is
//! nowhere above any of them is `min(h, min_i (a_i + L |x - x_i|), min_j (b_j + L dist(x, S_j)))`, each S a point or
//! a segment. Figure 1 of the paper shows points around a singularity.
//!
//! **Departures.** Between the points of a field nothing is interpolated: a field should be as dense as it is
//! detailed, and its steps are smoothed to the slope L.

use septet_geometry::point::Point;

use super::cones::{Cone, Cones};
use crate::distance::closest_on_segment;
use crate::executor::Sequential;

/// Where the size falls to a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Singularity<P> {
    /// To a point.
    Point(P),
    /// To a segment.
    Line(P, P),
}

impl<P: Point> Singularity<P> {
    /// The distance to it.
    pub fn distance(&self, x: P) -> f64 {
        let closest = match *self {
            Singularity::Point(p) => p,
            Singularity::Line(p, q) if p == q => p,
            Singularity::Line(p, q) => closest_on_segment(p, q, x),
        };
        (x - closest).norm2().sqrt()
    }
}

/// What a user asks for. Lengths are in the unit of the coordinates that it is asked with.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints<P> {
    /// The largest size anywhere.
    pub most: Option<f64>,
    /// The smallest size anywhere; it wins over everything else, local feature size included.
    pub least: Option<f64>,
    /// Sizes at points.
    pub field: Vec<Cone<P>>,
    /// Sizes at singularities.
    pub singularities: Vec<(Singularity<P>, f64)>,
}

impl<P> Default for Constraints<P> {
    fn default() -> Self {
        Constraints { most: None, least: None, field: Vec::new(), singularities: Vec::new() }
    }
}

/// Wishes as an L-Lipschitz function.
#[derive(Clone, Debug)]
pub struct User<P> {
    most: f64,
    pub(super) least: f64,
    field: Cones<P>,
    singularities: Vec<(Singularity<P>, f64)>,
}

impl<P: Point> User<P> {
    /// The function of slope L.
    pub fn new(slope: f64, constraints: &Constraints<P>) -> Self {
        User {
            most: constraints.most.unwrap_or(f64::INFINITY),
            least: constraints.least.unwrap_or(0.0),
            field: Cones::new(slope, constraints.field.clone()).filtered(&Sequential),
            singularities: constraints.singularities.clone(),
        }
    }

    /// The largest size wished for at a point, the smallest size left aside; infinite if there is none.
    pub fn at(&self, x: P) -> f64 {
        let slope = self.field.slope();
        let towards = self.singularities.iter().map(|(s, size)| size + slope * s.distance(x));
        self.field.below(x, towards.fold(self.most, f64::min))
    }
}
