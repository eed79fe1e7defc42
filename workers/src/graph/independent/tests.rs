use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::dist2;

use super::*;
use crate::config::{Wanted, WorkerConfig};
use crate::machine::context::{Context, Running};
use crate::machine::host::Host;
use crate::partition::leader::Plan;
use crate::{partition, summaries};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::message::PointBatch;
use septet_protocol::transport::{Delivery, TransportError};

fn config(fixed: u64, leaf: u64, workers: u32) -> Arc<WorkerConfig> {
    let task = Task::Independent { fixed };
    let wanted = Wanted::Fixed(Supergraph::Density { alpha: 1.0 });
    Arc::new(WorkerConfig { task, workers, leaf, wanted, ..WorkerConfig::plain() })
}

/// What the workers send of the set, the phases they went through, and their steps in that of the set.
#[derive(Default)]
struct Outcome {
    members: Vec<u64>,
    undecided: Vec<u64>,
    phases: Vec<Phase>,
    steps: u32,
    /// Messages of the set between workers.
    told: usize,
    ledger: LedgerPart,
}

/// What rank 0 runs: blocks, the lead of the root, and what comes in the end.
async fn root<P: Point>(
    mut cx: Context<P>,
    points: &[P],
    radii2: &[f64],
) -> Result<(Outcome, LedgerPart), TransportError> {
    let (n, p) = (points.len(), cx.config.workers);
    for rank in 1..=p {
        let share = |r: u32| n * r as usize / p as usize;
        let range = share(rank - 1)..share(rank);
        let block = PointBatch {
            ids: Bulk(range.clone().map(|i| i as u64).collect()),
            owners: Bulk(vec![rank; range.len()]),
            radii2: Bulk(radii2[range.clone()].to_vec()),
            positions: Bulk(points[range].to_vec()),
        };
        cx.send(rank, NodeId::ROOT, 0, Body::Start { population: n as u64, frame: PointBatch::default() });
        cx.send(rank, NodeId::ROOT, 0, Body::Block(block));
    }
    while cx.exchange().await? {}
    let led = partition::lead_root(&mut cx, n as u64, Plan::new()).await?;
    summaries::lead_root(&mut cx, &led).await?;
    let mut outcome = Outcome::default();
    for phase in [Phase::Sets, Phase::Graph, Phase::Independent, Phase::Collect] {
        cx.enter(phase)?;
        while cx.exchange().await? {
            collect(cx.parts().2, &mut outcome);
        }
    }
    Ok((outcome, cx.ledger))
}

/// Takes what is for the coordinator at the end.
fn collect<P: Point>(inbox: &mut Vec<Message<P>>, outcome: &mut Outcome) {
    inbox.retain(|message| match &message.body {
        Body::Selected { members, undecided } => {
            outcome.members.extend(&members.0);
            let sums = &mut outcome.undecided;
            sums.resize(sums.len().max(undecided.len()), 0);
            sums.iter_mut().zip(&undecided.0).for_each(|(sum, count)| *sum += count);
            false
        }
        Body::Ledger(words) => {
            outcome.ledger.merge(&LedgerPart::from_words(words).unwrap());
            false
        }
        _ => true,
    });
}

/// A machine without a transport: messages are handed over as they are, the last ones first.
fn run<P: Point>(points: &[P], radii2: &[f64], config: &Arc<WorkerConfig>) -> Outcome {
    let mut first = Running::start(COORDINATOR, config.clone(), None, |cx| root(cx, points, radii2));
    let mut host = Host::<P>::new(1..=config.workers, config, &None);
    let mut wire = first.step().unwrap();
    wire.extend(host.begin().unwrap());
    let (mut steps, mut told, mut phases) = (0, 0, Vec::new());
    for round in 1.. {
        let active = first.busy() || host.busy() || !wire.is_empty();
        if active && host.phase() == Phase::Independent {
            steps += 1;
            told += wire.len();
        }
        wire.reverse();
        let (up, inbox) = std::mem::take(&mut wire).into_iter().partition(|m| m.to == 0);
        first.deliver(round, active.then_some(up));
        wire = first.step().unwrap();
        wire.extend(host.turn(Delivery { inbox, active }).unwrap());
        assert_eq!(first.is_done(), host.is_done());
        if first.is_done() {
            break;
        }
        if !active {
            assert_eq!(first.phase(), host.phase());
            phases.push(host.phase());
        }
    }
    let (mut outcome, ledger) = first.into_result().unwrap();
    (outcome.steps, outcome.told, outcome.phases) = (steps, told, phases);
    outcome.ledger.merge(&ledger);
    outcome
}

/// The greedy algorithm by all pairs.
fn greedy<P: Point>(points: &[P], radii2: &[f64], fixed: usize) -> Vec<u64> {
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

fn checked<P: Point>(points: &[P], radii2: &[f64], what: &str) {
    for (fixed, leaf) in [(0, 30), (0, 10_000), (points.len() / 10, 30)] {
        let expected = greedy(points, radii2, fixed);
        let one = run(points, radii2, &config(fixed as u64, leaf, 1));
        for workers in [1, 2, 5, 8, 64] {
            let what = format!("{what}, {fixed} fixed, leaves of {leaf}, {workers} workers");
            let mut outcome = run(points, radii2, &config(fixed as u64, leaf, workers));
            outcome.members.sort_unstable();
            assert_eq!(outcome.members, expected, "{what}");
            assert_eq!(outcome.undecided, one.undecided, "{what}");
            assert!(outcome.undecided.windows(2).all(|w| w[1] < w[0]), "{what}: {:?}", outcome.undecided);
            // Two steps a round; one before, if there was something to tell; one after, for those that left last.
            let (steps, rounds) = (outcome.steps as usize, 2 * outcome.undecided.len());
            assert!((rounds..=rounds + 2).contains(&steps), "{what}: {steps} steps, {:?}", outcome.undecided);
            assert_eq!(outcome.ledger.edge_hash, one.ledger.edge_hash, "{what}");
            assert_eq!(outcome.phases, PHASES);
            let charge = |key: &(u8, NodeId)| outcome.ledger.charges.get(key);
            for (key, cost) in one.ledger.charges.iter().filter(|c| c.0.0 == Phase::Independent as u8) {
                assert_eq!(charge(key), Some(cost), "{what}: {key:?}");
            }
            let divided = workers > 1 && points.len() > 100 && leaf < 100;
            assert_eq!(outcome.told > 0, divided, "{what}: {} messages", outcome.told);
        }
    }
}

const PHASES: [Phase; 6] =
    [Phase::Partition, Phase::Summaries, Phase::Sets, Phase::Graph, Phase::Independent, Phase::Collect];

fn random(n: usize) -> Vec<DVec3> {
    let mut state = 77u64;
    let mut unit = || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n).map(|_| DVec3::new(unit(), unit(), unit())).collect()
}

#[test]
fn workers_take_the_greedy_set() {
    for n in [0, 1, 2, 3, 10, 600] {
        let cloud = random(n);
        let radius = |degree: f64| (degree / n.max(1) as f64 / 4.19).cbrt();
        let even = vec![radius(12.0) * radius(12.0); n];
        checked(&cloud, &even, "even");
        let rough: Vec<f64> = cloud.iter().map(|p| (1e-3 + 0.5 * p.x * p.y * p.z).powi(2)).collect();
        checked(&cloud, &rough, "rough");
        let plane: Vec<DVec2> = cloud.iter().map(|p| DVec2::new(p.x, p.y)).collect();
        checked(&plane, &vec![0.01; n], "plane");
    }
}

#[test]
fn sets_that_do_not_span_the_space() {
    let cloud = random(600);
    let flat: Vec<DVec3> = cloud.iter().map(|p| DVec3::new(p.x, p.y, 0.5 * p.x - p.y)).collect();
    checked(&flat, &vec![0.0064; 600], "flat");
    let line: Vec<DVec3> = cloud.iter().map(|p| DVec3::new(p.x, 2.0 * p.x, -p.x)).collect();
    checked(&line, &vec![0.0001; 600], "line");
}
