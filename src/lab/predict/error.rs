//! Errors of predictions.

use thiserror::Error;

/// A reason why nothing can be predicted from a record.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PredictError {
    /// Parts of the record are inconsistent.
    #[error("corrupt record of tasks: {what}")]
    Corrupt {
        /// The inconsistency.
        what: &'static str,
    },
    /// Several workers would share a subproblem that no separator splits.
    #[error(
        "node {node} with {population} points could not be split, and several of these workers would share it, \
         which cannot be predicted; use fewer workers"
    )]
    Unsplit {
        /// The id of the node.
        node: u64,
        /// Number of points of the node.
        population: u64,
    },
    /// The number of workers is 0, or exceeds the number of ranks that a machine can have.
    #[error("cannot predict {workers} workers: the number must be from 1 to {most}")]
    Workers {
        /// The requested number.
        workers: u32,
        /// The largest possible number.
        most: u32,
    },
}
