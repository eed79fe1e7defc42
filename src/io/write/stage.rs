//! Files that appear whole or not at all: written under a temporary name beside the target, renamed
//! when all files of a set are complete, removed on every other way out.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::{Fault, OutputError};

/// Distinguishes the temporary files of one process.
static SERIAL: AtomicU64 = AtomicU64::new(0);

/// How many temporary names to try before giving up on a directory full of leftovers.
const ATTEMPTS: u32 = 1000;

/// A set of files on the way to their names.
#[derive(Default)]
pub(crate) struct Stage {
    /// Temporary name and target of every complete file, in the order of writing.
    files: Vec<(PathBuf, PathBuf)>,
}

impl Stage {
    /// Opens one file of the set under a temporary name, for a caller that writes it bit by bit and closes
    /// it before the set is committed.
    pub(crate) fn open(&mut self, target: &Path) -> Result<File, OutputError> {
        let (file, temporary) = create_beside(target)?;
        self.files.push((temporary, target.to_path_buf()));
        Ok(file)
    }

    /// Writes one file of the set under a temporary name.
    pub(in crate::io::write) fn write(
        &mut self,
        target: &Path,
        body: impl FnOnce(&mut dyn Write) -> Result<(), Fault>,
    ) -> Result<(), OutputError> {
        let file = self.open(target)?;
        let mut buffered = BufWriter::with_capacity(1 << 18, file);
        body(&mut buffered).map_err(|fault| fault.at(target))?;
        let io_error = |source| OutputError::Io { path: target.to_path_buf(), source };
        let file = buffered.into_inner().map_err(|error| io_error(error.into_error()))?;
        file.sync_all().map_err(io_error)
    }

    /// Gives all files their names, replacing earlier files of those names; returns the names. Where
    /// one cannot be renamed, those already renamed are removed, so that no mixed set remains.
    pub(crate) fn commit(mut self) -> Result<Vec<PathBuf>, OutputError> {
        for (_, target) in &self.files {
            refuse_directory(target)?;
        }
        let files = std::mem::take(&mut self.files);
        let mut done = Vec::with_capacity(files.len());
        for (index, (temporary, target)) in files.iter().enumerate() {
            if let Err(source) = fs::rename(temporary, target) {
                self.files = files[index..].to_vec();
                for path in &done {
                    let _ = fs::remove_file(path);
                }
                return Err(OutputError::Io { path: target.clone(), source });
            }
            done.push(target.clone());
        }
        Ok(done)
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        for (temporary, _) in &self.files {
            // Nothing better can be done with a failure here.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Can a file be written under this name? Creates and removes a temporary file to find out.
pub(crate) fn probe(target: &Path) -> Result<(), OutputError> {
    refuse_directory(target)?;
    if let Ok(metadata) = fs::metadata(target)
        && metadata.permissions().readonly()
    {
        let source = io::Error::new(ErrorKind::PermissionDenied, "the file is read-only");
        return Err(OutputError::NotWritable { path: target.to_path_buf(), source });
    }
    let (file, temporary) = create_beside(target)?;
    drop(file);
    let path = || target.to_path_buf();
    fs::remove_file(temporary).map_err(|source| OutputError::NotWritable { path: path(), source })
}

fn refuse_directory(target: &Path) -> Result<(), OutputError> {
    if target.is_dir() || target.file_name().is_none() {
        return Err(OutputError::IsDirectory { path: target.to_path_buf() });
    }
    Ok(())
}

/// A new file in the directory of the target.
fn create_beside(target: &Path) -> Result<(File, PathBuf), OutputError> {
    let path = || target.to_path_buf();
    let directory = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !directory.is_dir() {
        let directory = directory.to_path_buf();
        return Err(OutputError::MissingDirectory { path: path(), directory });
    }
    let mut last = None;
    for _ in 0..ATTEMPTS {
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let name = format!(".septet-{}-{serial}.partial", std::process::id());
        let temporary = directory.join(name);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((file, temporary)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => last = Some(error),
            Err(source) => {
                return Err(OutputError::NotWritable { path: path(), source });
            }
        }
    }
    let source = last.unwrap_or_else(|| io::Error::from(ErrorKind::AlreadyExists));
    Err(OutputError::NotWritable { path: path(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn nothing_shows_before_commit() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("a.off");
        fs::write(&target, "old").unwrap();
        let mut stage = Stage::default();
        stage.write(&target, |out| Ok(out.write_all(b"new")?)).unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"old");
        assert_eq!(stage.commit().unwrap(), std::slice::from_ref(&target));
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert_eq!(names(directory.path()), ["a.off"]);
    }

    #[test]
    fn a_failing_body_leaves_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("a.off");
        let mut stage = Stage::default();
        stage.write(&directory.path().join("b.off"), |_| Ok(())).unwrap();
        let full = || io::Error::from(ErrorKind::StorageFull);
        let error = stage
            .write(&target, |out| {
                out.write_all(&vec![0; 1 << 20])?;
                Err(full().into())
            })
            .unwrap_err();
        assert!(matches!(&error, OutputError::Io { path, .. } if *path == target));
        drop(stage);
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn a_panicking_body_leaves_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("a.off");
        let result = std::panic::catch_unwind(|| {
            let mut stage = Stage::default();
            let _ = stage.write(&target, |_| -> Result<(), Fault> { panic!("planned") });
        });
        assert!(result.is_err());
        assert!(names(directory.path()).is_empty());
    }

    /// Two files of a set, written and not yet in place.
    fn staged(directory: &Path) -> (Stage, PathBuf) {
        let (first, second) = (directory.join("a.node"), directory.join("a.ele"));
        let mut stage = Stage::default();
        stage.write(&first, |_| Ok(())).unwrap();
        stage.write(&second, |_| Ok(())).unwrap();
        (stage, second)
    }

    #[test]
    fn a_failing_rename_leaves_no_mixed_set() {
        let directory = tempfile::tempdir().unwrap();
        let (stage, _) = staged(directory.path());
        // The temporary of the second file vanishes: its rename must fail.
        fs::remove_file(&stage.files[1].0).unwrap();
        assert!(stage.commit().is_err());
        assert!(names(directory.path()).is_empty());
    }

    #[test]
    fn a_directory_in_the_way_is_found_before_any_rename() {
        let directory = tempfile::tempdir().unwrap();
        let (stage, second) = staged(directory.path());
        fs::create_dir(&second).unwrap();
        let error = stage.commit().unwrap_err();
        assert!(matches!(error, OutputError::IsDirectory { .. }));
        assert_eq!(names(directory.path()), ["a.ele"]);
    }

    #[test]
    fn probing_finds_what_stands_in_the_way() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        probe(&at("a.off")).unwrap();
        assert!(names(directory.path()).is_empty());
        fs::write(at("file"), "").unwrap();
        let error = probe(&at("file/a.off")).unwrap_err();
        assert!(matches!(error, OutputError::MissingDirectory { .. }));
        let error = probe(&at("none/a.off")).unwrap_err();
        assert!(error.to_string().contains("none"));
        fs::create_dir(at("dir.off")).unwrap();
        assert!(matches!(probe(&at("dir.off")).unwrap_err(), OutputError::IsDirectory { .. }));
        let mut permissions = fs::metadata(at("file")).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(at("file"), permissions).unwrap();
        assert!(matches!(probe(&at("file")).unwrap_err(), OutputError::NotWritable { .. }));
    }

    /// `/proc` takes no new files even from the superuser.
    #[cfg(target_os = "linux")]
    #[test]
    fn an_unwritable_directory_is_refused() {
        let error = probe(Path::new("/proc/septet-test.off")).unwrap_err();
        assert!(matches!(error, OutputError::NotWritable { .. }), "{error}");
    }
}
