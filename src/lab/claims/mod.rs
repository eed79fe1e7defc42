//! The paper's claims as experiments: each runs, measures apart from the algorithm, and is held against a bound
//! that was stated before.
//!
//! **What a claim is.** A sentence of the paper with its place, an experiment, and figures with their bounds. A
//! figure comes from runs: from their ledger, or measured on their points, cells and separators by code that shares
//! nothing with the algorithm (`measure`: all pairs, Cramer's rule, plain distances). A bound has a reason: a proof,
//! or a measurement at other sizes with the slack that is named.
//!
//! **Readings.** Where a sentence does not hold as it is printed, the claim says so, reports the figure of the printed
//! form beside it, and is judged by the reading that the algorithm needs ([`Reading::AsRead`]).
//!
//! **Repetition.** Everything is a function of (claims, [`Extent`], seed): no clock decides anything.

mod claim;
mod error;
mod extent;
mod figure;
mod generation;
mod hulls;
mod lab;
mod machine;
mod measure;
mod random;
mod ratio;
mod recursion;
mod report;
mod separators;
mod tree;

pub use claim::{Claim, Reading};
pub use error::ClaimError;
pub use extent::Extent;
pub use figure::{Figure, Relation};
pub use lab::{Lab, Setting};
pub use report::{ClaimReport, Judged, SCHEMA};

/// All claims, in the paper's order.
pub fn registry() -> impl Iterator<Item = &'static Claim> {
    let groups: [&'static [Claim]; 8] = [
        separators::CLAIMS,
        ratio::CLAIMS,
        hulls::CLAIMS,
        recursion::CLAIMS,
        tree::CLAIMS,
        random::CLAIMS,
        machine::CLAIMS,
        generation::CLAIMS,
    ];
    groups.into_iter().flatten()
}

/// The claims of these names, in the paper's order; all for none.
///
/// # Errors
/// A name that no claim has.
pub fn select(names: &[String]) -> Result<Vec<&'static Claim>, ClaimError> {
    if let Some(name) = names.iter().find(|name| registry().all(|claim| claim.name != **name)) {
        return Err(ClaimError::Unknown { name: name.clone() });
    }
    Ok(registry().filter(|claim| names.is_empty() || names.iter().any(|n| n == claim.name)).collect())
}
