//! The paper's claims as experiments: planted faults turn the right ones, and only those, to FAIL.

use septet_core::config::{Correction, Fault};
use septet_lab::claims::{CheckedClaim, ClaimReport, Extent, Lab, LabOptions, Reading, registry, select};

fn brief(fault: Option<Fault>) -> LabOptions {
    LabOptions { extent: Extent::Brief, fault, ..LabOptions::default() }
}

fn checked(names: &[&str], setting: LabOptions) -> Vec<CheckedClaim> {
    let mut lab = Lab::new(setting, |_| {});
    let names: Vec<String> = names.iter().map(|name| (*name).to_string()).collect();
    let claims = select(&names).unwrap();
    claims
        .into_iter()
        .map(|claim| claim.check(&mut lab).unwrap_or_else(|e| panic!("{}: {e}", claim.name)))
        .collect()
}

/// Without the fault all pass; with it these fail and those still pass.
fn turns(fault: Fault, fail: &[&str], pass: &[&str]) {
    turns_with(brief(Some(fault)), &fault.to_string(), fail, pass);
}

fn turns_with(setting: LabOptions, fault: &str, fail: &[&str], pass: &[&str]) {
    let names = [fail, pass].concat();
    for claim in checked(&names, brief(None)) {
        assert!(claim.passed, "without a fault: {}{}", claim.rows(), claim.details(true));
    }
    for claim in checked(&names, setting) {
        print!("{fault}: {}", claim.rows());
        let expected = pass.contains(&claim.name);
        assert_eq!(claim.passed, expected, "{fault}: {}{}", claim.rows(), claim.details(true));
    }
}

#[test]
fn half_of_alpha_loses_edges() {
    turns(
        Fault::HalveAlpha,
        &["supergraph", "local-hulls", "graph-exact"],
        &["lower-hull", "alpha", "separator-split", "no-edges-density", "levels"],
    );
}

#[test]
fn half_of_the_separator_points_lose_edges() {
    for fault in [Fault::HalfGhosts, Fault::HalfSeparators] {
        turns(fault, &["graph-exact"], &["lower-hull", "separator-split", "levels"]);
    }
}

#[test]
fn free_phases_cost_less_than_the_bounds_from_outside() {
    for phase in [
        "partition",
        "radii",
        "neighbours",
        "summaries",
        "knn-radii",
        "knn",
        "separator-sets",
        "graph",
        "hulls",
        "merge",
    ] {
        turns(format!("free:{phase}").parse().unwrap(), &["lower-bounds"], &["separator-split"]);
    }
    for phase in ["radii", "neighbours", "summaries", "knn-radii", "graph", "hulls"] {
        turns(format!("work:{phase}:0.5").parse().unwrap(), &["lower-bounds"], &["separator-split"]);
    }
}

#[test]
fn a_sphere_round_a_sample_splits_nothing() {
    turns(Fault::SmallSphere, &["separator-split", "levels"], &["graph-exact", "lower-hull", "local-hulls"]);
}

#[test]
fn a_clock_for_each_worker_makes_subproblems_wait() {
    turns(
        Fault::OneClock,
        &["free-of-workers", "level-depth", "brent"],
        &["levels", "supergraph", "replication", "merged-per-round"],
    );
}

#[test]
fn a_correction_node_by_node_is_no_descent() {
    let naive = LabOptions { correction: Correction::BottomUp, ..brief(None) };
    turns_with(
        naive,
        "naive correction",
        &["level-depth", "depth-law"],
        &["levels", "graph-exact", "local-hulls", "replication"],
    );
}

#[test]
fn every_claim_explains_itself() {
    let mut names: Vec<&str> = registry().map(|claim| claim.name).collect();
    assert!(names.len() >= 30);
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), registry().count(), "names are distinct");
    for claim in registry() {
        let lines = claim.explained();
        assert!(lines.iter().all(|line| line.ends_with('.') && !line.contains('\n')), "{lines:?}");
        if let Reading::AsRead { instead, because } = claim.reading {
            assert!(!instead.is_empty() && !because.is_empty());
        }
    }
    assert!(select(&["levels".to_string(), "no-such".to_string()]).is_err());
}

/// Where the printed form is not checked, it is measured all the same.
#[test]
fn printed_forms_are_reported() {
    let claims = checked(&["separator-split", "no-edges-overlap", "random-neighbours"], brief(None));
    let report = ClaimReport::of(Extent::Brief, 1, claims);
    assert!(report.passed, "{}", report.summary());
    for claim in &report.claims {
        assert_eq!(claim.holds_as_printed, Some(false), "{}", claim.rows());
        assert!(claim.rows().contains("as printed: does not hold"), "{}", claim.rows());
    }
    let again = checked(&["separator-split"], brief(None));
    assert_eq!(again[0], report.claims.iter().find(|c| c.name == "separator-split").unwrap().clone());
}
