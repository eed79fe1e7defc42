//! Appends the kept columns of one file to those of the files before it.

use super::super::points::Column;

/// Appends values by the names of their columns. Returns `false`, without a change, if the names differ. The order of
/// the columns may differ.
pub(super) fn append(all: &mut [Column], more: Vec<Column>) -> bool {
    let sorted = |columns: &[Column]| {
        let mut names: Vec<String> = columns.iter().map(|c| c.name.clone()).collect();
        names.sort();
        names
    };
    if sorted(all) != sorted(&more) {
        return false;
    }
    for mut column in more {
        if let Some(own) = all.iter_mut().find(|own| own.name == column.name) {
            own.values.append(&mut column.values);
        }
    }
    true
}

/// Returns the names of columns.
pub(super) fn names(columns: &[Column]) -> Vec<String> {
    columns.iter().map(|column| column.name.clone()).collect()
}
