//! Tests of replies from two ranks to one ball, and of inconsistent replies.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use glam::DVec2;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::Phase;
use septet_protocol::message::{PROTOCOL_VERSION, PointBatch};

use super::*;
use crate::config::WorkerConfig;
use crate::machine::context::Running;

/// Returns points of another rank at the positions `xs` on the first axis.
fn points(xs: &[u64]) -> PointBatch<DVec2> {
    let mut points = PointBatch::default();
    for &x in xs {
        points.push(x, DVec2::new(x as f64, 0.0), 2, f64::INFINITY);
    }
    points
}

/// A point, the squared radius of its list, and the ids of its list.
type Found = (u32, f64, Vec<u64>);

/// Runs a rank that owns a point at the origin, whose ball waits for two replies. The rank receives the messages
/// `bodies` in one round. Returns the lists of the rank.
fn receive(bodies: Vec<Body<DVec2>>) -> Result<Vec<Found>, TransportError> {
    let config = Arc::new(WorkerConfig { workers: 2, ..WorkerConfig::plain() });
    let run = config.run;
    let lists = Rc::new(RefCell::new(Vec::new()));
    let mut rank = Running::start(1, config, None, |cx| waiting(cx, lists.clone()));
    rank.step()?;
    let inbox = (0..).zip(bodies).map(|(sequence, body)| Message {
        version: PROTOCOL_VERSION,
        run,
        from: 2,
        to: 1,
        node: NodeId::ROOT,
        attempt: 0,
        round: 0,
        sequence,
        body,
    });
    rank.deliver(1, Some(inbox.collect()));
    rank.step()?;
    rank.deliver(2, None);
    rank.step()?;
    assert!(rank.is_done());
    Ok(lists.take())
}

async fn waiting(mut cx: Context<DVec2>, lists: Rc<RefCell<Vec<Found>>>) -> Result<(), TransportError> {
    cx.enter(Phase::Knn)?;
    let subdomain = Subdomain::default();
    let mut table = Table::of_owned(vec![0], vec![DVec2::ZERO], 1);
    let search = Search { phase: Phase::Knn, wanted: 3, probe: false, own_leaf: false, everywhere: false };
    let mut descent = Descent::new(&subdomain, search, &[]);
    descent.pending.push(WaitingBall { outstanding: 2, ..WaitingBall::of_owned(0, DVec2::ZERO, 25.0) });
    let complete = descent.run(&mut cx, &mut table).await?;
    let ids = |list: &[u32]| list.iter().map(|&j| table.ids()[j as usize]).collect();
    lists
        .borrow_mut()
        .extend(complete.iter().map(|nearest| (nearest.point, nearest.kth2, ids(nearest.list))));
    Ok(())
}

/// Returns two replies to the ball. In the first, the list belongs to the second group. The ball keeps the three
/// nearest points of both replies.
fn replies() -> [ReplyBatch<DVec2>; 2] {
    let first = ReplyBatch {
        slots: Bulk(vec![0]),
        counts: Bulk(vec![3]),
        groups: Bulk(vec![0, 1]),
        sizes: Bulk(vec![1, 3]),
        places: Bulk(vec![2, 0, 1]),
        points: points(&[9, 4, 1, 3]),
    };
    let second = ReplyBatch {
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
fn the_parts_of_a_list_are_joined() {
    let lists = receive(replies().map(Body::Reply).into()).unwrap();
    assert_eq!(lists, [(0, 9.0, vec![3, 1, 2])]);
}

#[test]
fn an_inconsistent_reply_is_refused() {
    let spoil: [fn(&mut ReplyBatch<DVec2>); 3] =
        [|a| a.places[0] = 3, |a| a.counts[0] = 4, |a| a.points.owners.0.truncate(3)];
    for spoil in spoil {
        let [mut first, _] = replies();
        spoil(&mut first);
        refused(receive(vec![Body::Reply(first)]), "fit together");
    }
    let query = QueryBatch { slots: Bulk(vec![1]), wanted: 3, ..QueryBatch::default() };
    refused(receive(vec![Body::Query(query)]), "fit together");
}

/// In one phase, all ranks have the same search.
#[test]
fn a_query_of_another_search_is_refused() {
    let same = QueryBatch { wanted: 3, ..QueryBatch::default() };
    assert!(receive(vec![Body::Query(same.clone())]).is_ok());
    for other in [QueryBatch { wanted: 2, ..same.clone() }, QueryBatch { probe: true, ..same }] {
        refused(receive(vec![Body::Query(other)]), "it has no place in phase knn");
    }
}

/// Slot 7 is unused, and slot 0 has received all its replies.
#[test]
fn a_reply_to_no_query_is_refused() {
    for slot in [0, 7] {
        let [first, second] = replies();
        let mut third = second.clone();
        third.slots[0] = slot;
        refused(receive([first, second, third].map(Body::Reply).into()), "not sent");
    }
}

fn refused<T>(result: Result<T, TransportError>, why: &str) {
    let Err(error) = result else { panic!("the reply was accepted") };
    assert!(matches!(error, TransportError::BadMessage { from: 2, .. }), "{error}");
    assert!(error.to_string().contains(why), "{error}");
}
