//! The lists of phases of the claims against the table of phases.

use std::collections::BTreeSet;

use septet_protocol::ids::Phase;

use super::{bounds, depth_law, floors, sweeps};

/// A list of phases: its name, its entries, and the phases without an entry with the reasons.
type List = (&'static str, Vec<&'static str>, &'static [(&'static [Phase], &'static str)]);

/// The reason for phases that the runs of the claims do not have.
const ABSENT: (&[Phase], &str) = (
    &[Phase::Choice, Phase::Repair, Phase::ProbeCells, Phase::Fallback],
    "runs with a given graph, over well-spaced points",
);

/// The phases that only meshes have.
const MESHES: (&[Phase], &str) = (&Phase::OF_MESHES, "the claim `mesh-brent` bounds them");

/// The reason for the phase of sets that draw their own separators.
const OWN: (&[Phase], &str) =
    (&[Phase::OwnSets], "the sets are known only from the run, and have their own claim");

fn lists() -> [List; 4] {
    const SITES: (&[Phase], &str) = (&[Phase::Independent], "independent sets have their own claims");
    const PROBES: (&[Phase], &str) =
        (&[Phase::Probe, Phase::KnnProbe], "a run probes only if a ball is large");
    const REPAIRS: (&[Phase], &str) = (&[Phase::Certificate], "a run certifies again only after splaying");
    const LEVELS: (&[Phase], &str) = (
        &[Phase::Hulls, Phase::Check, Phase::Merge, Phase::Certificate, Phase::Independent],
        "their charges are at the leaves, or a constant at each node",
    );
    const LEAVES: (&[Phase], &str) =
        (&[Phase::Radii, Phase::KnnRadii, Phase::Graph], "only leaves are charged");
    [
        ("bounds", bounds::PHASES.iter().map(|row| row.name).collect(), &[ABSENT, OWN, SITES, MESHES]),
        (
            "floors",
            floors::FLOORS.iter().map(|row| row.phase).collect(),
            &[ABSENT, OWN, PROBES, REPAIRS, MESHES],
        ),
        (
            "levels",
            bounds::LEVELS.iter().map(|row| row.name).collect(),
            &[ABSENT, OWN, LEVELS, LEAVES, MESHES],
        ),
        ("sweeps", sweeps::all_phases().collect(), &[ABSENT, OWN, SITES, PROBES, REPAIRS, MESHES]),
    ]
}

#[test]
fn every_phase_with_work_is_in_each_list_or_exempt() {
    let expected: BTreeSet<&str> =
        Phase::ALL.into_iter().filter(|phase| phase.group().counts_work()).map(Phase::name).collect();
    for (list, entries, exempt) in lists() {
        let entries: BTreeSet<&str> = entries.into_iter().collect();
        let exempt: BTreeSet<&str> =
            exempt.iter().flat_map(|(phases, _)| *phases).map(|phase| phase.name()).collect();
        let both: Vec<_> = entries.intersection(&exempt).collect();
        assert!(both.is_empty(), "{list}: {both:?} have entries and are exempt");
        assert_eq!(
            &entries | &exempt,
            expected,
            "{list}: state a bound for each phase, or a reason for none"
        );
    }
}

/// The fits of depths have a column for the levels, unless the phase runs within leaves.
#[test]
fn phases_within_leaves_are_those_without_a_level() {
    let levels: BTreeSet<&str> = bounds::LEVELS.iter().map(|row| row.name).collect();
    let mut local: BTreeSet<&str> = sweeps::all_phases().filter(|name| !levels.contains(name)).collect();
    assert!(local.remove("merge"), "a reduction over the children of each node");
    assert_eq!(local, depth_law::LOCAL.into_iter().collect());
}
