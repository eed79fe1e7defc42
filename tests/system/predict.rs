//! The work and the traffic of ranks, and the prices of rounds.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::sets::{plane, space};
use crate::common::{combinations, simulated, with_graph};
use septet_core::generate::Kind;
use septet_core::spec::{Partition, Transport, Workers};
use septet_core::{Outcome, Spec, simulate};
use septet_geometry::point::Point;
use septet_lab::predict::{Hardware, predict};
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::RankTally;

const WORKERS: [u32; 4] = [1, 7, 64, 300];

fn run<P: Point>(points: &[P], spec: &Spec, workers: u32) -> Outcome {
    let spec = spec.clone().with(|c| c.machine.workers = Workers::Count(workers));
    simulate(points, &spec).unwrap_or_else(|e| panic!("{spec:?}: {e}"))
}

/// The work and the messages of the ranks add up to the counts of the phases, the links and the rounds.
fn adds_up<P: Point>(points: &[P], spec: &Spec) {
    for workers in WORKERS {
        let run = run(points, spec, workers);
        let part = &run.ledger.part;
        for total in &run.ledger.phases {
            let rows = || part.ranks.iter().filter(|(key, _)| key.phase == total.phase).map(|(_, row)| row);
            assert_eq!(rows().map(|row| row.work).sum::<u64>(), total.work, "{workers} {:?}", total.phase);
            assert_eq!(rows().map(|row| row.sent.bytes).sum::<u64>(), total.bytes);
            assert_eq!(rows().map(|row| row.received.messages).sum::<u64>(), total.messages);
        }
        let mut received: BTreeMap<Rank, u64> = BTreeMap::new();
        let mut arrived = received.clone();
        part.ranks.iter().for_each(|(key, row)| *received.entry(key.rank).or_default() += row.received.bytes);
        part.links.iter().for_each(|(link, moved)| *arrived.entry(link.to).or_default() += moved.bytes);
        received.retain(|_, bytes| *bytes > 0);
        assert_eq!(received, arrived);
        assert!(part.ranks.keys().all(|key| key.rank <= workers));
    }
}

#[test]
fn ranks_add_up_in_space_and_in_the_plane() {
    for choice in combinations(false) {
        let spec = with_graph(&simulated(Workers::Count(1), 7, 60), choice);
        adds_up(&space(Kind::Uniform, 1200, 3), &spec);
        adds_up(&plane(Kind::GradedPoint, 1200, 4), &spec);
    }
    let planes = simulated(Workers::Count(1), 7, 60).with(|c| c.tree.partition = Partition::Kd);
    adds_up(&space(Kind::Grid, 1331, 1), &planes);
}

#[test]
fn ranks_have_the_same_counts_on_every_transport() {
    let points = space(Kind::WellSpaced, 3000, 1);
    let spec = simulated(Workers::Count(1), 7, 60);
    let channels = spec.clone().with(|c| {
        c.machine.transport = Transport::Channel;
        c.machine.threads = Some(2);
    });
    let (a, b) = (run(&points, &spec, 13), run(&points, &channels, 13));
    assert_eq!(a.ledger.part.ranks, b.ledger.part.ranks);
    let hardware = Hardware::default();
    assert_eq!(predict(&a, &hardware), predict(&b, &hardware));
}

/// The largest values of a function of the ranks, summed over the rounds.
fn slowest(run: &Outcome, of: impl Fn(u32, Rank) -> f64) -> f64 {
    let last = run.ledger.part.ranks.keys().map(|key| key.round).max().unwrap_or(0);
    let ranks = || 0..=run.settled.workers;
    (0..=last).map(|round| ranks().map(|rank| of(round, rank)).fold(0.0, f64::max)).sum()
}

/// Every price, computed rank by rank from the rows of the ledger.
#[test]
fn prices_are_those_of_the_slowest_ranks() {
    let points = space(Kind::Uniform, 3000, 3);
    let run = run(&points, &simulated(Workers::Count(1), 7, 60), 16);
    let mut hardware = Hardware {
        latency: 3.0,
        overhead: 5.0,
        bandwidth: 7.0,
        rate: 11.0,
        fixed: 13.0,
        ..Hardware::default()
    };
    hardware.phase_rates.insert("hulls".to_owned(), 17.0);
    let part = &run.ledger.part;
    let rows = |round, rank| part.ranks.iter().filter(move |(key, _)| (key.round, key.rank) == (round, rank));
    let rate = |phase| if phase == Phase::Hulls { 17.0 } else { 11.0 };
    let compute = slowest(&run, |round, rank| {
        rows(round, rank).map(|(key, row)| row.work as f64 / rate(key.phase)).sum()
    });
    let load = |round, rank| {
        let sum = |of: fn(&RankTally) -> u64| rows(round, rank).map(|(_, row)| of(row)).sum::<u64>() as f64;
        (sum(|r| r.sent.messages + r.received.messages), sum(|r| r.sent.bytes).max(sum(|r| r.received.bytes)))
    };
    let active: BTreeSet<u32> =
        part.rounds.iter().filter(|(_, tally)| tally.messages > 0).map(|(key, _)| key.round).collect();
    let latency = 3.0 * active.len() as f64;
    let bsp = latency + slowest(&run, |round, rank| load(round, rank).1 / 7.0);
    let loggp = latency
        + slowest(&run, |round, rank| {
            let (messages, bytes) = load(round, rank);
            messages * 5.0 + bytes / 7.0
        });
    let predicted = predict(&run, &hardware);
    for (price, expected) in [
        (predicted.bsp.compute, 13.0 + compute),
        (predicted.loggp.compute, 13.0 + compute),
        (predicted.bsp.communicate, bsp),
        (predicted.loggp.communicate, loggp),
        (
            predicted.busiest_work as f64,
            slowest(&run, |round, rank| rows(round, rank).map(|(_, row)| row.work).sum::<u64>() as f64),
        ),
    ] {
        assert!((price / expected - 1.0).abs() < 1e-9, "{price} {expected}");
    }
    let all: u64 = run.ledger.phases.iter().map(|p| p.work).sum();
    let totals = &run.ledger.totals;
    assert_eq!(predicted.brent, all / 16 + totals.paper.depth + totals.repair.depth + totals.selection.depth);
}

/// Each rank of a balanced machine does its share of the work.
#[test]
fn the_work_of_the_busiest_rank_falls_with_the_workers() {
    let points = space(Kind::WellSpaced, 8000, 1);
    let spec = simulated(Workers::Count(1), 7, 100);
    let works: Vec<(u64, u64)> = [1, 2, 4, 8]
        .map(|workers| {
            let run = run(&points, &spec, workers);
            let work = run.ledger.phases.iter().map(|p| p.work).sum::<u64>();
            (work / u64::from(workers), predict(&run, &Hardware::default()).busiest_work)
        })
        .to_vec();
    for (share, busiest) in works {
        assert!(busiest as f64 > 0.8 * share as f64 && busiest < 2 * share, "{busiest} of {share}");
    }
}
