use std::collections::BTreeMap;

use glam::DVec3;
use septet_geometry::graph::Supergraph;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::COORDINATOR;
use septet_protocol::message::PointBatch;

use super::*;
use crate::config::Wanted;
use crate::partition::leader::Plan;
use crate::worker::{Worker, work};
use crate::{frame, partition, summaries};

type Journal = BTreeMap<Rank, Vec<Option<Vec<Message<DVec3>>>>>;

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

fn config(workers: u32, counted: bool) -> Arc<WorkerConfig> {
    let wanted = Wanted::Fixed(Supergraph::Density { alpha: 2.5 });
    Arc::new(WorkerConfig { workers, leaf: 12, counted, wanted, ..WorkerConfig::plain() })
}

/// What rank 0 runs, up to the phases that these tests are about.
async fn root(mut cx: Context<DVec3>, points: Vec<DVec3>) -> Result<(), TransportError> {
    let p = cx.config.workers as usize;
    for rank in 1..=p {
        let range = points.len() * (rank - 1) / p..points.len() * rank / p;
        let ids = range.clone().map(|i| i as u64).collect();
        let block = PointBatch::homeless(ids, points[range].to_vec());
        let mut frame = PointBatch::default();
        (0..4).for_each(|i| frame.push(i as u64, points[i], COORDINATOR, f64::INFINITY));
        let population = points.len() as u64;
        cx.send(rank as Rank, NodeId::ROOT, 0, Body::Start { population, frame });
        cx.send(rank as Rank, NodeId::ROOT, 0, Body::Block(block));
    }
    while cx.exchange().await? {}
    let led = partition::lead_root(&mut cx, points.len() as u64, Plan::new()).await?;
    if cx.config.counted {
        for phase in [Phase::Radii, Phase::Probe, Phase::Neighbours] {
            cx.enter(phase)?;
            while cx.exchange().await? {}
        }
        return summaries::lead_root(&mut cx, &led).await;
    }
    cx.enter(Phase::Halo)?;
    let mut known = PointBatch::default();
    while cx.exchange().await? {
        frame::collect(&mut cx, &mut known);
    }
    Ok(())
}

/// Runs the machine until rank 0 is done; returns what every rank was delivered, and what each sent in each round.
fn run(config: &Arc<WorkerConfig>) -> (Journal, Vec<Vec<Message<DVec3>>>) {
    let mut ranks = vec![Running::start(0, config.clone(), None, |cx| root(cx, random(900)))];
    ranks.extend((1..=config.workers).map(|rank| Running::start(rank, config.clone(), None, work::<DVec3>)));
    let (mut journal, mut sent) = (Journal::new(), Vec::new());
    for round in 1.. {
        let wire: Vec<Vec<_>> = ranks.iter_mut().map(|rank| rank.step().unwrap()).collect();
        if ranks[0].is_done() {
            break;
        }
        let active = ranks.iter().any(Running::busy) || wire.iter().any(|sent| !sent.is_empty());
        for rank in &mut ranks {
            let inbox = wire.iter().flatten().rev().filter(|m| m.to == rank.rank()).cloned().collect();
            let inbox = active.then_some(inbox);
            journal.entry(rank.rank()).or_default().push(inbox.clone());
            rank.deliver(round, inbox);
        }
        sent.push(wire.concat());
    }
    (journal, sent)
}

/// A rank that is lost in any round is rebuilt from what it was delivered, and goes on as it would have.
#[test]
fn a_rank_is_rebuilt_from_its_journal() {
    for counted in [false, true] {
        let config = config(7, counted);
        let (journal, sent) = run(&config);
        assert!(sent.len() >= 20, "{} rounds", sent.len());
        for (&rank, deliveries) in journal.iter().filter(|(rank, _)| **rank > 0) {
            for lost in 0..deliveries.len() {
                let mut rebuilt = Running::start(rank, config.clone(), None, work::<DVec3>);
                for (round, inbox) in (1..).zip(&deliveries[..lost]) {
                    rebuilt.step().unwrap();
                    rebuilt.deliver(round, inbox.clone());
                }
                for (at, inbox) in deliveries.iter().enumerate().skip(lost) {
                    let expected = sent[at].iter().filter(|m| m.from == rank);
                    assert!(
                        rebuilt.step().unwrap().iter().eq(expected),
                        "rank {rank}, round {at}, from {lost}"
                    );
                    rebuilt.deliver(at as u32 + 1, inbox.clone());
                }
            }
        }
    }
}

/// What belongs to another phase is refused; a dialogue in which nobody speaks is an error, and no hang.
#[test]
fn what_has_no_place_is_refused() {
    let config = config(2, false);
    let deliver = |bodies: Vec<Option<Vec<Body<DVec3>>>>| {
        let mut rank = Running::start(1, config.clone(), None, work::<DVec3>);
        rank.step().unwrap();
        let mut outcome = Ok(Vec::new());
        for (round, bodies) in (1..).zip(bodies) {
            let mut out = Outbox::new(config.run, 2);
            bodies.iter().flatten().for_each(|body| out.send(1, NodeId::ROOT, 0, body.clone()));
            let inbox = out.take(Phase::Load, &mut LedgerPart::default());
            rank.deliver(round, bodies.is_some().then_some(inbox));
            outcome = rank.step();
        }
        outcome.unwrap_err().to_string()
    };
    let start = || Some(vec![Body::Start { population: 100, frame: PointBatch::default() }]);
    let late = deliver(vec![start(), None, Some(vec![Body::Block(PointBatch::default())])]);
    assert_eq!(late, "bad message from rank 2: it has no place in phase partition");
    let silent = deliver(vec![start(), None, Some(vec![]), None]);
    assert_eq!(silent, "worker 1 failed: nothing was said in the middle of phase partition");
    let twice = Body::Sphere(Bulk(vec![]));
    let twice = deliver(vec![start(), None, Some(vec![]), Some(vec![twice.clone(), twice])]);
    assert_eq!(twice, "worker 1 failed: 2 messages in phase partition where there is one");
}

/// The memory of a rank beside its points: all phases share the room of the largest.
#[test]
fn futures_are_small() {
    let all = |cx: Context<DVec3>| async move {
        let mut cx = cx;
        let mut subdomain = crate::state::subdomain::Subdomain::default();
        let (mut table, mut frame) = (crate::state::table::Table::default(), PointBatch::default());
        let context = size_of_val(&cx);
        let exchange = size_of_val(&cx.exchange());
        let partition = size_of_val(&partition::partition(&mut cx, 0, PointBatch::default()));
        let halo = size_of_val(&crate::direct::halo::halo(&mut cx, &subdomain, &mut table, &mut frame));
        let summaries = size_of_val(&summaries::summaries(&mut cx, &mut subdomain, &mut table, &mut frame));
        let sizes = [
            context,
            exchange,
            partition,
            halo,
            summaries,
            size_of_val(&work(cx)),
            size_of::<Worker<DVec3>>(),
        ];
        println!("context, exchange, partition, halo, summaries, work, Worker: {sizes:?}");
        Ok(sizes[5])
    };
    let mut rank = Running::start(1, config(1, true), None, all);
    rank.step().unwrap();
    assert!(rank.into_result().unwrap() < 16 << 10);
}
