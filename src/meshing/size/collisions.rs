//! Features that meet at such small angles that points on the two features may be closer to each other than the size
//! function allows.
//!
//! **Statement.** Let two straight features meet at an angle t < 90 degrees, at a point with the size `f0`. A point
//! of one feature at distance u from this point has a distance of at least `u sin t` from the other feature. The size
//! there is at most `f0 + L u`. Therefore, beyond the distance `f0 / (sin t - L)`, points on one feature cannot be
//! closer than f to points on the other. Within this distance, they can be closer. If `sin t <= L`, they can be
//! closer everywhere.
//!
//! **Work and depth.** See [`Domain::small_angles`].

use super::SizeFunction;
use crate::angles::SmallAngle;
use crate::domain::Domain;
use crate::space::Space;

/// A small angle, and the range in which points may be too close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// The angle, with the features and the location where they meet. Two facets meet along their whole common
    /// segment.
    pub angle: SmallAngle,
    /// The largest size where the features meet.
    pub size: f64,
    /// The distance from there beyond which points cannot be too close. `None` if there is no such distance.
    pub reach: Option<f64>,
}

impl<P: Space> SizeFunction<P> {
    /// Returns all pairs of features that meet at less than `limit` degrees, in ascending order of the angle.
    pub fn collisions(&self, domain: &Domain<P>, limit: f64) -> Vec<Collision> {
        let point = |v: u32| domain.points()[v as usize];
        let angles = domain.small_angles(limit).into_iter();
        let collision = |angle: SmallAngle| {
            // Along a segment, f is at most its value at an end plus L times half the length.
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
