//! Errors of reading by several processes.

use std::path::PathBuf;

use septet_core::{Code, Remedy};
use septet_protocol::wire::{Ended, Processes};

use super::super::error::{InputError, shown};
use super::super::list::ListError;

/// A reason why several processes cannot read an input.
#[derive(Debug, thiserror::Error)]
pub(super) enum SharedError {
    /// The only file cannot be read.
    #[error(transparent)]
    File(Box<InputError>),
    /// A file of a list cannot be read, or does not agree with the files before it.
    #[error(transparent)]
    List(Box<ListError>),
    /// A file that one process must read is too large.
    #[error("{}: the file has more than {limit} bytes, and several processes cannot read it in parts", shown(.path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The largest size in bytes.
        limit: u64,
    },
    /// The heights of all points are too large for each process.
    #[error("each process would hold {bytes} bytes of heights, more than {limit}")]
    Heights {
        /// The size in bytes of the heights of all points.
        bytes: u64,
        /// The largest size in bytes.
        limit: u64,
    },
    /// Two processes see other files at the same path.
    #[error("{}: process {process} sees {found}, but process 0 sees {expected}", shown(.path))]
    Differs {
        /// The file.
        path: PathBuf,
        /// The process.
        process: u32,
        /// The size or the header that it sees.
        found: String,
        /// The size or the header that process 0 sees.
        expected: String,
    },
    /// Two processes have other lists of files.
    #[error("process {process} has {found} files, but process 0 has {expected}")]
    OtherList {
        /// The process.
        process: u32,
        /// The number of its files.
        found: u64,
        /// The number of files of process 0.
        expected: u64,
    },
    /// The blocks of the processes are not consecutive.
    #[error("the blocks of the processes do not divide the {rows} rows")]
    Blocks {
        /// The number of rows.
        rows: u64,
    },
    /// The user interrupted the run.
    #[error("interrupted; no partial output was left")]
    Interrupted,
    /// A file changed while it was read.
    #[error("{}: the file changed while it was read", shown(.path))]
    Changed {
        /// The file.
        path: PathBuf,
    },
}

impl From<InputError> for SharedError {
    fn from(error: InputError) -> Self {
        SharedError::File(Box::new(error))
    }
}

impl From<ListError> for SharedError {
    fn from(error: ListError) -> Self {
        SharedError::List(Box::new(error))
    }
}

impl SharedError {
    /// Returns the error for a file among `files` files. `before` is the number of rows in the files before it.
    pub fn of(error: InputError, files: usize, before: u64) -> Self {
        if files == 1 {
            return error.into();
        }
        ListError::File { error: Box::new(error), before }.into()
    }

    /// Returns the error for the weights of the rows of `files` files.
    pub fn of_weights(error: InputError, files: usize) -> Self {
        if files == 1 {
            return error.into();
        }
        ListError::Weights { error: Box::new(error) }.into()
    }

    /// Returns what to do.
    fn remedy(&self) -> Option<Remedy> {
        Some(match self {
            Self::File(error) => return error.remedy(),
            Self::List(error) => return error.remedy(),
            Self::TooLarge { .. } => Remedy::of("save it as .npy in C order, or read it in one process"),
            Self::Heights { .. } => Remedy::of("run in one process, or without {terrain}"),
            Self::Differs { .. } => Remedy::of("give all processes the same file"),
            Self::OtherList { .. } => Remedy::of("give all processes the same list"),
            Self::Blocks { .. } => Remedy::REPORT,
            Self::Interrupted => return None,
            Self::Changed { .. } => Remedy::of("read it again"),
        })
    }

    /// Returns the exit code of the program.
    fn code(&self) -> Code {
        match self {
            Self::TooLarge { .. } | Self::Heights { .. } => Code::Limit,
            Self::Blocks { .. } => Code::Failed,
            Self::Interrupted => Code::Interrupted,
            Self::File(error) => error.exit_code(),
            Self::List(error) => error.exit_code(),
            Self::Differs { .. } | Self::OtherList { .. } | Self::Changed { .. } => Code::Input,
        }
    }
}

/// Returns the value of this process if no process has an error, otherwise the error of the first process that has one.
pub(super) fn agree<T>(processes: &mut Processes<'_>, own: Result<T, SharedError>) -> Result<T, Ended> {
    processes.agree(own, |error| (error.code() as u8, error.to_string(), Remedy::sent(error.remedy())))
}
