//! Notes on the files of a list. A note that several files share is given once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A note, the first file that it concerns, and the number of other files.
struct Shared {
    text: String,
    path: PathBuf,
    others: u64,
}

/// The notes so far.
#[derive(Default)]
pub(in super::super) struct Notes {
    shared: Vec<Shared>,
    positions: BTreeMap<String, usize>,
}

impl Notes {
    /// Adds the notes on a file.
    pub fn add(&mut self, path: &Path, notes: Vec<String>) {
        for text in notes {
            if let Some(&at) = self.positions.get(&text) {
                self.shared[at].others += 1;
                continue;
            }
            self.positions.insert(text.clone(), self.shared.len());
            self.shared.push(Shared { text, path: path.to_owned(), others: 0 });
        }
    }

    /// Returns one line per note, in the order of the files.
    pub fn lines(self) -> Vec<String> {
        let line = |Shared { text, path, others }| {
            let path: PathBuf = path;
            match others {
                0 => format!("{}: {text}", path.display()),
                1 => format!("{} and 1 other file: {text}", path.display()),
                _ => format!("{} and {others} other files: {text}", path.display()),
            }
        };
        self.shared.into_iter().map(line).collect()
    }
}
