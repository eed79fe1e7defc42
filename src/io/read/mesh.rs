//! Files of points and cells, read as points or as cells.

use super::cells::{CellFile, CellOptions, Indices};
use super::collect::Collector;
use super::error::{InputError, Place};
use super::points::{PointFile, ReadOptions};
use super::text::Source;
use septet_core::model::Points;

/// A mesh as it was read.
pub(super) struct FileMesh<'a> {
    pub source: Source<'a>,
    pub points: Collector<'a>,
    pub triangles: Indices<'a>,
    pub tetrahedra: Indices<'a>,
    /// The location and name of the first cell that is not a point, line, triangle or tetrahedron.
    pub other: Option<(Place, String)>,
}

/// The kinds of cells that the readers distinguish.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum CellKind {
    /// A point or line, which is ignored.
    Lower,
    Triangle,
    Tetrahedron,
    Other,
}

impl<'a> FileMesh<'a> {
    /// Creates a mesh of these points without cells. `first` is the id of point 0 in the file.
    pub fn new(source: Source<'a>, points: Collector<'a>, first: u64) -> Self {
        let limit = Some(points.met);
        let list = |width| Indices::new(source, width, first, limit);
        FileMesh { source, points, triangles: list(3), tetrahedra: list(4), other: None }
    }

    /// Returns the list of the cells of this kind.
    pub fn list(&mut self, kind: CellKind) -> Option<&mut Indices<'a>> {
        match kind {
            CellKind::Triangle => Some(&mut self.triangles),
            CellKind::Tetrahedron => Some(&mut self.tetrahedra),
            CellKind::Lower | CellKind::Other => None,
        }
    }

    /// Returns the points. If all cells are triangles and every z is 0, the points are two-dimensional.
    pub fn into_points(self, options: &ReadOptions) -> Result<PointFile, InputError> {
        let planar = self.triangles.rows() > 0 && self.tetrahedra.rows() == 0 && self.other.is_none();
        let mut file = self.points.finish();
        let Points::Space(space) = &file.points else {
            if options.dimension == Some(3) {
                let (path, place) = (self.source.path.to_owned(), Place::Whole);
                if options.terrain {
                    return Err(InputError::NoHeights { path, place });
                }
                return Err(InputError::MixedDimension { path, place, expected: 3, found: 2, row: None });
            }
            return Ok(file);
        };
        let lifted = space.iter().filter(|p| p.z != 0.0).count();
        let plane = match options.dimension {
            Some(dimension) => dimension == 2,
            None => planar && lifted == 0,
        };
        if plane {
            if lifted > 0 {
                file.notes.push(format!("z is dropped, although it is not 0 for {lifted} points"));
            }
            file.points = Points::Plane(space.iter().map(|p| p.truncate()).collect());
        } else if lifted == 0 && !space.is_empty() && !options.terrain {
            file.notes
                .push("every z is 0, so dimension 2 triangulates the same points in the plane".to_owned());
        }
        Ok(file)
    }

    /// Returns the cells of the requested dimension. By default, it returns tetrahedra if there are any,
    /// otherwise triangles.
    pub fn into_cells(self, options: &CellOptions) -> Result<CellFile, InputError> {
        Ok(self.into_both(options)?.1)
    }

    /// Returns all points with three coordinates, and the cells as [`FileMesh::into_cells`] does.
    pub fn into_both(self, options: &CellOptions) -> Result<(PointFile, CellFile), InputError> {
        let points = self.points.finish();
        let solid = self.tetrahedra.rows() > 0;
        let dimension = options.dimension.unwrap_or(if solid || self.triangles.rows() == 0 { 3 } else { 2 });
        if let Some((place, what)) = self.other {
            return Err(self.source.unsupported(place, what, "give a mesh of triangles or tetrahedra"));
        }
        let mut notes = Vec::new();
        if dimension == 3 {
            if self.triangles.rows() > 0 {
                let reason = if solid { "the mesh has tetrahedra" } else { "tetrahedra were requested" };
                notes.push(format!("{} triangles are ignored: {reason}", self.triangles.rows()));
            }
            return Ok((points, self.tetrahedra.finish(notes)));
        }
        if solid {
            notes
                .push(format!("{} tetrahedra are ignored: triangles were requested", self.tetrahedra.rows()));
        }
        Ok((points, self.triangles.finish(notes)))
    }
}
