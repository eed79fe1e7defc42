//! A row of a file of sizes: coordinates and the size there.

use septet_core::mesh::field::SizeField;

use super::error::InputError;

/// The description of a valid size in messages.
const SIZE: &str = "a size: a positive number";

/// Adds a row of coordinates and a size. `blame` creates the error for an invalid number, from its column and the
/// requirement.
pub(super) fn push(
    field: &mut SizeField,
    row: &[f64],
    blame: impl Fn(usize, &'static str) -> InputError,
) -> Result<(), InputError> {
    let (at, size) = (&row[..field.dimension], row[field.dimension]);
    if let Some(bad) = at.iter().position(|c| !c.is_finite()) {
        return Err(blame(bad, "a finite coordinate"));
    }
    if !(size > 0.0 && size.is_finite()) {
        return Err(blame(field.dimension, SIZE));
    }
    let mut point = [0.0; 3];
    // Adding zero converts -0.0 to 0.0.
    point.iter_mut().zip(at).for_each(|(slot, c)| *slot = c + 0.0);
    field.rows.push((point, size));
    Ok(())
}
