//! Messages in transit: the ids of their arrows, and their bytes.

use std::collections::BTreeMap;

/// The identity of a message: run, sender, and sequence number of the sender.
pub(super) type Name = (u64, u64, u64);

/// The messages in transit.
#[derive(Debug, Default)]
pub(super) struct Flights {
    next: u64,
    open: BTreeMap<Name, (u64, u64)>,
    /// Bytes in transit in each run.
    sums: BTreeMap<u64, u64>,
}

impl Flights {
    /// Adds a sent message, and returns the id of its arrow.
    pub(super) fn leave(&mut self, name: Name, bytes: u64) -> u64 {
        self.next += 1;
        self.open.insert(name, (self.next, bytes));
        *self.sums.entry(name.0).or_default() += bytes;
        self.next
    }

    /// Removes a received message and returns the id of its arrow. Returns `None` if the sending was not recorded, or
    /// if the message has already arrived.
    pub(super) fn arrive(&mut self, name: Name) -> Option<u64> {
        let (id, bytes) = self.open.remove(&name)?;
        *self.sums.entry(name.0).or_default() -= bytes;
        Some(id)
    }

    /// Returns the number of bytes in transit in a run.
    pub(super) fn in_flight(&self, run: u64) -> u64 {
        self.sums.get(&run).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leaves_is_in_flight_until_its_first_arrival() {
        let mut flights = Flights::default();
        let a = flights.leave((1, 2, 3), 10);
        let b = flights.leave((1, 4, 3), 5);
        assert_ne!(a, b);
        assert_eq!(flights.in_flight(1), 15);
        assert_eq!(flights.arrive((1, 2, 3)), Some(a));
        assert_eq!(flights.arrive((1, 2, 3)), None);
        assert_eq!(flights.arrive((2, 4, 3)), None);
        assert_eq!((flights.in_flight(1), flights.in_flight(2)), (5, 0));
    }
}
