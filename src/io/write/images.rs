//! Columns of the points of a periodic triangulation whose images that are vertices are points of their own.

use septet_core::result::unfolded::Unfolded;

use crate::read::Column;

/// Returns the row and the offset of each point as the columns `site` and `image_x` to `image_z`. `source` is the row of the input of
/// each row, if rows were dropped.
pub fn image_columns(of: &Unfolded, space: usize, source: Option<&[u64]>) -> Vec<Column> {
    let row = |&row: &u64| source.map_or(row, |source| source[row as usize]) as f64;
    let site = Column { name: "site".to_owned(), values: of.rows.iter().map(row).collect() };
    let axis = |(axis, name): (usize, &str)| {
        let values = of.offsets.iter().skip(axis).step_by(space).map(|&steps| f64::from(steps));
        Column { name: format!("image_{name}"), values: values.collect() }
    };
    std::iter::once(site).chain(["x", "y", "z"].into_iter().take(space).enumerate().map(axis)).collect()
}
