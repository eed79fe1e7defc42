//! Flat arrays as rows of points.

use bytemuck::cast_slice;
use glam::{DVec2, DVec3};
use septet_geometry::point::Point;

use crate::failure::Failure;

/// Points of the plane or of space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rows<'a> {
    Plane(&'a [DVec2]),
    Space(&'a [DVec3]),
}

impl<'a> Rows<'a> {
    /// Reads rows of `columns` numbers.
    ///
    /// # Errors
    /// Fails if there are not 2 or 3 columns, or if the last row is not whole.
    pub(crate) fn of(flat: &'a [f64], columns: usize) -> Result<Self, Failure> {
        check_columns(columns)?;
        if columns == 2 { whole(flat).map(Rows::Plane) } else { whole(flat).map(Rows::Space) }
    }
}

/// Checks a number of coordinates.
///
/// # Errors
/// Fails if there are not 2 or 3.
pub fn check_columns(columns: usize) -> Result<(), Failure> {
    let advice = match columns {
        2 | 3 => return Ok(()),
        4..=6 => "save them in a file and run `septet triangulate`",
        _ => "pass 2 coordinates for the plane, or 3 for space",
    };
    Err(Failure::usage(format!("points with {columns} coordinates, but 2 or 3 are expected; {advice}")))
}

/// Reads points of one dimension.
///
/// # Errors
/// Fails if the last row is not whole.
pub(crate) fn whole<P: Point>(flat: &[f64]) -> Result<&[P], Failure> {
    if !flat.len().is_multiple_of(P::DIM) {
        return Err(Failure::usage(format!(
            "{} numbers are not whole rows of {} coordinates; pass all coordinates of each point",
            flat.len(),
            P::DIM
        )));
    }
    Ok(cast_slice(flat))
}

/// Reads one point.
///
/// # Errors
/// Fails if there are more or fewer numbers than coordinates.
pub(crate) fn one<P: Point>(flat: &[f64]) -> Result<P, Failure> {
    let points: &[P] = if flat.len() == P::DIM { cast_slice(flat) } else { &[] };
    points.first().copied().ok_or_else(|| {
        Failure::usage(format!("{} numbers for a point with {} coordinates", flat.len(), P::DIM))
    })
}
