//! A bit of a message that is flipped before the message is sent.

use septet_geometry::hash::mix;
use septet_protocol::ids::{COORDINATOR, Rank};
use septet_protocol::message::KINDS;

/// The kinds that only the coordinator sends.
const OF_COORDINATOR: [&str; 5] = ["start", "block", "choice", "outcome", "region"];

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

    /// Returns `true` if the flip strikes message number `earlier` of its kind from rank `from`, out of `ranks` ranks.
    pub(crate) fn strikes(self, from: Rank, ranks: u32, earlier: u32) -> bool {
        let [lot, place] = [1, 2].map(|use_of| mix(use_of, self.seed));
        // The coordinator sends much, so it is drawn as often as all workers together if there are three.
        let drawn = match (lot % 4, ranks - 1) {
            (0, _) | (_, 0) => COORDINATOR,
            (_, workers) => 1 + (lot / 4 % u64::from(workers)) as Rank,
        };
        let sender = if OF_COORDINATOR.contains(&self.kind) { COORDINATOR } else { drawn };
        // Each number is half as likely as the number before, so most flips strike.
        from == sender && earlier == place.trailing_zeros()
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
    fn a_flip_strikes_at_most_one_message_of_a_run() {
        let all = || (0..9).flat_map(|from| (0..64).map(move |earlier| (from, earlier)));
        let mut by_workers = 0;
        for seed in 0..400 {
            let struck = |kind: &str| {
                let flip = Flip::new(kind, seed).unwrap();
                assert!((1..70).all(|bits| flip.bit(bits) < bits));
                all().filter(|&(from, earlier)| flip.strikes(from, 9, earlier)).collect::<Vec<_>>()
            };
            assert!(matches!(struck("block")[..], [(COORDINATOR, _)]));
            let [(from, _)] = struck("move")[..] else { panic!("one message of all") };
            by_workers += usize::from(from > 0);
        }
        assert!((250..350).contains(&by_workers), "{by_workers}");
        assert_eq!(Flip::new("lunch", 0), None);
    }
}
