//! The start of a wire: the first process gives every other process one end of a connection to each process.
//!
//! No socket has a name, so that no program outside the run can connect. The first process starts each other process with
//! one end of a pair as its standard input, the *launch stream*. Over it, the other process learns its place and receives
//! descriptors. The launch stream then is the connection to the first process.
//!
//! | bytes | direction | content |
//! |---|---|---|
//! | 16 | to the process | [`GREETING`], number of the process u32, number of processes u32 |
//! | 4, with a descriptor | to the process | number of another process u32, and the connection to it |
//! | 1 | from the process | [`TAKEN`]: it has the greeting, or this descriptor |
//!
//! The first process keeps an end that it sends until the process has it, because some systems close a socket
//! that is held by a message only. At most [`BATCH`] connections are under way, because the system limits descriptors in
//! messages by the limit of open files.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, IoSlice, IoSliceMut, Read, Write};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use rustix::cmsg_space;
use rustix::io::{Errno, FdFlags, fcntl_setfd};
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage,
    SendFlags, recvmsg, sendmsg,
};

/// The time in which all processes must have started.
const PATIENCE: Duration = Duration::from_mins(1);

/// The time between two looks at the clock and at the other processes.
const PAUSE: Duration = Duration::from_millis(10);

/// The first bytes of a launch stream.
const GREETING: [u8; 8] = *b"septet\0\x01";

/// The byte with which a process confirms the greeting and each descriptor.
const TAKEN: u8 = 1;

/// The largest number of connections that are under way at a time.
const BATCH: usize = 32;

/// A connection to each other process, by number; `None` at the place of this one.
pub(super) type Streams = Vec<Option<UnixStream>>;

/// A function that fails if the start has no chance of success.
pub(super) type Check<'a> = &'a mut dyn FnMut() -> io::Result<()>;

/// The patience of the first process.
struct Wait<'a> {
    check: Check<'a>,
    end: Instant,
}

impl Wait<'_> {
    /// Fails if the start takes too long or has no chance.
    fn look(&mut self) -> io::Result<()> {
        (self.check)()?;
        if Instant::now() < self.end { Ok(()) } else { Err(late()) }
    }

    /// Repeats an operation on a stream with a timeout of [`PAUSE`] until it succeeds.
    fn until_done<T>(&mut self, mut attempt: impl FnMut() -> io::Result<T>) -> io::Result<T> {
        loop {
            match attempt() {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => self.look()?,
                Err(error) if Errno::from_io_error(&error) == Some(Errno::TOOMANYREFS) => {
                    self.look()?;
                    std::thread::sleep(PAUSE);
                }
                done => return done,
            }
        }
    }
}

/// Returns the error for a process that does not appear.
fn late() -> io::Error {
    io::Error::new(ErrorKind::TimedOut, "a process of the run did not start within a minute")
}

/// Connects all processes, on the first one. `launched` are the launch streams of the others. Returns the connections of the
/// first process.
pub(super) fn hand_out(launched: Vec<UnixStream>, check: Check<'_>) -> io::Result<Streams> {
    let wait = &mut Wait { check, end: Instant::now() + PATIENCE };
    for (process, stream) in (1_u32..).zip(&launched) {
        stream.set_read_timeout(Some(PAUSE))?;
        stream.set_write_timeout(Some(PAUSE))?;
        let mut greeting = [0; 16];
        greeting[..8].copy_from_slice(&GREETING);
        greeting[8..12].copy_from_slice(&process.to_le_bytes());
        greeting[12..].copy_from_slice(&(launched.len() as u32 + 1).to_le_bytes());
        // A stream that nothing was written to takes this many bytes at once.
        (&*stream).write_all(&greeting)?;
    }
    for stream in &launched {
        confirm(stream, wait)?;
    }
    let last = launched.len() as u32;
    let pairs = (1..=last).flat_map(|one| (one + 1..=last).map(move |other| (one, other)));
    for batch in pairs.collect::<Vec<_>>().chunks(BATCH) {
        connect(batch, &launched, wait)?;
    }
    for stream in &launched {
        stream.set_read_timeout(None)?;
        stream.set_write_timeout(None)?;
    }
    Ok([None].into_iter().chain(launched.into_iter().map(Some)).collect())
}

/// Connects pairs of processes, and waits until they have their ends.
fn connect(pairs: &[(u32, u32)], launched: &[UnixStream], wait: &mut Wait<'_>) -> io::Result<()> {
    let mut sent = Vec::with_capacity(2 * pairs.len());
    for &(one, other) in pairs {
        let (end_of_one, end_of_other) = UnixStream::pair()?;
        for (receiver, peer, end) in [(one, other, end_of_one), (other, one, end_of_other)] {
            let stream = &launched[receiver as usize - 1];
            wait.until_done(|| send(stream, peer, &end))?;
            sent.push((stream, end));
        }
    }
    // The ends stay open until here.
    sent.into_iter().try_for_each(|(stream, _end)| confirm(stream, wait))
}

/// Waits until a process confirms what it received.
fn confirm(mut stream: &UnixStream, wait: &mut Wait<'_>) -> io::Result<()> {
    let mut byte = [0];
    wait.until_done(|| stream.read_exact(&mut byte))?;
    if byte == [TAKEN] { Ok(()) } else { Err(io::Error::other("a process did not confirm the start")) }
}

/// Sends the connection to the process `peer`.
fn send(stream: &UnixStream, peer: u32, end: &UnixStream) -> io::Result<()> {
    let fds = [end.as_fd()];
    let mut space = [MaybeUninit::uninit(); cmsg_space!(ScmRights(1))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    if !control.push(SendAncillaryMessage::ScmRights(&fds)) {
        return Err(io::Error::other("there is no space for a descriptor"));
    }
    let number = peer.to_le_bytes();
    let count = sendmsg(stream, &[IoSlice::new(&number)], &mut control, SendFlags::empty())?;
    // The system sends so few bytes together or not at all.
    if count == number.len() { Ok(()) } else { Err(io::Error::other("a number was sent in part")) }
}

/// Receives the number of another process and the connection to it.
fn receive(stream: &UnixStream) -> io::Result<(u32, UnixStream)> {
    let mut number = [0; 4];
    let (mut count, mut end) = (0, None);
    while count < number.len() {
        let mut space = [MaybeUninit::uninit(); cmsg_space!(ScmRights(1))];
        let mut control = RecvAncillaryBuffer::new(&mut space);
        let parts = &mut [IoSliceMut::new(&mut number[count..])];
        let got = match recvmsg(stream, parts, &mut control, RecvFlags::empty()) {
            Err(Errno::INTR) => continue,
            got => got?.bytes,
        };
        end = end.or_else(|| control.drain().find_map(first_descriptor));
        if got == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        count += got;
    }
    // The system drops a descriptor that does not fit.
    let missing =
        || io::Error::other("a connection did not arrive, because the limit of open files is too low");
    let end = end.ok_or_else(missing)?;
    fcntl_setfd(&end, FdFlags::CLOEXEC)?;
    Ok((u32::from_le_bytes(number), end.into()))
}

fn first_descriptor(message: RecvAncillaryMessage<'_>) -> Option<OwnedFd> {
    match message {
        RecvAncillaryMessage::ScmRights(mut fds) => fds.next(),
        _ => None,
    }
}

/// Reads the greeting of a launch stream.
///
/// # Errors
/// Fails if the stream does not begin with the greeting for this place, or if nothing arrives within a minute.
fn greeted(mut launch: &UnixStream, (process, processes): (u32, u32)) -> io::Result<()> {
    let mut greeting = [0; 16];
    launch.read_exact(&mut greeting)?;
    let [.., a, b, c, d, e, f, g, h] = greeting;
    let place = [[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes);
    if greeting[..8] == GREETING && place == [process, processes] && 0 < process && process < processes {
        return Ok(());
    }
    let reason = "standard input does not come from the first process of the run";
    Err(io::Error::new(ErrorKind::InvalidData, reason))
}

/// Receives the connections of a process that is not the first one.
pub(super) fn take(launch: UnixStream, (process, processes): (u32, u32)) -> io::Result<Streams> {
    launch.set_read_timeout(Some(PATIENCE))?;
    let reason_of = |error: io::Error| match error.kind() {
        ErrorKind::WouldBlock => late(),
        ErrorKind::UnexpectedEof => io::Error::new(ErrorKind::UnexpectedEof, "the first process has ended"),
        _ => error,
    };
    greeted(&launch, (process, processes)).map_err(reason_of)?;
    (&launch).write_all(&[TAKEN])?;
    // Memory grows with the connections that arrive, whatever the number of processes is said to be.
    let mut ends = BTreeMap::new();
    for _ in 2..processes {
        let (peer, end) = receive(&launch).map_err(reason_of)?;
        let is_known = peer < processes && ![0, process].contains(&peer);
        if !is_known || ends.insert(peer, end).is_some() {
            return Err(io::Error::other("the first process sent the number of no other process"));
        }
        (&launch).write_all(&[TAKEN])?;
    }
    launch.set_read_timeout(None)?;
    ends.insert(0, launch);
    Ok((0..processes).map(|peer| ends.remove(&peer)).collect())
}
