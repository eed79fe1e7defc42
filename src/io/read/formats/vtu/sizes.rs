//! Sizes at the points of a grid.

use super::arrays::{self, DataArray};
use super::grid::parse;
use crate::read::error::{InputError, Place};
use crate::read::mesh_sizes;
use crate::read::points::ReadOptions;
use crate::read::scalar::Scalar;
use crate::read::text::{Source, number};
use septet_core::mesh::field::SizeField;

/// Reads the array `size` of the points, or their only array of floating-point numbers.
pub fn read_sizes(source: Source<'_>) -> Result<SizeField, InputError> {
    let grid = arrays::open(source)?;
    let named = |(name, _): &&(String, DataArray<'_>)| name == "size";
    let only = if let [only] = &grid.point_values[..] { Some(only) } else { None };
    let Some((_, found)) = grid.point_values.iter().find(named).or(only) else {
        let what = format!("a mesh with {} arrays of numbers at its points", grid.point_values.len());
        return Err(source.unsupported(Place::Whole, what, "name the array of the sizes `size`"));
    };
    let sizes = grid.values(found, Scalar::float, number)?;
    mesh_sizes::field(source, parse(source, &ReadOptions::default())?, &sizes)
}
