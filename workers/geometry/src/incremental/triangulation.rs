//! A triangulation that grows point by point: its construction and the order of its insertions.

use super::cells::Cells;
use super::order::insertion_order;
use super::scratch::Scratch;
use super::sphere::Frame;
use thiserror::Error;

use crate::complex::{INFINITE, NONE};
use crate::point::{Point, Simplex};
use crate::predicates::{Sign, orientation, raises_dimension};

/// Why points could not be triangulated.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum IncrementalError {
    /// The points span a point, a line or a plane, or there are none (-1).
    #[error("the points span dimension {dimension}: no cell can be built")]
    Flat {
        /// Dimension of the affine hull.
        dimension: isize,
    },
    /// A point has the coordinates of a vertex.
    #[error("point {point} coincides with vertex {vertex}")]
    Coincident {
        /// The number of the point that was not inserted.
        point: u32,
        /// The vertex with its coordinates.
        vertex: u32,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} has a coordinate that is not finite")]
    NotFinite {
        /// The number of the point.
        point: u32,
    },
    /// It was told to stop.
    #[error("the triangulation was stopped")]
    Stopped,
    /// More points or cells than one triangulation can number.
    #[error("more than 2^26 points or 2^29 cells in one triangulation")]
    TooMany,
}

/// A Delaunay triangulation that grows point by point. Vertices are numbers of points.
#[derive(Clone, Debug)]
pub struct Incremental<P: Point> {
    pub(super) points: Vec<P>,
    pub(super) cells: Cells<P::Cell>,
    /// A cell of each vertex, at its number plus 1; of infinity at 0. `NONE` before insertion.
    pub(super) incident: Vec<u32>,
    pub(super) last: u32,
    pub(super) frame: Frame<P>,
    pub(super) scratch: Scratch<P>,
}

/// Random points in space have 6.8 cells each: at this number less than [`MOST_CELLS`].
const MOST_POINTS: usize = 1 << 26;

/// Half of what can be numbered: one insertion adds at most two cells per vertex.
const MOST_CELLS: u32 = 1 << 29;

/// Points between two questions whether to go on.
pub const STOP_CHECK_INTERVAL: usize = 4096;

impl<P: Point> Incremental<P> {
    /// Triangulates `points`; vertex `i` is `points[i]`. Equal to [`Incremental::build`] with
    /// [`insertion_order`].
    ///
    /// # Errors
    ///
    /// Any [`IncrementalError`]; of coincident points, the first met in the order of insertion.
    pub fn new(points: Vec<P>) -> Result<Self, IncrementalError> {
        let order = insertion_order(&points);
        Self::build(points, Some(&order))
    }

    /// Triangulates `points` in the given order (each number once), or as they stand. With an order the
    /// points are copied and the vertices renamed at the end: points that stand along
    /// [`insertion_order`] already, and are inserted as they stand, cost neither.
    ///
    /// # Errors
    ///
    /// Any [`IncrementalError`]; of coincident points, the first met in the order of insertion.
    pub fn build(points: Vec<P>, order: Option<&[u32]>) -> Result<Self, IncrementalError> {
        Self::build_while(points, order, &mut || true)
    }

    /// The same, as long as `go_on`, which is asked every [`STOP_CHECK_INTERVAL`] points, answers yes.
    ///
    /// # Errors
    ///
    /// As [`Incremental::build`]; [`IncrementalError::Stopped`].
    pub fn build_while(
        mut points: Vec<P>,
        order: Option<&[u32]>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, IncrementalError> {
        let Some(order) = order else {
            let vertices = 0..points.len() as u32;
            return Self::build_in_place(points, vertices, go_on);
        };
        clean(&mut points)?;
        let sorted = order.iter().map(|&i| points[i as usize]).collect();
        let mut this = Self::in_place(sorted, 0..order.len() as u32, go_on).map_err(|error| match error {
            IncrementalError::Coincident { point, vertex } => {
                IncrementalError::Coincident { point: order[point as usize], vertex: order[vertex as usize] }
            }
            other => other,
        })?;
        this.rename(points, order);
        Ok(this)
    }

    /// Triangulates `points` where they stand, inserting them in the given order (each number once): no copy, and vertex `i`
    /// is `points[i]` from the start. For orders that follow few runs of the points. What `points` has room for, the
    /// triangulation has too: a vector with more capacity than points is for more to be inserted.
    ///
    /// # Errors
    ///
    /// As [`Incremental::build_while`].
    pub fn build_in_place(
        mut points: Vec<P>,
        order: impl IntoIterator<Item = u32>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, IncrementalError> {
        clean(&mut points)?;
        Self::in_place(points, order, go_on)
    }

    /// Triangulates points, which are clean, as they stand.
    fn in_place(
        points: Vec<P>,
        order: impl IntoIterator<Item = u32>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Self, IncrementalError> {
        if points.len() > MOST_POINTS {
            return Err(IncrementalError::TooMany);
        }
        // Room for the points that will come is made now: cells are not moved when they do.
        let room = points.capacity().min(MOST_POINTS);
        let mut incident = Vec::with_capacity(room + 1);
        incident.resize(points.len() + 1, NONE);
        incident[0] = 0;
        let mut this = Incremental {
            incident,
            frame: Frame::over(&points),
            cells: Cells::with_capacity(room * expected_cells(P::DIM)),
            last: 0,
            scratch: Scratch::default(),
            points,
        };
        let first = this.start()?;
        for (count, vertex) in order.into_iter().enumerate() {
            if count.is_multiple_of(STOP_CHECK_INTERVAL) && !go_on() {
                return Err(IncrementalError::Stopped);
            }
            if !first.as_ref().contains(&vertex) {
                this.insert_vertex(vertex, this.last, INFINITE)?;
            }
        }
        Ok(this)
    }

    /// Starts from the first affinely independent points.
    fn start(&mut self) -> Result<P::Cell, IncrementalError> {
        let mut cell = P::Cell::splat(0);
        let mut basis: Vec<P> = Vec::with_capacity(P::DIM + 1);
        for (v, &p) in (0u32..).zip(&self.points) {
            if raises_dimension(&basis, p) {
                cell.as_mut()[basis.len()] = v;
                basis.push(p);
                if basis.len() > P::DIM {
                    break;
                }
            }
        }
        if basis.len() <= P::DIM {
            return Err(IncrementalError::Flat { dimension: basis.len() as isize - 1 });
        }
        if orientation(&basis) == Sign::Negative {
            cell.as_mut().swap(0, 1);
        }
        self.cells.start(cell);
        for &v in cell.as_ref() {
            self.incident[v as usize + 1] = 0;
        }
        self.incident[0] = 1;
        Ok(cell)
    }

    /// Names vertex `i` `order[i]`, which is its place in `points`.
    fn rename(&mut self, points: Vec<P>, order: &[u32]) {
        for cell in &mut self.cells.slots {
            for v in cell.vertices_mut().as_mut() {
                if *v != INFINITE {
                    *v = order[*v as usize];
                }
            }
        }
        let mut incident = vec![NONE; points.len() + 1];
        incident[0] = self.incident[0];
        for (&to, &cell) in order.iter().zip(&self.incident[1..]) {
            incident[to as usize + 1] = cell;
        }
        self.incident = incident;
        self.points = points;
    }

    /// Adds a point and returns its vertex. The walk starts at the cell `hint` if that is live, else at
    /// the last cell made.
    ///
    /// # Errors
    ///
    /// [`IncrementalError::Coincident`] with the vertex that stands there already; `NotFinite` and
    /// `TooMany`. The triangulation is then as before.
    pub fn insert(&mut self, p: P, hint: Option<u32>) -> Result<u32, IncrementalError> {
        let vertex = self.points.len() as u32;
        self.insert_if_adjacent(p, hint, INFINITE).map(|_| vertex)
    }

    /// The same, if one of the new vertex' neighbours is below `bound` or it undoes very many cells; else nothing changes,
    /// and there is no vertex.
    ///
    /// What is left out so never becomes the neighbour of such a vertex: an edge between two points stays one as long
    /// as the two do when others are left out, so it would be one now. What undoes many cells is let in so that the next
    /// one there does not: points that fall into an empty part would all look at the same large cells.
    ///
    /// # Errors
    ///
    /// As [`Incremental::insert`].
    pub fn insert_if_adjacent(
        &mut self,
        p: P,
        hint: Option<u32>,
        bound: u32,
    ) -> Result<Option<u32>, IncrementalError> {
        let vertex = self.points.len() as u32;
        if self.points.len() >= MOST_POINTS {
            return Err(IncrementalError::TooMany);
        }
        let p = cleaned(p).ok_or(IncrementalError::NotFinite { point: vertex })?;
        self.frame.extend(p);
        self.points.push(p);
        self.incident.push(NONE);
        let done = self.insert_vertex(vertex, self.start_of(hint), bound);
        if done != Ok(true) {
            self.points.pop();
            self.incident.pop();
        }
        done.map(|is_adjacent| is_adjacent.then_some(vertex))
    }

    /// Adds points in the order of [`insertion_order`], each walk starting where the point before was
    /// added, and returns the vertex of each: a new one, or the one that stands there already. New
    /// vertices are numbered in the order of insertion. `go_on` is asked every [`STOP_CHECK_INTERVAL`] points.
    ///
    /// # Errors
    ///
    /// `NotFinite` with the point's position in `points`, before anything is added; `TooMany` and
    /// `Stopped`, when the points before the one that failed are added.
    pub fn insert_all(
        &mut self,
        points: &[P],
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<u32>, IncrementalError> {
        let mut points = points.to_vec();
        clean(&mut points)?;
        let mut vertices = vec![NONE; points.len()];
        for (count, i) in insertion_order(&points).into_iter().enumerate() {
            if count.is_multiple_of(STOP_CHECK_INTERVAL) && !go_on() {
                return Err(IncrementalError::Stopped);
            }
            vertices[i as usize] = match self.insert(points[i as usize], None) {
                Ok(vertex) | Err(IncrementalError::Coincident { vertex, .. }) => vertex,
                Err(error) => return Err(error),
            };
        }
        Ok(vertices)
    }

    /// Joins a vertex to the others, if one of its neighbours will be below `bound`; was it?
    fn insert_vertex(&mut self, vertex: u32, start: u32, bound: u32) -> Result<bool, IncrementalError> {
        if self.cells.slots() > MOST_CELLS {
            return Err(IncrementalError::TooMany);
        }
        let q = self.points[vertex as usize];
        let query = self.frame.query(q);
        let (mut seed, certain) = self.descend(&query, start);
        if !certain {
            seed = self.walk(q, seed);
            // Only the cell that holds a point can have it as a vertex.
            for &v in self.cells.cell(seed).as_ref() {
                if v != INFINITE && self.points[v as usize] == q {
                    return Err(IncrementalError::Coincident { point: vertex, vertex: v });
                }
            }
        }
        Ok(self.replace(vertex, &query, seed, bound))
    }
}

/// Room made for the cells of each point, in whole cells: what random points need, and a little more.
/// Memory that is not written to is not used.
fn expected_cells(dimension: usize) -> usize {
    if dimension == 2 { 2 } else { 7 }
}

/// Reads `-0.0` as `0.0` everywhere, if all coordinates are finite.
fn clean<P: Point>(points: &mut [P]) -> Result<(), IncrementalError> {
    for (i, p) in (0u32..).zip(points) {
        *p = cleaned(*p).ok_or(IncrementalError::NotFinite { point: i })?;
    }
    Ok(())
}

/// The point with `-0.0` read as `0.0`, if it is finite.
fn cleaned<P: Point>(mut p: P) -> Option<P> {
    for i in 0..P::DIM {
        if !p.coord(i).is_finite() {
            return None;
        }
        p.set_coord(i, p.coord(i) + 0.0);
    }
    Some(p)
}
