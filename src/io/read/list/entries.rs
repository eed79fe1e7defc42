//! Text files with one path of a point file per line.

use std::fs;
use std::path::{Path, PathBuf};

use super::super::load::{self, Packing};
use super::super::text::Lines;
use super::error::{EntryFault, ListError};

/// Reads the paths of a list.
pub(super) fn read(list: &Path) -> Result<Vec<PathBuf>, ListError> {
    let data = load::load(list, Packing::of(list), &mut |_, _| {})
        .map_err(|error| ListError::List { error: Box::new(error) })?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let itself = list.canonicalize().ok();
    let mut files = Vec::new();
    for line in Lines::new(&data) {
        let text = line.text.trim_ascii();
        if text.is_empty() || text.starts_with(b"#") {
            continue;
        }
        let file = entry(text, folder, itself.as_deref());
        files.push(file.map_err(|fault| ListError::Entry {
            list: list.to_owned(),
            line: line.number,
            name: String::from_utf8_lossy(text).into_owned(),
            fault,
        })?);
    }
    if files.is_empty() { Err(ListError::NoEntry { list: list.to_owned() }) } else { Ok(files) }
}

/// Returns the file that a line names, relative to the folder of the list. `itself` is the canonical path of the list.
fn entry(text: &[u8], folder: &Path, itself: Option<&Path>) -> Result<PathBuf, EntryFault> {
    let name = std::str::from_utf8(text).map_err(|_| EntryFault::NotUtf8)?;
    if name == "-" {
        return Err(EntryFault::StandardInput);
    }
    let is_itself = |path: &Path| itself.is_some() && path.canonicalize().ok().as_deref() == itself;
    if let Some(other) = name.strip_prefix('@') {
        return Err(if is_itself(&folder.join(other)) { EntryFault::Itself } else { EntryFault::List });
    }
    let path = folder.join(name);
    if is_itself(&path) {
        return Err(EntryFault::Itself);
    }
    match fs::metadata(&path) {
        Ok(found) if found.is_dir() => Err(EntryFault::Folder),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Err(EntryFault::Missing { path }),
        // Other errors are reported when the file is read.
        _ => Ok(path),
    }
}
