//! What can go wrong while a file is written.

use std::io;
use std::path::PathBuf;

use super::topology::TopologyError;

/// Why an output could not be written. Every variant that concerns a file names it.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The extension of the file name stands for no format that can be written.
    #[error("{}: unknown output format; known extensions are {known}", .path.display())]
    UnknownFormat {
        /// The path asked for.
        path: PathBuf,
        /// The extensions that are known, separated by blanks.
        known: String,
    },
    /// The directory that should hold the file does not exist, or is not a directory.
    #[error("{}: the directory {} does not exist", .path.display(), .directory.display())]
    MissingDirectory {
        /// The path asked for.
        path: PathBuf,
        /// The directory that is missing.
        directory: PathBuf,
    },
    /// There is a directory where the file should be.
    #[error("{}: is a directory", .path.display())]
    IsDirectory {
        /// The path asked for.
        path: PathBuf,
    },
    /// The file exists and is read-only, its directory takes no new files, or the name is not one of a file that could be
    /// replaced.
    #[error("{}: cannot be written: {source}", .path.display())]
    NotWritable {
        /// The path asked for.
        path: PathBuf,
        /// What stands in the way.
        source: io::Error,
    },
    /// Writing failed on the way, for instance because the disk is full.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file being written.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A stream supplied by the caller refused data.
    #[error("the output stream failed: {source}")]
    Stream {
        /// What the stream said.
        source: io::Error,
    },
    /// The cells do not form a mesh that has the facets or neighbours the format asks for.
    #[error("{}: {source}", .path.display())]
    Topology {
        /// The file being written.
        path: PathBuf,
        /// What is wrong with the cells.
        source: TopologyError,
    },
    /// The arrays of the mesh do not fit together.
    #[error("the mesh is inconsistent: {reason}")]
    InvalidMesh {
        /// What does not fit.
        reason: String,
    },
    /// The first id of a `TetGen` file must be 0 or 1.
    #[error("the first id must be 0 or 1, not {first_id}")]
    FirstId {
        /// The value asked for.
        first_id: u64,
    },
}

/// A failure inside a format writer, which does not know the name of its file.
#[derive(Debug)]
pub(super) enum Fault {
    /// The sink refused data.
    Io(io::Error),
    /// The cells are not a manifold.
    Topology(TopologyError),
}

impl Fault {
    /// Names the file.
    pub(super) fn at(self, path: &std::path::Path) -> OutputError {
        let path = path.to_path_buf();
        match self {
            Fault::Io(source) => OutputError::Io { path, source },
            Fault::Topology(source) => OutputError::Topology { path, source },
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Fault::Io(error)
    }
}

impl From<TopologyError> for Fault {
    fn from(error: TopologyError) -> Self {
        Fault::Topology(error)
    }
}
