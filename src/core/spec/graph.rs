//! The supergraph of the Delaunay triangulation.

use std::fmt;

use serde::Serialize;

use septet_workers::config::Neighbours;

use crate::spec::SpecError;

/// The kinds of supergraphs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GraphKind {
    /// The alpha-density graph (paper, Section 4.2).
    Density,
    /// The alpha-overlap graph (Section 4.4).
    Overlap,
    /// The k-nearest-neighbour graph (Section 4.5).
    Knn,
}

impl GraphKind {
    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            GraphKind::Density => "density",
            GraphKind::Overlap => "overlap",
            GraphKind::Knn => "knn",
        }
    }
}

/// alpha of a density or overlap graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// From the known spacing of the point set, otherwise from a sample of stars.
    Auto,
    /// At least 1.
    Value(f64),
}

impl fmt::Display for Alpha {
    /// Writes the value as it is given on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Alpha::Auto => f.write_str("auto"),
            Alpha::Value(alpha) => alpha.fmt(f),
        }
    }
}

/// The supergraph that `simulate` builds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Graph {
    /// The density graph (paper, Section 4.2).
    Density {
        /// Its alpha.
        alpha: Alpha,
    },
    /// The overlap graph (Section 4.4).
    Overlap {
        /// Its alpha.
        alpha: Alpha,
    },
    /// The graph of k nearest neighbours (Section 4.5).
    Knn {
        /// Its k.
        k: Neighbours,
    },
}

impl Default for Graph {
    fn default() -> Self {
        Graph::Density { alpha: Alpha::Auto }
    }
}

impl Graph {
    /// Returns the graph of a kind with the parameter that applies to it.
    ///
    /// # Errors
    /// Returns [`SpecError::Unused`] if the parameter of another kind is given.
    pub fn new(kind: GraphKind, alpha: Alpha, k: Neighbours) -> Result<Self, SpecError> {
        let unused = |parameter| SpecError::Unused { graph: kind.name(), parameter };
        match (kind, alpha, k) {
            (GraphKind::Knn, Alpha::Value(_), _) => Err(unused("alpha")),
            (GraphKind::Knn, Alpha::Auto, k) => Ok(Graph::Knn { k }),
            (_, _, Neighbours::Count(_) | Neighbours::Log(_)) => Err(unused("k")),
            (GraphKind::Density, alpha, Neighbours::Auto) => Ok(Graph::Density { alpha }),
            (GraphKind::Overlap, alpha, Neighbours::Auto) => Ok(Graph::Overlap { alpha }),
        }
    }

    /// Returns the kind.
    pub fn kind(self) -> GraphKind {
        match self {
            Graph::Density { .. } => GraphKind::Density,
            Graph::Overlap { .. } => GraphKind::Overlap,
            Graph::Knn { .. } => GraphKind::Knn,
        }
    }

    /// Returns alpha, which is [`Alpha::Auto`] for nearest neighbours.
    pub fn alpha(self) -> Alpha {
        match self {
            Graph::Density { alpha } | Graph::Overlap { alpha } => alpha,
            Graph::Knn { .. } => Alpha::Auto,
        }
    }

    /// Returns k, which is [`Neighbours::Auto`] for density and overlap graphs.
    pub fn k(self) -> Neighbours {
        match self {
            Graph::Density { .. } | Graph::Overlap { .. } => Neighbours::Auto,
            Graph::Knn { k } => k,
        }
    }
}

/// Returns alpha for a maximal f-spaced set whose size function is L-Lipschitz: `2 (1 + L) / (1 - L)`, times 1.25.
///
/// The first factor is proved for the interior. The second covers cells at the boundary, by observation.
pub const fn alpha_of_spacing(lipschitz: f64) -> f64 {
    1.25 * 2.0 * (1.0 + lipschitz) / (1.0 - lipschitz)
}

/// alpha of a set with a constant size function, 2.5. Leaf sizes and experiments assume it for sets without a spacing.
pub const DEFAULT_ALPHA: f64 = alpha_of_spacing(0.0);
