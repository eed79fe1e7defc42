//! Where features meet at so small an angle that points on the one come closer to those on the other than the
//! size function allows.
//!
//! **Statement.** Let two features meet at an angle t < 90 degrees in a place where the size is `f0`. A point of the
//! one at distance u from there is at least `u sin t` from the other, as long as the features are straight, and the
//! size at it is at most `f0 + L u`. So beyond the distance `f0 / (sin t - L)` points on the two that are spaced by f
//! cannot be closer than f; before, they can. If `sin t <= L`, they can all along.
//!
//! **Work and depth.** That of [`Domain::small_angles`].

use super::SizeFunction;
use crate::angles::SmallAngle;
use crate::domain::Domain;
use crate::space::Space;

/// A small angle, and how far from its place points may collide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// The angle, with the features and the place. For two facets the place is all of their common segment.
    pub angle: SmallAngle,
    /// The largest size at the place.
    pub size: f64,
    /// The distance from the place beyond which they do not; none if they may everywhere.
    pub reach: Option<f64>,
}

impl<P: Space> SizeFunction<P> {
    /// All places where features meet at less than `limit` degrees, the smallest angle first.
    pub fn collisions(&self, domain: &Domain<P>, limit: f64) -> Vec<Collision> {
        let point = |v: u32| domain.points()[v as usize];
        let angles = domain.small_angles(limit).into_iter();
        let collision = |angle: SmallAngle| {
            // Along a segment f is at most its value at an end and L times half of the length.
            let size = match angle.along {
                None => self.at(point(angle.at)),
                Some(s) => {
                    let [a, b] = domain.segments[s as usize].ends().map(point);
                    let length = (b - a).norm2().sqrt();
                    0.5 * (self.at(a) + self.at(b) + self.lipschitz() * length)
                }
            };
            let cosine = angle.cosine.clamp(0.0, 1.0);
            let margin = (1.0 - cosine * cosine).sqrt() - self.lipschitz();
            Collision { angle, size, reach: (margin > 0.0).then(|| size / margin) }
        };
        angles.map(collision).collect()
    }
}
