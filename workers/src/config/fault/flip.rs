//! A bit of a message that is flipped before the message is sent.

use septet_geometry::hash::mix;
use septet_protocol::ids::{COORDINATOR, Rank};
use septet_protocol::message::kinds::KINDS;

/// The kinds that the coordinator sends first. In machines of up to 33 ranks, no other rank sends them.
const OF_COORDINATOR: [&str; 2] = ["choice", "outcome"];

/// One flipped bit in one message of a kind. The sender of the message, the number of earlier messages of that kind from
/// that sender, and the bit depend on the seed. If the sender sends fewer messages of that kind, no bit is flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    /// The name of the kind.
    kind: &'static str,
    /// The seed of the choice.
    seed: u64,
}

impl Flip {
    /// Creates the fault, if there is a kind of this name.
    pub fn new(kind: &str, seed: u64) -> Option<Self> {
        KINDS.into_iter().find(|&name| name == kind).map(|kind| Flip { kind, seed })
    }

    /// Returns the name of the kind.
    pub fn kind(self) -> &'static str {
        self.kind
    }

    /// Returns the seed.
    pub fn seed(self) -> u64 {
        self.seed
    }

    /// Returns the sender of the message in a machine of `ranks` ranks, and the number of the sender's earlier messages of
    /// that kind.
    pub fn target(self, ranks: u32) -> (Rank, u32) {
        let [lot, place] = [1, 2].map(|use_of| mix(use_of, self.seed));
        let drawn = (lot % u64::from(ranks)) as Rank;
        let sender = if OF_COORDINATOR.contains(&self.kind) { COORDINATOR } else { drawn };
        // Each number is half as likely as the number before, so most flips strike.
        (sender, place.trailing_zeros())
    }

    /// Returns the bit to flip in a body of `bits` bits, of which there is at least one.
    pub(crate) fn bit(self, bits: u64) -> u64 {
        mix(3, self.seed) % bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flips_strike_first_messages_of_all_senders() {
        let (mut by_workers, mut first) = (0, 0);
        for seed in 0..400 {
            let struck = |kind: &str| {
                let flip = Flip::new(kind, seed).unwrap();
                assert!((1..70).all(|bits| flip.bit(bits) < bits));
                flip.target(9)
            };
            assert_eq!(struck("choice").0, COORDINATOR);
            let (from, earlier) = struck("move");
            assert!(from < 9);
            by_workers += usize::from(from > 0);
            first += usize::from(earlier == 0);
        }
        assert!((330..380).contains(&by_workers) && (150..250).contains(&first), "{by_workers}, {first}");
        assert_eq!(Flip::new("lunch", 0), None);
    }
}
