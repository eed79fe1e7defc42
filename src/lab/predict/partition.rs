//! Replays the partition phase: four rounds per attempt, and one move of the points per level.

use std::collections::BTreeMap;

use septet_protocol::ids::{NodeId, Phase, Rank};

use super::machine::Replay;

/// Blocks of the input with their numbers of points, sorted.
type Blocks = Vec<(u32, u32)>;

/// The tables of the record that the replay reads.
struct Tables<'a> {
    /// Owned points of each group, by block.
    origins: Vec<Blocks>,
    samples: BTreeMap<(NodeId, u32), &'a [(u32, u32)]>,
    attempts: BTreeMap<u64, u64>,
}

fn unite(a: &Blocks, b: &Blocks) -> Blocks {
    let mut all: BTreeMap<u32, u32> = a.iter().copied().collect();
    for &(block, count) in b {
        *all.entry(block).or_default() += count;
    }
    all.into_iter().collect()
}

pub(super) fn replay(replay: &mut Replay<'_>) {
    let log = replay.log;
    let groups = replay.place.groups.clone();
    let mut origins: Vec<Blocks> = vec![Vec::new(); groups.len()];
    for (at, leaf) in log.leaves.iter().enumerate() {
        let piece = replay.place.piece[&replay.place.holder[at]];
        debug_assert!(groups[piece].node.contains(NodeId(*leaf)));
        origins[piece] = unite(&origins[piece], &log.first_blocks[at]);
    }
    for at in (0..groups.len()).rev() {
        if let Some([a, b]) = groups[at].children {
            origins[at] = unite(&origins[a], &origins[b]);
        }
    }
    let tables = Tables {
        origins,
        samples: log.samples.iter().map(|(n, a, s)| ((NodeId(*n), *a), s.as_slice())).collect(),
        attempts: log.nodes.iter().map(|n| (n.0, n.2)).collect(),
    };
    let workers = u64::from(replay.place.workers);
    let share = |block: u32| (u64::from(block) * workers / u64::from(log.blocks)) as Rank + 1;
    let at_root: Vec<Rank> = (0..log.blocks).map(share).collect();
    if groups[0].whole {
        let held = vec![groups[0].first; at_root.len()];
        moves(replay, &tables, 0, (&at_root, &held), 1);
        return;
    }
    // Each entry has the group, the current and the previous ranks of each block's points, and the round of the
    // samples.
    let mut open = vec![(0usize, at_root.clone(), at_root, 1)];
    while let Some((at, holders, before, round)) = open.pop() {
        let round = attempts(replay, &tables, at, (&holders, &before), round);
        let Some(children) = groups[at].children else { continue };
        for child in children {
            let below: Vec<Rank> = holders
                .iter()
                .map(|&rank| {
                    let stays = groups[child].holds(rank) && !groups[child].whole;
                    if stays { rank } else { replay.place.member_below(at, rank, child) }
                })
                .collect();
            moves(replay, &tables, child, (&holders, &below), round);
            if !groups[child].whole {
                open.push((child, below, holders.clone(), round));
            }
        }
    }
}

/// Replays all attempts at a shared node, and returns the round in which its points move. The parent's group sends the
/// first samples before the points move.
fn attempts(
    replay: &mut Replay<'_>,
    tables: &Tables<'_>,
    at: usize,
    (holders, before): (&[Rank], &[Rank]),
    mut round: u32,
) -> u32 {
    let group = replay.place.groups[at].clone();
    let members = group.first..group.first + group.ranks;
    let senders = group.parent.map_or(members.clone(), |p| {
        let parent = &replay.place.groups[p];
        parent.first..parent.first + parent.ranks
    });
    let sizes = replay.sizes;
    let tries = tables.attempts.get(&group.node.0).copied().unwrap_or(0) as u32;
    for attempt in 0..tries {
        let (from, places) =
            if attempt == 0 { (senders.clone(), before) } else { (members.clone(), holders) };
        let mut counts: BTreeMap<Rank, u64> = from.map(|rank| (rank, 0)).collect();
        for &(block, count) in tables.samples.get(&(group.node, attempt)).copied().unwrap_or_default() {
            *counts.entry(places[block as usize]).or_default() += u64::from(count);
        }
        for (rank, count) in counts {
            let bytes = sizes.samples + count * sizes.position;
            replay.send(Phase::Partition, round, (rank, group.leader), bytes);
        }
        let decision = if attempt + 1 == tries { sizes.split } else { sizes.retry };
        for rank in members.clone() {
            replay.send(Phase::Partition, round + 1, (group.leader, rank), sizes.sphere);
            replay.send(Phase::Partition, round + 2, (rank, group.leader), sizes.counts);
            replay.send(Phase::Partition, round + 3, (group.leader, rank), decision);
        }
        round += 4;
    }
    round
}

/// Replays the move of a group's points from their previous to their current ranks.
fn moves(
    replay: &mut Replay<'_>,
    tables: &Tables<'_>,
    at: usize,
    (from, to): (&[Rank], &[Rank]),
    round: u32,
) {
    let mut batches: BTreeMap<(Rank, Rank), u64> = BTreeMap::new();
    for &(block, count) in &tables.origins[at] {
        let between = (from[block as usize], to[block as usize]);
        *batches.entry(between).or_default() += u64::from(count);
    }
    for (between, points) in batches {
        let bytes = replay.sizes.moved + points * replay.sizes.owned;
        replay.send(Phase::Partition, round, between, bytes);
    }
}
