//! The reasons for the angles of the worst cells.
//!
//! **Statement.** A cell touches an input angle if it has a vertex in the corner, or on the segment, in which the two
//! features meet. Cells there cannot all have larger angles than the features. An input angle below [`SMALL`] degrees is
//! the reason for the smallest angle of a cell that touches it. For a remeshed surface, only the ridges count.
//!
//! **Work and depth.** One test for each cell and each small angle. Angles are rounded.

use std::collections::BTreeSet;

use super::WorstCell;
use crate::angles::SmallAngle;
use crate::domain::{Domain, Feature};
use crate::mesh::Carrier;
use crate::space::Space;

/// Input angles below this, in degrees, are named as reasons.
pub const SMALL: f64 = 30.0;

/// The reason for the smallest angle of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The cell touches this input angle, the smallest of all that it touches.
    InputAngle(SmallAngle),
    /// All its vertices lie on the boundary.
    Boundary,
    /// Nothing restricts it but the cells around it.
    Surroundings,
}

/// Returns the reason for each cell. `feature_angle` is that of a remeshed surface, in degrees.
pub fn reasons<P: Space>(
    domain: &Domain<P>,
    cells: &[WorstCell<P>],
    feature_angle: Option<f64>,
) -> Vec<Reason> {
    let ridges: Option<BTreeSet<u32>> = feature_angle.map(|angle| domain.ridges(angle).into_iter().collect());
    let mut angles = domain.small_angles(SMALL);
    if let Some(ridges) = &ridges {
        let is_kept = |f: &Feature| matches!(f, Feature::Segment(s) if ridges.contains(s));
        angles.retain(|a| a.features.iter().all(is_kept) || a.along.is_some_and(|s| ridges.contains(&s)));
    }
    let of = |cell: &WorstCell<P>| {
        // The angles ascend.
        let touched = angles.iter().find(|angle| cell.vertices.iter().any(|v| touches(domain, angle, v.1)));
        let is_inner = cell.vertices.iter().any(|v| v.1 == Carrier::Volume);
        let other = if is_inner { Reason::Surroundings } else { Reason::Boundary };
        touched.map_or(other, |&angle| Reason::InputAngle(angle))
    };
    cells.iter().map(of).collect()
}

/// Returns `true` if a point on this carrier lies where the features of an angle meet.
fn touches<P: Space>(domain: &Domain<P>, angle: &SmallAngle, carrier: Carrier) -> bool {
    match (carrier, angle.along) {
        (Carrier::Corner(c), None) => domain.corners[c as usize] == angle.at,
        (Carrier::Corner(c), Some(s)) => {
            domain.segments[s as usize].ends().contains(&domain.corners[c as usize])
        }
        (Carrier::Segment(t), Some(s)) => s == t,
        _ => false,
    }
}
