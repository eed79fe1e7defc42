use super::*;

#[test]
fn encoded_len_is_exact_and_messages_round_trip() {
    let mut batch = PointBatch::default();
    batch.push(3, [1.0f64, 2.0], 1, 0.5);
    assert!(batch.is_consistent());
    let bodies = [
        Body::Move(batch.clone()),
        Body::Samples(Bulk(vec![[0.0, 1.0]])),
        Body::Copies(PointBatch::in_transit(vec![4], vec![[0.5, 1.0]])),
        Body::Splits(SplitBatch {
            nodes: Bulk(vec![1]),
            interior: Bulk(vec![2]),
            separators: Bulk(vec![0.25; 9]),
            boxes: Bulk(vec![[0.0, 1.0]; 4]),
        }),
        Body::Decision {
            decision: Decision::Split([Child { population: 1, first: 2, ranks: 3, leaf: true }; 2]),
            boxes: Bulk(vec![[0.0, 0.0]; 4]),
            routes: Box::new([
                Route { receivers: Bulk(vec![2, 4]), counts: Bulk(vec![7, 1]) },
                Route::default(),
            ]),
        },
        Body::BranchDecision {
            decision: Decision::Leaf,
            boxes: Bulk(Vec::new()),
            routes: RouteBatch::of(&[
                [Route { receivers: Bulk(vec![2, 4]), counts: Bulk(vec![7, 1]) }, Route::default()],
                [Route::default(), Route { receivers: Bulk(vec![3]), counts: Bulk(vec![5]) }],
            ]),
        },
        Body::BranchCounts {
            inside: Bulk(vec![3, 1]),
            outside: Bulk(vec![4, 0]),
            boxes: Bulk(vec![[0.0, 0.0]; 4]),
        },
        Body::Merged(Merged { cells: 4, ..Merged::default() }),
        Body::Totals(Box::new(Totals { cell_hash: 5, balance: u64::MAX, ..Totals::default() })),
        Body::Sites(SiteTotals { heaviest: -0.5, hidden: 7 }),
        Body::Outcome(crate::outcome::Outcome::GatherUnresolved),
        Body::Joined(Bulk(vec![7, 1 << 40])),
        Body::Left(Bulk(Vec::new())),
    ];
    for body in bodies {
        let message = Message {
            version: PROTOCOL_VERSION,
            run: 9,
            from: 1,
            to: 0,
            node: NodeId::ROOT,
            attempt: 0,
            round: 4,
            sequence: 2,
            body,
        };
        let bytes = message.encode().unwrap();
        assert_eq!(bytes.len(), message.encoded_len());
        assert_eq!(Message::decode(&bytes).unwrap(), message);
        for cut in 0..bytes.len() {
            assert!(Message::<[f64; 2]>::decode(&bytes[..cut]).is_err());
        }
    }
}

/// The checks detect every array that is one entry too short or too long.
#[test]
fn batches_of_queries_and_answers_fit_together_or_not() {
    let query = QueryBatch::<[f64; 3]> {
        slots: Bulk(vec![4, 5, 6]),
        centres: Bulk(vec![[0.0; 3]; 3]),
        radii2: Bulk(vec![1.0; 3]),
        groups: Bulk(vec![2, 0, 1]),
        ..QueryBatch::default()
    };
    assert!(query.is_consistent() && QueryBatch::<[f64; 3]>::default().is_consistent());
    let spoil: [fn(&mut QueryBatch<[f64; 3]>); 4] =
        [|q| q.slots.push(7), |q| q.centres.0.truncate(2), |q| q.radii2.push(1.0), |q| q.groups[1] = 1];
    for spoil in spoil {
        let mut spoilt = query.clone();
        spoil(&mut spoilt);
        assert!(!spoilt.is_consistent());
    }
    let mut points = PointBatch::default();
    (0..3).for_each(|id| points.push(id, [0.0; 3], 1, 1.0));
    let answer = ReplyBatch {
        slots: Bulk(vec![4, 5, 6]),
        counts: Bulk(vec![2, 1, 0]),
        groups: Bulk(vec![1, 2]),
        sizes: Bulk(vec![2, 1]),
        places: Bulk(vec![1, 0, 0]),
        points,
    };
    assert!(answer.is_consistent() && ReplyBatch::<[f64; 3]>::default().is_consistent());
    // A group that found nothing.
    let nothing = ReplyBatch::<[f64; 3]> {
        slots: Bulk(vec![4, 5]),
        counts: Bulk(vec![0; 2]),
        groups: Bulk(vec![2]),
        sizes: Bulk(vec![0]),
        ..ReplyBatch::default()
    };
    assert!(nothing.is_consistent());
    let spoil: [fn(&mut ReplyBatch<[f64; 3]>); 10] = [
        |a| a.slots.push(7),
        |a| a.counts.push(0),
        |a| a.counts[2] = 1,
        |a| a.counts[0] = u32::MAX,
        |a| a.groups[0] = 2,
        |a| a.groups.push(0),
        |a| a.sizes[1] = 2,
        |a| a.places[2] = 1,
        |a| a.places.push(0),
        |a| a.points.positions.0.truncate(2),
    ];
    for spoil in spoil {
        let mut spoilt = answer.clone();
        spoil(&mut spoilt);
        assert!(!spoilt.is_consistent());
    }
}

#[test]
fn routes_survive_in_batches() {
    let route = |receivers: &[Rank]| Route {
        receivers: Bulk(receivers.to_vec()),
        counts: Bulk(receivers.iter().map(|&rank| u64::from(rank) + 7).collect()),
    };
    for routes in [
        vec![],
        vec![[route(&[]), route(&[])]],
        vec![[route(&[1, 2]), route(&[])], [route(&[3]), route(&[1, 4])]],
    ] {
        assert_eq!(RouteBatch::of(&routes).to_routes(), routes);
    }
    let mut spoilt = RouteBatch::of(&[[route(&[1, 2]), route(&[3])]]);
    spoilt.lengths[0] = u32::MAX;
    assert!(!spoilt.is_consistent() && spoilt.to_routes().is_empty());
}
