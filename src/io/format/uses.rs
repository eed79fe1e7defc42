//! Which formats have a use, and what to do with a file that cannot have it.

use std::path::Path;

use super::Format;
use super::others::OTHERS;
use super::role::Role;
use super::row::Row;
use crate::ending::extension;
use crate::spelling::nearest;

impl Role {
    /// Returns the formats that have this use.
    pub fn formats(self) -> impl Iterator<Item = Format> {
        Format::ALL.iter().copied().filter(move |format| format.has(self))
    }

    /// Returns the names of the formats that have this use, and the other extensions of these formats.
    pub fn names(self) -> Vec<&'static str> {
        self.formats().flat_map(|format| format.row().extensions).copied().collect()
    }

    /// Returns the extensions with dots of the formats that have this use and fulfil a condition, separated by spaces.
    pub fn extensions(self, holds: impl Fn(&Row) -> bool) -> String {
        let rows = self.formats().map(Format::row).filter(|row| holds(row));
        let dotted: Vec<String> =
            rows.flat_map(|row| row.extensions).map(|name| format!(".{name}")).collect();
        dotted.join(" ")
    }

    /// Returns the extensions of the formats that have this use, and which of them may be compressed, for messages.
    pub fn known(self) -> String {
        let packable = self.extensions(|row| row.is_packable);
        let other = self.extensions(|row| !row.is_packable);
        let all = self.extensions(|_| true);
        match (packable.is_empty(), other.is_empty()) {
            (true, _) => all,
            (false, true) => format!("{all} (each also with .gz)"),
            (false, false) => format!("{all} (each but {other} also with .gz)"),
        }
    }

    /// Returns what to do instead with a file that cannot have this use, judged by its extension. Returns `None` if the
    /// extension has no near word.
    pub fn advice(self, path: &Path) -> Option<String> {
        let extension = extension(path);
        let known = Format::ALL.iter().find(|format| format.row().has_extension(&extension));
        if let Some(advice) = known.and_then(|format| format.instead(self)) {
            return Some(advice.to_owned());
        }
        if let Some(other) = OTHERS.iter().find(|other| other.extensions.contains(&extension.as_str())) {
            return Some(if self.is_output() {
                other.write.to_owned()
            } else {
                format!("this is {}: {}", other.what, other.read)
            });
        }
        if self.is_output()
            && known.is_some_and(|format| format.row().ambiguous.contains(&extension.as_str()))
        {
            return Some("write .xyz or .csv for text".to_owned());
        }
        let near = nearest(&extension, self.names())?;
        Some(if self.is_output() {
            format!("the nearest is .{near}")
        } else {
            format!("rename it if it is a .{near} file")
        })
    }
}
