//! The paper's claims as experiments. Each claim is measured by code that is independent of the algorithm, and
//! compared with a bound stated in advance.
//!
//! **Claims.** A claim is a sentence of the paper with its place, an experiment, and figures with their bounds. A
//! figure comes from the ledgers of runs, or is measured on their points, cells and separators. The measurements
//! (`measure`) share no code with the algorithm: they use all pairs, Cramer's rule and plain distances. Each bound has
//! a reason: a proof, or a measurement at other sizes with a stated slack.
//!
//! **Readings.** If a sentence is false as printed, the claim says so. It is checked by the reading that the algorithm
//! needs ([`Reading::AsRead`]), and the figure of the printed form is reported below.
//!
//! **Repetition.** Everything is a function of the claims, the [`Extent`] and the seed. No clock decides anything.

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
pub use lab::{Lab, LabOptions};
pub use report::{CheckedClaim, ClaimReport, SCHEMA};

/// Returns all claims, in the paper's order.
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

/// Returns the claims of these names, in the paper's order; all claims if there are no names.
///
/// # Errors
/// Fails if no claim has one of the names.
pub fn select(names: &[String]) -> Result<Vec<&'static Claim>, ClaimError> {
    if let Some(name) = names.iter().find(|name| registry().all(|claim| claim.name != **name)) {
        return Err(ClaimError::Unknown { name: name.clone() });
    }
    Ok(registry().filter(|claim| names.is_empty() || names.iter().any(|n| n == claim.name)).collect())
}
