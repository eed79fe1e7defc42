//! A wire between the threads of one program, for tests.

use std::sync::mpsc::{Receiver, Sender, channel};

use septet_protocol::wire::{Arrived, Parcel, PartBytes, Wire, WireError};

/// The bytes of a parcel, if there is one, and the state of its sender.
type Sent = (Option<Vec<u8>>, u8);

/// The ends of the channels of a process, one pair for each process.
pub(crate) struct Threads {
    process: u32,
    to: Vec<Sender<Sent>>,
    from: Vec<Receiver<Sent>>,
}

/// Connects processes.
pub(crate) fn connect(processes: u32) -> Vec<Threads> {
    let mut all: Vec<Threads> =
        (0..processes).map(|process| Threads { process, to: Vec::new(), from: Vec::new() }).collect();
    for from in 0..processes as usize {
        for to in 0..processes as usize {
            let (sender, receiver) = channel();
            all[from].to.push(sender);
            all[to].from.push(receiver);
        }
    }
    all
}

impl Wire for Threads {
    fn process(&self) -> u32 {
        self.process
    }

    fn processes(&self) -> u32 {
        self.to.len() as u32
    }

    fn exchange(&mut self, members: u32, sent: Vec<Parcel>, state: u8) -> Result<Arrived, WireError> {
        let lost = |process: u32| WireError::Lost { process, reason: "its thread ended".to_string() };
        let mut sent: Vec<_> = sent.into_iter().map(|Parcel { process, bytes }| (process, bytes)).collect();
        for (process, to) in (0..members).zip(&self.to) {
            let at = sent.iter().position(|(to, _)| *to == process);
            let bytes = at.map(|at| sent.swap_remove(at).1);
            to.send((bytes, state)).map_err(|_| lost(process))?;
        }
        assert!(sent.is_empty(), "parcels to processes that are no members");
        let mut arrived = Arrived::default();
        for (process, from) in (0..members).zip(&self.from) {
            let (bytes, state) = from.recv().map_err(|_| lost(process))?;
            arrived.parcels.extend(bytes.map(|bytes| Parcel { process, bytes }));
            arrived.state = arrived.state.max(state);
        }
        Ok(arrived)
    }

    fn set_part_bytes(&mut self, _: PartBytes) {}
}
