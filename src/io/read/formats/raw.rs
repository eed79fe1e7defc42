//! Raw files: coordinates in binary without a header, row after row.

use crate::read::array::Layout;
use crate::read::error::InputError;
use crate::read::points::{PointFile, ReadOptions};
use crate::read::raw_rows::RawRows;
use crate::read::text::Source;

/// Returns the layout of a file of `size` bytes.
pub fn layout(source: Source<'_>, rows: RawRows, size: u64) -> Result<Layout, InputError> {
    let RawRows { scalar, endian, dimension } = rows;
    let row = (dimension * scalar.size()) as u64;
    if !size.is_multiple_of(row) {
        return Err(InputError::PartOfRow { path: source.path.to_owned(), size, row });
    }
    Ok(Layout {
        scalar,
        endian,
        rows: size / row,
        columns: dimension,
        weight: None,
        fortran: false,
        fields: None,
        start: 0,
        surplus: 0,
    })
}

/// Reads points.
pub fn read(source: Source<'_>, rows: RawRows, options: &ReadOptions) -> Result<PointFile, InputError> {
    layout(source, rows, source.data.len() as u64)?.points(source, options)
}
