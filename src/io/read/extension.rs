//! Extensions that do not determine the format.

use std::path::Path;

use crate::ending::extension;

/// Extensions that many programs use for text tables and for other files. The content of the file decides.
const AMBIGUOUS: [&str; 6] = ["dat", "pts", "asc", "data", "tsv", "xy"];

/// Returns `true` if the name does not show whether the file is a table: its extension is ambiguous, such as `.dat`, or
/// missing.
pub(super) fn may_be_table(path: &Path) -> bool {
    let extension = extension(path);
    extension.is_empty() || AMBIGUOUS.contains(&extension.as_str())
}
