//! The sizes that a user requests.
//!
//! **Statement.** There are three kinds of constraints: a size everywhere, sizes at points, and singularities,
//! towards which the size decreases to a given value. The points form a field, or are the vertices of a background
//! mesh. The largest L-Lipschitz function that exceeds none of them is
//! `min(h, min_i (a_i + L |x - x_i|), min_j (b_j + L dist(x, S_j)))`. Each `S_j` is a point or a segment. Figure 1 of
//! the paper shows points around a singularity.
//!
//! **Departures.** The field is not interpolated between its points, so it should be dense enough to represent its
//! details. Jumps are smoothed to the slope L.

use septet_geometry::cost::Sweep;
use septet_geometry::point::Point;

use super::cones::{Cone, Cones};
use crate::distance::closest_on_segment;
use crate::executor::Evaluator;

/// A set towards which sizes decrease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Singularity<P> {
    /// A point.
    Point(P),
    /// A segment.
    Line(P, P),
}

impl<P: Point> Singularity<P> {
    /// Returns the distance from a point.
    pub fn distance(&self, x: P) -> f64 {
        let closest = match *self {
            Singularity::Point(p) => p,
            Singularity::Line(p, q) if p == q => p,
            Singularity::Line(p, q) => closest_on_segment(p, q, x),
        };
        (x - closest).norm2().sqrt()
    }
}

/// The size constraints of a user. Lengths have the same unit as the coordinates at which the function is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints<P> {
    /// The largest size anywhere.
    pub most: Option<f64>,
    /// The smallest size anywhere. It overrides everything else, including the local feature size.
    pub least: Option<f64>,
    /// Sizes at points.
    pub field: Vec<Cone<P>>,
    /// Singularities, and the sizes there.
    pub singularities: Vec<(Singularity<P>, f64)>,
}

impl<P> Default for Constraints<P> {
    fn default() -> Self {
        Constraints { most: None, least: None, field: Vec::new(), singularities: Vec::new() }
    }
}

/// The constraints of a user as an L-Lipschitz function.
#[derive(Clone, Debug)]
pub struct User<P> {
    most: f64,
    pub(super) least: f64,
    field: Cones<P>,
    singularities: Vec<(Singularity<P>, f64)>,
}

impl<P: Point> User<P> {
    /// Creates the function with slope L.
    ///
    /// # Errors
    /// Returns the error of the machine if it fails.
    pub fn new<M: Evaluator<P>>(
        slope: f64,
        constraints: &Constraints<P>,
        machine: &M,
    ) -> Result<Self, M::Error> {
        Ok(User {
            most: constraints.most.unwrap_or(f64::INFINITY),
            least: constraints.least.unwrap_or(0.0),
            field: Cones::new(slope, constraints.field.clone()).filtered(machine)?,
            singularities: constraints.singularities.clone(),
        })
    }

    /// Returns the largest size that the constraints allow at a point, regardless of the smallest size. It is infinite
    /// if there are no constraints.
    pub fn at(&self, x: P) -> f64 {
        self.at_counted(x, &mut Sweep::default())
    }

    /// Returns [`User::at`], and counts the singularities, and the visits of the tree of the field.
    pub(super) fn at_counted(&self, x: P, visits: &mut Sweep) -> f64 {
        let slope = self.field.slope();
        let towards =
            visits.visit_all(&self.singularities).iter().map(|(s, size)| size + slope * s.distance(x));
        let towards = towards.fold(self.most, f64::min);
        self.field.below_counted(x, towards, visits)
    }
}
