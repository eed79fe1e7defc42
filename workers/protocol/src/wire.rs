//! Bytes between processes, and the collective operations of processes around a run.
//!
//! A [`Wire`] connects processes, for example through sockets or MPI. [`Processes`] adds checksums and the collective
//! operations. All calls are collective: every process makes the same calls in the same order.

use bincode::{Decode, Encode};
use thiserror::Error;

use crate::checksum::checksum;
use crate::codec;

/// Bytes from a process or to a process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parcel {
    /// The other process: the receiver of a parcel that is sent, the sender of one that arrived.
    pub process: u32,
    /// The content.
    pub bytes: Vec<u8>,
}

/// The result of an exchange for one process.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Arrived {
    /// The parcels to this process, in the order of their senders.
    pub parcels: Vec<Parcel>,
    /// The largest state of all members.
    pub state: u8,
}

/// The reason why processes lost each other. The run cannot continue.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum WireError {
    /// A process ended, or its connection broke.
    #[error("process {process} is gone: {reason}")]
    Lost {
        /// The process.
        process: u32,
        /// The reason, as the connection reports it.
        reason: String,
    },
    /// The bytes of a parcel are not those that were sent.
    #[error("process {process} sent a parcel that does not decode: {reason}")]
    Corrupt {
        /// The sender.
        process: u32,
        /// The defect.
        reason: String,
    },
}

/// The error with which all processes of a run end: the first one, by the number of its process.
#[derive(Clone, Debug, PartialEq, Eq, Error, Encode, Decode)]
#[error("{message}")]
pub struct Refused {
    /// The process that had the error.
    pub process: u32,
    /// The exit code of the program.
    pub code: u8,
    /// The message, which names the place.
    pub message: String,
    /// The template of the remedy, or nothing.
    pub remedy: String,
}

/// The end of a run on all processes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Ended {
    /// All processes know the error.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// The processes lost each other.
    #[error(transparent)]
    Wire(#[from] WireError),
}

/// The largest number of bytes of a part of a parcel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartBytes(usize);

impl PartBytes {
    /// The largest possible number, because a message of MPI has at most 2^31 - 1 bytes.
    pub const MOST: u64 = 1 << 30;

    /// Returns the number, which must be between 1 and [`PartBytes::MOST`].
    pub fn new(bytes: u64) -> Option<Self> {
        (1..=Self::MOST).contains(&bytes).then_some(PartBytes(bytes as usize))
    }

    /// Returns the number of bytes.
    pub fn get(self) -> usize {
        self.0
    }
}

impl Default for PartBytes {
    /// Returns 256 MiB.
    fn default() -> Self {
        PartBytes(1 << 28)
    }
}

/// A connection of processes, which are numbered from 0.
pub trait Wire {
    /// Returns the number of this process.
    fn process(&self) -> u32;

    /// Returns the number of processes.
    fn processes(&self) -> u32;

    /// Sends at most one parcel to each other process, and receives the parcels to this one. The first `members` processes
    /// take part, and this process is one of them. The call returns when all members have made it.
    ///
    /// # Errors
    /// Fails if a member is gone.
    fn exchange(&mut self, members: u32, sent: Vec<Parcel>, state: u8) -> Result<Arrived, WireError>;

    /// Cuts the parcels of later exchanges into parts of at most this many bytes. Their receivers see whole parcels. All processes
    /// make this call between the same exchanges. A wire that moves whole parcels, such as one between threads, ignores it.
    fn set_part_bytes(&mut self, part_bytes: PartBytes);
}

/// The wire of a process alone, which has nobody to send to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Wire for Alone {
    fn process(&self) -> u32 {
        0
    }

    fn processes(&self) -> u32 {
        1
    }

    fn exchange(&mut self, _: u32, _: Vec<Parcel>, state: u8) -> Result<Arrived, WireError> {
        Ok(Arrived { parcels: Vec::new(), state })
    }

    fn set_part_bytes(&mut self, _: PartBytes) {}
}

/// The processes of a run, connected by a wire.
pub struct Processes<'a> {
    wire: &'a mut dyn Wire,
    /// Bytes that this process received and sent.
    moved: [u64; 2],
}

impl<'a> Processes<'a> {
    /// Wraps a wire.
    pub fn over(wire: &'a mut dyn Wire) -> Self {
        Processes { wire, moved: [0; 2] }
    }

    /// Returns the number of this process.
    pub fn process(&self) -> u32 {
        self.wire.process()
    }

    /// Returns the number of processes.
    pub fn processes(&self) -> u32 {
        self.wire.processes()
    }

    /// Returns the bytes that this process has received from other processes and sent to them.
    pub fn moved(&self) -> [u64; 2] {
        self.moved
    }

    /// Cuts later parcels into parts of at most this many bytes, on all processes.
    pub fn set_part_bytes(&mut self, part_bytes: PartBytes) {
        self.wire.set_part_bytes(part_bytes);
    }

    /// Sends at most one parcel to each of the first `members` processes, this one included. Returns the parcels to this
    /// process in the order of their senders, and the largest state.
    ///
    /// # Errors
    /// Fails if a member is gone, or if bytes changed on the way.
    pub fn exchange(&mut self, members: u32, mut sent: Vec<Parcel>, state: u8) -> Result<Arrived, WireError> {
        let process = self.process();
        let own = sent.iter().position(|parcel| parcel.process == process).map(|at| sent.swap_remove(at));
        for parcel in &mut sent {
            let sum = checksum(&parcel.bytes);
            parcel.bytes.extend_from_slice(&sum.to_le_bytes());
            self.moved[1] += parcel.bytes.len() as u64;
        }
        let mut arrived = self.wire.exchange(members, sent, state)?;
        for parcel in &mut arrived.parcels {
            self.moved[0] += parcel.bytes.len() as u64;
            open(parcel)?;
        }
        if let Some(own) = own {
            let at = arrived.parcels.partition_point(|parcel| parcel.process < process);
            arrived.parcels.insert(at, own);
        }
        Ok(arrived)
    }

    /// Sends a parcel to each process. Returns the parcels to this process.
    ///
    /// # Errors
    /// See [`Processes::exchange`].
    pub fn scatter(&mut self, sent: Vec<Parcel>) -> Result<Vec<Parcel>, WireError> {
        Ok(self.exchange(self.processes(), sent, 0)?.parcels)
    }

    /// Sends a value of each process to the first one. Returns the values there, in the order of the processes, and no
    /// values on the others.
    ///
    /// # Errors
    /// See [`Processes::all_gather`].
    pub fn gather<T: Encode + Decode<()>>(&mut self, value: &T) -> Result<Vec<T>, WireError> {
        let own = self.process();
        let bytes =
            codec::encode(value).map_err(|e| WireError::Corrupt { process: own, reason: e.to_string() })?;
        let parcels = self.scatter(vec![Parcel { process: 0, bytes }])?;
        parcels.iter().map(decoded).collect()
    }

    /// Returns the value of this process if no process has an error.
    ///
    /// # Errors
    /// Returns the first error, on all processes, with the exit code, the message and the remedy that `describe` returns for it.
    pub fn agree<T, E>(
        &mut self,
        own: Result<T, E>,
        describe: impl FnOnce(&E) -> (u8, String, String),
    ) -> Result<T, Ended> {
        let process = self.process();
        let refused = own.as_ref().err().map(|error| {
            let (code, message, remedy) = describe(error);
            Refused { process, code, message, remedy }
        });
        match (self.all_gather(&refused)?.into_iter().flatten().next(), own) {
            (None, Ok(value)) => Ok(value),
            (Some(first), _) => Err(first.into()),
            (None, Err(_)) => {
                Err(WireError::Lost { process, reason: "its own error is lost".to_string() }.into())
            }
        }
    }

    /// Returns the values of all processes, in their order.
    ///
    /// # Errors
    /// See [`Processes::exchange`]. Also fails if a value does not decode.
    pub fn all_gather<T: Encode + Decode<()>>(&mut self, value: &T) -> Result<Vec<T>, WireError> {
        let corrupt = |process: u32, reason: String| WireError::Corrupt { process, reason };
        let bytes = codec::encode(value).map_err(|e| corrupt(self.process(), e.to_string()))?;
        let to_each = (0..self.processes()).map(|process| Parcel { process, bytes: bytes.clone() });
        let parcels = self.scatter(to_each.collect())?;
        if parcels.len() != self.processes() as usize {
            return Err(corrupt(self.process(), format!("{} values arrived", parcels.len())));
        }
        parcels.iter().map(decoded).collect()
    }
}

fn decoded<T: Decode<()>>(parcel: &Parcel) -> Result<T, WireError> {
    codec::decode(&parcel.bytes)
        .map_err(|e| WireError::Corrupt { process: parcel.process, reason: e.to_string() })
}

/// Checks the checksum of a parcel, and removes it.
fn open(Parcel { process, bytes }: &mut Parcel) -> Result<(), WireError> {
    let changed = || WireError::Corrupt { process: *process, reason: "its checksum is wrong".to_string() };
    let end = bytes.len().checked_sub(8).ok_or_else(changed)?;
    if checksum(&bytes[..end]).to_le_bytes() != bytes[end..] {
        return Err(changed());
    }
    bytes.truncate(end);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wire of one process, which returns these parcels as those of other processes.
    struct Alone {
        arrives: Vec<Parcel>,
    }

    impl Wire for Alone {
        fn process(&self) -> u32 {
            1
        }

        fn processes(&self) -> u32 {
            3
        }

        fn exchange(&mut self, _: u32, _: Vec<Parcel>, state: u8) -> Result<Arrived, WireError> {
            Ok(Arrived { parcels: std::mem::take(&mut self.arrives), state })
        }

        fn set_part_bytes(&mut self, _: PartBytes) {}
    }

    fn sealed(process: u32, bytes: &[u8]) -> Parcel {
        let sum = checksum(bytes).to_le_bytes();
        Parcel { process, bytes: [bytes, &sum].concat() }
    }

    #[test]
    fn parts_have_1_byte_to_1_gib() {
        assert_eq!(
            [0, 1, 4096, 1 << 30, (1 << 30) + 1].map(|n| PartBytes::new(n).map(PartBytes::get)),
            [None, Some(1), Some(4096), Some(1 << 30), None]
        );
        assert_eq!(PartBytes::new(1 << 28), Some(PartBytes::default()));
    }

    #[test]
    fn values_arrive_in_the_order_of_the_processes() {
        let [zero, two] = [0_u32, 2].map(|of| sealed(of, &codec::encode(&(of * 10)).unwrap()));
        let mut wire = Alone { arrives: vec![zero, two] };
        let mut processes = Processes::over(&mut wire);
        assert_eq!(processes.all_gather(&10_u32).unwrap(), [0, 10, 20]);
        assert!(processes.moved().iter().all(|&bytes| bytes > 0));
        assert!(
            matches!(processes.all_gather(&10_u32), Err(WireError::Corrupt { .. })),
            "values are missing"
        );
    }

    #[test]
    fn the_first_error_ends_all_processes() {
        let first = Refused { process: 0, code: 3, message: "bad row".into(), remedy: "drop it".into() };
        for own in [Ok(7), Err("no space")] {
            let [zero, two] = [(0, Some(first.clone())), (2, None)]
                .map(|(of, it)| sealed(of, &codec::encode(&it).unwrap()));
            let mut wire = Alone { arrives: vec![zero, two] };
            let agreed = Processes::over(&mut wire).agree(own, |error| (1, error.to_string(), String::new()));
            assert_eq!(agreed, Err(Ended::Refused(first.clone())));
        }
        let none = codec::encode(&None::<Refused>).unwrap();
        let arrives = || vec![sealed(0, &none), sealed(2, &none)];
        let agreed =
            Processes::over(&mut Alone { arrives: arrives() }).agree(Ok::<_, String>(7), |_| unreachable!());
        assert_eq!(agreed, Ok(7));
        let agreed = Processes::over(&mut Alone { arrives: arrives() })
            .agree(Err::<u8, _>(4), |_| (1, "no".into(), "yes".into()));
        assert_eq!(
            agreed,
            Err(Refused { process: 1, code: 1, message: "no".into(), remedy: "yes".into() }.into())
        );
    }

    #[test]
    fn changed_parcels_are_refused() {
        for bit in 0..8 * 12 {
            let mut parcel = sealed(2, b"four");
            parcel.bytes[bit / 8] ^= 1 << (bit % 8);
            let mut wire = Alone { arrives: vec![parcel] };
            let arrived = Processes::over(&mut wire).exchange(3, Vec::new(), 0);
            assert!(matches!(arrived, Err(WireError::Corrupt { process: 2, .. })), "bit {bit}: {arrived:?}");
        }
        let mut wire = Alone { arrives: vec![Parcel { process: 0, bytes: vec![1] }] };
        assert!(Processes::over(&mut wire).scatter(Vec::new()).is_err(), "too short");
    }
}
