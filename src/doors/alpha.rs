//! Alpha complexes and shapes over flat arrays.

use bytemuck::cast_slice;
use septet_queries::{AlphaFiltration, AlphaShape, Dimension};

use crate::call::Call;
use crate::failure::Failure;
use crate::sites::Query;
use crate::triangulated::{Triangulated, either};

/// The squared radius from which on each face belongs to the alpha complex.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Filtration {
    /// The squared radius of each cell.
    pub cells: Vec<f64>,
    /// All facets, as many vertices each as a point has coordinates: ascending, sorted.
    pub facets: Vec<u32>,
    /// The squared radius of each facet.
    pub facet_values: Vec<f64>,
    /// All edges: two vertices each, smaller first, sorted. In the plane, they are the facets.
    pub edges: Vec<u32>,
    /// The squared radius of each edge.
    pub edge_values: Vec<f64>,
}

/// The alpha complex of a radius.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Shape {
    /// Whether each cell belongs to the complex.
    pub cells: Vec<bool>,
    /// The facets between a cell that belongs to the complex and one that does not, or the outside: counter-clockwise from
    /// outside, sorted.
    pub boundary: Vec<u32>,
    /// The facets of the complex without a cell of the complex on either side, sorted.
    pub singular: Vec<u32>,
    /// The area or volume of the cells of the complex.
    pub volume: f64,
}

impl<P: Dimension> From<AlphaFiltration<P>> for Filtration {
    fn from(of: AlphaFiltration<P>) -> Self {
        Filtration {
            cells: of.cells,
            facets: cast_slice(&of.facets).to_vec(),
            facet_values: of.facet_values,
            edges: of.edges.into_flattened(),
            edge_values: of.edge_values,
        }
    }
}

impl<P: Dimension> From<AlphaShape<P>> for Shape {
    fn from(of: AlphaShape<P>) -> Self {
        Shape {
            cells: of.cells,
            boundary: cast_slice(&of.boundary).to_vec(),
            singular: cast_slice(&of.singular).to_vec(),
            volume: of.volume,
        }
    }
}

impl Triangulated {
    /// Returns the squared radii of all faces. Without cells, all lists are empty.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn alpha_filtration(&self, call: &Call) -> Result<Filtration, Failure> {
        either!(self.asked(Query::Alpha, call)?, t => call.within(|| t.alpha_filtration().into()))
    }

    /// Returns the squared circumradius of each cell, from which on it belongs to the alpha complex.
    ///
    /// # Errors
    /// Fails if the call is cancelled.
    pub fn alpha_values(&self, call: &Call) -> Result<Vec<f64>, Failure> {
        either!(self.asked(Query::Alpha, call)?, t => call.within(|| t.alpha_values()))
    }

    /// Returns the alpha complex of a radius.
    ///
    /// # Errors
    /// Fails if the radius is negative or not a number, or if the call is cancelled.
    pub fn alpha_shape(&self, radius: f64, call: &Call) -> Result<Shape, Failure> {
        either!(self.asked(Query::Alpha, call)?, t => call.ask(|| t.alpha_shape(radius).map(Shape::from)))
    }
}
