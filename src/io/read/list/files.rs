//! The files of a list, and the arguments that name a list.

use std::path::{Path, PathBuf};

use super::entries;
use super::error::ListError;
use super::pattern::{self, NamePattern};

/// Files of points that are read as one set, in this order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileList {
    files: Vec<PathBuf>,
    source: Option<PathBuf>,
}

impl FileList {
    /// Creates a list of these files.
    pub fn new(files: Vec<PathBuf>) -> Self {
        FileList { files, source: None }
    }

    /// Returns `true` if an argument of the command line names a list and not one file.
    ///
    /// `@FILE` names a list. A file name with `*`, `?` or `[...]` is a pattern, unless a file has exactly this name. The
    /// folder before the file name is not a pattern.
    pub fn is_named_by(argument: &str) -> bool {
        list_of(argument).is_some() || NamePattern::of(argument).is_some()
    }

    /// Finds the files that an argument of the command line names, or returns `None` if it names no list.
    ///
    /// The files of a pattern are in byte order of their names: `part-10` precedes `part-2`. Only a pattern that begins
    /// with a dot matches such names, and folders do not match.
    ///
    /// `@FILE` names a text file with one path per line, relative to its folder. `@-` reads the lines from standard
    /// input, and the paths are relative to the working directory. Whitespace around a path is not part of it. Empty
    /// lines and lines that begin with `#` are skipped.
    ///
    /// # Errors
    /// Returns [`ListError`] if a pattern is invalid or matches no file, if the list cannot be read or names no file, or
    /// if one of its lines does not name a file.
    pub fn of_argument(argument: &str) -> Result<Option<Self>, ListError> {
        if let Some(list) = list_of(argument) {
            let files = entries::read(&list)?;
            return Ok(Some(FileList { files, source: Some(list) }));
        }
        let pattern = NamePattern::of(argument);
        pattern.map(|pattern| Ok(FileList::new(pattern::matches(&pattern)?))).transpose()
    }

    /// Returns the files in their order.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Returns the file that contains the names, if there is one.
    pub fn source(&self) -> Option<&Path> {
        self.source.as_deref()
    }
}

/// Returns the file after `@`.
fn list_of(argument: &str) -> Option<PathBuf> {
    argument.strip_prefix('@').filter(|list| !list.is_empty()).map(PathBuf::from)
}
