//! The traffic of the ledger as rows, by sender, receiver and round. If there are many ranks, they are grouped in
//! bins.

use std::collections::BTreeMap;

use serde::Serialize;

use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::{Ledger, LedgerPart, LinkKey, RankKey, Traffic};

/// Largest number of bins of contiguous workers.
pub const MOST_BINS: u32 = 512;

/// A bin of ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BinReport {
    /// First rank; the coordinator is 0 and has its own bin.
    pub first: Rank,
    /// Last rank.
    pub last: Rank,
}

/// Messages by phase, sender and receiver.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrafficReport {
    /// The bins. `from` and `to` are positions in this list.
    pub bins: Vec<BinReport>,
    /// Whether some bins contain more than one rank.
    pub grouped: bool,
    /// One row for each phase and pair of bins with messages.
    pub rows: Vec<LinkReport>,
}

/// The messages from one bin to another in a phase.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LinkReport {
    /// The phase.
    pub phase: &'static str,
    /// Sender: a position in `bins`.
    pub from: u32,
    /// Receiver: a position in `bins`.
    pub to: u32,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
}

/// Messages by round, phase and sender.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TimelineReport {
    /// The bins. `worker` is a position in this list.
    pub bins: Vec<BinReport>,
    /// Whether some bins contain more than one rank.
    pub grouped: bool,
    /// One row for each round, phase and bin with messages.
    pub rows: Vec<SenderReport>,
}

/// The messages of one bin in a round.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SenderReport {
    /// The round.
    pub round: u32,
    /// The phase.
    pub phase: &'static str,
    /// Sender: a position in `bins`.
    pub worker: u32,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of all messages.
    pub bytes: u64,
    /// Number of points in the messages.
    pub points: u64,
}

/// Returns the bins of a machine: the coordinator, then workers in equal shares.
fn bins(workers: u32) -> Vec<BinReport> {
    let count = u64::from(workers.min(MOST_BINS));
    let start = |bin: u64| 1 + (u64::from(workers) * bin).checked_div(count).unwrap_or(0) as Rank;
    let share = |bin| BinReport { first: start(bin), last: start(bin + 1) - 1 };
    std::iter::once(BinReport { first: 0, last: 0 }).chain((0..count).map(share)).collect()
}

fn bin_of(bins: &[BinReport], rank: Rank) -> u32 {
    bins.partition_point(|b| b.last < rank) as u32
}

/// Replaces every rank by the first rank of its bin. The number of rows then has a bound, however many workers there are, and
/// the rows of the report are the same.
pub fn bin_ranks(part: &mut LedgerPart, workers: u32) {
    if workers <= MOST_BINS {
        return;
    }
    let bins = bins(workers);
    let first = |rank: Rank| bins[bin_of(&bins, rank) as usize].first;
    for (key, moved) in std::mem::take(&mut part.links) {
        let bin = LinkKey { from: first(key.from), to: first(key.to), ..key };
        part.links.entry(bin).or_default().add(&moved);
    }
    for (key, tally) in std::mem::take(&mut part.ranks) {
        part.rank(RankKey { rank: first(key.rank), ..key }).add(&tally);
    }
}

/// Returns the messages by sender and receiver.
pub(super) fn links(ledger: &Ledger, workers: u32) -> TrafficReport {
    let bins = bins(workers);
    let mut sums: BTreeMap<(Phase, u32, u32), Traffic> = BTreeMap::new();
    for (&LinkKey { phase, from, to }, moved) in &ledger.part.links {
        sums.entry((phase, bin_of(&bins, from), bin_of(&bins, to))).or_default().add(moved);
    }
    let row = |((phase, from, to), moved): ((Phase, u32, u32), Traffic)| LinkReport {
        phase: phase.name(),
        from,
        to,
        messages: moved.messages,
        bytes: moved.bytes,
    };
    TrafficReport { grouped: workers > MOST_BINS, rows: sums.into_iter().map(row).collect(), bins }
}

/// Returns the messages by round and sender.
pub(super) fn senders(ledger: &Ledger, workers: u32) -> TimelineReport {
    let bins = bins(workers);
    let mut sums: BTreeMap<(u32, Phase, u32), Traffic> = BTreeMap::new();
    for (&RankKey { round, phase, rank }, tally) in &ledger.part.ranks {
        if tally.sent.messages > 0 {
            sums.entry((round, phase, bin_of(&bins, rank))).or_default().add(&tally.sent);
        }
    }
    let row = |((round, phase, worker), moved): ((u32, Phase, u32), Traffic)| SenderReport {
        round,
        phase: phase.name(),
        worker,
        messages: moved.messages,
        bytes: moved.bytes,
        points: moved.points,
    };
    TimelineReport { grouped: workers > MOST_BINS, rows: sums.into_iter().map(row).collect(), bins }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binned_ledgers_have_the_same_rows() {
        let workers = 2 * MOST_BINS + 100;
        let mut part = LedgerPart::default();
        for from in 0..=workers {
            let moved = Traffic { messages: 1, bytes: 10 + u64::from(from), points: 3 };
            part.bill(
                RankKey { round: from % 3, phase: Phase::Halo, rank: from },
                (from * 7) % workers,
                moved,
            );
        }
        let rows = |part: &LedgerPart| {
            let ledger = Ledger { part: part.clone(), ..Ledger::default() };
            (links(&ledger, workers), senders(&ledger, workers))
        };
        let (whole, of_ranks) = (rows(&part), part.ranks.len());
        bin_ranks(&mut part, workers);
        assert_eq!(rows(&part), whole);
        assert!(part.ranks.len() < of_ranks);
        let before = part.clone();
        bin_ranks(&mut part, MOST_BINS);
        assert_eq!(part, before);
    }

    #[test]
    fn every_rank_has_one_bin() {
        for workers in [0, 1, 2, 511, 512, 513, 1000, 4096] {
            let bins = bins(workers);
            assert!(bins.len() as u32 <= MOST_BINS + 1);
            for rank in 0..=workers {
                let bin = bins[bin_of(&bins, rank) as usize];
                assert!((bin.first..=bin.last).contains(&rank), "{rank} of {workers}");
            }
        }
    }
}
