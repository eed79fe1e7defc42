//! The row of a format in the table.

use super::role::Role;

/// The files that an output consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Files {
    /// One file.
    One,
    /// The set of `TetGen`, whichever of its files is named.
    Set,
    /// A folder of files.
    Folder,
    /// A file that lists pieces, and a folder with a piece for each worker.
    Pieces,
}

/// The facts about a format. The texts are cells of the tables of the guide; an empty text stands for "yes".
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The extensions without dots. The first is the name of the format.
    pub extensions: &'static [&'static str],
    /// Extensions that other files also have, so that the content of the file decides. Nothing is written under them.
    pub ambiguous: &'static [&'static str],
    /// The uses, each with a remark.
    pub roles: &'static [(Role, &'static str)],
    /// The uses that several processes divide: each reads or writes its own part. In the other uses, the first process
    /// reads or writes for all.
    pub divided: &'static [Role],
    /// The files of an output.
    pub files: Files,
    /// Whether files may be compressed with gzip.
    pub is_packable: bool,
    /// Whether files are tables of text, with columns to choose.
    pub is_table: bool,
    /// Whether outputs hold values at points and owners of cells.
    pub has_data: bool,
    /// Whether a triangulation in space is written as its surface.
    pub is_surface: bool,
    /// Whether only triangulations in the plane are written.
    pub is_plane: bool,
    /// Whether only triangulations in space are written.
    pub is_space: bool,
    /// Whether outputs may have quadratic cells.
    pub has_order_2: bool,
    /// Whether triangulations of periodic boxes are written: without points, or with values at the images of points.
    pub has_images: bool,
    /// Whether points are numbered by the rows of the input, including dropped ones, because the file lacks some points.
    pub has_input_rows: bool,
    /// Parts of a mesh of a domain that are written: cells, faces on facets, edges on segments, points.
    pub labels: Option<[&'static str; 4]>,
    /// What to do instead of the uses that the format does not have.
    pub instead: &'static [(Role, &'static str)],
}

/// A format without uses.
pub(super) const NONE: Row = Row {
    extensions: &[],
    ambiguous: &[],
    roles: &[],
    divided: &[],
    files: Files::One,
    is_packable: true,
    is_table: false,
    has_data: false,
    is_surface: false,
    is_plane: false,
    is_space: false,
    has_order_2: false,
    has_images: false,
    has_input_rows: false,
    labels: None,
    instead: &[],
};

/// The advice for a mesh of a solver.
pub(super) const OF_SOLVER: &[(Role, &str)] = &[
    (Role::Points, "write .vtu or .msh with meshio"),
    (Role::Cells, "write .vtu or .msh with meshio"),
    (Role::PointSet, "write .vtu or .ply"),
];

/// The advice for a dataset that `ParaView` reads.
pub(super) const OF_PARAVIEW: &[(Role, &str)] = &[
    (Role::Points, "write .vtu with ParaView or meshio"),
    (Role::Cells, "write .vtu with ParaView or meshio"),
    (Role::PointSet, "write .vtu"),
];

impl Row {
    /// Whether the format has this extension, also one that does not determine it.
    pub(super) fn has_extension(&self, extension: &str) -> bool {
        self.extensions.contains(&extension) || self.ambiguous.contains(&extension)
    }

    /// Returns the remark on a use, or `None` if the format does not have it.
    pub fn remark(&self, role: Role) -> Option<&'static str> {
        self.roles.iter().find(|(own, _)| *own == role).map(|(_, remark)| *remark)
    }

    /// Whether several processes divide this use among themselves.
    pub const fn is_divided(&self, role: Role) -> bool {
        let mut at = 0;
        while at < self.divided.len() {
            if self.divided[at] as u8 == role as u8 {
                return true;
            }
            at += 1;
        }
        false
    }
}
