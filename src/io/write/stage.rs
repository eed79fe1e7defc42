//! Files that appear complete or not at all. They are written under a temporary name next to the target. When all files
//! of a set are complete, they are renamed. If anything fails, they are removed.
//!
//! Special targets are devices, pipes and names of open files, such as `/dev/null`, `>(command)` of a shell and
//! `/dev/stdout`. They are opened for appending, because a rename would replace them. Opening a pipe waits for its
//! reader.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::error::{OutputError, WriteFault};
use crate::ending::without_gz;

/// The number of the next temporary file of this process.
static SERIAL: AtomicU64 = AtomicU64::new(0);

/// The number of temporary names to try in a directory.
const ATTEMPTS: u32 = 1000;

/// The files and folders of this process that still have temporary names.
static WAITING: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Returns the files and folders of this process that still have temporary names.
pub(super) fn waiting() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    WAITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the files and folders of this process that still have temporary names. The process then exits, and drops nothing.
pub fn remove_waiting() {
    remove_where(|_| true);
}

/// Removes the files and folders with certain temporary names.
fn remove_where(holds: impl Fn(&Path) -> bool) {
    for path in waiting().iter().filter(|path| holds(path)) {
        if fs::remove_file(path).is_err() {
            // The process created the folder. The caller cannot report a failure.
            let _ = fs::remove_dir_all(path);
        }
    }
}

/// A set of files that are not yet renamed to their targets.
#[derive(Default)]
pub struct Stage {
    /// The temporary name and the target of every file, in the order of writing. A special target needs no temporary
    /// name.
    files: Vec<(Option<PathBuf>, PathBuf)>,
}

impl Stage {
    /// Opens one file of the set, under a temporary name unless the target is special. The caller writes and closes
    /// the file before the set is committed.
    pub fn open(&mut self, target: &Path) -> Result<File, OutputError> {
        if is_special(target) {
            let opened = OpenOptions::new().append(true).open(target);
            let file = opened.map_err(|source| not_writable(target, source))?;
            self.files.push((None, target.to_path_buf()));
            return Ok(file);
        }
        let (file, temporary) = create_beside(target)?;
        self.add(temporary, target);
        Ok(file)
    }

    /// Creates an empty file of the set under a temporary name, which is returned without its directory. The target is not
    /// special.
    pub(super) fn reserve(&mut self, target: &Path) -> Result<String, OutputError> {
        let (_, temporary) = create_beside(target)?;
        let name = temporary.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.add(temporary, target);
        Ok(name)
    }

    fn add(&mut self, temporary: PathBuf, target: &Path) {
        waiting().insert(temporary.clone());
        self.files.push((Some(temporary), target.to_path_buf()));
    }

    /// Writes one file of the set. The bytes are compressed if its name ends in `.gz`.
    pub(in crate::write) fn write(
        &mut self,
        target: &Path,
        body: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
    ) -> Result<(), OutputError> {
        if !without_gz(target).1 {
            return self.write_plain(target, body);
        }
        self.write_plain(target, |out| {
            let mut encoder = GzEncoder::new(out, Compression::default());
            body(&mut encoder)?;
            encoder.finish()?;
            Ok(())
        })
    }

    /// Writes one file of the set without compression.
    fn write_plain(
        &mut self,
        target: &Path,
        body: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
    ) -> Result<(), OutputError> {
        let file = self.open(target)?;
        write_synced(file, target, body)
    }

    /// Renames all files to their targets, replaces existing files, and returns the targets. If a rename fails, the
    /// files that are already renamed are removed, so that no incomplete set remains.
    pub fn commit(mut self) -> Result<Vec<PathBuf>, OutputError> {
        for (_, target) in &self.files {
            refuse_directory(target)?;
        }
        let files = std::mem::take(&mut self.files);
        let mut done = Vec::with_capacity(files.len());
        for (index, (temporary, target)) in files.iter().enumerate() {
            let Some(temporary) = temporary else { continue };
            if let Err(source) = fs::rename(temporary, target) {
                self.files = files[index..].to_vec();
                for path in &done {
                    let _ = fs::remove_file(path);
                }
                return Err(OutputError::Io { path: target.clone(), source });
            }
            waiting().remove(temporary);
            done.push(target.clone());
        }
        Ok(files.into_iter().map(|(_, target)| target).collect())
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        for temporary in self.files.iter().filter_map(|(temporary, _)| temporary.as_ref()) {
            // `drop` cannot report a failure.
            let _ = fs::remove_file(temporary);
            waiting().remove(temporary);
        }
    }
}

/// Writes the content of a file and waits until it is on disk. Errors name the target.
pub(super) fn write_synced(
    file: File,
    target: &Path,
    body: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
) -> Result<(), OutputError> {
    let mut buffered = BufWriter::with_capacity(1 << 18, file);
    body(&mut buffered).map_err(|fault| fault.at(target))?;
    let io_error = |source| OutputError::Io { path: target.to_path_buf(), source };
    let file = buffered.into_inner().map_err(|error| io_error(error.into_error()))?;
    sync(&file).map_err(io_error)
}

/// Checks that a file can be written under this name: creates and removes a temporary file next to it. A special target
/// is not opened, because a pipe waits for its reader. Only its permissions are checked.
pub fn probe(target: &Path) -> Result<(), OutputError> {
    refuse_directory(target)?;
    if let Ok(metadata) = fs::metadata(target) {
        refuse_read_only(target, &metadata)?;
        if is_special(target) {
            return Ok(());
        }
    }
    let (file, temporary) = create_beside(target)?;
    drop(file);
    fs::remove_file(temporary).map_err(|source| not_writable(target, source))
}

fn not_writable(target: &Path, source: io::Error) -> OutputError {
    OutputError::NotWritable { path: target.to_path_buf(), source }
}

/// Refuses a file or folder that is read-only.
pub(super) fn refuse_read_only(target: &Path, found: &fs::Metadata) -> Result<(), OutputError> {
    if found.permissions().readonly() {
        return Err(not_writable(target, io::Error::new(ErrorKind::PermissionDenied, "it is read-only")));
    }
    Ok(())
}

fn refuse_directory(target: &Path) -> Result<(), OutputError> {
    if target.is_dir() || target.file_name().is_none() {
        return Err(OutputError::IsDirectory { path: target.to_path_buf() });
    }
    Ok(())
}

/// Returns `true` if a rename must not replace this target: a device, a pipe, a socket, or the name of an open file.
pub fn is_special(target: &Path) -> bool {
    let of_system = |directory: PathBuf| directory == Path::new("/dev") || directory.starts_with("/proc");
    fs::metadata(target).is_ok_and(|found| {
        !found.is_dir() && (!found.is_file() || directory_of(target).canonicalize().is_ok_and(of_system))
    })
}

/// Waits until the bytes of a file are on disk.
pub fn sync(file: &File) -> io::Result<()> {
    if file.metadata()?.is_file() { file.sync_all() } else { Ok(()) }
}

pub(super) fn directory_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates a temporary file in the directory of the target.
fn create_beside(target: &Path) -> Result<(File, PathBuf), OutputError> {
    beside(target, |path| OpenOptions::new().write(true).create_new(true).open(path))
}

/// Calls `make` with temporary names in the directory of the target until the name is free. Returns the result and the
/// name.
pub(super) fn beside<T>(
    target: &Path,
    make: impl Fn(&Path) -> io::Result<T>,
) -> Result<(T, PathBuf), OutputError> {
    let path = || target.to_path_buf();
    let directory = directory_of(target);
    if !directory.is_dir() {
        let directory = directory.to_path_buf();
        return Err(OutputError::MissingDirectory { path: path(), directory });
    }
    let mut last = None;
    for _ in 0..ATTEMPTS {
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let name = format!(".septet-{}-{serial}.partial", std::process::id());
        let temporary = directory.join(name);
        match make(&temporary) {
            Ok(made) => return Ok((made, temporary)),
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
    fn files_appear_at_commit() {
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
            let _ = stage.write(&target, |_| -> Result<(), WriteFault> { panic!("planned") });
        });
        assert!(result.is_err());
        assert!(names(directory.path()).is_empty());
    }

    /// Writes two files of a set without renaming them.
    fn staged(directory: &Path) -> (Stage, PathBuf) {
        let (first, second) = (directory.join("a.node"), directory.join("a.ele"));
        let mut stage = Stage::default();
        stage.write(&first, |_| Ok(())).unwrap();
        stage.write(&second, |_| Ok(())).unwrap();
        (stage, second)
    }

    #[test]
    fn files_that_wait_are_removed_before_an_exit() {
        let directory = tempfile::tempdir().unwrap();
        let (stage, _) = staged(directory.path());
        let kept = directory.path().join("b.off");
        let mut other = Stage::default();
        other.write(&kept, |_| Ok(())).unwrap();
        other.commit().unwrap();
        // Other tests have files of their own.
        remove_where(|path| path.starts_with(directory.path()));
        assert_eq!(names(directory.path()), ["b.off"]);
        drop(stage);
        assert!(!waiting().iter().any(|path| path.starts_with(directory.path())));
    }

    #[test]
    fn a_failing_rename_leaves_no_mixed_set() {
        let directory = tempfile::tempdir().unwrap();
        let (stage, _) = staged(directory.path());
        // The temporary file of the second target is removed, so its rename must fail.
        fs::remove_file(stage.files[1].0.as_ref().unwrap()).unwrap();
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

    /// If the target is a pipe, its reader receives the bytes, and it stays a pipe.
    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_written_to_and_stay() {
        use std::os::unix::fs::FileTypeExt;
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("a.off");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        probe(&pipe).unwrap();
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        let mut stage = Stage::default();
        stage.write(&pipe, |out| Ok(out.write_all(b"through")?)).unwrap();
        assert_eq!(stage.commit().unwrap(), std::slice::from_ref(&pipe));
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert_eq!(names(directory.path()), ["a.off"]);
        // A device remains both if the set is committed and if it is dropped.
        let null = Path::new("/dev/null");
        probe(null).unwrap();
        for complete in [false, true] {
            let mut stage = Stage::default();
            stage.write(null, |out| Ok(out.write_all(b"nothing")?)).unwrap();
            assert!(stage.files.iter().all(|(temporary, _)| temporary.is_none()));
            if complete {
                stage.commit().unwrap();
            }
            assert!(fs::metadata(null).unwrap().file_type().is_char_device());
        }
    }

    /// If the target is the name of an open file, the bytes are appended and the name stays.
    #[cfg(target_os = "linux")]
    #[test]
    fn open_files_are_appended_to() {
        use std::os::fd::AsRawFd;
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("log.txt");
        fs::write(&path, "first").unwrap();
        let file = OpenOptions::new().append(true).open(&path).unwrap();
        for folder in ["/dev/fd", "/proc/self/fd"] {
            let name = Path::new(folder).join(file.as_raw_fd().to_string());
            probe(&name).unwrap();
            let mut stage = Stage::default();
            stage.write(&name, |out| Ok(out.write_all(b", more")?)).unwrap();
            stage.commit().unwrap();
        }
        assert_eq!(fs::read(&path).unwrap(), b"first, more, more");
        assert_eq!(names(directory.path()), ["log.txt"]);
    }

    #[test]
    fn probing_finds_obstacles() {
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

    /// In `/proc`, even the superuser cannot create files.
    #[cfg(target_os = "linux")]
    #[test]
    fn an_unwritable_directory_is_refused() {
        let error = probe(Path::new("/proc/septet-test.off")).unwrap_err();
        assert!(matches!(error, OutputError::NotWritable { .. }), "{error}");
    }
}
