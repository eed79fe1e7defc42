//! The endings of file names: the extension, and a final `.gz`.

use std::path::{Path, PathBuf};

/// Returns the path without a final `.gz`, in upper or lower case, and whether it had one.
pub fn without_gz(path: &Path) -> (PathBuf, bool) {
    let zipped = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    (if zipped { path.with_extension("") } else { path.to_path_buf() }, zipped)
}

/// Returns the extension before a final `.gz` in lower case, or an empty string.
pub fn extension(path: &Path) -> String {
    let plain = without_gz(path).0;
    plain.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_is_the_one_before_gz() {
        for (path, plain, ending, zipped) in [
            ("a/b.1.ele", "a/b.1.ele", "ele", false),
            ("a/b.VTU.GZ", "a/b.VTU", "vtu", true),
            ("a.gz", "a", "", true),
            (".gz", ".gz", "", false),
            ("a.gz/b", "a.gz/b", "", false),
            ("-", "-", "", false),
        ] {
            assert_eq!(without_gz(Path::new(path)), (PathBuf::from(plain), zipped), "{path}");
            assert_eq!(extension(Path::new(path)), ending, "{path}");
        }
    }
}
