//! The lengths of messages, measured with the codec.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_geometry::separator::SEPARATOR_WORDS;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::NodeId;
use septet_protocol::message::{
    Body, Child, ChosenSupergraph, Decision, Fingerprint, Merged, Message, PROTOCOL_VERSION, PointBatch,
    QueryBatch, ReplyBatch, SampleStars, Summary,
};
use septet_protocol::outcome::Outcome;

/// Sizes in bytes of each kind of message without items, and of one item. Every item has a fixed size.
#[derive(Clone, Copy, Debug)]
pub(super) struct MessageSizes {
    pub(super) start: u64,
    pub(super) block: u64,
    /// A point on its way to its owner.
    pub(super) owned: u64,
    /// A point in any other batch.
    pub(super) point: u64,
    pub(super) samples: u64,
    /// The coordinates of a point.
    pub(super) position: u64,
    pub(super) sphere: u64,
    pub(super) counts: u64,
    pub(super) split: u64,
    pub(super) retry: u64,
    pub(super) moved: u64,
    pub(super) query: u64,
    pub(super) one_query: u64,
    /// A leaf that has balls in a batch.
    pub(super) query_group: u64,
    pub(super) answer: u64,
    pub(super) one_answer: u64,
    pub(super) answer_group: u64,
    /// An entry of a list.
    pub(super) entry: u64,
    pub(super) summary: u64,
    pub(super) children: u64,
    pub(super) frame: u64,
    pub(super) sample_stars: u64,
    pub(super) choice: u64,
    pub(super) ghosts: u64,
    pub(super) reverse: u64,
    pub(super) fingerprint: u64,
    pub(super) list: u64,
    pub(super) propose: u64,
    pub(super) object: u64,
    pub(super) merged: u64,
    pub(super) outcome: u64,
    pub(super) cells: u64,
}

fn length<P: Point>(body: Body<P>) -> u64 {
    let message = Message {
        version: PROTOCOL_VERSION,
        run: 0,
        from: 0,
        to: 0,
        node: NodeId::ROOT,
        attempt: 0,
        round: 0,
        sequence: 0,
        body,
    };
    message.encoded_len() as u64
}

fn points<P: Point>(count: usize) -> PointBatch<P> {
    let mut batch = PointBatch::default();
    (0..count).for_each(|_| batch.push(0, P::splat(0.0), 0, 0.0));
    batch
}

impl MessageSizes {
    pub(super) fn of<P: Point>() -> Self {
        let none = || points::<P>(0);
        let child = Child { population: 0, first: 0, ranks: 0, leaf: false };
        let summary = || Summary { max_radius2: 0.0, smallest: points::<P>(1) };
        let corners = || Bulk(vec![P::splat(0.0); 4]);
        let queries = |n: usize, groups: usize| QueryBatch {
            slots: Bulk(vec![0; n]),
            centres: Bulk(vec![P::splat(0.0); n]),
            radii2: Bulk(vec![0.0; n]),
            groups: Bulk(vec![0; groups]),
            probe: false,
            wanted: 0,
        };
        let answers = |n: usize, groups: usize, entries: usize| ReplyBatch {
            slots: Bulk(vec![0; n]),
            counts: Bulk(vec![0; n]),
            groups: Bulk(vec![0; groups]),
            sizes: Bulk(vec![0; groups]),
            places: Bulk(vec![0; entries]),
            points: none(),
        };
        let (block, ghosts) = (length(Body::Block(none())), length(Body::Ghosts(none())));
        let in_transit = PointBatch::in_transit(vec![0], vec![P::splat(0.0)]);
        let query = length(Body::Query(queries(0, 0)));
        let answer = length(Body::Reply(answers(0, 0, 0)));
        MessageSizes {
            start: length(Body::Start { population: 0, frame: points::<P>(P::DIM + 1) }),
            block,
            owned: length(Body::Block(in_transit)) - block,
            point: length(Body::Ghosts(points::<P>(1))) - ghosts,
            samples: length::<P>(Body::Samples(Bulk(Vec::new()))),
            position: size_of::<P>() as u64,
            sphere: length::<P>(Body::Sphere(Bulk(vec![0.0; SEPARATOR_WORDS]))),
            counts: length(Body::Counts { inside: 0, outside: 0, boxes: corners() }),
            split: length(Body::Decision { decision: Decision::Split([child; 2]), boxes: corners() }),
            retry: length::<P>(Body::Decision { decision: Decision::Retry, boxes: Bulk(Vec::new()) }),
            moved: length(Body::Move(none())),
            query,
            one_query: length(Body::Query(queries(1, 0))) - query,
            query_group: length(Body::Query(queries(0, 1))) - query,
            answer,
            one_answer: length(Body::Reply(answers(1, 0, 0))) - answer,
            answer_group: length(Body::Reply(answers(0, 1, 0))) - answer,
            entry: length(Body::Reply(answers(0, 0, 1))) - answer,
            summary: length(Body::Summary(summary())),
            children: length(Body::Children(Box::new([summary(), summary()]))),
            frame: length(Body::Frame(none())),
            sample_stars: length::<P>(Body::SampleStars(SampleStars::default())),
            choice: length::<P>(Body::Choice(ChosenSupergraph(Supergraph::Density { alpha: 0.0 }))),
            ghosts,
            reverse: length(Body::Reverse {
                points: none(),
                counts: Bulk(Vec::new()),
                targets: Bulk(Vec::new()),
            }),
            fingerprint: length::<P>(Body::Fingerprint(Fingerprint::default())),
            list: length::<P>(Body::FingerprintList(Bulk(Vec::new()))),
            propose: length(Body::Propose { points: none(), cells: Bulk(Vec::new()) }),
            object: length(Body::Object {
                points: none(),
                cells: Bulk(Vec::new()),
                counts: Bulk(Vec::new()),
                conflicts: Bulk(Vec::new()),
            }),
            merged: length::<P>(Body::Merged(Merged::default())),
            outcome: length::<P>(Body::Outcome(Outcome::default())),
            cells: length::<P>(Body::Cells { cells: Bulk(Vec::new()), leaves: Bulk(Vec::new()) }),
        }
    }
}
