//! A wire between processes of one computer, over Unix sockets without names.
//!
//! The first process makes all connections and hands them out (file `handout.rs`). A thread for each connection reads parcels, so
//! that writing never waits for the other side to write. A process can be at most one exchange ahead of another. A
//! connection that ends before an awaited parcel means that the process is gone.
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
//! The receiver does not know the length of a parcel in advance, so its memory grows with the bytes that arrive. It refuses a
//! head that no process writes before it reads the content. It holds at most `AHEAD` parcels of a process that were not
//! taken.
//!
//! [`Processes`](septet_protocol::wire::Processes) adds the checksum of the content.

mod handout;

use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::thread;

use crossbeam_channel::{Receiver, bounded};
use septet_protocol::wire::{Arrived, Parcel, PartBytes, Wire, WireError};

use handout::Streams;

/// The number of bytes that are read at a time, so that memory grows with the bytes that arrive.
const STEP: usize = 1 << 22;

/// The largest number of exchanges of a process that another one has not completed: the one that it waits for, and one more.
const AHEAD: usize = 2;

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
    /// The stream, which the reading thread shares, so that a connection takes one descriptor.
    stream: Arc<UnixStream>,
    received: Receiver<io::Result<Sent>>,
}

/// A function that a connection calls when it ends, from a thread of its own. The end of a process that computes is
/// noticed at once, and not in the next exchange.
pub type OnEnd = Arc<dyn Fn() + Send + Sync>;

/// The end of one process.
pub struct SocketWire {
    process: u32,
    part_bytes: PartBytes,
    /// The other processes, by number; `None` at the place of this one.
    peers: Vec<Option<Peer>>,
}

impl SocketWire {
    /// Connects the first process with the others, whose launch streams these are, in the order of their numbers. Connects the
    /// others with each other. While it waits, it calls `check`. Each connection calls `on_end` when it ends, also at the end of a
    /// run.
    ///
    /// # Errors
    /// Fails if the system refuses a connection, if a process does not appear within a minute, or with the error of `check`.
    pub fn first(
        launched: Vec<UnixStream>,
        check: &mut dyn FnMut() -> io::Result<()>,
        on_end: &OnEnd,
    ) -> io::Result<Self> {
        Self::of_streams(0, handout::hand_out(launched, check)?, on_end)
    }

    /// Connects process `process` of `processes`, which is not the first one. `launch` is its end of its launch stream. Each
    /// connection calls `on_end` when it ends, also at the end of a run.
    ///
    /// # Errors
    /// Fails if the launch stream belongs to no run, or to another place in it ([`ErrorKind::InvalidData`]), or if the start
    /// does not continue within a minute.
    pub fn started(launch: UnixStream, (process, processes): (u32, u32), on_end: &OnEnd) -> io::Result<Self> {
        Self::of_streams(process, handout::take(launch, (process, processes))?, on_end)
    }

    fn of_streams(process: u32, streams: Streams, on_end: &OnEnd) -> io::Result<Self> {
        let peers = streams.into_iter().map(|stream| stream.map(|stream| peer(stream, on_end)).transpose());
        Ok(SocketWire { process, part_bytes: PartBytes::default(), peers: peers.collect::<io::Result<_>>()? })
    }
}

/// Starts the thread that reads from a connection. It ends with the connection.
fn peer(stream: UnixStream, on_end: &OnEnd) -> io::Result<Peer> {
    let (to, received) = bounded(AHEAD);
    let stream = Arc::new(stream);
    let (reading, on_end) = (stream.clone(), on_end.clone());
    thread::Builder::new().name("septet-wire".to_string()).spawn(move || {
        loop {
            let sent = read_sent(&mut &*reading);
            let is_end = sent.is_err();
            if is_end {
                on_end();
            }
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
        let length = u32::from_le_bytes(length);
        let is_legal = match kind {
            NO_PARCEL => is_first && length == 0,
            LAST => u64::from(length) <= PartBytes::MOST,
            MORE => (1..=PartBytes::MOST).contains(&u64::from(length)),
            _ => false,
        };
        if !is_legal {
            return Err(io::Error::new(ErrorKind::InvalidData, "the head of a part is invalid"));
        }
        read_part(from, length as usize, &mut bytes)?;
        match kind {
            NO_PARCEL => return Ok(Sent { state, bytes: None }),
            LAST => return Ok(Sent { state, bytes: Some(bytes) }),
            _ => is_first = false,
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
                let written = write_sent(&mut &**stream, state, bytes.as_deref(), self.part_bytes);
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
mod tests;
