//! MPI as a wire.
//!
//! An exchange is sparse (the algorithm NBX): a send is synchronous, so it is complete only after its receiver has
//! accepted it. A process whose sends are complete enters a reduction that does not block, and the reduction ends after
//! all members have entered it. Until then the process accepts messages. So no process needs to know its senders.

use std::collections::{BTreeMap, BTreeSet};

use mpi::Tag;
use mpi::collective::{CommunicatorCollectives, SystemOperation};
use mpi::datatype::Equivalence;
use mpi::point_to_point::{Destination, Message, Source};
use mpi::request;
use mpi::topology::{Communicator, Group, Rank, SimpleCommunicator};
use septet_protocol::wire::{Arrived, Parcel, PartBytes, Wire, WireError};

use crate::idle::Idle;
use crate::parts::{Inbox, Outgoing};

/// The number of tags. A process can be one round ahead of another one, so two tags would suffice; MPI has at least 2^15.
const TAGS: Tag = 1 << 15;

/// A connection of processes by MPI.
///
/// Open MPI and MPICH end all processes if one is lost or if a call of MPI fails. So no exchange fails with
/// [`WireError::Lost`]. The wire cannot move to another thread, because only the main thread may call MPI.
pub struct MpiWire {
    process: u32,
    processes: u32,
    part_bytes: PartBytes,
    /// The members of exchanges, by their number.
    groups: BTreeMap<u32, Members>,
}

impl MpiWire {
    /// Connects the processes of a communicator. All of them make this call. The wire has a communicator of its own, so
    /// its messages do not meet those of the caller. It must end before MPI does.
    pub fn new(communicator: &dyn Communicator) -> Self {
        let all = communicator.duplicate();
        let (process, processes) = (all.rank() as u32, all.size() as u32);
        let groups = BTreeMap::from([(processes, Members::new(all))]);
        MpiWire { process, processes, part_bytes: PartBytes::default(), groups }
    }
}

impl Wire for MpiWire {
    fn process(&self) -> u32 {
        self.process
    }

    fn processes(&self) -> u32 {
        self.processes
    }

    fn exchange(&mut self, members: u32, sent: Vec<Parcel>, state: u8) -> Result<Arrived, WireError> {
        assert!(self.process < members && members <= self.processes, "this process is not a member");
        let receivers: BTreeSet<u32> = sent.iter().map(|parcel| parcel.process).collect();
        let is_valid = receivers.iter().all(|&process| process < members && process != self.process);
        assert!(is_valid && receivers.len() == sent.len(), "a member gets at most one parcel");
        if members == 1 {
            return Ok(Arrived { parcels: Vec::new(), state });
        }
        if !self.groups.contains_key(&members) {
            let first = self.groups[&self.processes].first(members);
            self.groups.insert(members, first);
        }
        let part_bytes = self.part_bytes.get();
        let sent: Vec<_> = sent.into_iter().map(|parcel| Outgoing::new(parcel, part_bytes)).collect();
        self.groups.get_mut(&members).expect("the group exists").exchange(&sent, part_bytes, state)
    }

    /// Cuts parcels into parts. The last part has eight more bytes.
    fn set_part_bytes(&mut self, part_bytes: PartBytes) {
        self.part_bytes = part_bytes;
    }
}

/// The processes that take part in an exchange. Their ranks in the communicator are their numbers.
struct Members {
    communicator: SimpleCommunicator,
    /// The number of exchanges so far, modulo the number of tags.
    round: Tag,
}

impl Members {
    fn new(communicator: SimpleCommunicator) -> Self {
        Members { communicator, round: 0 }
    }

    /// Connects the first `members` processes. Only these make this call.
    fn first(&self, members: u32) -> Self {
        let ranks: Vec<Rank> = (0..members as Rank).collect();
        let group = self.communicator.group().include(&ranks);
        let first = self.communicator.split_by_subgroup(&group);
        Members::new(first.expect("this process is a member"))
    }

    fn exchange(&mut self, sent: &[Outgoing], part_bytes: usize, state: u8) -> Result<Arrived, WireError> {
        // MPICH 4.0 compares bytes as signed numbers, so the state is reduced as a longer number.
        let (tag, own, mut largest) = (self.round, [i32::from(state)], [0_i32]);
        self.round = (self.round + 1) % TAGS;
        let mut inbox = Inbox::new(part_bytes);
        let mut idle = Idle::begin();
        let count = sent.iter().map(|parcel| parcel.messages(part_bytes).count()).sum();
        request::multiple_scope(count, |scope, sends| {
            for parcel in sent {
                let receiver = self.communicator.process_at_rank(parcel.process as Rank);
                for message in parcel.messages(part_bytes) {
                    sends.add(receiver.immediate_synchronous_send_with_tag(scope, message, tag));
                }
            }
            let (mut pending, mut completed) = (count, Vec::new());
            while pending > 0 {
                sends.test_some(&mut completed);
                pending -= completed.len();
                let is_new = self.accept(tag, &mut inbox);
                if is_new || !completed.is_empty() { idle.reset() } else { idle.rest() }
            }
            let all = &self.communicator;
            let mut end = all.immediate_all_reduce_into(scope, &own, &mut largest, SystemOperation::max());
            while let Err(open) = end.test() {
                end = open;
                if self.accept(tag, &mut inbox) { idle.reset() } else { idle.rest() }
            }
        });
        Ok(Arrived { parcels: inbox.finish()?, state: largest[0] as u8 })
    }

    /// Receives a message of the round, if there is one.
    fn accept(&self, tag: Tag, inbox: &mut Inbox) -> bool {
        let any = self.communicator.any_process();
        let Some((message, status)) = any.immediate_matched_probe_with_tag(tag) else { return false };
        let (process, bytes) = (status.source_rank() as u32, status.count(u8::equivalent_datatype()));
        receive(message, inbox.room(process, bytes as usize));
        inbox.arrived(process);
        true
    }
}

/// Receives a message whose sender is known. The sender may have to push it, so the process rests in between.
fn receive(message: Message, room: &mut [u8]) {
    let mut idle = Idle::begin();
    request::scope(|scope| {
        let mut receipt = message.immediate_matched_receive_into(scope, room);
        while let Err(open) = receipt.test() {
            receipt = open;
            idle.rest();
        }
    });
}
