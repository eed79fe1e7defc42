//! A host runs ranks: the loop that every thread or process of workers runs.

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::message::Message;
use septet_protocol::transport::{Transport, TransportError};

use crate::schedule::next;
use crate::worker::Worker;

/// Runs workers until the last phase is over: one exchange a round, a phase ends when nothing moved.
///
/// # Errors
/// What the transport or a worker reports.
pub fn serve<P: Point>(
    transport: &mut dyn Transport<P>,
    workers: &mut [Worker<P>],
) -> Result<(), TransportError> {
    let mut phase = Phase::Load;
    let mut round = 0;
    let mut outbox = Vec::new();
    while phase != Phase::Done {
        let busy = workers.iter().any(Worker::busy);
        let delivery = transport.exchange(std::mem::take(&mut outbox), busy)?;
        round += 1;
        if delivery.active {
            outbox = step_all(workers, round, delivery.inbox)?;
        } else if let Some(worker) = workers.first() {
            phase = worker.next_phase();
            for worker in workers.iter_mut() {
                outbox.extend(worker.begin(phase, round)?);
            }
        } else {
            return Ok(());
        }
    }
    Ok(())
}

/// Hands each worker its messages.
///
/// # Errors
/// What a worker reports.
pub fn step_all<P: Point>(
    workers: &mut [Worker<P>],
    round: u32,
    inbox: Vec<Message<P>>,
) -> Result<Vec<Message<P>>, TransportError> {
    let first = workers.first().map_or(0, Worker::rank);
    let stride = workers.get(1).map_or(1, |w| w.rank() - first).max(1);
    let mut boxes: Vec<Vec<Message<P>>> = workers.iter().map(|_| Vec::new()).collect();
    for message in inbox {
        let place = message.to.checked_sub(first).map(|d| d / stride).map(|i| i as usize);
        let place = place.filter(|&i| workers.get(i).is_some_and(|w| w.rank() == message.to));
        if let Some(i) = place {
            boxes[i].push(message);
        } else {
            let reason = format!("it is for rank {}, which is not here", message.to);
            return Err(TransportError::BadMessage { from: message.from, reason });
        }
    }
    let mut outbox = Vec::new();
    for (worker, inbox) in workers.iter_mut().zip(boxes) {
        outbox.extend(worker.step(round, inbox)?);
    }
    Ok(outbox)
}

impl<P: Point> Worker<P> {
    /// The phase after the present one.
    pub fn next_phase(&self) -> Phase {
        next(self.phase, &self.config, &self.known)
    }
}
