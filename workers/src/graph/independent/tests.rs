use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::graph::Supergraph;
use septet_geometry::hash::Draw;
use septet_geometry::point::dist2;

use super::*;
use crate::config::{Task, Wanted, WorkerConfig};
use crate::hosts::host::{Host, Job};
use crate::input::{Rows, Source, squared_radius};
use crate::partition::leader::Plan;
use crate::share::{Share, merged_ledger};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::transport::Delivery;

fn config(fixed: u64, leaf: u64, workers: u32) -> Arc<WorkerConfig> {
    let task = Task::Independent { fixed };
    let wanted = Wanted::Fixed(Supergraph::Density { alpha: 1.0 });
    let mut config = WorkerConfig { task, workers, ..WorkerConfig::plain() };
    (config.tree.leaf, config.graph.wanted) = (leaf, wanted);
    Arc::new(config)
}

/// The set that the shares contain, the phases of the run, and the number of steps in phase `independent`.
#[derive(Default)]
struct Outcome {
    members: Vec<u64>,
    undecided: Vec<u64>,
    phases: Vec<Phase>,
    steps: u32,
    /// The number of messages in phase `independent`.
    messages: usize,
    ledger: LedgerPart,
}

/// Points and their sizes, as the source of a run.
struct Sites<'a, P>(&'a [P], &'a [f64]);

impl<P: Point> Source<P> for Sites<'_, P> {
    fn block(&self, block: u32, blocks: u32) -> Rows<P> {
        Rows::of_whole(0, self.0, self.1, block, blocks)
    }
}

/// Runs a machine without a transport. Messages arrive unchanged, in reverse order.
fn run<P: Point>(points: &[P], sizes: &[f64], config: &Arc<WorkerConfig>) -> Outcome {
    let sites = Sites(points, sizes);
    let job = Job { config: config.clone(), source: &sites, plan: &Plan::new() };
    let mut host = Host::<P>::new(0..config.ranks(), &job, &None);
    let mut wire = host.begin().unwrap();
    let (mut steps, mut messages, mut phases) = (0, 0, Vec::new());
    loop {
        let active = host.busy() || !wire.is_empty();
        if active && host.phase() == Phase::Independent {
            steps += 1;
            messages += wire.len();
        }
        wire.reverse();
        wire = host.turn(Delivery { inbox: wire, active }).unwrap();
        if host.is_done() {
            break;
        }
        if !active {
            phases.push(host.phase());
        }
    }
    let shares = host.into_shares();
    assert_eq!(shares.len() as u32, config.ranks());
    let ledger = merged_ledger(shares.iter().map(|share| &share.ledger.part), None);
    let (mut members, mut undecided) = (Vec::new(), Vec::new());
    for Share { selected, .. } in shares {
        members.extend(selected.members);
        undecided.resize(undecided.len().max(selected.undecided.len()), 0);
        undecided.iter_mut().zip(selected.undecided).for_each(|(sum, count)| *sum += count);
    }
    Outcome { members, undecided, phases, steps, messages, ledger }
}

/// Returns the set of the greedy algorithm, which compares all pairs of points.
fn greedy<P: Point>(points: &[P], sizes: &[f64], fixed: usize) -> Vec<u64> {
    let radii2: Vec<f64> = sizes.iter().map(|&size| squared_radius(size)).collect();
    let mut order: Vec<usize> = (fixed..points.len()).collect();
    let key = |i: usize| (priority(5, points[i]), points[i]);
    order.sort_by(|&i, &j| compare(key(i), key(j)));
    let mut taken: Vec<usize> = (0..fixed).collect();
    for i in order {
        let near = |&j: &usize| dist2(points[i], points[j]) <= radii2[i].min(radii2[j]);
        if !taken.iter().any(near) {
            taken.push(i);
        }
    }
    let mut members: Vec<u64> = taken[fixed..].iter().map(|&i| i as u64).collect();
    members.sort_unstable();
    members
}

fn checked<P: Point>(points: &[P], sizes: &[f64], what: &str) {
    for (fixed, leaf) in [(0, 30), (0, 10_000), (points.len() / 10, 30)] {
        let expected = greedy(points, sizes, fixed);
        let one = run(points, sizes, &config(fixed as u64, leaf, 1));
        for workers in [1, 2, 5, 8, 64] {
            let what = format!("{what}, {fixed} fixed, leaves of {leaf}, {workers} workers");
            let mut outcome = run(points, sizes, &config(fixed as u64, leaf, workers));
            outcome.members.sort_unstable();
            assert_eq!(outcome.members, expected, "{what}");
            assert_eq!(outcome.undecided, one.undecided, "{what}");
            assert!(outcome.undecided.windows(2).all(|w| w[1] < w[0]), "{what}: {:?}", outcome.undecided);
            // Each round takes two steps. One step precedes them if decisions on fixed points were sent. One step
            // follows if the last decisions were that points leave.
            let (steps, rounds) = (outcome.steps as usize, 2 * outcome.undecided.len());
            assert!((rounds..=rounds + 2).contains(&steps), "{what}: {steps} steps, {:?}", outcome.undecided);
            assert_eq!(outcome.ledger.edge_hash, one.ledger.edge_hash, "{what}");
            assert_eq!(outcome.phases, PHASES);
            let charges = |ledger: &LedgerPart| -> Vec<_> {
                ledger.members(Phase::Independent).map(|(node, charge)| (node, *charge)).collect()
            };
            assert_eq!(charges(&outcome.ledger), charges(&one.ledger), "{what}");
            let divided = workers > 1 && points.len() > 100 && leaf < 100;
            // The parts of two workers may have no common edge.
            let talks = outcome.messages > 0;
            assert!(talks == divided || !talks && workers == 2, "{what}: {} messages", outcome.messages);
        }
    }
}

const PHASES: [Phase; 7] = [
    Phase::Load,
    Phase::Partition,
    Phase::Summaries,
    Phase::Sets,
    Phase::Graph,
    Phase::Independent,
    Phase::Collect,
];

fn random(n: usize) -> Vec<DVec3> {
    let mut draw = Draw::new(77);
    (0..n).map(|_| draw.point()).collect()
}

#[test]
fn workers_select_the_greedy_set() {
    for n in [0, 1, 2, 3, 10, 600] {
        let cloud = random(n);
        let radius = |degree: f64| (degree / n.max(1) as f64 / 4.19).cbrt();
        let even = vec![radius(12.0); n];
        checked(&cloud, &even, "even");
        let rough: Vec<f64> = cloud.iter().map(|p| 1e-3 + 0.5 * p.x * p.y * p.z).collect();
        checked(&cloud, &rough, "rough");
        let plane: Vec<DVec2> = cloud.iter().map(|p| DVec2::new(p.x, p.y)).collect();
        checked(&plane, &vec![0.1; n], "plane");
    }
}

#[test]
fn sets_that_do_not_span_the_space() {
    let cloud = random(600);
    let flat: Vec<DVec3> = cloud.iter().map(|p| DVec3::new(p.x, p.y, 0.5 * p.x - p.y)).collect();
    checked(&flat, &vec![0.08; 600], "flat");
    let line: Vec<DVec3> = cloud.iter().map(|p| DVec3::new(p.x, 2.0 * p.x, -p.x)).collect();
    checked(&line, &vec![0.01; 600], "line");
}
