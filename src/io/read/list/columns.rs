//! Appends the kept columns of one file to those of the files before it.

use std::path::Path;

use super::super::points::Column;
use super::error::ListError;

/// Appends values by the names of their columns, whose order may differ. `first` is the first file with points.
///
/// # Errors
/// Fails, without a change, if the names differ.
pub(in super::super) fn append(
    all: &mut [Column],
    more: Vec<Column>,
    (path, first): (&Path, &Path),
) -> Result<(), ListError> {
    let names = |columns: &[Column]| columns.iter().map(|column| column.name.clone()).collect::<Vec<_>>();
    let sorted = |columns: &[Column]| {
        let mut names = names(columns);
        names.sort();
        names
    };
    if sorted(all) != sorted(&more) {
        let (path, first) = (path.to_owned(), first.to_owned());
        return Err(ListError::MixedColumns { path, found: names(&more), first, expected: names(all) });
    }
    for mut column in more {
        if let Some(own) = all.iter_mut().find(|own| own.name == column.name) {
            own.values.append(&mut column.values);
        }
    }
    Ok(())
}
