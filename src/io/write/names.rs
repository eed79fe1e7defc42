//! Names of output files: the set of `TetGen`, and the pieces of a `.pvtu` file.

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

/// Returns the folder of the pieces of a `.pvtu` file: `NAME.pieces` for `NAME.pvtu`. Another extension stays.
pub(super) fn pieces_path(path: &Path) -> PathBuf {
    let has_extension = path.extension().is_some_and(|own| own.eq_ignore_ascii_case("pvtu"));
    let mut folder = if has_extension { path.with_extension("") } else { path.to_path_buf() };
    folder.as_mut_os_string().push(".pieces");
    folder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_of_the_pieces_has_the_name_of_the_file() {
        for (path, folder) in [
            ("a/b.pvtu", "a/b.pieces"),
            ("b.1.PVTU", "b.1.pieces"),
            ("b.out", "b.out.pieces"),
            ("./b", "./b.pieces"),
        ] {
            assert_eq!(pieces_path(Path::new(path)), Path::new(folder));
        }
    }
}
