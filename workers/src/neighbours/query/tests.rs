//! Answers of two workers to one ball, and those that do not fit together.

use std::sync::Arc;

use glam::DVec2;
use septet_protocol::codec::Bulk;
use septet_protocol::message::{PROTOCOL_VERSION, PointBatch};

use super::*;
use crate::config::WorkerConfig;
use crate::state::table::Table;

/// Points of another worker on the first axis, at these places.
fn points(places: &[u64]) -> PointBatch<DVec2> {
    let mut points = PointBatch::default();
    for &place in places {
        points.push(place, DVec2::new(place as f64, 0.0), 2, f64::INFINITY);
    }
    points
}

/// A worker with a point at the origin whose ball waits for two answers.
fn waiting() -> Worker<DVec2> {
    let mut worker = Worker::new(1, Arc::new(WorkerConfig::plain()), None);
    worker.table = Table::of_home(vec![0], vec![DVec2::ZERO], 1);
    worker.phase = Phase::Knn;
    worker.ask_afresh(Ask { wanted: 3, ..Ask::default() });
    worker.engine.await_answer(0, DVec2::ZERO, 25.0);
    worker.engine.pending[0].outstanding = 2;
    worker
}

fn message(worker: &Worker<DVec2>, from: Rank, sequence: u32, batch: AnswerBatch<DVec2>) -> Message<DVec2> {
    Message {
        version: PROTOCOL_VERSION,
        run: worker.config.run,
        from,
        to: 1,
        node: NodeId::ROOT,
        attempt: 0,
        round: 0,
        sequence,
        body: Body::Answer(batch),
    }
}

/// The list of the first is in its second group, the second one's alone; the ball keeps its three nearest of both.
fn answers() -> [AnswerBatch<DVec2>; 2] {
    let first = AnswerBatch {
        slots: Bulk(vec![0]),
        counts: Bulk(vec![3]),
        groups: Bulk(vec![0, 1]),
        sizes: Bulk(vec![1, 3]),
        places: Bulk(vec![2, 0, 1]),
        points: points(&[9, 4, 1, 3]),
    };
    let second = AnswerBatch {
        slots: Bulk(vec![0]),
        counts: Bulk(vec![1]),
        groups: Bulk(vec![1]),
        sizes: Bulk(vec![1]),
        places: Bulk(vec![0]),
        points: points(&[2]),
    };
    [first, second]
}

#[test]
fn the_parts_of_a_list_come_together() {
    let mut worker = waiting();
    let [first, second] = answers();
    let inbox = vec![message(&worker, 2, 0, first), message(&worker, 3, 0, second)];
    worker.step(1, inbox).unwrap();
    let done = worker.land(Phase::Knn);
    let lists: Vec<_> = done.iter().collect();
    let [(home, kth2, list)] = lists[..] else { panic!("{} lists", lists.len()) };
    let ids: Vec<u64> = list.iter().map(|&j| worker.table.ids[j as usize]).collect();
    assert_eq!((home, kth2, ids), (0, 9.0, vec![3, 1, 2]));
}

#[test]
fn an_answer_that_does_not_fit_together_is_refused() {
    let spoil: [fn(&mut AnswerBatch<DVec2>); 3] =
        [|a| a.places[0] = 3, |a| a.counts[0] = 4, |a| a.points.owners.0.truncate(3)];
    for spoil in spoil {
        let mut worker = waiting();
        let [mut first, _] = answers();
        spoil(&mut first);
        let inbox = vec![message(&worker, 2, 0, first)];
        refused(worker.step(1, inbox), "fit together");
    }
    let mut worker = waiting();
    let mut query = message(&worker, 2, 0, answers().into_iter().next().unwrap());
    query.body = Body::Query(QueryBatch { slots: Bulk(vec![1]), ..QueryBatch::default() });
    refused(worker.step(1, vec![query]), "fit together");
}

/// One query is not there, one has had all its answers.
#[test]
fn what_was_not_asked_is_not_answered() {
    for slot in [0, 7] {
        let mut worker = waiting();
        let [first, second] = answers();
        let mut third = second.clone();
        third.slots[0] = slot;
        let batches = (0..).zip([first, second, third]);
        let inbox = batches.map(|(sequence, batch)| message(&worker, 2, sequence, batch)).collect();
        refused(worker.step(1, inbox), "not asked");
    }
}

fn refused<T>(result: Result<T, TransportError>, why: &str) {
    let Err(error) = result else { panic!("it was taken") };
    assert!(matches!(error, TransportError::BadMessage { from: 2, .. }), "{error}");
    assert!(error.to_string().contains(why), "{error}");
}
