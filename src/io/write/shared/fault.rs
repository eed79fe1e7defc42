//! Errors of outputs that several processes write, with the exit codes of the program.

use std::path::PathBuf;

use crate::write::error::OutputError;

/// The exit code if the run failed, or if an output cannot be written.
const FAILED: u8 = 1;

/// The exit code for options that are not possible.
const USAGE: u8 = 2;

/// The exit code if a limit was reached.
const LIMIT: u8 = 5;

/// The exit code after an interrupt.
const INTERRUPTED: u8 = 130;

/// A reason why several processes cannot write an output. The clause after the last semicolon is the remedy.
#[derive(Debug, thiserror::Error)]
pub(super) enum SharedFault {
    /// One process could not write it either.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Only one process can write such an output.
    #[error("{}: several processes cannot write {what}; {remedy}", .path.display())]
    NotShared { path: PathBuf, what: &'static str, remedy: &'static str },
    /// Only one process can write what an option adds.
    #[error("{option} is not possible if several processes write the output; omit it")]
    Option { option: &'static str },
    /// Two outputs have a file in common.
    #[error("outputs {} and {} would write the same file; give each output its own name", .first.display(), .second.display())]
    SameFile { first: PathBuf, second: PathBuf },
    /// The processes were started with different outputs.
    #[error("process {process} has other outputs than process 0; give all processes the same outputs")]
    OtherOutputs { process: u32 },
    /// The processes do not share a folder.
    #[error("{}: process {process} does not see the folder {} of process 0; choose a folder that all processes share", .path.display(), .folder.display())]
    NotVisible { path: PathBuf, folder: PathBuf, process: u32 },
    /// The user interrupted the run.
    #[error("interrupted; no partial output was left")]
    Interrupted,
}

impl SharedFault {
    /// Returns the error of shares that contradict each other.
    pub fn inconsistent(reason: impl Into<String>) -> Self {
        OutputError::InvalidMesh { reason: reason.into() }.into()
    }
}

/// Returns the exit code and the message, which ends with the remedy.
pub(super) fn describe(fault: &SharedFault) -> (u8, String) {
    let SharedFault::Output(error) = fault else {
        let code = match fault {
            SharedFault::NotVisible { .. } => FAILED,
            SharedFault::Interrupted => INTERRUPTED,
            _ => USAGE,
        };
        return (code, fault.to_string());
    };
    let remedy = match error {
        OutputError::UnknownFormat { .. }
        | OutputError::NotOneFile
        | OutputError::Compressed { .. }
        | OutputError::NotText { .. }
        | OutputError::NoPieces { .. } => return (USAGE, error.to_string()),
        OutputError::TooLarge { .. } => return (LIMIT, error.to_string()),
        OutputError::MissingDirectory { .. } => "create the directory, or choose another",
        OutputError::IsDirectory { .. } => "give the name of a file in it",
        OutputError::Obstructed { .. } => "choose another name for the output, or move the obstacle away",
        OutputError::NotWritable { .. } => "choose a directory that you can write to",
        OutputError::Io { .. } | OutputError::Stream { .. } => "check the free space on the disk",
        _ => "this is a defect of septet: please report it with the input",
    };
    (FAILED, format!("{error}; {remedy}"))
}
