//! Why a record predicts nothing.

use thiserror::Error;

/// Why a record predicts nothing.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PredictError {
    /// Parts of the record do not fit together.
    #[error("the record of tasks is torn: {what}")]
    Torn {
        /// What.
        what: &'static str,
    },
    /// A subproblem that no separator splits would be shared.
    #[error(
        "node {node} of {population} points could not be split: with so many workers it would be shared, \
         which is not predicted; ask for fewer"
    )]
    Unsplit {
        /// Its path.
        node: u64,
        /// Its points.
        population: u64,
    },
    /// No workers, or more than ranks can be told apart.
    #[error("{workers} workers cannot be predicted: from 1 to {most}")]
    Workers {
        /// Asked for.
        workers: u32,
        /// Allowed.
        most: u32,
    },
}
