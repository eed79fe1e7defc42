//! The supergraph of the Delaunay triangulation.

use std::fmt;

use serde::Serialize;

use septet_workers::config::Neighbours;

use crate::spec::SpecError;
use crate::spec::value::{Setting, Value, Words};

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

words!(GraphKind {
    Density "density" "The density graph of the paper",
    Overlap "overlap" "Overlapping neighbour balls",
    Knn "knn" "The k nearest neighbours",
});

impl GraphKind {
    /// Returns the graph of this kind with automatic parameters.
    pub fn graph(self) -> Graph {
        match self {
            GraphKind::Density => Graph::Density { alpha: Alpha::Auto },
            GraphKind::Overlap => Graph::Overlap { alpha: Alpha::Auto, k: Neighbours::Auto },
            GraphKind::Knn => Graph::Knn { k: Neighbours::Auto },
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

impl Value for Alpha {
    fn read(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Alpha::Auto),
            _ => text
                .parse()
                .map(Alpha::Value)
                .map_err(|_| "expected a number of at least 1, or `auto`".into()),
        }
    }

    fn setting(&self) -> Setting {
        Setting::Text(self.to_string())
    }
}

impl Value for Neighbours {
    fn read(text: &str) -> Result<Self, String> {
        let expected = || "expected a number, `auto`, or a factor of ln n such as `10ln`".to_owned();
        match (text, text.strip_suffix("ln")) {
            ("auto", _) => Ok(Neighbours::Auto),
            (_, Some(factor)) => factor.parse().map(Neighbours::Log).map_err(|_| expected()),
            _ => text.parse().map(Neighbours::Count).map_err(|_| expected()),
        }
    }

    fn setting(&self) -> Setting {
        Setting::Text(self.to_string())
    }
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
        /// The neighbour to which its balls extend: a number, or [`Neighbours::Auto`] for the first.
        k: Neighbours,
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
    /// Returns the graph of a kind with the parameters that apply to it.
    ///
    /// # Errors
    /// Returns [`SpecError::Unused`] if the parameter of another kind is given.
    pub fn new(kind: GraphKind, alpha: Alpha, k: Neighbours) -> Result<Self, SpecError> {
        kind.graph().with_alpha(alpha)?.with_k(k)
    }

    /// Returns the graph with this alpha.
    ///
    /// # Errors
    /// Returns [`SpecError::Unused`] if the graph has no alpha.
    pub fn with_alpha(self, alpha: Alpha) -> Result<Self, SpecError> {
        match (self, alpha) {
            (Graph::Density { .. }, alpha) => Ok(Graph::Density { alpha }),
            (Graph::Overlap { k, .. }, alpha) => Ok(Graph::Overlap { alpha, k }),
            (Graph::Knn { .. }, Alpha::Auto) => Ok(self),
            (Graph::Knn { .. }, Alpha::Value(_)) => Err(self.unused("alpha")),
        }
    }

    /// Returns the graph with this k.
    ///
    /// # Errors
    /// Returns [`SpecError::Unused`] if the graph has no k.
    pub fn with_k(self, k: Neighbours) -> Result<Self, SpecError> {
        match (self, k) {
            (Graph::Knn { .. }, k) => Ok(Graph::Knn { k }),
            (Graph::Overlap { alpha, .. }, k) => Ok(Graph::Overlap { alpha, k }),
            (Graph::Density { .. }, Neighbours::Auto) => Ok(self),
            (Graph::Density { .. }, Neighbours::Count(_) | Neighbours::Log(_)) => Err(self.unused("k")),
        }
    }

    fn unused(self, parameter: &'static str) -> SpecError {
        SpecError::Unused { graph: self.kind().name(), parameter }
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
            Graph::Density { alpha } | Graph::Overlap { alpha, .. } => alpha,
            Graph::Knn { .. } => Alpha::Auto,
        }
    }

    /// Returns k, which is [`Neighbours::Auto`] for density graphs.
    pub fn k(self) -> Neighbours {
        match self {
            Graph::Density { .. } => Neighbours::Auto,
            Graph::Overlap { k, .. } | Graph::Knn { k } => k,
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
