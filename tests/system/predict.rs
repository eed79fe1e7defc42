//! Predicted rounds, messages and bytes are those of real runs, phase by phase.

use crate::common::sets::{plane, space};
use crate::common::{combinations, simulated, with_graph};
use septet_core::config::{Alpha, GraphKind, Neighbours, Partition, SeparatorSets, Workers};
use septet_core::generate::Kind;
use septet_core::{Config, simulate};
use septet_geometry::point::Point;
use septet_lab::predict::{Hardware, predict};
use septet_protocol::tasks::TaskLog;

type Row = (&'static str, u64, u64, u64);

fn real<P: Point>(points: &[P], config: &Config) -> Vec<Row> {
    let run = simulate(points, config).unwrap_or_else(|e| panic!("{config:?}: {e}"));
    let sends = run.ledger.phases.iter().filter(|p| p.messages > 0);
    sends.map(|p| (p.phase.name(), p.rounds, p.messages, p.bytes)).collect()
}

fn compare<P: Point>(points: &[P], config: &Config, workers: &[u32]) {
    let alone = config.clone().with(|c| {
        c.machine.workers = Workers::Count(1);
        c.keep.tasks = true;
    });
    let log = simulate(points, &alone).unwrap().tasks.expect("a record");
    for &p in workers {
        let prediction = predict(&log, p, &Hardware::default()).unwrap();
        assert!(prediction.exact);
        let sends = prediction.phases.iter().filter(|ph| ph.messages > 0);
        let predicted: Vec<Row> = sends.map(|ph| (ph.name, ph.rounds, ph.messages, ph.bytes)).collect();
        let ran = real(points, &config.clone().with(|c| c.machine.workers = Workers::Count(p)));
        assert_eq!(predicted, ran, "{p} workers, {config:?}");
    }
}

const P: [u32; 6] = [1, 2, 8, 16, 64, 512];

#[test]
fn predictions_equal_runs_in_space() {
    for choice in combinations(false) {
        let config = with_graph(&simulated(Workers::Count(1), 7, 60), choice);
        if config.separator_sets == SeparatorSets::Ghost {
            compare(&space(Kind::Uniform, 3000, 3), &config, &P);
        }
    }
}

#[test]
fn predictions_equal_runs_in_the_plane() {
    for choice in combinations(false) {
        let config = with_graph(&simulated(Workers::Count(1), 7, 50), choice);
        if config.separator_sets == SeparatorSets::Ghost {
            compare(&plane(Kind::GradedPoint, 3000, 4), &config, &P);
        }
    }
}

#[test]
fn predictions_equal_runs_with_ties_and_with_one_busy_rank() {
    let config = simulated(Workers::Count(1), 7, 60);
    compare(&space(Kind::Grid, 1728, 1), &config, &P);
    compare(&space(Kind::WellSpaced, 3000, 1), &config, &P);
    compare(&space(Kind::Uniform, 40, 1), &config, &P);
}

#[test]
fn predictions_equal_runs_with_separating_planes() {
    let config = simulated(Workers::Count(1), 7, 60).with(|c| c.partition = Partition::Kd);
    compare(&space(Kind::Uniform, 2000, 3), &config, &P);
    compare(&plane(Kind::Grid, 2500, 3), &config, &P);
}

#[test]
fn the_task_record_does_not_depend_on_the_workers() {
    let points = space(Kind::Uniform, 2000, 5);
    let config = simulated(Workers::Count(8), 7, 60).with(|c| c.keep.tasks = true);
    let beside = simulate(&points, &config).unwrap();
    let alone = simulate(&points, &config.with(|c| c.machine.workers = Workers::Count(1))).unwrap();
    assert!(beside.tasks.is_some() && beside.tasks == alone.tasks);
    assert_eq!(beside.cells(), alone.cells());
}

/// Records that say less than they did, or more than can be, are refused.
#[test]
fn corrupt_task_records_are_refused() {
    let nearest = (GraphKind::Knn, SeparatorSets::Ghost, Alpha::Auto, Neighbours::Count(12));
    let config = with_graph(&simulated(Workers::Count(1), 7, 60), nearest);
    let config = config.with(|c| c.keep.tasks = true);
    let log = simulate(&space(Kind::Uniform, 1000, 5), &config).unwrap().tasks.expect("a record");
    assert!(!log.senders.is_empty() && predict(&log, 8, &Hardware::default()).is_ok());
    let refused = |change: &dyn Fn(&mut TaskLog)| {
        let mut torn = log.clone();
        change(&mut torn);
        predict(&torn, 8, &Hardware::default()).unwrap_err().to_string()
    };
    assert!(refused(&|log| log.senders.clear()).contains("an earlier version"));
    assert!(refused(&|log| log.senders[0].3 = u64::MAX).contains("more edges"));
    assert!(refused(&|log| log.reverse[0].2 = u64::MAX).contains("more edges"));
    assert!(refused(&|log| log.senders[0].2 = u32::MAX).contains("a leaf that does not exist"));
}
