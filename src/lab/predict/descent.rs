//! Replays descents through the shared part of the tree: queries about balls with their replies, and pushed points.
//!
//! Balls of one leaf travel together until their paths separate. The record contains the number of balls that reach
//! each node. The reply to a batch of queries is one message. It is sent after the replies to all batches that the
//! batch caused.

use std::collections::{BTreeMap, BTreeSet};

use septet_protocol::ids::{Phase, Rank};

use super::machine::Replay;

/// For one group, and by the leaf of the balls that reach it: the numbers of balls, of entries that they find, and of
/// points in these entries.
type Reaching = BTreeMap<u32, [u64; 3]>;

/// A batch in transit.
struct Batch {
    from: Rank,
    to: Rank,
    group: usize,
    leaves: BTreeSet<u32>,
    /// Batches that caused this one. Their replies wait for the reply to this batch. Empty for balls that `from` owns.
    accounts: Vec<usize>,
    outstanding: usize,
}

/// Returns, for each group, how many balls of each leaf reach it.
fn reaching(replay: &Replay<'_>, phase: Phase) -> Vec<Reaching> {
    let numbers: BTreeMap<u64, usize> =
        replay.place.groups.iter().enumerate().map(|(at, g)| (g.node.0, at)).collect();
    let mut table = vec![Reaching::new(); replay.place.groups.len()];
    for &(p, leaf, node, balls, entries, points) in &replay.log.reach {
        if p == phase
            && let Some(&at) = numbers.get(&node)
        {
            table[at].insert(leaf, [balls, entries, points]);
        }
    }
    table
}

/// Batches that leave a rank: for each group and receiver, the leaves of the balls and the batches that caused it.
type Leaving = BTreeMap<(usize, Rank), (BTreeSet<u32>, BTreeSet<usize>)>;

/// Walks down from a shared group as its member `rank` does, and collects the batches for other ranks.
fn walk(
    replay: &Replay<'_>,
    table: &[Reaching],
    (mut at, rank): (usize, Rank),
    leaves: &BTreeSet<u32>,
    account: Option<usize>,
    out: &mut Leaving,
) {
    let mut under_way = leaves.clone();
    while let Some(children) = replay.place.groups[at].children {
        let mut inside = None;
        for child in children {
            let below = &replay.place.groups[child];
            let own = below.holds(rank) && (!below.whole || below.first == rank);
            let reached: BTreeSet<u32> =
                under_way.iter().copied().filter(|leaf| table[child].contains_key(leaf)).collect();
            if own {
                inside = Some((child, reached));
            } else if !reached.is_empty() {
                let to = replay.place.member_below(at, rank, child);
                let entry = out.entry((child, to)).or_default();
                entry.0.extend(reached);
                entry.1.extend(account);
            }
        }
        let Some((child, reached)) = inside else { return };
        (at, under_way) = (child, reached);
    }
}

/// Returns the batches of a rank's own balls.
fn set_out(replay: &Replay<'_>, table: &[Reaching], rank: Rank) -> Leaving {
    let mut out = Leaving::new();
    let leaves: BTreeSet<u32> = replay.place.leaves_of[&rank].iter().copied().collect();
    let piece = replay.place.piece[&rank];
    for at in replay.place.above(piece) {
        for child in replay.place.groups[at].children.into_iter().flatten() {
            if replay.place.groups[child].node.contains(replay.place.groups[piece].node) {
                continue;
            }
            let reached: BTreeSet<u32> =
                leaves.iter().copied().filter(|leaf| table[child].contains_key(leaf)).collect();
            if !reached.is_empty() {
                let to = replay.place.member_below(at, rank, child);
                out.entry((child, to)).or_default().0.extend(reached);
            }
        }
    }
    out
}

fn sum(table: &Reaching, leaves: &BTreeSet<u32>) -> [u64; 3] {
    let rows = leaves.iter().filter_map(|leaf| table.get(leaf));
    rows.fold([0; 3], |sum, row| [0, 1, 2].map(|i| sum[i] + row[i]))
}

/// Replays the balls of a phase and their replies. Returns, for each rank with balls at other ranks, the round in
/// which it receives the last reply, which is the round of its next message.
pub(super) fn queries(replay: &mut Replay<'_>, phase: Phase) -> BTreeMap<Rank, u32> {
    let table = reaching(replay, phase);
    let sizes = replay.sizes;
    let mut batches: Vec<Batch> = Vec::new();
    let mut done: BTreeMap<Rank, u32> = BTreeMap::new();
    let (mut arriving, mut answered): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    for &rank in replay.place.leaves_of.clone().keys() {
        let out = set_out(replay, &table, rank);
        post(replay, phase, 1, rank, out, &table, &mut batches, &mut arriving);
    }
    let mut round = 1;
    while !arriving.is_empty() || !answered.is_empty() {
        round += 1;
        let mut complete = Vec::new();
        let mut leaving: BTreeMap<Rank, Leaving> = BTreeMap::new();
        for &at in &arriving {
            let batch = &batches[at];
            let out = leaving.entry(batch.to).or_default();
            walk(replay, &table, (batch.group, batch.to), &batch.leaves, Some(at), out);
        }
        let came = std::mem::take(&mut arriving);
        for (rank, out) in leaving {
            post(replay, phase, round, rank, out, &table, &mut batches, &mut arriving);
        }
        complete.extend(came.into_iter().filter(|&at| batches[at].outstanding == 0));
        for at in std::mem::take(&mut answered) {
            let (from, accounts) = (batches[at].from, std::mem::take(&mut batches[at].accounts));
            if accounts.is_empty() {
                done.insert(from, round);
            }
            for account in accounts {
                batches[account].outstanding -= 1;
                if batches[account].outstanding == 0 {
                    complete.push(account);
                }
            }
        }
        for at in complete {
            let batch = &batches[at];
            let [balls, entries, points] = sum(&table[batch.group], &batch.leaves);
            let groups = batch.leaves.len() as u64 * sizes.answer_group;
            let lists = balls * sizes.one_answer + entries * sizes.entry;
            let bytes = sizes.answer + groups + lists + points * sizes.point;
            replay.send(phase, round, (batch.to, batch.from), bytes);
            answered.push(at);
        }
    }
    done
}

fn post(
    replay: &mut Replay<'_>,
    phase: Phase,
    round: u32,
    from: Rank,
    out: Leaving,
    table: &[Reaching],
    batches: &mut Vec<Batch>,
    arriving: &mut Vec<usize>,
) {
    for ((group, to), (leaves, accounts)) in out {
        let [balls, ..] = sum(&table[group], &leaves);
        let groups = leaves.len() as u64 * replay.sizes.query_group;
        let bytes = replay.sizes.query + groups + balls * replay.sizes.one_query;
        replay.send(phase, round, (from, to), bytes);
        for &account in &accounts {
            batches[account].outstanding += 1;
        }
        let accounts = accounts.into_iter().collect();
        arriving.push(batches.len());
        batches.push(Batch { from, to, group, leaves, accounts, outstanding: 0 });
    }
}

/// Replays the points that are pushed to every leaf that one of their edges can reach.
pub(super) fn ghosts(replay: &mut Replay<'_>) {
    let table = reaching(replay, Phase::Sets);
    let mut leaving: BTreeMap<Rank, Leaving> = BTreeMap::new();
    for &rank in replay.place.leaves_of.keys() {
        leaving.insert(rank, set_out(replay, &table, rank));
    }
    let mut round = 1;
    while leaving.values().any(|out| !out.is_empty()) {
        let mut next: BTreeMap<Rank, Leaving> = BTreeMap::new();
        for (from, out) in leaving {
            for ((group, to), (leaves, _)) in out {
                let [points, ..] = sum(&table[group], &leaves);
                let bytes = replay.sizes.ghosts + points * replay.sizes.point;
                replay.send(Phase::Sets, round, (from, to), bytes);
                walk(replay, &table, (group, to), &leaves, None, next.entry(to).or_default());
            }
        }
        leaving = next;
        round += 1;
    }
}
