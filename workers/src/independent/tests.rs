use std::sync::Arc;

use glam::{DVec2, DVec3};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::dist2;

use super::*;
use crate::config::{Correction, Partition, SetRule, Stop, Wanted, WorkerConfig};
use septet_protocol::message::{PROTOCOL_VERSION, PointBatch};

fn config(fixed: u64, leaf: u64) -> Arc<WorkerConfig> {
    Arc::new(WorkerConfig {
        run: 1,
        seed: 5,
        task: Task::Independent { fixed },
        workers: 1,
        leaf,
        counted: true,
        wanted: Wanted::Fixed(Supergraph::Density { alpha: 1.0 }),
        sets: SetRule::Ghost,
        collect_graph: false,
        until: None,
        with_leaves: false,
        view: 0,
        exchange_cap: None,
        partition: Partition::Sphere,
        correction: Correction::Descent,
        record_tasks: false,
        fault: None,
        stop: Stop::default(),
    })
}

/// What one worker sends of the set, the phases it went through, and its steps in that of the set.
struct Outcome {
    members: Vec<u64>,
    undecided: Vec<u64>,
    phases: Vec<Phase>,
    steps: u32,
}

fn run<P: Point>(points: &[P], radii2: &[f64], fixed: u64, leaf: u64) -> Outcome {
    let n = points.len() as u64;
    let block = PointBatch {
        ids: Bulk((0..n).collect()),
        positions: Bulk(points.to_vec()),
        owners: Bulk(vec![1; points.len()]),
        radii2: Bulk(radii2.to_vec()),
    };
    let message = |sequence: u32, body: Body<P>| Message {
        version: PROTOCOL_VERSION,
        run: 1,
        from: COORDINATOR,
        to: 1,
        node: NodeId::ROOT,
        attempt: 0,
        round: 0,
        sequence,
        body,
    };
    let mut worker = Worker::new(1, config(fixed, leaf), None);
    let start = Body::Start { population: n, frame: PointBatch::default() };
    let mut sent = worker.step(1, vec![message(0, start), message(1, Body::Block(block))]).unwrap();
    let mut outcome = Outcome { members: Vec::new(), undecided: Vec::new(), phases: Vec::new(), steps: 0 };
    for round in 2.. {
        for message in std::mem::take(&mut sent) {
            if let Body::Selected { members, undecided } = message.body {
                (outcome.members, outcome.undecided) = (members.0, undecided.0);
            }
        }
        if worker.busy() {
            outcome.steps += u32::from(worker.phase == Phase::Independent);
            sent = worker.step(round, Vec::new()).unwrap();
        } else {
            let phase = worker.next_phase();
            if phase == Phase::Done {
                break;
            }
            outcome.phases.push(phase);
            sent = worker.begin(phase, round).unwrap();
        }
    }
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
        let outcome = run(points, radii2, fixed as u64, leaf);
        let mut members = outcome.members;
        members.sort_unstable();
        assert_eq!(members, greedy(points, radii2, fixed), "{what}, {fixed} fixed, leaves of {leaf}");
        assert!(outcome.undecided.windows(2).all(|w| w[1] < w[0]), "{what}: {:?}", outcome.undecided);
        // Two steps a round.
        assert_eq!(outcome.steps as usize, 2 * outcome.undecided.len(), "{what}");
        let phases = [
            Phase::Partition,
            Phase::Summaries,
            Phase::Sets,
            Phase::Graph,
            Phase::Independent,
            Phase::Collect,
        ];
        assert_eq!(outcome.phases, phases);
    }
}

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
fn one_worker_takes_the_greedy_set() {
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
