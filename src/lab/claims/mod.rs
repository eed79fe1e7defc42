//! The paper's claims as experiments. The figures of each claim are compared with bounds that were stated in advance.
//!
//! **Claims.** A claim consists of a statement of the paper, an experiment, and figures with their bounds. A figure is
//! taken from the ledgers of runs, or measured on their points, cells and separators. The code of the measurements
//! (`measure`) is independent of the algorithm: it uses all pairs, Cramer's rule and plain distances. Each bound has a
//! reason: a proof, or a measurement at other sizes with a stated slack.
//!
//! **Readings.** If a statement is false as printed, its claim says so, and checks the reading that the algorithm needs
//! ([`Reading::AsRead`]). The report then also shows the figure of the printed form.
//!
//! **Repetition.** All results are functions of the claims, the [`Extent`] and the seed. No decision depends on a
//! clock.

mod ablation;
mod accounts;
mod ball_order;
mod bounds;
mod brent;
mod choice;
mod claim;
mod counted;
mod depth_law;
mod dimensions;
mod distance;
mod error;
mod exact_counts;
mod exponent;
mod extent;
mod figure;
mod floors;
mod generation;
mod holm;
mod hubs;
mod hulls;
mod journal;
mod lab;
mod level_depth;
mod lower_bounds;
mod machine;
mod measure;
mod mesh_costs;
mod neighbours;
mod own_sets;
mod own_spheres;
mod random;
mod ratio;
mod reached;
mod recursion;
mod replication;
mod report;
mod sample;
mod separators;
mod sites;
mod sizes;
mod surfaces;
mod sweeps;
#[cfg(test)]
mod tests;
mod torus;
mod tree;
mod weights;

pub use claim::{Claim, Reading, Role, Statistics};
pub use error::ClaimError;
pub use extent::Extent;
pub use figure::{Figure, Relation};
pub use journal::ClaimJournal;
pub use lab::{Lab, LabOptions};
pub use report::{CheckedClaim, ClaimReport, SCHEMA};

/// Returns all claims, in the paper's order.
pub fn registry() -> impl Iterator<Item = &'static Claim> {
    let groups: [&'static [Claim]; 27] = [
        separators::CLAIMS,
        exponent::CLAIMS,
        ball_order::CLAIMS,
        ablation::CLAIMS,
        ratio::CLAIMS,
        hulls::CLAIMS,
        hubs::CLAIMS,
        distance::CLAIMS,
        weights::CLAIMS,
        recursion::CLAIMS,
        own_spheres::CLAIMS,
        replication::CLAIMS,
        torus::CLAIMS,
        dimensions::CLAIMS,
        tree::CLAIMS,
        level_depth::CLAIMS,
        depth_law::CLAIMS,
        neighbours::CLAIMS,
        brent::CLAIMS,
        choice::CLAIMS,
        lower_bounds::CLAIMS,
        random::CLAIMS,
        machine::CLAIMS,
        accounts::CLAIMS,
        exact_counts::CLAIMS,
        generation::CLAIMS,
        mesh_costs::CLAIMS,
    ];
    groups.into_iter().flatten()
}

/// Returns the claims with these names, or all claims if there are no names, in the paper's order.
///
/// # Errors
/// Returns [`ClaimError::Unknown`] if one of the names is unknown.
pub fn select(names: &[String]) -> Result<Vec<&'static Claim>, ClaimError> {
    if let Some(name) = names.iter().find(|name| registry().all(|claim| claim.name != **name)) {
        return Err(ClaimError::Unknown { name: name.clone() });
    }
    Ok(registry().filter(|claim| names.is_empty() || names.iter().any(|n| n == claim.name)).collect())
}
