use super::*;

fn ignored() -> OnEnd {
    Arc::new(|| {})
}

/// Runs a function on each of `n` processes, which are threads here.
fn each<T: Send>(n: u32, of: impl Fn(&mut SocketWire) -> T + Sync) -> Vec<T> {
    let (launched, launches): (Vec<_>, Vec<_>) = (1..n).map(|_| UnixStream::pair().unwrap()).unzip();
    thread::scope(|scope| {
        let of = &of;
        let first =
            scope.spawn(move || of(&mut SocketWire::first(launched, &mut || Ok(()), &ignored()).unwrap()));
        let started =
            |process, launch| of(&mut SocketWire::started(launch, (process, n), &ignored()).unwrap());
        let others = (1..).zip(launches);
        let others = others.map(|(process, launch)| scope.spawn(move || started(process, launch)));
        let threads: Vec<_> = [first].into_iter().chain(others).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Every process is connected to the processes that it names. Threads need all descriptors in one process.
#[test]
fn many_processes_are_connected() {
    const N: u32 = 20;
    let found = each(N, |wire| {
        let own = wire.process();
        let sent = (0..N).filter(|&to| to != own).map(|to| Parcel { process: to, bytes: vec![own as u8] });
        let arrived = wire.exchange(N, sent.collect(), 0).unwrap();
        let from: Vec<_> = arrived.parcels.iter().map(|p| (p.process, u32::from(p.bytes[0]))).collect();
        from == (0..N).filter(|&other| other != own).map(|other| (other, other)).collect::<Vec<_>>()
    });
    assert_eq!(found, [true; N as usize]);
}

/// Starts a process with the launch stream of a stranger, who writes these bytes.
fn started_by_stranger(bytes: &[u8], place: (u32, u32)) -> ErrorKind {
    let (mut stranger, launch) = UnixStream::pair().unwrap();
    stranger.write_all(bytes).unwrap();
    stranger.shutdown(std::net::Shutdown::Write).unwrap();
    SocketWire::started(launch, place, &ignored()).err().unwrap().kind()
}

#[test]
fn a_launch_stream_must_have_the_place_of_the_process() {
    let greeting = |process: u32, processes: u32| {
        [b"septet\0\x01".as_slice(), &process.to_le_bytes(), &processes.to_le_bytes()].concat()
    };
    let invalid = |bytes: &[u8], place| {
        assert_eq!(started_by_stranger(bytes, place), ErrorKind::InvalidData, "{bytes:?} {place:?}");
    };
    invalid(&greeting(1, 4), (2, 4));
    invalid(&greeting(1, 4), (1, 4_000_000_000));
    invalid(&greeting(4, 4), (4, 4));
    invalid(&greeting(0, 4), (0, 4));
    invalid(&[7; 16], (1, 4));
    // The number of processes is right and absurd: nothing is allocated for it.
    assert_eq!(started_by_stranger(&greeting(1, u32::MAX), (1, u32::MAX)), ErrorKind::UnexpectedEof);
    // A number without its connection.
    for peer in [0, 1, 2, 9_u32] {
        let bytes = [greeting(1, 4), peer.to_le_bytes().to_vec()].concat();
        assert_eq!(started_by_stranger(&bytes, (1, 4)), ErrorKind::Other, "{peer}");
    }
    for end in 0..20 {
        let bytes = [greeting(1, 4), 2_u32.to_le_bytes().to_vec()].concat();
        assert_eq!(started_by_stranger(&bytes[..end], (1, 4)), ErrorKind::UnexpectedEof, "{end} bytes");
    }
}

/// The first process gives up when its check fails, although a process stays silent.
#[test]
fn a_silent_process_does_not_hold_the_first_one() {
    let (launched, _silent): (Vec<_>, Vec<_>) = (0..2).map(|_| UnixStream::pair().unwrap()).unzip();
    let mut looks = 0;
    let check = &mut || {
        looks += 1;
        if looks < 5 { Ok(()) } else { Err(io::Error::other("process 2 ended")) }
    };
    assert_eq!(SocketWire::first(launched, check, &ignored()).err().unwrap().to_string(), "process 2 ended");
}

#[test]
fn parcels_arrive_in_the_order_of_their_senders() {
    for n in [1, 2, 5] {
        each(n, |wire| {
            let own = wire.process();
            for round in 0..50_u32 {
                wire.set_part_bytes(if round % 2 == 0 { of(1 << 12) } else { PartBytes::default() });
                // Large enough that a socket does not take it at once.
                let bytes = |from: u32, to: u32| vec![(from * 7 + to + round) as u8; (1 << 18) * to as usize];
                let receives = |from: u32, to: u32| from != to && !(from + to + round).is_multiple_of(3);
                let sent = (0..n).filter(|&to| receives(own, to));
                let sent = sent.map(|to| Parcel { process: to, bytes: bytes(own, to) }).collect();
                let arrived = wire.exchange(n, sent, (own == round % n) as u8 * 9).unwrap();
                let expected = (0..n).filter(|&from| receives(from, own));
                let expected: Vec<Parcel> =
                    expected.map(|from| Parcel { process: from, bytes: bytes(from, own) }).collect();
                assert!(arrived.parcels == expected && arrived.state == 9, "{n} {own} {round}");
            }
        });
    }
}

fn of(part_bytes: u64) -> PartBytes {
    PartBytes::new(part_bytes).unwrap()
}

#[test]
fn parcels_are_cut_into_parts() {
    for (length, part_bytes) in
        (0..20).flat_map(|length| [1, 2, 3, 7, 19, 20, 100].map(|part| (length, part)))
    {
        let bytes: Vec<u8> = (1..=length).collect();
        let mut written = Vec::new();
        write_sent(&mut written, 9, Some(&bytes), of(part_bytes)).unwrap();
        let parts = u64::from(length).div_ceil(part_bytes).max(1) as usize;
        assert_eq!(written.len(), bytes.len() + parts * HEAD, "{length} {part_bytes}");
        let mut from = &written[..];
        for part in 1..=parts {
            let (head, rest) = from.split_at(HEAD);
            let content = u32::from_le_bytes(head[2..].try_into().unwrap()) as usize;
            assert!(content as u64 <= part_bytes, "{length} {part_bytes}");
            assert_eq!(head[..2], [9, if part == parts { LAST } else { MORE }]);
            from = &rest[content..];
        }
        let mut from = &written[..];
        let Sent { state, bytes: read } = read_sent(&mut from).unwrap();
        assert_eq!((state, read, from.len()), (9, Some(bytes), 0));
        for end in 0..written.len() {
            let error = read_sent(&mut &written[..end]).err().unwrap();
            assert_eq!(error.kind(), ErrorKind::UnexpectedEof, "{length} {part_bytes}");
        }
    }
    let mut written = Vec::new();
    write_sent(&mut written, 3, None, of(1)).unwrap();
    assert_eq!(written, [3, NO_PARCEL, 0, 0, 0, 0]);
    let Sent { state, bytes } = read_sent(&mut &written[..]).unwrap();
    assert_eq!((state, bytes), (3, None));
}

#[test]
fn invalid_heads_are_refused() {
    for parts in [
        &[0, 3, 0, 0, 0, 0][..],
        &[0, NO_PARCEL, 1, 0, 0, 0, 7],
        &[0, MORE, 1, 0, 0, 0, 7, 0, NO_PARCEL, 0, 0, 0, 0],
        &[0, MORE, 0, 0, 0, 0, 0, LAST, 0, 0, 0, 0],
        // A length above 1 GiB is refused before the content.
        &[0, MORE, 1, 0, 0, 0x40],
        &[0, LAST, 0xff, 0xff, 0xff, 0xff],
    ] {
        let error = read_sent(&mut &parts[..]).err().unwrap();
        assert_eq!(error.kind(), ErrorKind::InvalidData, "{parts:?}");
    }
}

#[test]
fn the_first_processes_can_exchange_alone() {
    let found = each(4, |wire| {
        let alone = (wire.process() < 2).then(|| wire.exchange(2, Vec::new(), 3).unwrap().state);
        (alone, wire.exchange(4, Vec::new(), wire.process() as u8).unwrap().state)
    });
    assert_eq!(found, [(Some(3), 3), (Some(3), 3), (None, 3), (None, 3)]);
}

#[test]
fn a_process_that_ends_is_lost() {
    let found = each(3, |wire| {
        wire.exchange(3, Vec::new(), 0).unwrap();
        (wire.process() != 1).then(|| wire.exchange(3, Vec::new(), 0).unwrap_err())
    });
    let lost = |of: u32| WireError::Lost { process: of, reason: "its connection ended".to_string() };
    assert!(found[1].is_none());
    // The third process may notice the end of the first before that of the second.
    assert!([&found[0], &found[2]].iter().any(|e| **e == Some(lost(1))), "{found:?}");
}

/// The end of a process is noticed while the others compute.
#[test]
fn the_end_of_a_process_is_noticed_at_once() {
    let (own, other) = UnixStream::pair().unwrap();
    let (to, ended) = bounded(1);
    let on_end: OnEnd = Arc::new(move || {
        let _ = to.send(());
    });
    let first = thread::spawn(move || SocketWire::first(vec![own], &mut || Ok(()), &on_end).unwrap());
    let second = SocketWire::started(other, (1, 2), &ignored()).unwrap();
    let _first = first.join().unwrap();
    assert!(ended.try_recv().is_err());
    drop(second);
    ended.recv_timeout(std::time::Duration::from_secs(10)).unwrap();
}
