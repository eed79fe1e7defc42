//! The rounds of a machine, each with the largest loads of a rank.

use std::collections::BTreeMap;

use septet_protocol::ids::Rank;
use septet_protocol::ledger::{Ledger, RankKey, RankTally};

use super::hardware::Hardware;

/// The largest loads of a rank in one round. Each may be the load of a different rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Round {
    /// Charged work.
    pub(super) work: u64,
    /// Seconds of computation.
    pub(super) compute: f64,
    /// Bytes in one direction: the `h` of an h-relation.
    pub(super) bytes: u64,
    /// Seconds that a rank needs for its messages, without latency.
    pub(super) transfer: f64,
}

impl Round {
    fn most(self, other: Round) -> Round {
        Round {
            work: self.work.max(other.work),
            compute: self.compute.max(other.compute),
            bytes: self.bytes.max(other.bytes),
            transfer: self.transfer.max(other.transfer),
        }
    }
}

/// Returns the rounds of a ledger, in order.
pub(super) fn rounds<'a>(ledger: &'a Ledger, hardware: &'a Hardware) -> impl Iterator<Item = Round> + 'a {
    let rows: Vec<(&RankKey, &RankTally)> = ledger.part.ranks.iter().collect();
    let mut first = 0;
    std::iter::from_fn(move || {
        let round = rows.get(first)?.0.round;
        let same = rows[first..].iter().take_while(|(key, _)| key.round == round).count();
        let rows = &rows[first..first + same];
        first += same;
        Some(slowest(rows, hardware))
    })
}

/// Returns the largest loads of one round. A round that ends one phase and begins another has rows of both.
fn slowest(rows: &[(&RankKey, &RankTally)], hardware: &Hardware) -> Round {
    let mut sums: BTreeMap<Rank, (f64, RankTally)> = BTreeMap::new();
    for (key, tally) in rows {
        let (compute, sum) = sums.entry(key.rank).or_default();
        *compute += tally.work as f64 / hardware.rate_of(key.phase);
        sum.add(tally);
    }
    let loads = sums.into_values().map(|(compute, RankTally { work, sent, received })| {
        let bytes = sent.bytes.max(received.bytes);
        let messages = (sent.messages + received.messages) as f64;
        let transfer = messages * hardware.overhead + bytes as f64 / hardware.bandwidth;
        Round { work, compute, bytes, transfer }
    });
    loads.fold(Round::default(), Round::most)
}
