//! Checks the output files before a run starts: no file is written twice or overwrites the input, and all are
//! writable.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use septet_io::Files;
use septet_io::write::stage::is_special;
use septet_io::write::{OutputError, WriteOptions, check_output, check_text_output, write_rows_to};

use super::errors::{Code, Failure};

/// Returns the canonical path of a file, which may not exist yet.
fn identity(path: &Path) -> PathBuf {
    if let Ok(real) = path.canonicalize() {
        return real;
    }
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (parent.canonicalize(), path.file_name()) {
        (Ok(parent), Some(name)) => parent.join(name),
        _ => path.to_owned(),
    }
}

#[cfg(unix)]
fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|found| found.file_type().is_char_device())
}

#[cfg(not(unix))]
fn is_device(_path: &Path) -> bool {
    false
}

/// Returns all files that an output consists of.
fn files_of(path: &Path, options: &WriteOptions<'_>) -> Vec<PathBuf> {
    options.format_of(path).map_or_else(|_| vec![path.to_owned()], |format| format.files(path))
}

/// Returns `true` if two outputs write the same file, or if one is in a folder that the other replaces.
fn overlap(a: &Path, b: &Path) -> bool {
    a.starts_with(b) || b.starts_with(a)
}

/// Returns the reason why an output would overwrite a file with another name than its own.
fn help(output: &Path, options: &WriteOptions<'_>) -> &'static str {
    match options.format_of(output).map(|format| format.row().files) {
        Ok(Files::Set) => {
            "an output named .node, .ele, .face, .edge or .neigh writes all five files: choose another name, such \
             as one that ends in .1.ele"
        }
        Ok(Files::Pieces) => {
            "an output named NAME.pvtu replaces the folder NAME.pieces: choose another name for the output"
        }
        Ok(Files::One | Files::Folder) | Err(_) => "choose another name for the output",
    }
}

/// Checks all outputs of a run before any work.
///
/// `texts` are single files: report, tables, trace. `-` is standard output.
pub fn check(inputs: &[&Path], outputs: &[PathBuf], texts: &[&Path]) -> Result<(), Failure> {
    check_as(inputs, outputs, &WriteOptions::default(), texts)
}

/// Checks all outputs of a run before any work, given the options of their writers.
///
/// If an output goes to standard output, nothing else may go there.
pub fn check_as(
    inputs: &[&Path],
    outputs: &[PathBuf],
    options: &WriteOptions<'_>,
    texts: &[&Path],
) -> Result<(), Failure> {
    let mut taken: Vec<(PathBuf, &Path)> = Vec::new();
    let inputs: Vec<(&Path, PathBuf)> = inputs.iter().map(|input| (*input, identity(input))).collect();
    let is_stream = |path: &Path| path.as_os_str() == "-";
    let streams = outputs.iter().map(PathBuf::as_path).filter(|o| is_stream(o));
    if streams.clone().next().is_some()
        && streams.chain(texts.iter().copied().filter(|t| is_stream(t))).count() > 1
    {
        let message = "two outputs go to standard output";
        return Err(Failure::new(Code::Usage, message).help("write all but one of them to files"));
    }
    let texts = texts.iter().copied().filter(|t| !is_stream(t));
    for output in outputs {
        // An unknown format is a usage error. Usage errors are reported before other failures.
        if options.format_of(output)?.row().files != Files::One && is_stream(output) {
            return Err(OutputError::NotOneFile.into());
        }
    }
    let files = outputs.iter().filter(|o| !is_stream(o));
    let meshes = files.clone().map(|o| (o.as_path(), files_of(o, options)));
    for (output, files) in meshes.chain(texts.clone().map(|t| (t, vec![t.to_owned()]))) {
        let mut own: Vec<PathBuf> = files.iter().map(|f| identity(f)).collect();
        own.sort();
        own.dedup();
        for file in own {
            if let Some((input, _)) = inputs.iter().find(|(_, input)| overlap(input, &file)) {
                let (from, to) = (input.display(), output.display());
                let message = format!("output {to} would overwrite the input file {from}");
                let help = if files.len() > 1 {
                    help(output, options)
                } else {
                    "choose another name for the output"
                };
                return Err(Failure::new(Code::Usage, message).help(help));
            }
            // Several outputs may go to the same device, one after another.
            if is_device(&file) {
                continue;
            }
            if let Some((_, other)) = taken.iter().find(|(f, _)| overlap(f, &file)) {
                let message =
                    format!("outputs {} and {} would write the same file", other.display(), output.display());
                return Err(Failure::new(Code::Usage, message).help("give each output its own name"));
            }
            taken.push((file, output));
        }
    }
    for output in files {
        check_output(output, options)?;
    }
    for path in texts {
        check_text_output(path)?;
    }
    Ok(())
}

/// Writes text to a file atomically, or to standard output for `-`. A closed pipe at standard output is not an error.
pub fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    if path.as_os_str() == "-" {
        let mut out = std::io::stdout().lock();
        let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
        return match written {
            Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(OutputError::Stream { source }),
            _ => Ok(()),
        };
    }
    septet_io::write::write_text(path, text)
}

/// Writes numbers of rows to a file atomically, or as text to standard output for `-`. A closed pipe at standard output is not an
/// error.
pub fn write_rows(path: &Path, rows: &[u64]) -> Result<(), OutputError> {
    if path.as_os_str() != "-" {
        return septet_io::write::write_rows(path, rows);
    }
    match write_rows_to(&mut std::io::stdout().lock(), rows) {
        Err(OutputError::Stream { source }) if source.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Removes files that a failing run has written. Devices, pipes, folders and names of open files stay.
pub fn remove(files: &[PathBuf]) {
    for file in files.iter().filter(|file| file.is_file() && !is_special(file)) {
        // A file that is already gone is as wanted.
        let _ = std::fs::remove_file(file);
    }
}

/// The files that a step has written so far. They are removed if the step fails or unwinds.
#[derive(Default)]
pub struct Fresh(Vec<PathBuf>);

impl Fresh {
    /// Adds files that are complete.
    pub fn extend(&mut self, files: Vec<PathBuf>) {
        self.0.extend(files);
    }

    /// Returns the files of a step that succeeded. They stay.
    pub fn keep(mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.0)
    }
}

impl Drop for Fresh {
    fn drop(&mut self) {
        remove(&self.0);
    }
}

/// Prints text to standard output.
pub fn print(text: &str) -> Result<(), OutputError> {
    write_text(Path::new("-"), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn only_regular_files_are_removed() {
        use std::os::fd::AsRawFd;
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        std::fs::write(at("a.off"), "OFF").unwrap();
        let log = std::fs::File::create(at("log.txt")).unwrap();
        let open = PathBuf::from(format!("/dev/fd/{}", log.as_raw_fd()));
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        remove(&[at("a.off"), at("none"), at("pipe"), "/dev/null".into(), open]);
        assert!(!at("a.off").exists());
        assert!(at("log.txt").exists() && at("pipe").exists() && Path::new("/dev/null").exists());
    }

    #[test]
    fn a_failing_step_leaves_no_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.off");
        let step = |fails: bool| {
            std::fs::write(&path, "OFF").unwrap();
            let mut fresh = Fresh::default();
            fresh.extend(vec![path.clone()]);
            assert!(!fails, "planned");
            fresh.keep()
        };
        assert_eq!(step(false), std::slice::from_ref(&path));
        assert!(path.exists());
        assert!(std::panic::catch_unwind(|| step(true)).is_err());
        assert!(!path.exists());
    }
}
