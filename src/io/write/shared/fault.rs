//! Errors of outputs that several processes write, with the exit codes of the program.

use std::path::PathBuf;

use septet_core::{Code, Remedy};

use crate::format::Role;
use crate::write::error::OutputError;

/// A reason why several processes cannot write an output.
#[derive(Debug, thiserror::Error)]
pub(super) enum SharedFault {
    /// One process could not write it either.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Only a process of its own can write to a stream.
    #[error("{}: several processes cannot write a stream or a device", .path.display())]
    NotAFile { path: PathBuf },
    /// The triangulation, or its values of all rows, are too large for one process.
    #[error("one process would hold {bytes} bytes of all rows and cells, more than {limit}")]
    TooLarge { bytes: u64, limit: u64, divided: String },
    /// Two outputs have a file in common.
    #[error("outputs {} and {} would write the same file", .first.display(), .second.display())]
    SameFile { first: PathBuf, second: PathBuf },
    /// The processes were started with different outputs.
    #[error("process {process} has other outputs than process 0")]
    OtherOutputs { process: u32 },
    /// The processes do not share a folder.
    #[error("{}: process {process} does not see the folder {} of process 0", .path.display(), .folder.display())]
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

    /// Returns what to do.
    fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            Self::Output(error) => return error.remedy(),
            Self::NotAFile { .. } => "write a file",
            Self::TooLarge { divided, .. } => {
                let remedy = Remedy::of("run in one process, or write ").and(divided);
                return Some(remedy.then(" without {keep-columns} and {skip-invalid}"));
            }
            Self::SameFile { .. } => "give each output its own name",
            Self::OtherOutputs { .. } => "give all processes the same outputs",
            Self::NotVisible { .. } => "choose a folder that all processes share",
            Self::Interrupted => return None,
        }))
    }
}

/// The largest size in bytes of the data that one of several processes holds for all: the triangulation, or the values of all rows.
pub const GATHER_LIMIT: u64 = 1 << 30;

/// Checks the size of the data that one process holds for all.
pub(super) fn fits(bytes: u64) -> Result<(), SharedFault> {
    let divided = || Role::Triangulation.extensions(|row| row.is_divided(Role::Triangulation));
    let too_large = || SharedFault::TooLarge { bytes, limit: GATHER_LIMIT, divided: divided() };
    if bytes > GATHER_LIMIT { Err(too_large()) } else { Ok(()) }
}

/// Returns the exit code, the message and the remedy.
pub(super) fn describe(fault: &SharedFault) -> (u8, String, String) {
    let code = match fault {
        SharedFault::Output(error) => error.exit_code(),
        SharedFault::NotVisible { .. } => Code::Failed,
        SharedFault::TooLarge { .. } => Code::Limit,
        SharedFault::Interrupted => Code::Interrupted,
        _ => Code::Usage,
    };
    (code as u8, fault.to_string(), Remedy::sent(fault.remedy()))
}
