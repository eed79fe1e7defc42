//! A wire between processes of one computer, over Unix sockets.
//!
//! Every process listens in a folder that only its user can open, and connects to the processes before it. A thread for
//! each connection reads parcels, so that writing never waits for the other side to write. A process can be at most one
//! exchange ahead of another. A connection that ends before an awaited parcel means that the process is gone.
//!
//! A parcel is cut into parts. Each has a head and a content:
//!
//! | bytes | content |
//! |---|---|
//! | 0 | the state |
//! | 1 | 0: there is no parcel; 1: this is the last part of the parcel; 2: more parts follow |
//! | 2 to 5 | the length of the part, u32 |
//! | from 6 | the bytes of the part |
//!
//! The receiver does not know the length of a parcel in advance, so its memory grows with the bytes that arrive.
//!
//! [`Processes`](septet_protocol::wire::Processes) adds the checksum of the content.

use std::fs;
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, unbounded};
use septet_protocol::wire::{Arrived, Parcel, PartBytes, Wire, WireError};

/// The time in which all processes must have started.
const PATIENCE: Duration = Duration::from_mins(1);

/// The time between two attempts to connect.
const PAUSE: Duration = Duration::from_millis(2);

/// The number of bytes that are read at a time, so that memory grows with the bytes that arrive.
const STEP: usize = 1 << 22;

/// Bytes of the head of a part.
const HEAD: usize = 6;

/// The second byte of a head: there is no parcel.
const NO_PARCEL: u8 = 0;

/// The second byte of a head: the part is the last one.
const LAST: u8 = 1;

/// The second byte of a head: more parts follow.
const MORE: u8 = 2;

/// The data that a process sends to another one in an exchange.
struct Sent {
    state: u8,
    bytes: Option<Vec<u8>>,
}

/// The connection to another process.
struct Peer {
    stream: UnixStream,
    received: Receiver<io::Result<Sent>>,
}

/// The end of one process.
pub struct SocketWire {
    process: u32,
    part_bytes: PartBytes,
    /// The other processes, by number; `None` at the place of this one.
    peers: Vec<Option<Peer>>,
}

impl SocketWire {
    /// Connects process `process` of `processes` with the others. All of them call this function with the same folder, and
    /// the last one removes it. While it waits, a process calls `check`.
    ///
    /// # Errors
    /// Fails if the folder cannot be used, if a process does not appear within a minute, or with the error of `check`.
    pub fn connect(
        folder: &Path,
        process: u32,
        processes: u32,
        check: &mut dyn FnMut() -> io::Result<()>,
    ) -> io::Result<Self> {
        let end = Instant::now() + PATIENCE;
        let wait = &mut || {
            check()?;
            if Instant::now() > end {
                let reason = "a process of the run did not start within a minute";
                return Err(io::Error::new(ErrorKind::TimedOut, reason));
            }
            thread::sleep(PAUSE);
            Ok(())
        };
        let own = address(folder, process);
        // The name is complete before the socket appears under it.
        let draft = own.with_extension("new");
        let listener = UnixListener::bind(&draft)?;
        fs::rename(&draft, &own)?;
        let mut peers: Vec<Option<Peer>> = (0..processes).map(|_| None).collect();
        for other in 0..process {
            let mut stream = reach(&address(folder, other), wait)?;
            stream.write_all(&process.to_le_bytes())?;
            peers[other as usize] = Some(peer(stream)?);
        }
        listener.set_nonblocking(true)?;
        for _ in process + 1..processes {
            let mut stream = accept(&listener, wait)?;
            stream.set_nonblocking(false)?;
            let mut number = [0; 4];
            stream.read_exact(&mut number)?;
            let place = peers.get_mut(u32::from_le_bytes(number) as usize).filter(|place| place.is_none());
            let unknown =
                || io::Error::new(ErrorKind::InvalidData, "a process with an invalid number connected");
            *place.ok_or_else(unknown)? = Some(peer(stream)?);
        }
        fs::remove_file(&own)?;
        // This fails as long as other sockets are in the folder.
        let _ = fs::remove_dir(folder);
        Ok(SocketWire { process, part_bytes: PartBytes::default(), peers })
    }
}

fn address(folder: &Path, process: u32) -> PathBuf {
    folder.join(process.to_string())
}

/// Connects to a socket that may not exist yet.
fn reach(address: &Path, wait: &mut dyn FnMut() -> io::Result<()>) -> io::Result<UnixStream> {
    loop {
        match UnixStream::connect(address) {
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::ConnectionRefused) => {
                wait()?;
            }
            connected => return connected,
        }
    }
}

fn accept(listener: &UnixListener, wait: &mut dyn FnMut() -> io::Result<()>) -> io::Result<UnixStream> {
    loop {
        match listener.accept() {
            Ok((stream, _)) => return Ok(stream),
            Err(error) if error.kind() == ErrorKind::WouldBlock => wait()?,
            Err(error) => return Err(error),
        }
    }
}

/// Starts the thread that reads from a connection. It ends with the connection.
fn peer(stream: UnixStream) -> io::Result<Peer> {
    let (to, received) = unbounded();
    let mut reading = stream.try_clone()?;
    thread::Builder::new().name("septet-wire".to_string()).spawn(move || {
        loop {
            let sent = read_sent(&mut reading);
            let is_end = sent.is_err();
            if to.send(sent).is_err() || is_end {
                return;
            }
        }
    })?;
    Ok(Peer { stream, received })
}

/// Reads all parts of what a process sends in an exchange.
fn read_sent(from: &mut impl Read) -> io::Result<Sent> {
    let (mut bytes, mut is_first) = (Vec::new(), true);
    loop {
        let mut head = [0; HEAD];
        from.read_exact(&mut head)?;
        let [state, kind, length @ ..] = head;
        read_part(from, u32::from_le_bytes(length) as usize, &mut bytes)?;
        match kind {
            NO_PARCEL if is_first && bytes.is_empty() => return Ok(Sent { state, bytes: None }),
            LAST => return Ok(Sent { state, bytes: Some(bytes) }),
            MORE => is_first = false,
            _ => return Err(io::Error::new(ErrorKind::InvalidData, "the head of a part is invalid")),
        }
    }
}

/// Appends the content of a part.
fn read_part(from: &mut impl Read, length: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
    let end = bytes.len() + length;
    while bytes.len() < end {
        let step = (end - bytes.len()).min(STEP);
        bytes.reserve(step);
        if from.by_ref().take(step as u64).read_to_end(bytes)? != step {
            return Err(ErrorKind::UnexpectedEof.into());
        }
    }
    Ok(())
}

/// Writes what a process sends in an exchange, in parts.
fn write_sent(to: &mut impl Write, state: u8, bytes: Option<&[u8]>, part_bytes: PartBytes) -> io::Result<()> {
    let mut rest = bytes.unwrap_or_default();
    loop {
        let (part, after) = rest.split_at(rest.len().min(part_bytes.get()));
        let kind = match bytes {
            None => NO_PARCEL,
            Some(_) if after.is_empty() => LAST,
            Some(_) => MORE,
        };
        let mut head = [state, kind, 0, 0, 0, 0];
        // A part has at most 2^30 bytes.
        head[2..].copy_from_slice(&(part.len() as u32).to_le_bytes());
        to.write_all(&head)?;
        to.write_all(part)?;
        if after.is_empty() {
            return Ok(());
        }
        rest = after;
    }
}

fn lost(process: usize, error: &io::Error) -> WireError {
    let reason = match error.kind() {
        ErrorKind::UnexpectedEof | ErrorKind::BrokenPipe | ErrorKind::ConnectionReset => {
            "its connection ended".to_string()
        }
        _ => error.to_string(),
    };
    WireError::Lost { process: process as u32, reason }
}

impl Wire for SocketWire {
    fn process(&self) -> u32 {
        self.process
    }

    fn processes(&self) -> u32 {
        self.peers.len() as u32
    }

    fn exchange(&mut self, members: u32, sent: Vec<Parcel>, state: u8) -> Result<Arrived, WireError> {
        let mut contents: Vec<Option<Vec<u8>>> = self.peers.iter().map(|_| None).collect();
        for Parcel { process, bytes } in sent {
            contents[process as usize] = Some(bytes);
        }
        let others = || self.peers.iter().enumerate().take(members as usize);
        for (process, peer) in others() {
            if let Some(Peer { stream, .. }) = peer {
                let bytes = contents[process].take();
                let written = write_sent(&mut &*stream, state, bytes.as_deref(), self.part_bytes);
                written.map_err(|error| lost(process, &error))?;
            }
        }
        let mut arrived = Arrived { parcels: Vec::new(), state };
        for (process, peer) in others() {
            let Some(Peer { received, .. }) = peer else { continue };
            let ended = || io::Error::from(ErrorKind::UnexpectedEof);
            let got = received.recv().unwrap_or_else(|_| Err(ended()));
            let Sent { state, bytes } = got.map_err(|error| lost(process, &error))?;
            arrived.state = arrived.state.max(state);
            arrived.parcels.extend(bytes.map(|bytes| Parcel { process: process as u32, bytes }));
        }
        Ok(arrived)
    }

    fn set_part_bytes(&mut self, part_bytes: PartBytes) {
        self.part_bytes = part_bytes;
    }
}

impl Drop for SocketWire {
    fn drop(&mut self) {
        // The reading threads end with their connections.
        for Peer { stream, .. } in self.peers.iter().flatten() {
            let _ = stream.shutdown(std::net::Shutdown::Write);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a function on each of `n` processes, which are threads here.
    fn each<T: Send>(n: u32, of: impl Fn(&mut SocketWire) -> T + Sync) -> Vec<T> {
        let folder = std::env::temp_dir().join(format!("septet-wire-{}-{n}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let all = thread::scope(|scope| {
            let (of, folder) = (&of, &folder);
            let run =
                move |process| of(&mut SocketWire::connect(folder, process, n, &mut || Ok(())).unwrap());
            let threads: Vec<_> = (0..n).map(|process| scope.spawn(move || run(process))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(!folder.exists());
        all
    }

    #[test]
    fn parcels_arrive_in_the_order_of_their_senders() {
        for n in [1, 2, 5] {
            each(n, |wire| {
                let own = wire.process();
                for round in 0..50_u32 {
                    wire.set_part_bytes(if round % 2 == 0 { of(1 << 12) } else { PartBytes::default() });
                    // Large enough that a socket does not take it at once.
                    let bytes =
                        |from: u32, to: u32| vec![(from * 7 + to + round) as u8; (1 << 18) * to as usize];
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
            &[0, MORE, 0, 0, 0, 0, 0, NO_PARCEL, 0, 0, 0, 0],
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
}
