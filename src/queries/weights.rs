//! Barycentric coordinates, and weights of interpolations as sparse rows.
//!
//! **Statement.** The barycentric coordinate of a query for a corner of its cell is the orientation determinant of the cell with
//! the corner replaced by the query, divided by that of the cell. Its sign is exact: it is 0 iff the query lies on the
//! opposite facet, and positive otherwise. The linear weights of a query are its coordinates that are not 0.
//!
//! **Source.** Moebius, *Der barycentrische Calcul* (1827).
//!
//! **Rounding.** If the rounded determinant of the cell may have a relative error above `THIN`, or a sign is uncertain, all are
//! computed by big integers and rounded once.
//!
//! **Work.** O(1) for each query after its location.

use septet_geometry::point::Simplex;
use septet_geometry::predicates::{Sign, orientation};
use septet_geometry::range::scale;

use crate::dimension::Dimension;
use crate::dual::THIN;
use crate::error::QueryError;
use crate::exact;
use crate::locate::Query;
use crate::loops;
use crate::natural::{Cavity, Natural, Row};
use crate::tessellation::{NONE, Tessellation};

/// A method of interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Linear in each cell.
    Linear,
    /// Natural neighbours by Sibson: the volumes that the query would take from the Voronoi cells.
    Sibson,
    /// Natural neighbours by Laplace: the Voronoi facets of the query, divided by their distances.
    Laplace,
}

impl Method {
    /// All methods.
    pub const ALL: [Method; 3] = [Method::Linear, Method::Sibson, Method::Laplace];

    /// Returns the name of the method.
    pub fn name(self) -> &'static str {
        match self {
            Method::Linear => "linear",
            Method::Sibson => "sibson",
            Method::Laplace => "laplace",
        }
    }
}

/// Weights of points, one sparse row for each query: `indices[offsets[i]..offsets[i + 1]]` with the weights at the same
/// positions of `values`. The row of a query outside of the hull is empty. In others, weights are positive and add up to 1.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Weights {
    /// The position of the first entry of each row, and the number of all entries.
    pub offsets: Vec<u64>,
    /// The points of each row, ascending.
    pub indices: Vec<u32>,
    /// Their weights.
    pub values: Vec<f64>,
    /// Number of points.
    points: usize,
}

impl Weights {
    /// Interpolates one value for each point. The result for a query outside of the hull is NaN. Values at duplicates are not
    /// used.
    ///
    /// # Errors
    /// Fails if the number of values is not that of the points.
    pub fn interpolate(&self, values: &[f64]) -> Result<Vec<f64>, QueryError> {
        self.interpolate_rows((values, 1), f64::NAN)
    }

    /// Interpolates a row of `columns` values for each point. The rows of queries outside of the hull are `outside`.
    ///
    /// # Errors
    /// Fails if the number of values is not `columns` for each point.
    pub fn interpolate_rows(
        &self,
        (values, columns): (&[f64], usize),
        outside: f64,
    ) -> Result<Vec<f64>, QueryError> {
        check_values(values, columns, self.points)?;
        let mut all = Vec::with_capacity((self.offsets.len() - 1) * columns);
        for ends in self.offsets.windows(2) {
            loops::check();
            let range = ends[0] as usize..ends[1] as usize;
            let start = all.len();
            all.resize(start + columns, if range.is_empty() { outside } else { 0.0 });
            for (&v, weight) in self.indices[range.clone()].iter().zip(&self.values[range]) {
                let row = &values[v as usize * columns..][..columns];
                all[start..].iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        Ok(all)
    }
}

/// Checks that there are `columns` values for each point.
pub(crate) fn check_values(values: &[f64], columns: usize, points: usize) -> Result<(), QueryError> {
    if points.checked_mul(columns) == Some(values.len()) {
        return Ok(());
    }
    Err(QueryError::Values { given: values.len(), columns, points })
}

/// Cells and barycentric coordinates of queries.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Barycentric {
    /// The smallest cell that contains each query, or [`NONE`] outside of the hull.
    pub cells: Vec<u32>,
    /// `d + 1` coordinates for each query, in the order of the vertices of its cell. NaN outside of the hull.
    pub coordinates: Vec<f64>,
}

impl<P: Dimension> Tessellation<P> {
    /// Returns the barycentric coordinates of each query in the smallest cell that contains it. They are at least 0 and add up to 1. The
    /// coordinate of a vertex is 0 iff the query lies on the opposite facet.
    pub fn barycentric(&self, queries: &[P]) -> Barycentric {
        let corners = P::Cell::LEN;
        let found = self.each(queries, (NONE, [f64::NAN; 4]), |query, place, seen| {
            if !place.inside {
                return (NONE, [f64::NAN; 4]);
            }
            let cell = self.smallest(query, place.cell, seen);
            (cell, self.coordinates(query, cell))
        });
        Barycentric {
            cells: found.iter().map(|(cell, _)| *cell).collect(),
            coordinates: found.iter().flat_map(|(_, row)| row[..corners].iter().copied()).collect(),
        }
    }

    /// Returns the weights of the points in an interpolation at each query, for use with many values. Linear functions are reproduced
    /// up to rounding. At a vertex, its weight is 1.
    ///
    /// On the hull, the weights of natural neighbours are their limits from inside. They are those of the points on the
    /// same edge, or on the same flat face, alone.
    pub fn weights(&self, queries: &[P], method: Method) -> Weights {
        let natural = match method {
            Method::Linear => None,
            Method::Sibson => Some(Natural::Sibson),
            Method::Laplace => Some(Natural::Laplace),
        };
        let rows = self.each(queries, Row::new(), |query, place, seen| {
            if !place.inside {
                return Row::new();
            }
            let cell = self.smallest(query, place.cell, seen);
            let linear = self.linear(query, cell);
            match natural {
                Some(natural) if linear.len() > 1 => Cavity::of(self, query, cell, seen)
                    .and_then(|cavity| cavity.row(natural))
                    .unwrap_or(linear),
                _ => linear,
            }
        });
        let mut weights =
            Weights { offsets: vec![0], indices: Vec::new(), values: Vec::new(), points: self.points.len() };
        for row in rows {
            weights.indices.extend(row.iter().map(|(v, _)| *v));
            weights.values.extend(row.iter().map(|(_, weight)| *weight));
            weights.offsets.push(weights.indices.len() as u64);
        }
        weights
    }

    /// Returns the coordinates that are not 0, in the order of the vertices.
    fn linear(&self, query: &Query<P>, cell: u32) -> Row {
        let coordinates = self.coordinates(query, cell);
        let vertices = self.cells[cell as usize].as_ref().iter().copied();
        let mut row: Row = vertices.zip(coordinates).filter(|(_, weight)| *weight > 0.0).collect();
        row.sort_unstable_by_key(|(v, _)| *v);
        row
    }

    /// Returns the barycentric coordinates of a query in a cell that contains it.
    pub(crate) fn coordinates(&self, query: &Query<P>, cell: u32) -> [f64; 4] {
        let corners = self.corners(cell);
        let values = match Self::quick(&corners, query) {
            Some(values) => values,
            None if query.fits => exact::barycentric(&corners, query.near),
            None => exact::barycentric(&corners.map(|corner| scale(corner, -self.exponent)), query.given),
        };
        let sum: f64 = values[..P::Cell::LEN].iter().sum();
        values.map(|value| value / sum)
    }

    /// Returns the determinants of the cell with each corner replaced by the query, unless they need big integers.
    fn quick(corners: &[P; 4], query: &Query<P>) -> Option<[f64; 4]> {
        let n = P::Cell::LEN;
        let whole = P::rounded_orientation(&corners[..n]);
        if !query.fits || whole.bound > whole.det * THIN {
            return None;
        }
        let mut values = [0.0; 4];
        for (corner, value) in values.iter_mut().enumerate().take(n) {
            let mut replaced = *corners;
            replaced[corner] = query.near;
            let rounded = P::rounded_orientation(&replaced[..n]);
            if rounded.is_certain() {
                *value = rounded.det;
            } else if orientation(&replaced[..n]) != Sign::Zero {
                return None;
            }
        }
        Some(values)
    }
}
