//! With many workers, no rank sends or receives many messages in a round of a collective phase.

use septet_core::generate::Kind;
use septet_core::spec::{Alpha, GraphKind, Neighbours, SeparatorSets, Workers};
use septet_core::{Outcome, Spec, simulate, triangulate};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

use crate::common::sets::{plane, space};
use crate::common::{check, check_counted, simulated, with_graph};

const WORKERS: u32 = 512;

/// The largest number of messages that a rank may send or receive in a round: twice the fan of the trees.
const MOST: u64 = 64;

/// The phases in which groups, the coordinator or neighbours send messages whose number does not follow the points.
const PHASES: [Phase; 5] =
    [Phase::Partition, Phase::Summaries, Phase::Merge, Phase::Certificate, Phase::Collect];

/// Returns the largest number of messages that a rank sends or receives in a round of a phase.
fn most(run: &Outcome, phase: Phase) -> u64 {
    let rows = run.ledger.part.ranks.iter().filter(|(key, _)| key.phase == phase);
    rows.map(|(_, row)| row.sent.messages.max(row.received.messages)).max().unwrap_or(0)
}

fn few_messages(run: &Outcome, phases: &[Phase], what: &str) {
    let found: Vec<(Phase, u64)> = phases.iter().map(|&phase| (phase, most(run, phase))).collect();
    assert!(found.iter().all(|&(_, messages)| messages <= MOST), "{what}: {found:?}");
    // The groups are large enough for trees.
    assert!(most(run, Phase::Partition) >= 32, "{what}: {found:?}");
}

/// Leaves of about the points of one worker, and leaves of the points of many.
fn triangulations<P: Point>(points: &[P]) {
    for leaf in [2 * points.len() as u64 / u64::from(WORKERS), 1000, 1 << 20] {
        let run = check(points, &simulated(Workers::Count(WORKERS), 3, leaf));
        few_messages(&run, &PHASES, &format!("{} dimensions, leaves of {leaf}", P::DIM));
    }
}

#[test]
fn triangulations_send_few_messages_per_rank_and_round() {
    triangulations(&space(Kind::Uniform, 6000, 5));
    triangulations(&plane(Kind::Uniform, 6000, 6));
}

#[test]
fn simulations_send_few_messages_per_rank_and_round() {
    use SeparatorSets::{Both, Smaller};
    let spec = |leaf| simulated(Workers::Count(WORKERS), 3, leaf);
    let run = check_counted(&space(Kind::Uniform, 4000, 5), &spec(40));
    few_messages(&run, &PHASES, "in space");
    let run = check_counted(&plane(Kind::Uniform, 4000, 6), &spec(20));
    few_messages(&run, &PHASES, "in the plane");
    for sets in [Both, Smaller] {
        let choice = (GraphKind::Density, sets, Alpha::Value(2.5), Neighbours::Auto);
        let run = check_counted(&plane(Kind::Uniform, 3000, 6), &with_graph(&spec(20), choice));
        few_messages(&run, &PHASES, "with separator sets");
    }
}

/// The trees change neither the cells nor the counts that do not depend on the workers.
#[test]
fn trees_change_no_result() {
    fn same<P: Point>(points: &[P], spec: &Spec, run: fn(&[P], &Spec) -> Outcome) {
        let with = |workers| {
            let spec = spec.clone().with(|c| c.machine.workers = Workers::Count(workers));
            run(points, &spec)
        };
        let few = with(3);
        for workers in [33, 34, 100, WORKERS] {
            let many = with(workers);
            assert_eq!(few.cells(), many.cells(), "{workers} workers");
            crate::common::assert_same_counts(&few.ledger, &many.ledger, &format!("{workers} workers"));
        }
    }
    let run = |points: &[_], spec: &Spec| simulate(points, spec).expect("a valid run");
    same(&space(Kind::Clusters, 1500, 2), &simulated(Workers::Count(1), 7, 40), run);
    let both = (GraphKind::Density, SeparatorSets::Both, Alpha::Value(2.5), Neighbours::Auto);
    let in_sets = with_graph(&simulated(Workers::Count(1), 7, 40), both);
    same(&space(Kind::Uniform, 1500, 2), &in_sets, run);
    let spec = simulated(Workers::Count(1), 7, 10);
    let points = space(Kind::Uniform, 3000, 2);
    let few = triangulate(&points, &spec.clone().with(|c| c.machine.workers = Workers::Count(3))).unwrap();
    for workers in [34, 100, WORKERS] {
        let many = spec.clone().with(|c| c.machine.workers = Workers::Count(workers));
        assert_eq!(few.cells(), triangulate(&points, &many).unwrap().cells(), "{workers} workers");
    }
}
