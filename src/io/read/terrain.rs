//! Terrain: points with a height, which are triangulated in the plane.
//!
//! The readers read such points in space, so that all formats, options and errors are those of points with three coordinates.
//! [`lowered`] then takes z from the points.

use std::borrow::Cow;
use std::path::Path;

use glam::DVec3;
use septet_core::model::Points;

use super::error::InputError;
use super::points::{PointFile, ReadOptions};

/// Returns the options with which the points of a terrain are read: in space. Other options stay as they are.
///
/// # Errors
/// Fails if the options request three dimensions for a terrain.
pub(super) fn in_space<'a>(
    path: &Path,
    options: &'a ReadOptions,
) -> Result<Cow<'a, ReadOptions>, InputError> {
    match options.dimension {
        _ if !options.terrain => Ok(Cow::Borrowed(options)),
        Some(3) => Err(InputError::TerrainInSpace { path: path.to_owned() }),
        _ => Ok(Cow::Owned(ReadOptions { dimension: Some(3), ..options.clone() })),
    }
}

/// Returns the dimension of the cells that belong to points with these options: the cells of a terrain are triangles.
pub(super) fn dimension_of_cells(options: &ReadOptions) -> Option<usize> {
    if options.terrain { Some(2) } else { options.dimension }
}

/// Returns a file of points as the options request it: the points of a terrain lie in the plane, with their heights.
pub(super) fn lowered(mut file: PointFile, options: &ReadOptions) -> PointFile {
    if options.terrain {
        let (points, heights) = plane_and_heights(file.points);
        (file.points, file.heights) = (points, Some(heights));
    }
    file
}

/// Divides points in space into points in the plane and heights.
pub(super) fn plane_and_heights(points: Points) -> (Points, Vec<f64>) {
    match points {
        Points::Space(points) => {
            let heights = points.iter().map(|point| point.z).collect();
            (Points::Plane(points.into_iter().map(DVec3::truncate).collect()), heights)
        }
        // The readers return points in space: a terrain is read as such.
        Points::Higher(points) => (Points::Higher(points), Vec::new()),
        Points::Plane(points) => {
            let heights = vec![0.0; points.len()];
            (Points::Plane(points), heights)
        }
    }
}
