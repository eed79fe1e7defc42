//! Size functions of the f-spaced kinds.
//!
//! **Statement.** A size function is `f(x) = least + slope * dist(x, centre)`, where the centre is a point or a line.
//! Hence f is `slope`-Lipschitz. A slope of 0 gives a constant size.

use septet_geometry::point::Point;

/// The set on which the size function is smallest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Centre {
    /// The midpoint of the domain.
    Point,
    /// The line through the midpoint along the last axis.
    Line,
}

/// A size function on the unit square or cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sizing {
    /// The set on which it is smallest.
    pub centre: Centre,
    /// Its Lipschitz constant.
    pub slope: f64,
    /// Its smallest value.
    pub least: f64,
}

impl Sizing {
    /// Evaluates the function at a point.
    #[inline]
    pub fn at<P: Point>(&self, p: &P) -> f64 {
        if self.slope == 0.0 {
            return self.least;
        }
        self.least + self.slope * self.distance(p)
    }

    /// Returns the distance from the centre.
    #[inline]
    pub fn distance<P: Point>(&self, p: &P) -> f64 {
        let axes = match self.centre {
            Centre::Point => P::DIM,
            Centre::Line => P::DIM - 1,
        };
        let mut sum = 0.0;
        for i in 0..axes {
            let x = p.coord(i) - 0.5;
            sum += x * x;
        }
        sum.sqrt()
    }
}
