//! The uses of formats.

/// A use of a format by a reader or a writer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Points are read.
    Points,
    /// Cells are read.
    Cells,
    /// A domain is read: a complex or a closed surface.
    Domain,
    /// Sizes at points are read.
    Sizes,
    /// Weights of points are read from a file of one number a row.
    Weights,
    /// Weights of points are read from a column of the file of the points.
    WeightColumn,
    /// A triangulation of points is written.
    Triangulation,
    /// A mesh of a domain is written.
    Mesh,
    /// A set of points is written.
    PointSet,
    /// Numbers of rows of the input are written.
    RowList,
    /// Offsets of the vertices of a periodic triangulation are written, and read by the verifier.
    Offsets,
}

impl Role {
    /// Whether the use is an output.
    pub const fn is_output(self) -> bool {
        matches!(self, Role::Triangulation | Role::Mesh | Role::PointSet | Role::RowList | Role::Offsets)
    }

    /// Returns the content in messages.
    pub const fn content(self) -> &'static str {
        match self {
            Role::Points | Role::PointSet => "points",
            Role::Cells => "cells",
            Role::Domain => "a domain",
            Role::Sizes => "sizes",
            Role::Weights => "weights",
            Role::WeightColumn => "points with a column of weights",
            Role::Triangulation => "a triangulation",
            Role::Mesh => "a mesh",
            Role::RowList => "a list of rows",
            Role::Offsets => "offsets of vertices",
        }
    }
}
