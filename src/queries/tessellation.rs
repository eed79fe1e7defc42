//! A triangulation in the layout that all queries share.
//!
//! **Scaling.** Coordinates are multiplied by one power of two that brings the largest to the upper end of the range of
//! exact signs ([`septet_geometry::range`]). This is exact, and it leaves all digits below those of the points to queries.

use septet_core::Outcome;
use septet_geometry::range::{Digits, HIGHEST, scale};

use crate::dimension::Dimension;
use crate::error::QueryError;
pub use crate::rows::NONE;
use crate::rows::Rows;
use crate::seen::Seen;

/// An immutable triangulation, for queries. Threads may share it.
///
/// Cells are rows of `d + 1` vertices: positively oriented, with the smallest vertex first, and sorted. They are those of
/// [`Outcome::cells`]. Indices have 32 bits, and [`NONE`] means none.
#[derive(Clone, Debug)]
pub struct Tessellation<P: Dimension> {
    /// Points multiplied by `2^exponent`.
    pub(crate) points: Vec<P>,
    pub(crate) exponent: i32,
    pub(crate) cells: Vec<P::Cell>,
    /// The cell across the facet opposite each vertex.
    pub(crate) neighbours: Vec<P::Cell>,
    /// The first cell of each vertex.
    pub(crate) vertex_cell: Vec<u32>,
    /// Coincident points, and the first point at each place.
    pub(crate) duplicates: Vec<[u32; 2]>,
    /// Dimension of the affine hull.
    pub(crate) dimension: isize,
    /// Vertices of a set without cells.
    pub(crate) loose: Vec<u32>,
    /// The corners of the bounding box of the vertices.
    pub(crate) bounds: [P; 2],
    /// Some vertices, from which walks start.
    pub(crate) starts: Vec<u32>,
}

impl<P: Dimension> Tessellation<P> {
    /// Takes the triangulation of `points` from the run that made it ([`septet_core::triangulate`], or
    /// [`septet_core::simulate`] to the end). Work: O(n + m) expected for n points and m cells of bounded stars.
    ///
    /// # Errors
    /// Fails if the points are not those of the run, if the run has weights, a periodic box or several processes, and if
    /// there are more than `2^32 - 2` points or cells.
    pub fn new(points: &[P], run: &Outcome) -> Result<Self, QueryError> {
        if run.points.hidden.is_some() {
            return Err(QueryError::OtherRun);
        }
        Self::regular(points, run)
    }

    /// Takes the regular triangulation of points with weights from the run that made it. Points that weights hide are not vertices.
    ///
    /// Cells, neighbours, hull, edges, volumes, location, barycentric coordinates, gradients and linear weights have their
    /// meaning. Nearest vertices, natural neighbours, alpha complexes and Voronoi cells do not: they are those of Delaunay
    /// triangulations. Volumes of power cells are in [`crate::power_volumes`].
    ///
    /// # Errors
    /// As [`Tessellation::new`], but the run may have weights.
    pub fn regular(points: &[P], run: &Outcome) -> Result<Self, QueryError> {
        let is_whole = run.is_whole() && run.kept.periodic.is_none();
        if !is_whole || run.ending().is_none() {
            return Err(QueryError::OtherRun);
        }
        if run.space != P::DIM || run.points.input != points.len() as u64 {
            return Err(QueryError::OtherPoints { given: points.len(), run: run.points.input });
        }
        for (what, count) in [("points", points.len()), ("cells", run.cell_count())] {
            if count >= NONE as usize {
                return Err(QueryError::TooMany { what, count });
            }
        }
        let Rows { cells, neighbours } = Rows::<P>::of_shares(&run.shares, points.len());
        if cells.len() != run.cell_count() {
            return Err(QueryError::OtherRun);
        }
        let duplicates = run.left_out.duplicates.iter().map(|&(point, of)| [point as u32, of as u32]);
        let refused = run.left_out.refused.iter().map(|&point| point as u32);
        let mut is_vertex = vec![true; points.len()];
        let hidden = run.left_out.hidden.iter().map(|&point| point as u32);
        for point in run.left_out.duplicates.iter().map(|pair| pair.0 as u32).chain(refused).chain(hidden) {
            is_vertex[point as usize] = false;
        }
        Self::of_rows(points, Rows { cells, neighbours }, (duplicates.collect(), &is_vertex, run.dimension))
    }

    /// Creates the tables from canonical rows, given the coincident points, whether each point is a vertex, and the dimension.
    pub(crate) fn of_rows(
        points: &[P],
        rows: Rows<P>,
        (duplicates, is_vertex, dimension): (Vec<[u32; 2]>, &[bool], isize),
    ) -> Result<Self, QueryError> {
        let vertices = || (0u32..).zip(points).filter(|(i, _)| is_vertex[*i as usize]);
        let used: Vec<P> = vertices().map(|(_, &p)| p).collect();
        let digits = Digits::of(&used).unwrap_or(Digits::NONE);
        // A spread of digits that no power of two brings into the range is an error.
        digits.exponent(&used)?;
        let exponent = if digits == Digits::NONE { 0 } else { HIGHEST - digits.ends().1 };
        // The addition turns a negative zero into a positive one, as in the run.
        let scaled: Vec<P> = points.iter().map(|&p| scale(p, exponent) + P::splat(0.0)).collect();
        let mut vertex_cell = vec![NONE; points.len()];
        for (at, cell) in rows.cells.iter().enumerate().rev() {
            for &v in cell.as_ref() {
                vertex_cell[v as usize] = at as u32;
            }
        }
        let has_cells = !rows.cells.is_empty();
        let loose = if has_cells { Vec::new() } else { vertices().map(|(i, _)| i).collect() };
        let mut bounds = [P::default(); 2];
        for (i, (v, _)) in vertices().enumerate() {
            let p = scaled[v as usize];
            bounds = if i == 0 { [p, p] } else { [least(bounds[0], p), most(bounds[1], p)] };
        }
        let starts = if has_cells { starts::<P>(&vertex_cell) } else { Vec::new() };
        let Rows { cells, neighbours } = rows;
        Ok(Tessellation {
            points: scaled,
            exponent,
            cells,
            neighbours,
            vertex_cell,
            duplicates,
            dimension,
            loose,
            bounds,
            starts,
        })
    }

    /// Returns the cells.
    pub fn cells(&self) -> &[P::Cell] {
        &self.cells
    }

    /// Returns the neighbours of each cell: entry `k` is the cell across the facet opposite vertex `k`, or [`NONE`] if the
    /// facet is on the hull.
    pub fn neighbours(&self) -> &[P::Cell] {
        &self.neighbours
    }

    /// Returns the number of points, duplicates included.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Returns a point, as it was given. A coordinate that was -0.0 is 0.0.
    ///
    /// # Panics
    /// Panics if there is no such point.
    pub fn point(&self, at: u32) -> P {
        scale(self.points[at as usize], -self.exponent)
    }

    /// Returns all points ([`Tessellation::point`]).
    pub fn points(&self) -> Vec<P> {
        self.points.iter().map(|&p| scale(p, -self.exponent)).collect()
    }

    /// Returns the dimension of the affine hull of the points, from -1 for no points. If it is less than the dimension of the
    /// space, there are no cells.
    pub fn dimension(&self) -> isize {
        self.dimension
    }

    /// Returns the coincident points, each with the first point at its place, which is the vertex.
    pub fn duplicates(&self) -> &[[u32; 2]] {
        &self.duplicates
    }

    /// Returns the smallest cell of each point: that of its vertex for a duplicate, or [`NONE`].
    pub fn vertex_cells(&self) -> Vec<u32> {
        let mut cells = self.vertex_cell.clone();
        for &[point, of] in &self.duplicates {
            cells[point as usize] = cells[of as usize];
        }
        cells
    }

    /// Returns the corners of a cell, scaled. In the plane, the last one is not used.
    #[inline]
    pub(crate) fn corners(&self, cell: u32) -> [P; 4] {
        let mut out = [P::default(); 4];
        for (corner, &v) in out.iter_mut().zip(self.cells[cell as usize].as_ref()) {
            *corner = self.points[v as usize];
        }
        out
    }

    /// Returns the position of a vertex in a cell.
    pub(crate) fn slot(&self, cell: u32, vertex: u32) -> Option<usize> {
        self.cells[cell as usize].as_ref().iter().position(|&v| v == vertex)
    }

    /// Replaces `star` by the cells of a vertex. Each is reached from the one before across facets at the vertex.
    pub(crate) fn star(&self, vertex: u32, star: &mut Seen) {
        star.clear();
        star.push(self.vertex_cell[vertex as usize]);
        let mut head = 0;
        while let Some(cell) = star.get(head) {
            head += 1;
            let row = self.cells[cell as usize].as_ref();
            for (&v, &next) in row.iter().zip(self.neighbours[cell as usize].as_ref()) {
                if v != vertex && next != NONE {
                    star.push(next);
                }
            }
        }
    }

    /// Returns a length to the given power in the units of the points, from scaled units. It may be infinite or zero.
    pub(crate) fn unscaled(&self, x: f64, power: i32) -> f64 {
        let (mut x, mut exponent) = (x, -self.exponent * power);
        while exponent != 0 {
            let step = exponent.clamp(-1000, 1000);
            x *= 2f64.powi(step);
            exponent -= step;
        }
        x
    }
}

/// Returns vertices that are spread over the numbers of all vertices: about `n^(1/d)`.
fn starts<P: Dimension>(vertex_cell: &[u32]) -> Vec<u32> {
    let n = vertex_cell.len();
    let count = (1..n).find(|i| i.pow(P::DIM as u32) >= n).unwrap_or(1);
    let spread = (0..count).map(|i| (i as u128 * n as u128 / count as u128) as u32);
    let mut starts: Vec<u32> = spread.filter(|&v| vertex_cell[v as usize] != NONE).collect();
    if starts.is_empty() {
        starts.extend((0u32..).zip(vertex_cell).find(|(_, cell)| **cell != NONE).map(|(v, _)| v));
    }
    starts
}

/// Returns the smaller coordinates.
pub(crate) fn least<P: Dimension>(mut a: P, b: P) -> P {
    (0..P::DIM).for_each(|i| a.set_coord(i, a.coord(i).min(b.coord(i))));
    a
}

/// Returns the larger coordinates.
pub(crate) fn most<P: Dimension>(mut a: P, b: P) -> P {
    (0..P::DIM).for_each(|i| a.set_coord(i, a.coord(i).max(b.coord(i))));
    a
}
