//! The constants of the partition: they change counts and no cell, and the floor of leaves follows the rule.

use septet_core::generate::Kind;
use septet_core::spec::{Partition, Purpose, SeparatorSets, Spec, Workers};
use septet_core::{Outcome, simulate, triangulate};
use septet_geometry::point::Point;

use crate::common::sets::space;

const WORKERS: [u32; 3] = [1, 3, 16];

fn spec(change: impl FnOnce(&mut Spec)) -> Spec {
    Spec::default()
        .with(|c| (c.machine.workers, c.machine.threads) = (Workers::Count(3), Some(2)))
        .with(change)
}

/// The samples, great circles and leaf size that a run used.
fn used(run: &Outcome) -> (u64, u32, u64) {
    (run.settled.samples, run.settled.tries, run.settled.leaf)
}

fn same_cells<P: Point>(points: &[P]) {
    let reference = triangulate(points, &spec(|_| ())).unwrap();
    for (samples, tries, leaf) in [(36, 1, 30), (64, 5, 60), (400, 10, 300)] {
        let given = |c: &mut Spec| {
            (c.tree.constants.samples, c.tree.constants.tries) = (Some(samples), Some(tries));
            c.tree.leaf = Some(leaf);
        };
        let first = simulate(points, &spec(given)).unwrap();
        assert_eq!(used(&first), (samples, tries, leaf));
        assert!(first.cells() == reference.cells(), "{samples} samples, leaf {leaf}");
        let unsplit = first.ledger.part.nodes.values().filter(|f| f.is_leaf() && f.population > leaf).count();
        assert_eq!(unsplit, 0, "{samples} samples, leaf {leaf}");
        for workers in WORKERS {
            let run = simulate(points, &spec(given).with(|c| c.machine.workers = Workers::Count(workers)));
            let (part, of_first) = (run.unwrap().ledger, &first.ledger);
            assert_eq!(part.part.nodes, of_first.part.nodes, "{workers} workers");
            assert_eq!(part.totals, of_first.totals, "{workers} workers");
        }
    }
}

#[test]
fn constants_change_no_cell_and_counts_are_free_of_workers() {
    same_cells(&space(Kind::Uniform, 2500, 4));
    same_cells(&space(Kind::Clusters, 2500, 4));
}

/// Only the rules by which children share separator points need large leaves.
#[test]
fn the_floor_of_leaves_follows_the_rule() {
    let points = space(Kind::Jittered, 2500, 3);
    let leaf = |change: &dyn Fn(&mut Spec)| {
        let run = simulate(&points, &spec(|c| c.recursion.spacing = Some(0.0)).with(change)).unwrap();
        run.settled.leaf
    };
    let ghost = leaf(&|_| ());
    assert!((30..=125).contains(&ghost), "{ghost}");
    assert_eq!(leaf(&|c| c.recursion.sets = SeparatorSets::Both), 1000);
    assert_eq!(leaf(&|c| c.recursion.sets = SeparatorSets::Smaller), 1000);
    assert_eq!(leaf(&|c| c.tree.constants.purpose = Purpose::Timing), 1000);
    assert_eq!(triangulate(&points, &spec(|_| ())).unwrap().settled.leaf, 1000);
}

/// The constants for counting do less work and take fewer steps than the constants for time, on a set of the paper's
/// class.
#[test]
fn constants_for_counting_take_fewer_steps() {
    let points = space(Kind::WellSpaced, 8000, 5);
    for partition in [Partition::Sphere, Partition::Kd] {
        let steps = |purpose| {
            let of = |c: &mut Spec| {
                (c.recursion.spacing, c.tree.partition, c.tree.constants.purpose) =
                    (Some(0.0), partition, purpose);
            };
            let ledger = simulate(&points, &spec(of)).unwrap().ledger;
            println!("{partition:?} {purpose:?}: {:?} {:?}", ledger.totals.paper, ledger.totals.repair);
            (
                ledger.totals.paper.work + ledger.totals.repair.work,
                ledger.totals.paper.brent + ledger.totals.repair.brent,
            )
        };
        let (counting, timing) = (steps(Purpose::Counting), steps(Purpose::Timing));
        assert!(2 * counting.0 < timing.0 && 3 * counting.1 < 2 * timing.1, "{counting:?} {timing:?}");
    }
}

/// The work of the splits at one level falls as the nodes shrink, because a small node has few samples.
#[test]
fn small_nodes_draw_few_samples() {
    let points = space(Kind::Uniform, 6000, 2);
    let work = |samples: u64| {
        let of = |c: &mut Spec| (c.tree.constants.samples, c.tree.leaf) = (Some(samples), Some(60));
        let ledger = simulate(&points, &spec(of)).unwrap().ledger;
        let partition = ledger.phases.iter().find(|p| p.phase.name() == "partition").unwrap();
        partition.work as f64 / points.len() as f64
    };
    let [few, many] = [64, 400].map(work);
    // With 400 samples in every node, the splits of nodes of 61 to 400 points would take at least 400 operations for
    // each point and level: two levels with 160,000 pairs for at most 400 points.
    println!("partition work a point: {few:.0} with 64 samples, {many:.0} with 400");
    assert!(few < many && many < 1600.0);
}
