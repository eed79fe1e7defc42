//! The paper's claims as experiments: planted faults turn the right ones, and only those, to FAIL.

use std::collections::BTreeSet;

use septet_core::spec::{Correction, FAULTS, Fault};
use septet_lab::claims::{
    CheckedClaim, Claim, ClaimReport, Extent, Lab, LabOptions, Reading, registry, select,
};
use septet_protocol::ids::{Group, Phase};

/// A fault, the claims that must fail on a machine with this fault, and the extent of their experiments.
struct Pair {
    fault: &'static str,
    fail: &'static [&'static str],
    extent: Extent,
}

const fn pair(fault: &'static str, fail: &'static [&'static str]) -> Pair {
    Pair { fault, fail, extent: Extent::Brief }
}

/// The pairs of faults and claims. The guide has them in the last column of the table of faults. `bench/accept/faults.py`
/// measures them at full size, where `slow:hulls:root3` needs no factor.
static PAIRS: [Pair; 23] = [
    pair("slow:partition:log2", &["level-depth"]),
    pair("slow:hulls:root3:4", &["depth-law"]),
    pair("sequential-leaf", &["brent"]),
    pair("free-loop", &["lower-bounds"]),
    pair("flood", &["brent", "replication"]),
    pair("far-ghosts:3", &["brent", "replication"]),
    pair("half-ghosts", &["graph-exact"]),
    pair("half-separators", &["graph-exact"]),
    pair("halve-alpha", &["supergraph", "local-hulls", "graph-exact", "weights"]),
    pair("blind-probes", &["distance"]),
    pair("first-ball", &["overlap-k"]),
    // The choice itself is a larger share of smaller sets.
    Pair { extent: Extent::Quick, ..pair("worst-choice", &["choice-near-best"]) },
    pair("free:choice", &["whole-sum"]),
    Pair { extent: Extent::Quick, ..pair("always-punt", &["neighbours-published"]) },
    pair("slow-hub", &["hubs"]),
    Pair { extent: Extent::Quick, ..pair("old-spheres", &["own-spheres"]) },
    pair("free:sizes", &["mesh-brent"]),
    pair("slow:octree:log2", &["mesh-brent"]),
    pair("work:hulls:1.1", &["exact-counts"]),
    pair("small-sphere", &["separator-split", "levels"]),
    // Smaller sets do not show the exponents.
    Pair { extent: Extent::Quick, ..pair("random-planes", &["separator-exponent"]) },
    Pair { extent: Extent::Quick, ..pair("median-planes", &["separator-exponent"]) },
    Pair { extent: Extent::Quick, ..pair("no-centrepoint", &["separator-exponent"]) },
];

/// The pairs of [`a_clock_for_each_worker_makes_subproblems_wait`].
static OF_CLOCKS: [&str; 3] = ["free-of-workers", "level-depth", "brent"];

/// The claims that must fail for a fault of each form of charges, for every phase of [`bounded`] or every phase of the paper.
static OF_CHARGES: [(&str, &[&str]); 3] = [
    ("slow", &["accounts"]),
    ("work", &["accounts", "lower-bounds"]),
    ("free", &["accounts", "lower-bounds"]),
];

/// Returns the phases of the paper with a natural size. The results do not need the probes, only a run knows the sets that
/// draw their own separators, and no bound has the phases of meshes.
fn bounded() -> impl Iterator<Item = &'static str> {
    let exempt = |phase: Phase| matches!(phase, Phase::Probe | Phase::KnnProbe | Phase::OwnSets);
    let all = Group::Paper.phases().filter(move |phase| !exempt(*phase) && !Phase::OF_MESHES.contains(phase));
    all.map(Phase::name)
}

fn brief(fault: Option<Fault>) -> LabOptions {
    LabOptions { extent: Extent::Brief, fault, ..LabOptions::default() }
}

fn checked(names: &[&str], setting: LabOptions) -> Vec<CheckedClaim> {
    let mut lab = Lab::new(setting, |_| {});
    let names: Vec<String> = names.iter().map(|name| (*name).to_string()).collect();
    let claims = select(&names).unwrap();
    let checked = |claim: &Claim| {
        let checked = claim.check(&mut lab).unwrap_or_else(|e| panic!("{}: {e}", claim.name));
        let is_statistical = claim.statistics.is_some();
        // The growth of the replication needs larger sets. A run that ends with an error has no p-value.
        if lab.options.fault.is_none() && claim.name != "replication" {
            assert_eq!(is_statistical, checked.is_statistical(), "{} states its power", claim.name);
        }
        assert!(is_statistical || !checked.is_statistical(), "{} states its power", claim.name);
        checked
    };
    claims.into_iter().map(checked).collect()
}

/// Asserts that all of these claims fail on a machine with the fault.
fn fails(fault: &str, names: &[&str], extent: Extent) {
    let setting = LabOptions { extent, ..brief(Some(fault.parse().unwrap())) };
    for claim in checked(names, setting) {
        print!("{fault}: {}", claim.rows());
        assert!(!claim.passed, "{fault} escapes {}", claim.rows());
    }
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

/// Without a fault, the claims of all pairs pass.
#[test]
fn the_right_machine_passes() {
    for extent in [Extent::Brief, Extent::Quick] {
        let faulty = PAIRS.iter().filter(|pair| pair.extent == extent).flat_map(|pair| pair.fail);
        let charges = OF_CHARGES.iter().filter(|_| extent == Extent::Brief).flat_map(|form| form.1);
        let names: BTreeSet<&str> = faulty.chain(charges).copied().collect();
        let names: Vec<&str> = names.into_iter().collect();
        for claim in checked(&names, LabOptions { extent, ..brief(None) }) {
            assert!(claim.passed, "{}{}", claim.rows(), claim.details(true));
        }
    }
    let statistical: Vec<&str> =
        registry().filter(|claim| claim.statistics.is_some()).map(|claim| claim.name).collect();
    assert_eq!(
        statistical,
        ["separator-exponent", "replication", "level-depth", "depth-law", "neighbours-published"]
    );
}

#[test]
fn every_fault_of_a_pair_is_caught() {
    for Pair { fault, fail, extent } in &PAIRS {
        fails(fault, fail, *extent);
    }
}

/// Every fault of the charges of a phase of the paper makes the two accounts differ. No second account prices the phases of
/// meshes.
#[test]
fn faults_of_charges_are_caught_by_the_second_account() {
    let recursion = Group::Paper.phases().filter(|phase| !Phase::OF_MESHES.contains(phase));
    for phase in recursion.map(Phase::name) {
        for fault in [
            format!("free:{phase}"),
            format!("work:{phase}:2"),
            format!("work:{phase}:0.5"),
            format!("slow:{phase}:log"),
            format!("slow:{phase}:root3"),
        ] {
            fails(&fault, &["accounts"], Extent::Brief);
        }
    }
}

/// The unit tests of the laboratory show that half of the work of every other phase is below its bound, too.
#[test]
fn free_and_halved_phases_cost_less_than_the_bounds_from_outside() {
    for phase in bounded() {
        fails(&format!("free:{phase}"), &["lower-bounds"], Extent::Brief);
    }
    for phase in ["partition", "separator-sets", "independent", "merge"] {
        fails(&format!("work:{phase}:0.5"), &["lower-bounds"], Extent::Brief);
    }
    // Other claims do not see the charges.
    turns("free:hulls".parse().unwrap(), &[], &["separator-split", "graph-exact"]);
}

/// The last column of the guide's table of faults has exactly the pairs of these tests.
#[test]
fn the_guide_lists_the_pairs() {
    let guide = include_str!("../../src/guide/experiments.md");
    let known: BTreeSet<&str> = registry().map(|claim| claim.name).collect();
    for form in FAULTS {
        let row = guide.lines().find(|line| line.starts_with(&format!("| `{}` |", form.text)));
        let row = row.unwrap_or_else(|| panic!("the guide has no fault {}", form.text));
        let column = row.trim_end_matches('|').rsplit('|').next().unwrap_or_default();
        let listed: BTreeSet<&str> = column.split('`').filter(|word| known.contains(word)).collect();
        let name = |fault: &str| fault.split(':').next() == Some(form.name());
        let pairs = PAIRS.iter().filter(|pair| name(pair.fault)).flat_map(|pair| pair.fail);
        let charges = OF_CHARGES.iter().filter(|(of, _)| name(of)).flat_map(|(_, fail)| *fail);
        let clocks = OF_CLOCKS.iter().filter(|_| name("one-clock"));
        let expected: BTreeSet<&str> = pairs.chain(charges).chain(clocks).copied().collect();
        assert_eq!(listed, expected, "{}", form.text);
    }
}

#[test]
fn half_of_alpha_leaves_other_claims() {
    turns(Fault::HalveAlpha, &[], &["lower-hull", "alpha", "separator-split", "no-edges-density", "levels"]);
}

#[test]
fn half_of_the_separator_points_leaves_other_claims() {
    for fault in [Fault::HalfGhosts, Fault::HalfSeparators] {
        turns(fault, &[], &["lower-hull", "separator-split", "levels"]);
    }
}

#[test]
fn a_sphere_round_a_sample_leaves_other_claims() {
    turns(Fault::SmallSphere, &[], &["graph-exact", "lower-hull", "local-hulls"]);
}

#[test]
fn a_clock_for_each_worker_makes_subproblems_wait() {
    turns(Fault::OneClock, &OF_CLOCKS, &["levels", "supergraph", "replication", "merged-per-round"]);
}

#[test]
fn a_correction_node_by_node_is_no_descent() {
    let naive = LabOptions { correction: Correction::BottomUp, ..brief(None) };
    turns_with(
        naive,
        "naive correction",
        &["level-depth", "depth-law"],
        &["levels", "graph-exact", "local-hulls"],
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
