//! Checks that several processes can write outputs together.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use septet_protocol::wire::{Ended, Processes};

use super::fault::{SharedFault, describe};
use crate::format::{Files, Format};
use crate::write::error::OutputError;
use crate::write::folder;
use crate::write::formats::{poly_mesh, pvtu};
use crate::write::options::{WriteOptions, check_first_id};
use crate::write::stage::{beside, directory_of, is_special, probe};

/// Checks outputs on all processes, and returns their formats.
pub(super) fn check(
    processes: &mut Processes<'_>,
    outputs: &[PathBuf],
    options: &WriteOptions<'_>,
) -> Result<Vec<Format>, Ended> {
    let name = |output: &PathBuf| output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let names: Vec<Vec<String>> = processes.all_gather(&outputs.iter().map(name).collect())?;
    let process = processes.process();
    let own = formats(outputs, options).and_then(|formats| {
        let is_same = names.first() == names.get(process as usize);
        if is_same { Ok(formats) } else { Err(SharedFault::OtherOutputs { process }) }
    });
    let formats = processes.agree(own, describe)?;
    let own = if process == 0 { Tokens::create(outputs, &formats) } else { Ok(Tokens::default()) };
    let tokens = processes.agree(own.map_err(SharedFault::from), describe)?;
    let made = processes.all_gather(&(tokens.text.clone(), tokens.names()))?.swap_remove(0);
    let seen = look(outputs, &made.1, &made.0, process);
    processes.agree(seen, describe)?;
    Ok(formats)
}

/// Returns the formats of outputs that several processes can write.
fn formats(outputs: &[PathBuf], options: &WriteOptions<'_>) -> Result<Vec<Format>, SharedFault> {
    check_first_id(options.first_id)?;
    let mut formats = Vec::with_capacity(outputs.len());
    for path in outputs {
        let format = options.format_of(path)?;
        if path.as_os_str() == "-" || is_special(path) {
            return Err(SharedFault::NotAFile { path: path.clone() });
        }
        formats.push(format);
    }
    check_names(outputs, &formats)?;
    Ok(formats)
}

/// Refuses outputs that have a file in common, or of which one is in a folder that another replaces.
fn check_names(outputs: &[PathBuf], formats: &[Format]) -> Result<(), SharedFault> {
    let mut taken: Vec<(PathBuf, &Path)> = Vec::new();
    for (path, format) in outputs.iter().zip(formats) {
        let folder = directory_of(path).canonicalize().unwrap_or_else(|_| directory_of(path).to_path_buf());
        let files = format.files(path);
        let files = files.iter().map(|file| folder.join(file.file_name().unwrap_or_default()));
        let files: Vec<PathBuf> = files.collect();
        for file in &files {
            let overlaps = |other: &PathBuf| other.starts_with(file) || file.starts_with(other);
            if let Some((_, first)) = taken.iter().find(|(other, _)| overlaps(other)) {
                return Err(SharedFault::SameFile { first: first.to_path_buf(), second: path.clone() });
            }
        }
        taken.extend(files.into_iter().map(|file| (file, path.as_path())));
    }
    Ok(())
}

/// Files beside the outputs by which processes see that they share the folders. Dropping removes them.
#[derive(Debug, Default)]
struct Tokens {
    files: Vec<PathBuf>,
    /// The content, which differs between runs.
    text: String,
}

impl Tokens {
    /// Checks that outputs can be written, and creates a token beside each.
    fn create(outputs: &[PathBuf], formats: &[Format]) -> Result<Self, OutputError> {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let text = format!("septet {} {}", std::process::id(), since.as_nanos());
        let mut tokens = Tokens { files: Vec::new(), text };
        for (path, format) in outputs.iter().zip(formats) {
            match format.row().files {
                Files::Pieces => pvtu::check(path)?,
                Files::Folder => folder::check(path, &poly_mesh::FILES)?,
                Files::One | Files::Set => format.files(path).iter().try_for_each(|file| probe(file))?,
            }
            let ((), token) = beside(path, |token| fs::File::create_new(token).map(drop))?;
            tokens.files.push(token.clone());
            let io_error = |source| OutputError::NotWritable { path: path.clone(), source };
            fs::write(token, &tokens.text).map_err(io_error)?;
        }
        Ok(tokens)
    }

    /// Returns the names without their folders.
    fn names(&self) -> Vec<String> {
        let name = |file: &PathBuf| file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.files.iter().map(name).collect()
    }
}

impl Drop for Tokens {
    fn drop(&mut self) {
        // `drop` cannot report a failure.
        self.files.iter().for_each(|file| drop(fs::remove_file(file)));
    }
}

/// Looks for the tokens of process 0 beside the outputs.
fn look(outputs: &[PathBuf], names: &[String], text: &str, process: u32) -> Result<(), SharedFault> {
    for (path, name) in outputs.iter().zip(names) {
        let folder = directory_of(path);
        if fs::read(folder.join(name)).ok().as_deref() != Some(text.as_bytes()) {
            let (path, folder) = (path.clone(), folder.to_path_buf());
            return Err(SharedFault::NotVisible { path, folder, process });
        }
    }
    Ok(())
}
