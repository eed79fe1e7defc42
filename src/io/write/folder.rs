//! Folders that appear complete or not at all: the pieces of a `.pvtu` file, and the files of a mesh in a folder.
//!
//! The pieces or files are written to a temporary folder next to the target. When all are complete, the folder takes the name of
//! the target. A former folder of pieces gets a temporary name until the caller keeps the new one. If anything fails
//! before, the former folder returns.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::{OutputError, WriteFault};
use super::stage::{beside, refuse_read_only, waiting, write_synced};

/// The smallest number of digits in the name of a piece.
const DIGITS: usize = 4;

/// The files of a folder of pieces under a temporary name.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    temporary: PathBuf,
    target: PathBuf,
    count: u32,
    names: Names,
}

/// The names of the files that a folder may contain: these, or those of pieces if there are none.
type Names = &'static [&'static str];

impl Pieces {
    /// Returns the files of a folder for this number of pieces, which has the name `temporary` now.
    pub(super) fn of(temporary: PathBuf, target: &Path, pieces: u32) -> Self {
        Pieces { temporary, target: target.to_path_buf(), count: pieces, names: &[] }
    }

    /// Returns the name of a piece, without its folder.
    pub(super) fn name(&self, piece: u32) -> String {
        let digits = self.count.saturating_sub(1).to_string().len().max(DIGITS);
        format!("{piece:0digits$}.vtu")
    }

    /// Returns the number of pieces.
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// Returns the final path of the folder.
    pub(super) fn target(&self) -> &Path {
        &self.target
    }

    /// Returns the temporary path of the folder.
    pub(super) fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Writes a piece.
    pub(super) fn write(
        &self,
        piece: u32,
        body: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
    ) -> Result<(), OutputError> {
        self.write_named(&self.name(piece), body)
    }

    /// Writes a file of the folder.
    pub(super) fn write_named(
        &self,
        name: &str,
        body: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
    ) -> Result<(), OutputError> {
        // Errors state the final name.
        let target = self.target.join(name);
        let file = fs::File::create_new(self.temporary.join(name));
        let file = file.map_err(|source| OutputError::Io { path: target.clone(), source })?;
        write_synced(file, &target, body)
    }
}

/// A folder of pieces under a temporary name. Unless it is placed, it is removed.
pub(super) struct Folder {
    pieces: Pieces,
    is_placed: bool,
}

impl Folder {
    /// Creates a folder for this number of pieces.
    pub(super) fn create(target: &Path, pieces: u32) -> Result<Self, OutputError> {
        let ((), temporary) = beside(target, |path| fs::create_dir(path))?;
        waiting().insert(temporary.clone());
        Ok(Folder { pieces: Pieces::of(temporary, target, pieces), is_placed: false })
    }

    /// Creates a folder for files with these names.
    pub(super) fn create_named(target: &Path, names: Names) -> Result<Self, OutputError> {
        let mut folder = Folder::create(target, 0)?;
        folder.pieces.names = names;
        Ok(folder)
    }

    /// Returns the files of the folder.
    pub(super) fn pieces(&self) -> &Pieces {
        &self.pieces
    }

    /// Gives the folder its name. A former folder of pieces is moved aside.
    pub(super) fn place(mut self) -> Result<Placed, OutputError> {
        let Pieces { temporary, target, names, .. } = self.pieces.clone();
        check(&target, names)?;
        let former = if fs::symlink_metadata(&target).is_ok() {
            let aside = |path: &Path| match fs::symlink_metadata(path) {
                Ok(_) => Err(io::Error::from(ErrorKind::AlreadyExists)),
                Err(_) => fs::rename(&target, path),
            };
            Some(beside(&target, aside)?.1)
        } else {
            None
        };
        let mut placed = Placed { target: target.clone(), names, former, is_new: false, is_kept: false };
        // If this fails, dropping `placed` restores the former folder.
        fs::rename(&temporary, &target).map_err(|source| OutputError::Io { path: target, source })?;
        self.is_placed = true;
        placed.is_new = true;
        Ok(placed)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.is_placed {
            remove(&self.pieces.temporary, self.pieces.names);
        }
        waiting().remove(&self.pieces.temporary);
    }
}

/// A folder of pieces under its name. Unless it is kept, the former folder returns.
pub(super) struct Placed {
    target: PathBuf,
    names: Names,
    /// The former folder, under its temporary name.
    former: Option<PathBuf>,
    /// Whether the new folder has its name.
    is_new: bool,
    is_kept: bool,
}

impl Placed {
    /// Keeps the folder and removes the former one.
    pub(super) fn keep(mut self) {
        self.is_kept = true;
        if let Some(former) = &self.former {
            remove(former, self.names);
        }
    }
}

impl Drop for Placed {
    fn drop(&mut self) {
        if self.is_kept {
            return;
        }
        if self.is_new {
            remove(&self.target, self.names);
        }
        if let Some(former) = &self.former {
            // `drop` cannot report a failure.
            let _ = fs::rename(former, &self.target);
        }
    }
}

/// Checks that a folder can have this name: there is nothing, or a folder that contains only files with these names, or
/// only pieces if there are no names.
pub(super) fn check(target: &Path, names: Names) -> Result<(), OutputError> {
    let obstructed = |obstacle: String| Err(OutputError::Obstructed { path: target.to_path_buf(), obstacle });
    let Ok(found) = fs::symlink_metadata(target) else { return Ok(()) };
    if !found.is_dir() {
        return obstructed("it is not a folder".to_string());
    }
    refuse_read_only(target, &found)?;
    let not_readable = |source| OutputError::NotWritable { path: target.to_path_buf(), source };
    for entry in fs::read_dir(target).map_err(not_readable)? {
        let entry = entry.map_err(not_readable)?;
        if !is_own(&entry, names) {
            let (name, what) =
                (entry.file_name(), if names.is_empty() { "a piece" } else { "a file of a mesh" });
            return obstructed(format!("it contains {}, which is not {what}", name.display()));
        }
    }
    Ok(())
}

/// Whether this is a file with one of these names, or with the name of a piece if there are none.
fn is_own(entry: &fs::DirEntry, names: Names) -> bool {
    let name = entry.file_name();
    let name = name.to_str().unwrap_or_default();
    let number = name.strip_suffix(".vtu").unwrap_or_default();
    let is_number = number.len() >= DIGITS && number.bytes().all(|digit| digit.is_ascii_digit());
    let is_named = if names.is_empty() { is_number } else { names.contains(&name) };
    is_named && entry.file_type().is_ok_and(|kind| kind.is_file())
}

/// Removes the files of a folder, and the folder if it is then empty.
fn remove(folder: &Path, names: Names) {
    let own = fs::read_dir(folder).into_iter().flatten().flatten().filter(|entry| is_own(entry, names));
    // The callers cannot report a failure.
    own.for_each(|file| drop(fs::remove_file(file.path())));
    let _ = fs::remove_dir(folder);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a directory with a folder of one former piece, and a new folder that waits for its name.
    fn waiting() -> (tempfile::TempDir, PathBuf, Folder) {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("a.pieces");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("0007.vtu"), "old").unwrap();
        let folder = Folder::create(&target, 3).unwrap();
        folder.pieces().write(1, |out| Ok(out.write_all(b"new")?)).unwrap();
        (directory, target, folder)
    }

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_is_replaced_whole() {
        let (directory, target, folder) = waiting();
        assert_eq!(names(&target), ["0007.vtu"]);
        folder.place().unwrap().keep();
        assert_eq!(names(&target), ["0001.vtu"]);
        assert_eq!(fs::read(target.join("0001.vtu")).unwrap(), b"new");
        assert_eq!(names(directory.path()), ["a.pieces"]);
    }

    #[test]
    fn a_folder_that_is_not_kept_leaves_the_former_one() {
        for is_placed in [false, true] {
            let (directory, target, folder) = waiting();
            if is_placed {
                drop(folder.place().unwrap());
            } else {
                drop(folder);
            }
            assert_eq!(names(&target), ["0007.vtu"]);
            assert_eq!(names(directory.path()), ["a.pieces"]);
        }
    }

    #[test]
    fn a_failing_rename_leaves_the_former_folder() {
        let (directory, target, folder) = waiting();
        remove(folder.pieces().temporary(), &[]);
        assert!(matches!(folder.place(), Err(OutputError::Io { .. })));
        assert_eq!(names(&target), ["0007.vtu"]);
        assert_eq!(names(directory.path()), ["a.pieces"]);
    }

    #[test]
    fn other_contents_are_left_alone() {
        for other in ["notes.txt", "007.vtu", "0007.vtu.gz", "x0007.vtu", "0008.vtu/"] {
            let (directory, target, folder) = waiting();
            let path = target.join(other);
            if other.ends_with('/') {
                fs::create_dir(&path).unwrap();
            } else {
                fs::write(&path, "").unwrap();
            }
            let Err(error) = folder.place() else { panic!("{other}") };
            assert!(error.to_string().contains(other.trim_end_matches('/')), "{error}");
            assert_eq!(names(&target).len(), 2);
            assert_eq!(names(directory.path()), ["a.pieces"]);
        }
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("a.pieces");
        fs::write(&file, "").unwrap();
        assert!(check(&file, &[]).unwrap_err().to_string().contains("not a folder"));
    }

    #[test]
    fn names_of_pieces_have_the_same_length() {
        let directory = tempfile::tempdir().unwrap();
        let name =
            |pieces, piece| Folder::create(&directory.path().join("p"), pieces).unwrap().pieces().name(piece);
        assert_eq!(name(0, 0), "0000.vtu");
        assert_eq!(name(10_000, 9_999), "9999.vtu");
        assert_eq!(name(10_001, 3), "00003.vtu");
        assert!(names(directory.path()).is_empty());
    }
}
