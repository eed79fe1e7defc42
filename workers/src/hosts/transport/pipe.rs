//! Workers as processes: one rank each, with every message as bytes through its standard input and output.
//!
//! In a round, every worker writes its state and its frames. The coordinator's process reads one worker after the
//! other, adds its own frames, and writes to each worker the frames for its rank and whether the machine was active.
//! A worker writes everything, then reads everything; the coordinator reads everything, then writes everything. The
//! processes therefore cannot deadlock in any order. A worker writes the state 0 (idle), 1 (busy) or 2 (failed), the
//! coordinator 1 if the machine was active and 0 otherwise. `frames` describes the bytes.
//!
//! A worker that failed or was interrupted sends one frame, the encoded [`TransportError`]. Before the first round, a
//! worker receives a frame with its block (`Assigned`). After the last, it sends a frame with its share.

mod shares;

use std::io::{BufReader, BufWriter, Error, ErrorKind, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;

use septet_geometry::point::Point;
use septet_protocol::codec;
use septet_protocol::ids::{COORDINATOR, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};

use crate::config::WorkerConfig;
use crate::hosts::host::{Host, Job, Unwatched, Watch, serve};
use crate::hosts::transport::frames::{Frame, read_round, write_round};
use crate::hosts::transport::{Machine, MachineError};
use crate::share::Share;
use shares::{Assigned, share_from_bytes, share_to_bytes};

const IDLE: u8 = 0;
const BUSY: u8 = 1;
const FAILED: u8 = 2;

/// Returns the error that a failed worker reported.
fn reported(from: Rank, frames: &[Frame]) -> TransportError {
    let error = frames.first().and_then(|(_, bytes)| codec::decode(bytes).ok());
    error.unwrap_or_else(|| bad(from, &"its report of a failure does not decode"))
}

fn bad(from: Rank, error: &dyn std::fmt::Display) -> TransportError {
    TransportError::BadMessage { from, reason: error.to_string() }
}

/// Starts the process of a rank with these parameters: returns the program and the arguments. The program must call
/// [`serve_pipe`] with the same parameters and rank.
pub type Program = dyn FnMut(&WorkerConfig, Rank) -> Command;

/// A machine of processes, one for each worker. The coordinator runs in the process of the caller, which sends each
/// worker its block before the first round and receives its share after the last.
pub struct Processes {
    program: Box<Program>,
}

impl Processes {
    /// Creates a machine whose workers run a program.
    pub fn new(program: impl FnMut(&WorkerConfig, Rank) -> Command + 'static) -> Self {
        Processes { program: Box::new(program) }
    }
}

impl<P: Point> Machine<P> for Processes {
    fn run(&mut self, job: &Job<'_, P>, watch: &mut dyn Watch) -> Result<Vec<Share<P>>, MachineError> {
        let mut pipes = Pipes::launch(&job.config, &mut self.program)?;
        pipes.send_blocks(job)?;
        let mut host = Host::new(std::iter::once(COORDINATOR), job, &None);
        serve(&mut pipes, &mut host, watch)?;
        let mut shares = host.into_shares();
        shares.extend(pipes.receive_shares()?);
        Ok(shares)
    }
}

/// The coordinator's end of a machine of processes. Dropping it ends the processes.
struct Pipes {
    children: Vec<Process>,
}

struct Process {
    child: Child,
    input: Option<BufWriter<ChildStdin>>,
    output: BufReader<ChildStdout>,
}

impl Pipes {
    /// Starts the processes of ranks `1..=workers`.
    fn launch(config: &WorkerConfig, program: &mut Program) -> std::io::Result<Self> {
        let mut pipes = Pipes { children: Vec::new() };
        for rank in 1..=config.workers {
            let mut child = program(config, rank).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
            let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
                return Err(Error::other("a process without pipes"));
            };
            let input = Some(BufWriter::new(input));
            pipes.children.push(Process { child, input, output: BufReader::new(output) });
        }
        Ok(pipes)
    }

    /// Sends each worker its block.
    fn send_blocks<P: Point>(&mut self, job: &Job<'_, P>) -> Result<(), TransportError> {
        for rank in 1..=job.config.workers {
            let bytes = Assigned::of(job, rank).to_bytes().map_err(|e| bad(COORDINATOR, &e))?;
            let written = match &mut self.children[rank as usize - 1].input {
                Some(input) => write_round(input, IDLE, &[(rank, bytes)]),
                None => return Err(TransportError::Stopped),
            };
            written.map_err(|e| self.failure(rank, &e))?;
        }
        Ok(())
    }

    /// Receives the share of each worker.
    fn receive_shares<P: Point>(&mut self) -> Result<Vec<Share<P>>, TransportError> {
        let mut shares = Vec::with_capacity(self.children.len());
        for rank in 1..=self.children.len() as Rank {
            let read = read_round(&mut self.children[rank as usize - 1].output);
            let (state, frames) = read.map_err(|e| self.failure(rank, &e))?;
            if state == FAILED {
                return Err(reported(rank, &frames));
            }
            let [(_, bytes)] = frames.as_slice() else { return Err(bad(rank, &"it did not send one share")) };
            shares.push(share_from_bytes(rank, bytes).map_err(|e| bad(rank, &e))?);
        }
        Ok(shares)
    }

    fn failure(&mut self, rank: Rank, error: &Error) -> TransportError {
        if error.kind() == ErrorKind::InvalidData {
            return bad(rank, error);
        }
        let process = &mut self.children[rank as usize - 1];
        process.input = None;
        let ended = match process.child.try_wait() {
            Ok(Some(status)) => format!(", {status}"),
            _ => String::new(),
        };
        TransportError::WorkerFailed { rank, reason: format!("its pipe broke: {error}{ended}") }
    }
}

impl<P: Point> Transport<P> for Pipes {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let ranks = self.children.len() + 1;
        let mut boxes: Vec<Vec<Frame>> = vec![Vec::new(); ranks];
        let mut active = state.is_busy()? || !outbox.is_empty();
        let mut route = |from: Rank, frame: Frame| match boxes.get_mut(frame.0 as usize) {
            Some(place) => {
                place.push(frame);
                Ok(())
            }
            None => Err(bad(from, &format!("there is no rank {}", frame.0))),
        };
        for message in outbox {
            let bytes = message.encode().map_err(|e| bad(message.from, &e))?;
            route(message.from, (message.to, bytes))?;
        }
        for rank in 1..ranks {
            let from = rank as Rank;
            let read = read_round(&mut self.children[rank - 1].output);
            let (state, frames) = read.map_err(|e| self.failure(from, &e))?;
            if state == FAILED {
                return Err(reported(from, &frames));
            }
            active |= state == BUSY || !frames.is_empty();
            for frame in frames {
                route(from, frame)?;
            }
        }
        let own = std::mem::take(&mut boxes[COORDINATOR as usize]);
        for (rank, frames) in boxes.iter().enumerate().skip(1) {
            let written = match &mut self.children[rank - 1].input {
                Some(input) => write_round(input, u8::from(active), frames),
                None => return Err(TransportError::Stopped),
            };
            written.map_err(|e| self.failure(rank as Rank, &e))?;
        }
        let decoded = own.iter().map(|(_, bytes)| Message::decode(bytes).map_err(|e| bad(0, &e)));
        Ok(Delivery { inbox: decoded.collect::<Result<_, _>>()?, active })
    }
}

impl Drop for Pipes {
    fn drop(&mut self) {
        for process in &mut self.children {
            process.input = None;
        }
        for process in &mut self.children {
            // A process that is not busy ends when its input is closed. Killing it ends a busy one as well.
            let _ = process.child.kill();
            let _ = process.child.wait();
        }
    }
}

/// A worker's end.
struct Pipe<R, W> {
    input: R,
    output: W,
}

impl<P: Point, R: Read + Send, W: Write + Send> Transport<P> for Pipe<R, W> {
    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let busy = state.is_busy().inspect_err(|error| self.report(error))?;
        let encoded = outbox.iter().map(|m| match m.encode() {
            Ok(bytes) => Ok((m.to, bytes)),
            Err(e) => Err(bad(m.from, &e)),
        });
        let frames = encoded.collect::<Result<Vec<_>, _>>().inspect_err(|error| self.report(error))?;
        let state = if busy { BUSY } else { IDLE };
        // A pipe breaks when the coordinator has ended.
        write_round(&mut self.output, state, &frames).map_err(|_| TransportError::Stopped)?;
        let (active, frames) = read_round(&mut self.input).map_err(|error| match error.kind() {
            ErrorKind::InvalidData => {
                let error = bad(COORDINATOR, &error);
                self.report(&error);
                error
            }
            _ => TransportError::Stopped,
        })?;
        let decoded = frames.iter().map(|(_, bytes)| Message::decode(bytes).map_err(|e| bad(0, &e)));
        let inbox = decoded.collect::<Result<_, _>>().inspect_err(|error| self.report(error))?;
        Ok(Delivery { inbox, active: active != 0 })
    }
}

impl<R: Read, W> Pipe<R, W> {
    /// Reads the input of the worker.
    fn read_assigned<P: Point>(&mut self) -> Result<Assigned<P>, TransportError> {
        let (_, frames) = read_round(&mut self.input).map_err(|error| match error.kind() {
            ErrorKind::InvalidData => bad(COORDINATOR, &error),
            // A pipe breaks when the coordinator has ended.
            _ => TransportError::Stopped,
        })?;
        let [(_, bytes)] = frames.as_slice() else {
            return Err(bad(COORDINATOR, &"it did not send one block"));
        };
        Assigned::from_bytes(bytes).map_err(|e| bad(COORDINATOR, &e))
    }
}

impl<R, W: Write> Pipe<R, W> {
    /// Reports an error to the coordinator, if the coordinator is still running.
    fn report(&mut self, error: &TransportError) {
        if let Ok(bytes) = codec::encode(error) {
            let _ = write_round(&mut self.output, FAILED, &[(COORDINATOR, bytes)]);
        }
    }
}

/// Runs one worker over a pair of pipes until the run is over: the main function of a worker's process. Errors are also
/// reported to the coordinator.
///
/// # Errors
/// Returns the error of the worker, or [`TransportError::Stopped`] if the coordinator has ended.
pub fn serve_pipe<P: Point>(
    input: impl Read + Send,
    output: impl Write + Send,
    rank: Rank,
    config: WorkerConfig,
) -> Result<(), TransportError> {
    let mut pipe = Pipe { input: BufReader::new(input), output: BufWriter::new(output) };
    let assigned = pipe.read_assigned::<P>().inspect_err(|error| pipe.report(error))?;
    let job = Job { config: Arc::new(config), source: &assigned, plan: assigned.plan() };
    let mut host = Host::<P>::new(std::iter::once(rank), &job, &None);
    serve(&mut pipe, &mut host, &mut Unwatched)?;
    for share in host.into_shares() {
        let bytes = share_to_bytes(&share).map_err(|e| bad(rank, &e));
        let bytes = bytes.inspect_err(|error| pipe.report(error))?;
        let sent = write_round(&mut pipe.output, IDLE, &[(COORDINATOR, bytes)]);
        sent.map_err(|_| TransportError::Stopped)?;
    }
    Ok(())
}
