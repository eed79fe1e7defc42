//! Errors of the writers.

use std::io;
use std::path::{Path, PathBuf};

use septet_core::{Code, Remedy};

use super::topology::TopologyError;
use crate::format::Role;

/// A reason why an output cannot be written. Variants that concern a file contain its path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The extension of the path does not belong to a format that can be written here.
    #[error("{}: unknown output format", .path.display())]
    UnknownFormat {
        /// The path.
        path: PathBuf,
        /// The nearest format, or what to do instead.
        advice: String,
        /// The use of the file.
        role: Role,
    },
    /// The format consists of several files and cannot be written to one stream or device.
    #[error(
        "a .node/.ele set, a .pvtu file or a polyMesh folder has several files and cannot be written to a stream"
    )]
    NotOneFile,
    /// The path of a `.pvtu` file ends in `.gz`.
    #[error("{}: VTK does not read a compressed .pvtu file", .path.display())]
    Compressed {
        /// The path.
        path: PathBuf,
    },
    /// The name of a `.pvtu` file cannot be written in XML, but the file contains the path of its pieces.
    #[error("{}: the name of a .pvtu file must be Unicode without control characters", .path.display())]
    NotText {
        /// The path.
        path: PathBuf,
    },
    /// A `.pvtu` file has a piece for each worker, but the mesh does not state the worker of each point.
    #[error("{}: a .pvtu file needs the worker of each point, which only triangulate and simulate keep", .path.display())]
    NoPieces {
        /// The path.
        path: PathBuf,
    },
    /// The folder of the output would replace something else.
    #[error("{}: the files of the output cannot be written here, because {obstacle}", .path.display())]
    Obstructed {
        /// The folder.
        path: PathBuf,
        /// The obstacle.
        obstacle: String,
    },
    /// The mesh has more entries than the format can hold.
    #[error("{}: {entries} entries are too many for this format, whose numbers of entries have a limit", .path.display())]
    TooLarge {
        /// The path.
        path: PathBuf,
        /// The number of entries.
        entries: u64,
    },
    /// The format is a picture of the plane, but the points have three coordinates.
    #[error("{}: an .svg file is a picture of triangles in the plane, but the points have three coordinates", .path.display())]
    OnlyPlane {
        /// The path.
        path: PathBuf,
    },
    /// The format has no place for the dimension.
    #[error("{}: .{format} files hold points and cells of dimensions 2 and 3, but the points have {dimension} coordinates", .path.display())]
    OnlySpace {
        /// The path.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// Number of coordinates of a point.
        dimension: usize,
    },
    /// The format holds only meshes of space, but the points have two coordinates.
    #[error("{}: a .{format} output is a mesh of space, but the points have two coordinates", .path.display())]
    NotPlane {
        /// The path.
        path: PathBuf,
        /// The format.
        format: &'static str,
    },
    /// The format has no quadratic cells.
    #[error("{}: .{format} files hold linear cells, not cells of order 2", .path.display())]
    OnlyLinear {
        /// The path.
        path: PathBuf,
        /// The format.
        format: &'static str,
    },
    /// The directory of the file does not exist or is not a directory.
    #[error("{}: the directory {} does not exist", .path.display(), .directory.display())]
    MissingDirectory {
        /// The path.
        path: PathBuf,
        /// The directory.
        directory: PathBuf,
    },
    /// The path is a directory.
    #[error("{}: is a directory", .path.display())]
    IsDirectory {
        /// The path.
        path: PathBuf,
    },
    /// The file is read-only, its directory accepts no new files, or another file cannot take its name.
    #[error("{}: cannot be written: {source}", .path.display())]
    NotWritable {
        /// The path.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Writing failed, for example because the disk is full.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The output stream that the caller supplied failed.
    #[error("the output stream failed: {source}")]
    Stream {
        /// The error of the stream.
        source: io::Error,
    },
    /// The format needs facets or neighbours, but the cells do not form a manifold.
    #[error("{}: {source}", .path.display())]
    Topology {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: TopologyError,
    },
    /// The arrays of the mesh have lengths or indices that contradict each other.
    #[error("the mesh is inconsistent: {reason}")]
    InvalidMesh {
        /// The contradiction.
        reason: String,
    },
    /// The first id of a `TetGen` file must be 0 or 1.
    #[error("the first id must be 0 or 1, not {first_id}")]
    FirstId {
        /// The requested id.
        first_id: u64,
    },
}

impl OutputError {
    /// Returns the error for a path that does not determine a format of this use.
    pub(super) fn unknown(path: &Path, role: Role) -> Self {
        let advice = if path.as_os_str() == "-" {
            "standard output has no extension".to_owned()
        } else {
            role.advice(path).unwrap_or_else(|| "end the name in a known extension".to_owned())
        };
        OutputError::UnknownFormat { path: path.to_owned(), advice, role }
    }

    /// Returns the exit code of the program.
    pub fn exit_code(&self) -> Code {
        match self {
            OutputError::UnknownFormat { .. }
            | OutputError::NotOneFile
            | OutputError::Compressed { .. }
            | OutputError::NotText { .. }
            | OutputError::NoPieces { .. }
            | OutputError::OnlyPlane { .. }
            | OutputError::OnlySpace { .. }
            | OutputError::NotPlane { .. }
            | OutputError::OnlyLinear { .. } => Code::Usage,
            OutputError::TooLarge { .. } => Code::Limit,
            _ => Code::Failed,
        }
    }

    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(Remedy::of(match self {
            OutputError::UnknownFormat { advice, role, .. } => {
                let known = Remedy::plain(advice).and("; use one of ").and(role.known());
                return Some(known.then(", or state the format with {format}"));
            }
            OutputError::NotOneFile => "choose another format",
            OutputError::Compressed { .. } => "omit .gz",
            OutputError::NotText { .. } => "choose another name",
            OutputError::NoPieces { .. } | OutputError::TooLarge { .. } => "write .vtu",
            OutputError::OnlySpace { .. } => "write .npy",
            OutputError::NotPlane { .. } => "write .msh or .vtu",
            OutputError::OnlyLinear { .. } => "omit {order}, or write .vtu or .msh",
            OutputError::OnlyPlane { .. } => "write .vtu for ParaView; {dimension=2} takes x and y of points",
            OutputError::MissingDirectory { .. } => "create the directory, or choose another",
            OutputError::IsDirectory { .. } => "give the name of a file in it",
            OutputError::Obstructed { .. } => "choose another name for the output, or move the obstacle away",
            OutputError::NotWritable { .. } => "choose a directory that you can write to",
            OutputError::Io { .. } | OutputError::Stream { .. } => "check the free space on the disk",
            OutputError::FirstId { .. } => "use 0 or 1",
            OutputError::Topology { .. } | OutputError::InvalidMesh { .. } => {
                "check the arrays; if septet made them, please report it with the input"
            }
        }))
    }
}

/// A failure in the writer of a format. It has no path, because these writers do not know it.
#[derive(Debug)]
pub(super) enum WriteFault {
    /// Writing failed.
    Io(io::Error),
    /// The cells do not form a manifold.
    Topology(TopologyError),
    /// There are more entries than the format can count.
    TooLarge(u64),
    /// The mesh is not in the plane.
    OnlyPlane,
}

impl WriteFault {
    /// Adds the path.
    pub(super) fn at(self, path: &Path) -> OutputError {
        let path = path.to_path_buf();
        match self {
            WriteFault::Io(source) => OutputError::Io { path, source },
            WriteFault::Topology(source) => OutputError::Topology { path, source },
            WriteFault::OnlyPlane => OutputError::OnlyPlane { path },
            WriteFault::TooLarge(entries) => OutputError::TooLarge { path, entries },
        }
    }

    /// Converts the failure to the error of a stream.
    pub(super) fn of_stream(self) -> OutputError {
        match self {
            WriteFault::Io(source) => OutputError::Stream { source },
            other => other.at(std::path::Path::new("-")),
        }
    }
}

impl From<io::Error> for WriteFault {
    fn from(error: io::Error) -> Self {
        WriteFault::Io(error)
    }
}

impl From<TopologyError> for WriteFault {
    fn from(error: TopologyError) -> Self {
        WriteFault::Topology(error)
    }
}
