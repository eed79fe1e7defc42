//! Patterns of file names.

use std::fs;
use std::path::{Path, PathBuf};

use glob::{MatchOptions, Pattern};

use super::error::ListError;

/// The rules of shells: case counts, and a leading dot must be given.
const RULES: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// A path whose file name is a pattern.
pub(super) struct NamePattern<'a> {
    path: &'a Path,
    name: &'a str,
}

impl<'a> NamePattern<'a> {
    /// Returns the pattern that an argument contains, or `None` if it contains none, or names a file exactly.
    pub fn of(argument: &'a str) -> Option<Self> {
        let path = Path::new(argument);
        let name = path.file_name()?.to_str()?;
        let is_set = name.split_once('[').is_some_and(|(_, rest)| rest.contains(']'));
        let is_pattern = is_set || name.contains(['*', '?']);
        (is_pattern && !path.exists()).then_some(NamePattern { path, name })
    }
}

/// Returns the files that match a pattern, in byte order of their names.
pub(super) fn matches(pattern: &NamePattern<'_>) -> Result<Vec<PathBuf>, ListError> {
    let whole = || pattern.path.to_owned();
    let matcher = Pattern::new(pattern.name)
        .map_err(|error| ListError::Pattern { pattern: whole(), problem: error.msg })?;
    let folder = pattern.path.parent().unwrap_or(Path::new(""));
    let opened = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let unreadable = |source| ListError::Folder { pattern: whole(), folder: opened.to_owned(), source };
    let mut names = Vec::new();
    for entry in fs::read_dir(opened).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name();
        let is_folder = || fs::metadata(opened.join(&name)).is_ok_and(|found| found.is_dir());
        if matcher.matches_with(&name.to_string_lossy(), RULES) && !is_folder() {
            names.push(name);
        }
    }
    if names.is_empty() {
        return Err(ListError::NoMatch { pattern: whole() });
    }
    names.sort_by(|a, b| a.as_encoded_bytes().cmp(b.as_encoded_bytes()));
    Ok(names.into_iter().map(|name| folder.join(name)).collect())
}
