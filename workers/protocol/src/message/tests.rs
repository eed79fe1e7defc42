use super::*;

#[test]
fn encoded_len_is_exact_and_messages_round_trip() {
    let mut batch = PointBatch::default();
    batch.push(3, [1.0f64, 2.0], 1, 0.5);
    assert!(batch.is_consistent());
    let bodies = [
        Body::Block(batch.clone()),
        Body::Samples(Bulk(vec![[0.0, 1.0]])),
        Body::Seam { points: batch.clone(), cells: Bulk(vec![0, 1, u32::MAX]) },
        Body::Piece {
            leaf: 1,
            ids: Bulk(vec![7, 8, 9]),
            rows: Bulk(vec![0, 1, 2, 5, 6, 7]),
            open: Bulk(vec![0]),
        },
        Body::Decision {
            verdict: Verdict::Split([Child { population: 1, first: 2, ranks: 3, leaf: true }; 2]),
            boxes: Bulk(vec![[0.0, 0.0]; 4]),
        },
        Body::Merged(Merged { cells: 4, ..Merged::default() }),
        Body::Outcome(1),
        Body::Joined(Bulk(vec![7, 1 << 40])),
        Body::Left(Bulk(Vec::new())),
        Body::Selected { members: Bulk(vec![0, 3]), undecided: Bulk(vec![9, 2]) },
        Body::View(Box::new(ViewPart { points: batch, flags: Bulk(vec![2]), ..ViewPart::default() })),
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
