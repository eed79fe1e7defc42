//! Names of output files: the set of `TetGen`.

use std::path::{Path, PathBuf};

use crate::ending::without_gz;

/// The extensions of the set of `TetGen`.
const SET: [&str; 5] = ["node", "ele", "face", "edge", "neigh"];

/// Returns the path of the file of the set with this extension. If `path` already has the extension, its spelling is
/// kept. A final `.gz` is also kept.
pub(super) fn member(path: &Path, extension: &str) -> PathBuf {
    let (plain, zipped) = without_gz(path);
    match plain.extension() {
        Some(own) if own.eq_ignore_ascii_case(extension) => path.to_path_buf(),
        _ if zipped => plain.with_extension(format!("{extension}.gz")),
        _ => plain.with_extension(extension),
    }
}

/// Returns all files of the set of a path.
pub(super) fn siblings(path: &Path) -> impl Iterator<Item = PathBuf> {
    SET.iter().map(move |extension| member(path, extension))
}
