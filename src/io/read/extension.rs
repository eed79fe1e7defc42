//! Extensions of file names.

use std::path::Path;

/// Extensions that many programs use for text tables and for other files. The content of the file decides.
const AMBIGUOUS: [&str; 6] = ["dat", "pts", "asc", "data", "tsv", "xy"];

/// Returns `true` if the name does not show whether the file is a table: its extension is ambiguous, such as `.dat`, or
/// missing.
pub(super) fn may_be_table(path: &Path) -> bool {
    let (extension, _) = extension(path);
    extension.is_empty() || AMBIGUOUS.contains(&extension.as_str())
}

/// Returns the extension before `.gz` in lower case, or an empty string, and whether the name ends in `.gz`.
pub(super) fn extension(path: &Path) -> (String, bool) {
    let name = path.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let (stem, zipped) = name.strip_suffix(".gz").map_or((name.as_str(), false), |stem| (stem, true));
    (stem.rsplit_once('.').map_or_else(String::new, |(_, extension)| extension.to_owned()), zipped)
}
