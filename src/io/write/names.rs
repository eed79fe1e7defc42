//! Names of output files: extensions, `.gz`, and the set of `TetGen`.

use std::path::{Path, PathBuf};

/// The extensions of the set of `TetGen`.
const SET: [&str; 5] = ["node", "ele", "face", "edge", "neigh"];

/// Returns the path without a final `.gz`, in upper or lower case, and whether it had one.
pub(super) fn without_gz(path: &Path) -> (&Path, bool) {
    let is_gz = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let name = path.to_str().filter(|_| is_gz);
    name.map_or((path, false), |name| (Path::new(&name[..name.len() - 3]), true))
}

/// Returns the extension before `.gz` in lower case, or an empty string.
pub(super) fn extension(path: &Path) -> String {
    let extension = without_gz(path).0.extension().and_then(|e| e.to_str());
    extension.unwrap_or_default().to_ascii_lowercase()
}

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
