//! Queries of a triangulation over flat arrays of coordinates.

use septet_queries::{Barycentric, Method, Weights};

use crate::call::Call;
use crate::failure::Failure;
use crate::rows::whole;
use crate::sites::Query;
use crate::triangulated::{Triangulated, either};

impl Triangulated {
    /// Returns the smallest cell that contains each query, or [`crate::NONE`] outside of the hull and for a query that is not
    /// finite. Exact: every vertex is inside.
    ///
    /// # Errors
    /// Fails if the last query is not whole, or if the call is cancelled.
    pub fn locate(&self, queries: &[f64], call: &Call) -> Result<Vec<u32>, Failure> {
        either!(self.asked(Query::Locate, call)?, t => { let queries = whole(queries)?; call.within(|| t.locate(queries)) })
    }

    /// Returns the vertex nearest to each query, the smallest of several, or [`crate::NONE`] for a query that is not finite.
    /// Exact.
    ///
    /// # Errors
    /// Fails if the last query is not whole, or if the call is cancelled.
    pub fn nearest(&self, queries: &[f64], call: &Call) -> Result<Vec<u32>, Failure> {
        either!(self.asked(Query::Nearest, call)?, t => { let queries = whole(queries)?; call.within(|| t.nearest(queries)) })
    }

    /// Returns the smallest cell that contains each query, and the barycentric coordinates in it.
    ///
    /// # Errors
    /// Fails if the last query is not whole, or if the call is cancelled.
    pub fn barycentric(&self, queries: &[f64], call: &Call) -> Result<Barycentric, Failure> {
        either!(self.asked(Query::Barycentric, call)?, t => { let queries = whole(queries)?; call.within(|| t.barycentric(queries)) })
    }

    /// Returns the barycentric coordinates of each query in a given cell, `columns + 1` each. They may be negative. Those of a
    /// cell [`crate::NONE`] are NaN.
    ///
    /// # Errors
    /// Fails if the last query is not whole, if there is no cell for each query, if there is no such cell, or if the call is
    /// cancelled.
    pub fn barycentric_in(&self, queries: &[f64], cells: &[u32], call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self.asked(Query::Barycentric, call)?, t => { let queries = whole(queries)?; call.ask(|| t.barycentric_in(queries, cells)) })
    }

    /// Returns the weights of the points in an interpolation at each query.
    ///
    /// # Errors
    /// Fails if the last query is not whole, or if the call is cancelled.
    pub fn weights(&self, queries: &[f64], method: Method, call: &Call) -> Result<Weights, Failure> {
        either!(self.asked(asked(method), call)?, t => { let queries = whole(queries)?; call.within(|| t.weights(queries, method)) })
    }

    /// Interpolates `columns` values for each point at each query: rows of `columns` numbers. Outside of the hull, they are
    /// `outside`. Values at duplicates and skipped points are not used.
    ///
    /// # Errors
    /// Fails if the last query is not whole, if the number of values does not fit, or if the call is cancelled.
    pub fn interpolate(
        &self,
        (values, columns): (&[f64], usize),
        queries: &[f64],
        (method, outside): (Method, f64),
        call: &Call,
    ) -> Result<Vec<f64>, Failure> {
        /// Queries whose weights are in memory at the same time.
        const MANY: usize = 1 << 18;
        either!(self.asked(asked(method), call)?, t => {
            let queries = whole(queries)?;
            call.ask(|| {
                let mut all = t.weights(&[], method).interpolate_rows((values, columns), outside)?;
                for queries in queries.chunks(MANY) {
                    let weights = t.weights(queries, method);
                    all.extend(weights.interpolate_rows((values, columns), outside)?);
                }
                Ok(all)
            })
        })
    }
}

/// Returns the query of a method of interpolation.
fn asked(method: Method) -> Query {
    match method {
        Method::Linear => Query::Linear,
        Method::Sibson | Method::Laplace => Query::Natural,
    }
}
