use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::graph::Supergraph;
use septet_geometry::hash::Draw;
use septet_geometry::range::Digits;
use septet_protocol::codec::Bulk;
use septet_protocol::message::{PointBatch, PointSum, Survey};

use super::*;
use crate::config::{Task, Wanted};
use crate::input::{Rows, Source};
use crate::partition::leader::Plan;
use crate::programs::run;
use crate::programs::tests::{selecting, ways};
use crate::share::Share;

/// No plan of the placement.
static NO_PLAN: Plan = Plan::new();

type Journal = BTreeMap<Rank, Vec<Option<Vec<Message<DVec3>>>>>;

fn random(n: usize) -> Vec<DVec3> {
    let mut draw = Draw::new(77);
    (0..n).map(|_| draw.point()).collect()
}

fn config(workers: u32, counted: bool) -> Arc<WorkerConfig> {
    let wanted = Wanted::Fixed(Supergraph::Density { alpha: 2.5 });
    let mut config = WorkerConfig { workers, counted, ..WorkerConfig::plain() };
    (config.tree.leaf, config.graph.wanted) = (12, wanted);
    Arc::new(config)
}

/// The points of a run, in blocks.
struct Points(Vec<DVec3>);

impl Source<DVec3> for Points {
    fn block(&self, block: u32, blocks: u32) -> Rows<DVec3> {
        // Independent sets take the sizes from the input.
        Rows::of_whole(0, &self.0, &vec![0.1; self.0.len()], block, blocks)
    }
}

/// A rank that has not begun.
fn started<'a>(
    config: &Arc<WorkerConfig>,
    rank: Rank,
    points: &'a Points,
) -> Running<'a, DVec3, Share<DVec3>> {
    Running::start(rank, config.clone(), None, |cx| run(cx, points, &NO_PLAN))
}

/// Runs the machine until all ranks are done. Returns the messages that every rank received, and the messages of each round.
fn record(config: &Arc<WorkerConfig>, points: &Points) -> (Journal, Vec<Vec<Message<DVec3>>>) {
    let mut ranks: Vec<_> = (0..config.ranks()).map(|rank| started(config, rank, points)).collect();
    let (mut journal, mut sent) = (Journal::new(), Vec::new());
    for round in 1.. {
        let mut wire = Vec::new();
        for rank in &mut ranks {
            wire.extend(rank.step().unwrap());
        }
        if ranks.iter().all(Running::is_done) {
            let shares: Vec<_> = ranks.into_iter().filter_map(Running::into_result).collect();
            let certified = shares[0].certified.totals.merged;
            let stars = if config.task == Task::Delaunay { points.0.len() as u64 } else { 0 };
            assert_eq!((certified.stars, certified.disagreements), (stars, 0));
            assert!(stars > 0 || shares.iter().any(|share| !share.selected.members.is_empty()));
            break;
        }
        let active = ranks.iter().any(Running::busy) || !wire.is_empty();
        let mut inbox_of = |rank: Rank| {
            let inbox = wire.iter().rev().filter(|m| m.to == rank).cloned().collect();
            let inbox = active.then_some(inbox);
            journal.entry(rank).or_default().push(inbox.clone());
            inbox
        };
        for rank in &mut ranks {
            rank.deliver(round, inbox_of(rank.rank()));
        }
        sent.push(wire);
    }
    (journal, sent)
}

/// Rebuilds a rank that is lost in round `lost`, and compares its messages from that round on with those of the
/// original.
fn rebuild<T>(
    mut rebuilt: Running<'_, DVec3, T>,
    deliveries: &[Option<Vec<Message<DVec3>>>],
    sent: &[Vec<Message<DVec3>>],
    lost: usize,
) {
    let rank = rebuilt.rank();
    for (round, inbox) in (1..).zip(&deliveries[..lost]) {
        rebuilt.step().unwrap();
        rebuilt.deliver(round, inbox.clone());
    }
    for (at, inbox) in deliveries.iter().enumerate().skip(lost) {
        let expected = sent[at].iter().filter(|m| m.from == rank);
        assert!(rebuilt.step().unwrap().iter().eq(expected), "rank {rank}, round {at}, from {lost}");
        rebuilt.deliver(at as u32 + 1, inbox.clone());
    }
}

/// Discards every rank in every round of a run and rebuilds it. Returns the number of rounds.
fn rebuild_all(config: &Arc<WorkerConfig>, points: &Points) -> usize {
    let (journal, sent) = record(config, points);
    for (&rank, deliveries) in &journal {
        for lost in 0..deliveries.len() {
            rebuild(started(config, rank, points), deliveries, &sent, lost);
        }
    }
    sent.len()
}

/// Any rank, including rank 0, can be lost in any round of a run. Rebuilt from its deliveries, it continues as
/// before.
#[test]
fn a_rank_is_rebuilt_from_its_journal() {
    let points = Points(random(500));
    for counted in [false, true] {
        let rounds = rebuild_all(&config(5, counted), &points);
        assert!(rounds >= 30, "{rounds} rounds");
    }
}

/// A rank is rebuilt in every phase: with every rule of separator sets, both corrections and gathering, in `triangulate`, and in
/// the selection of an independent set.
#[test]
fn a_rank_is_rebuilt_in_every_phase() {
    let points = Points(random(150));
    for (name, mut config) in ways(3).into_iter().chain([("independent", selecting(3))]) {
        config.tree.leaf = if name == "whole" { 10_000 } else { 20 };
        let rounds = rebuild_all(&Arc::new(config), &points);
        println!("{name}: {rounds} rounds");
        assert!(rounds >= 4, "{name}: {rounds} rounds");
    }
}

/// A message of another phase is refused. A dialogue in which no rank sends a message is an error and does not hang.
#[test]
fn what_has_no_place_is_refused() {
    let config = config(2, false);
    let points = Points(random(10));
    let deliver = |bodies: Vec<Option<Vec<Body<DVec3>>>>| {
        let mut rank = started(&config, 1, &points);
        rank.step().unwrap();
        let mut outcome = Ok(Vec::new());
        for (round, bodies) in (1..).zip(bodies) {
            let mut out = Outbox::new(config.run, 2);
            bodies.iter().flatten().for_each(|body| out.send(1, NodeId::ROOT, 0, body.clone()));
            let inbox = out.take(Phase::Load, &mut LedgerPart::default());
            rank.deliver(round, bodies.is_some().then_some(inbox));
            outcome = rank.step();
            if outcome.is_err() {
                break;
            }
        }
        outcome.unwrap_err().to_string()
    };
    // Load: the survey goes up and comes down, no hashes are equal, and the points and the frame do the same.
    let digits = Digits::upper_bound(&points.0).unwrap().ends();
    let survey =
        || Some(vec![Body::Survey(Survey { rows: 10, first: 0, last: 9, digits, ..Survey::default() })]);
    let population = PointSum { count: 100, hash: 0 };
    let mut frame = PointBatch::default();
    for (id, &x) in (0..).zip(&points.0[..4]) {
        frame.push(id, x, 0, f64::INFINITY);
    }
    let start = || Some(vec![Body::Start { population, frame: frame.clone() }]);
    let load = || vec![Some(vec![]), survey(), Some(vec![]), None, Some(vec![]), start(), None];
    let late = deliver([load(), vec![Some(vec![Body::Gather(PointBatch::default())])]].concat());
    assert_eq!(late, "bad message from rank 2: it has no place in phase partition");
    let silent = deliver([load(), vec![Some(vec![]), None]].concat());
    assert_eq!(silent, "worker 1 failed: no rank sent a message in the middle of phase partition");
    let twice = vec![Some(vec![]), Some(vec![Body::Sphere(Bulk(vec![]))])];
    // Rank 1 leads the root, so it also receives the separator that it sends to itself.
    let again = deliver([load(), twice].concat());
    assert_eq!(again, "worker 1 failed: 2 messages instead of one in phase partition");
}

/// The memory of a rank apart from its points. All phases share the space of the largest.
#[test]
fn futures_are_small() {
    let all = |cx: Context<DVec3>| async move {
        let mut cx = cx;
        let exchange = size_of_val(&cx.exchange());
        let sizes = [size_of_val(&cx), exchange, size_of_val(&run(cx, &Points(Vec::new()), &NO_PLAN))];
        println!("context, exchange, work: {sizes:?}");
        Ok(sizes[2])
    };
    let mut rank = Running::start(1, config(1, true), None, all);
    rank.step().unwrap();
    assert!(rank.into_result().unwrap() < 16 << 10);
}
