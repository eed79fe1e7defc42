//! The incremental triangulation: construction, and insertion of points in a given order.

use super::cells::Cells;
use super::operations::Operations;
use super::order::insertion_order;
use super::scratch::Scratch;
use super::sphere::Frame;
use thiserror::Error;

use crate::complex::{INFINITE, NONE};
use crate::cost::Cost;
use crate::point::{Point, Simplex, lex_cmp};
use crate::predicates::{ExactTests, Sign, orientation, raises_dimension};
use crate::simd::larger;

/// The reason why a triangulation failed.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum IncrementalError {
    /// The points span only a point, a line or a plane, or there are none (dimension -1).
    #[error("the points span dimension {dimension}: no cell can be built")]
    Flat {
        /// Dimension of the affine hull.
        dimension: isize,
    },
    /// A point coincides with a vertex.
    #[error("point {point} coincides with vertex {vertex}")]
    Coincident {
        /// Index of the point that was not inserted.
        point: u32,
        /// Vertex with the same coordinates.
        vertex: u32,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} has a coordinate that is not finite")]
    NotFinite {
        /// Index of the point.
        point: u32,
    },
    /// The caller requested a stop.
    #[error("the triangulation was stopped")]
    Stopped,
    /// There are more points or cells than indices.
    #[error("more than 2^26 points or 2^29 cells in one triangulation")]
    TooMany,
}

/// A Delaunay triangulation to which points can be added; of points with weights, a regular triangulation
/// ([`crate::site`]). Vertices are indices of points. Hidden sites have an index, but no cells.
#[derive(Clone, Debug)]
pub struct Incremental<P: Point> {
    pub(super) points: Vec<P>,
    pub(super) cells: Cells<P::Cell>,
    /// One cell of each vertex, at the vertex index plus 1. Entry 0 is a cell of infinity. Entries are `NONE` before
    /// the insertion.
    pub(super) incident: Vec<u32>,
    pub(super) last: u32,
    pub(super) frame: Frame<P>,
    pub(super) scratch: Scratch<P>,
    pub(super) operations: Operations,
}

/// Largest number of points. Random points in space have 6.8 cells each, so this number of points has fewer than
/// [`MOST_CELLS`] cells.
const MOST_POINTS: usize = 1 << 26;

/// Half the number of cell indices. The margin suffices, because one insertion adds at most two cells for each vertex.
const MOST_CELLS: u32 = 1 << 29;

/// Number of insertions between two checks of whether to stop.
pub const STOP_CHECK_INTERVAL: usize = 4096;

/// Number of new cells after which a check precedes the next insertion: less than a mebibyte.
const CHECKED_CELLS: u32 = 1 << 14;

impl<P: Point> Incremental<P> {
    /// Triangulates `points`; vertex `i` is `points[i]`. Does the same as [`Incremental::build`] with
    /// [`insertion_order`].
    ///
    /// # Errors
    ///
    /// Returns an [`IncrementalError`]. If points coincide, the error names the first such point in the order of
    /// insertion.
    pub fn new(points: Vec<P>) -> Result<Self, IncrementalError> {
        let order = insertion_order(&points);
        Self::build(points, Some(&order))
    }

    /// Triangulates `points` in the given order (each index once), or in the order of the slice. With an order, the
    /// points are copied, and the vertices are renumbered at the end. If the points are already sorted by
    /// [`insertion_order`], `None` avoids both.
    ///
    /// # Errors
    ///
    /// Returns an [`IncrementalError`]. If points coincide, the error names the first such point in the order of
    /// insertion.
    pub fn build(points: Vec<P>, order: Option<&[u32]>) -> Result<Self, IncrementalError> {
        Self::build_while(points, order, &mut |_| true)
    }

    /// Triangulates as [`Incremental::build`] does, and stops when `go_on` returns `false`. `go_on` is called every
    /// [`STOP_CHECK_INTERVAL`] points and whenever the cells have grown by a mebibyte. It gets the bytes of the
    /// triangulation ([`Incremental::bytes`]).
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Incremental::build`], or [`IncrementalError::Stopped`].
    pub fn build_while(
        mut points: Vec<P>,
        order: Option<&[u32]>,
        go_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self, IncrementalError> {
        let Some(order) = order else {
            let vertices = 0..points.len() as u32;
            return Self::build_in_place(points, vertices, go_on);
        };
        clean(&mut points)?;
        let (sorted, heaviest) = (order.iter().map(|&i| points[i as usize]).collect(), heaviest(&points));
        let mut this =
            Self::in_place((sorted, heaviest), 0..order.len() as u32, go_on).map_err(
                |error| match error {
                    IncrementalError::Coincident { point, vertex } => IncrementalError::Coincident {
                        point: order[point as usize],
                        vertex: order[vertex as usize],
                    },
                    other => other,
                },
            )?;
        this.rename(points, order);
        Ok(this)
    }

    /// Triangulates `points` without copying them, in the given order of insertion (each index once). Vertex `i` is
    /// `points[i]` from the start. This is efficient for orders that consist of a few runs of consecutive points.
    /// Excess capacity of `points` also reserves room in the triangulation, for points to be inserted later.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Incremental::build_while`].
    pub fn build_in_place(
        mut points: Vec<P>,
        order: impl IntoIterator<Item = u32>,
        go_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self, IncrementalError> {
        clean(&mut points)?;
        let heaviest = heaviest(&points);
        Self::in_place((points, heaviest), order, go_on)
    }

    /// Triangulates as [`Incremental::build_in_place`] does. Balls and radii then hold for later points of weight at most
    /// `heaviest`, or the largest weight of `points` if that is larger.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Incremental::build_while`].
    pub fn build_below(
        (mut points, heaviest): (Vec<P>, f64),
        order: impl IntoIterator<Item = u32>,
        go_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self, IncrementalError> {
        clean(&mut points)?;
        let heaviest = larger(heaviest, self::heaviest(&points));
        Self::in_place((points, heaviest), order, go_on)
    }

    /// Triangulates points that [`clean`] has processed, without copying them. Their weights are at most `heaviest`.
    fn in_place(
        (points, heaviest): (Vec<P>, f64),
        order: impl IntoIterator<Item = u32>,
        go_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self, IncrementalError> {
        if points.len() > MOST_POINTS {
            return Err(IncrementalError::TooMany);
        }
        // Room for later points is reserved now, so that cells need not be moved then.
        let room = points.capacity().min(MOST_POINTS);
        let mut incident = Vec::with_capacity(room + 1);
        incident.resize(points.len() + 1, NONE);
        incident[0] = 0;
        let mut this = Incremental {
            incident,
            frame: Frame::over(&points, heaviest),
            cells: Cells::with_capacity(room * expected_cells(P::DIM)),
            last: 0,
            scratch: Scratch::default(),
            operations: Operations::default(),
            points,
        };
        let exact = ExactTests::so_far();
        let first = this.start()?;
        this.operations.exact += exact.since();
        let mut next = 0;
        for (count, vertex) in order.into_iter().enumerate() {
            if count.is_multiple_of(STOP_CHECK_INTERVAL) || this.cells.slots() >= next {
                if !go_on(this.bytes()) {
                    return Err(IncrementalError::Stopped);
                }
                next = this.cells.slots() + CHECKED_CELLS;
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

    /// Renumbers the vertices: vertex `i` becomes `order[i]`, its position in `points`.
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

    /// Inserts a point and returns its vertex, which may be hidden ([`Incremental::is_hidden`]). The walk starts at the cell `hint` if it is live, and otherwise at the
    /// last cell created.
    ///
    /// # Errors
    ///
    /// Returns [`IncrementalError::Coincident`] with the vertex at the same coordinates, `NotFinite` or `TooMany`. The
    /// triangulation is then unchanged.
    pub fn insert(&mut self, p: P, hint: Option<u32>) -> Result<u32, IncrementalError> {
        let vertex = self.points.len() as u32;
        self.insert_or_skip(p, hint, INFINITE).map(|_| vertex)
    }

    /// Inserts a point as [`Incremental::insert`] does, if a neighbour of the new vertex is below `bound` or the
    /// cavity has more than 128 cells. Otherwise leaves the triangulation unchanged and returns `None`.
    ///
    /// A point that is skipped never becomes a neighbour of a vertex below `bound`. A Delaunay edge persists if other
    /// points are removed, so the two would already be neighbours now. Points with a large cavity are inserted
    /// because points in an empty region would otherwise all search the same large cells. A hidden point is skipped,
    /// because it stays hidden if points are added.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Incremental::insert`].
    pub fn insert_if_adjacent(
        &mut self,
        p: P,
        hint: Option<u32>,
        bound: u32,
    ) -> Result<Option<u32>, IncrementalError> {
        let vertex = self.points.len() as u32;
        let is_inserted = self.insert_or_skip(p, hint, bound)?;
        Ok(is_inserted.then_some(vertex))
    }

    /// Inserts a point. Returns `false` if it is hidden, or if [`Incremental::insert_if_adjacent`] skips it. A hidden point
    /// keeps its index if `bound` is [`INFINITE`].
    fn insert_or_skip(&mut self, p: P, hint: Option<u32>, bound: u32) -> Result<bool, IncrementalError> {
        let vertex = self.points.len() as u32;
        if self.points.len() >= MOST_POINTS {
            return Err(IncrementalError::TooMany);
        }
        let p = cleaned(p).ok_or(IncrementalError::NotFinite { point: vertex })?;
        self.frame.extend(p);
        self.points.push(p);
        self.incident.push(NONE);
        let done = self.insert_vertex(vertex, self.start_of(hint), bound);
        let keeps_index = done.is_ok_and(|is_inserted| is_inserted || bound == INFINITE);
        if !keeps_index {
            self.points.pop();
            self.incident.pop();
        }
        done
    }

    /// Inserts points in the order of [`insertion_order`] and returns the vertex of each: a new one, or the existing
    /// one with the same coordinates, whatever its weight. Each walk starts at the previous point. New vertices are numbered in the order of
    /// insertion. `go_on` is called every [`STOP_CHECK_INTERVAL`] points.
    ///
    /// # Errors
    ///
    /// Returns `NotFinite` with the point's position in `points`, before any insertion. Returns `TooMany` or `Stopped`
    /// after inserting the points before the failure.
    pub fn insert_all(
        &mut self,
        points: &[P],
        go_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Vec<u32>, IncrementalError> {
        let mut points = points.to_vec();
        clean(&mut points)?;
        let mut vertices = vec![NONE; points.len()];
        for (count, i) in insertion_order(&points).into_iter().enumerate() {
            if count.is_multiple_of(STOP_CHECK_INTERVAL) && !go_on(self.bytes()) {
                return Err(IncrementalError::Stopped);
            }
            vertices[i as usize] = match self.insert(points[i as usize], None) {
                Ok(vertex) | Err(IncrementalError::Coincident { vertex, .. }) => vertex,
                Err(error) => return Err(error),
            };
        }
        Ok(vertices)
    }

    /// Returns the bytes that hold points, cells, incidences and the storage of an insertion. Reserved bytes that were
    /// never written do not count.
    pub fn bytes(&self) -> u64 {
        let points = size_of_val(&self.points[..]) + size_of_val(&self.incident[..]);
        (points + self.cells.bytes() + self.scratch.bytes()) as u64
    }

    /// Charges all insertions so far as one sequence of operations. Each cell that an insertion visits, removes or creates
    /// is one operation.
    pub fn charge(&self, cost: &mut Cost) {
        self.operations.charge(cost);
    }

    /// Returns the operations of [`Incremental::charge`] since the last call, and starts a new count.
    pub fn take_operations(&mut self) -> Operations {
        std::mem::take(&mut self.operations)
    }

    /// Inserts a vertex, if it is not hidden, and one of its neighbours will be below `bound` or its cavity is large.
    /// Returns `true` if it was inserted.
    fn insert_vertex(&mut self, vertex: u32, start: u32, bound: u32) -> Result<bool, IncrementalError> {
        if self.cells.slots() > MOST_CELLS {
            return Err(IncrementalError::TooMany);
        }
        let q = self.points[vertex as usize];
        let query = self.frame.query(q);
        let exact = ExactTests::so_far();
        let mut cells = std::mem::take(&mut self.operations.cells);
        let (mut seed, certain) = self.descend(&query, start, &mut cells);
        if !certain {
            seed = self.walk(q, seed, &mut cells);
        }
        self.operations.cells = cells;
        if !certain {
            // Only the cell that contains a point can have it as a vertex.
            for &v in self.cells.cell(seed).as_ref() {
                if v != INFINITE && lex_cmp(&self.points[v as usize], &q).is_eq() {
                    self.operations.exact += exact.since();
                    return Err(IncrementalError::Coincident { point: vertex, vertex: v });
                }
            }
        }
        // Without weights, the cell that contains a point is in conflict with it.
        let is_hidden = P::IS_WEIGHTED && !certain && !self.conflicts_with(seed, q);
        let is_inserted = !is_hidden && self.replace(vertex, &query, seed, bound);
        self.operations.exact += exact.since();
        Ok(is_inserted)
    }
}

/// Returns the number of cells reserved for each point: slightly more than random points need, rounded to an integer.
/// Reserved memory that is never written is not used.
fn expected_cells(dimension: usize) -> usize {
    if dimension == 2 { 2 } else { 7 }
}

/// Returns the largest weight; 0 without weights, or without points.
fn heaviest<P: Point>(points: &[P]) -> f64 {
    if !P::IS_WEIGHTED {
        return 0.0;
    }
    points.iter().map(P::weight).reduce(f64::max).unwrap_or(0.0)
}

/// Replaces `-0.0` by `0.0` everywhere, and checks that all coordinates are finite.
fn clean<P: Point>(points: &mut [P]) -> Result<(), IncrementalError> {
    for (i, p) in (0u32..).zip(points) {
        *p = cleaned(*p).ok_or(IncrementalError::NotFinite { point: i })?;
    }
    Ok(())
}

/// Returns the point with `-0.0` replaced by `0.0`, if it is finite.
fn cleaned<P: Point>(mut p: P) -> Option<P> {
    for i in 0..P::DIM {
        if !p.coord(i).is_finite() {
            return None;
        }
        p.set_coord(i, p.coord(i) + 0.0);
    }
    p.weight().is_finite().then_some(p)
}
