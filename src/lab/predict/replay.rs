//! Replays the machine's rounds on counts: sender, receiver, size and round of every message.
//!
//! Every function mirrors one phase of `septet_workers`. Tests compare the counts with real runs. The partition phase
//! is in [`super::partition`], and descents are in [`super::descent`].

use std::collections::{BTreeMap, BTreeSet};

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Phase, Rank};
use septet_protocol::tasks::TaskLog;
use septet_workers::result::collect::CELLS_PER_MESSAGE;

use super::error::PredictError;
use super::machine::Replay;
use super::placement::Placement;
use super::sizes::MessageSizes;
use super::traffic::PhaseTraffic;
use super::{descent, partition};

/// Replays all phases of a run on `workers` ranks.
pub(super) fn replay<P: Point>(
    log: &TaskLog,
    workers: u32,
) -> Result<(Placement, PhaseTraffic), PredictError> {
    let place = Placement::new(log, workers)?;
    let mut replay = Replay { log, place, sizes: MessageSizes::of::<P>(), traffic: PhaseTraffic::default() };
    replay.load();
    partition::replay(&mut replay);
    if log.chosen {
        replay.choice();
    }
    for phase in [Phase::Probe, Phase::Neighbours] {
        descent::queries(&mut replay, phase);
    }
    replay.summaries();
    for phase in [Phase::KnnProbe, Phase::Knn] {
        descent::queries(&mut replay, phase);
    }
    descent::ghosts(&mut replay);
    replay.reverse();
    replay.agreement(0, Phase::Check);
    replay.exchange();
    replay.agreement(1, Phase::Certificate);
    replay.merge();
    replay.collect();
    Ok((replay.place, replay.traffic))
}

impl Replay<'_> {
    pub(super) fn send(&mut self, phase: Phase, round: u32, between: (Rank, Rank), bytes: u64) {
        self.traffic.send(phase, round, between, bytes);
    }

    /// Sends a message of this size to every worker.
    fn broadcast(&mut self, phase: Phase, round: u32, bytes: u64) {
        for rank in 1..=self.place.workers {
            self.send(phase, round, (COORDINATOR, rank), bytes);
        }
    }

    fn load(&mut self) {
        let (n, p) = (u128::from(self.log.population), u128::from(self.place.workers));
        let share = |r: u32| (n * u128::from(r) / p) as u64;
        for rank in 1..=self.place.workers {
            let points = share(rank) - share(rank - 1);
            let (start, block) = (self.sizes.start, self.sizes.block + points * self.sizes.owned);
            self.send(Phase::Load, 0, (COORDINATOR, rank), start);
            self.send(Phase::Load, 0, (COORDINATOR, rank), block);
        }
    }

    /// Returns the round in which each group sends its result up: 1 for a group of one rank, otherwise one round
    /// after its children.
    fn rounds_up(&self) -> Vec<u32> {
        let mut rounds = vec![1; self.place.groups.len()];
        // In reverse order, children precede their parents.
        for at in (0..self.place.groups.len()).rev() {
            if let Some([a, b]) = self.place.groups[at].children {
                rounds[at] = rounds[a].max(rounds[b]) + 1;
            }
        }
        rounds
    }

    /// Sends results up the tree, from each child to the leader of its parent.
    fn up(&mut self, phase: Phase, bytes: u64) -> Vec<u32> {
        let rounds = self.rounds_up();
        for (group, &round) in self.place.groups.clone().iter().zip(&rounds) {
            let Some(parent) = group.parent else { continue };
            let from = if group.whole { group.first } else { group.leader };
            let to = self.place.groups[parent].leader;
            self.send(phase, round, (from, to), bytes);
        }
        rounds
    }

    fn summaries(&mut self) {
        let rounds = self.up(Phase::Summaries, self.sizes.summary);
        for (group, round) in self.place.groups.clone().iter().zip(rounds).filter(|(g, _)| !g.whole) {
            for rank in group.first..group.first + group.ranks {
                self.send(Phase::Summaries, round, (group.leader, rank), self.sizes.children);
            }
        }
        let mut leaves: BTreeMap<Rank, u64> = BTreeMap::new();
        for &leaf in &self.log.frame {
            *leaves.entry(self.place.holder[leaf as usize]).or_default() += 1;
        }
        for (rank, points) in leaves {
            let bytes = self.sizes.frame + points * self.sizes.point;
            self.send(Phase::Summaries, 1, (rank, COORDINATOR), bytes);
        }
        let all = self.sizes.frame + self.log.frame.len() as u64 * self.sizes.point;
        self.broadcast(Phase::Summaries, 2, all);
    }

    fn choice(&mut self) {
        let done = descent::queries(self, Phase::Choice);
        let mut last = 0;
        for rank in 1..=self.place.workers {
            let round = done.get(&rank).copied().unwrap_or(1);
            last = last.max(round);
            self.send(Phase::Choice, round, (rank, COORDINATOR), self.sizes.sample_stars);
        }
        self.broadcast(Phase::Choice, last + 1, self.sizes.choice);
    }

    fn ranks(&self, from: u32, to: u32) -> (Rank, Rank) {
        (self.place.holder[from as usize], self.place.holder[to as usize])
    }

    fn reverse(&mut self) {
        // Numbers of edges and of the points that send them, for each sender and receiver.
        let mut sent: BTreeMap<(Rank, Rank), (u64, u64)> = BTreeMap::new();
        for &(from, to, number) in &self.log.reverse {
            sent.entry(self.ranks(from, to)).or_default().0 += number;
        }
        for &(from, to, before, number) in &self.log.senders {
            let holder = &self.place.holder;
            // `before` is the previous leaf to which the points are sent. For the first leaf, it is their own leaf,
            // to which they are not sent.
            if before == from || holder[before as usize] != holder[to as usize] {
                sent.entry(self.ranks(from, to)).or_default().1 += number;
            }
        }
        let (count, id) = (size_of::<u32>() as u64, size_of::<u64>() as u64);
        for (between, (edges, points)) in sent {
            let bytes = self.sizes.reverse + points * (self.sizes.point + count) + edges * id;
            self.send(Phase::Sets, 1, between, bytes);
        }
    }

    /// Replays the exchange of fingerprints, and of the lists that follow if the sums of two ranks differ.
    fn agreement(&mut self, check: u32, phase: Phase) {
        let mut sums: BTreeMap<(Rank, Rank), (u128, u64)> = BTreeMap::new();
        for &(_, from, to, low, high, pairs) in self.log.agreement.iter().filter(|row| row.0 == check) {
            let between = self.ranks(from, to);
            if between.0 == between.1 {
                continue;
            }
            let sum = sums.entry(between).or_default();
            sum.0 = sum.0.wrapping_add(u128::from(low) | u128::from(high) << 64);
            sum.1 += pairs;
        }
        sums.retain(|_, sum| *sum != (0, 0));
        let mut differ: BTreeSet<(Rank, Rank)> = BTreeSet::new();
        for (&(from, to), sum) in &sums {
            self.send(phase, 1, (from, to), self.sizes.fingerprint);
            if sums.get(&(to, from)) != Some(sum) {
                differ.extend([(from, to), (to, from)]);
            }
        }
        for between in differ {
            let pairs = sums.get(&between).map_or(0, |s| s.1);
            let bytes = self.sizes.list + pairs * size_of::<u64>() as u64;
            self.send(phase, 2, between, bytes);
        }
    }

    fn exchange(&mut self) {
        /// Numbers of cells and of conflicts, and the points that they refer to.
        type Batch<'a> = (u64, u64, BTreeSet<&'a u64>);
        let mut batches: BTreeMap<(u32, bool, (Rank, Rank)), Batch<'_>> = BTreeMap::new();
        for exchange in &self.log.exchange {
            let between = self.ranks(exchange.from, exchange.to);
            if between.0 != between.1 {
                let batch = batches.entry((exchange.step, exchange.objection, between)).or_default();
                batch.0 += exchange.cells;
                batch.1 += exchange.conflicts;
                batch.2.extend(&exchange.points);
            }
        }
        let index = size_of::<u32>() as u64;
        let row = index * u64::from(self.log.dimension + 1);
        for ((step, objection, between), (cells, conflicts, points)) in batches {
            let points = points.len() as u64 * self.sizes.point;
            let bytes = if objection {
                self.sizes.object + points + cells * (row + index) + conflicts * index
            } else {
                self.sizes.propose + points + cells * row
            };
            self.send(Phase::Repair, step + 1, between, bytes);
        }
    }

    fn merge(&mut self) {
        let rounds = self.up(Phase::Merge, self.sizes.merged);
        let (whole, holder) = (self.place.groups[0].whole, self.place.groups[0].first);
        if whole {
            self.send(Phase::Merge, 1, (holder, COORDINATOR), self.sizes.merged);
        }
        let sent = if whole { 2 } else { rounds[0] };
        self.broadcast(Phase::Merge, sent, self.sizes.outcome);
    }

    fn collect(&mut self) {
        let width = u64::from(self.log.dimension + 1);
        for (&rank, leaves) in &self.place.leaves_of.clone() {
            let mut waiting = 0;
            let post = |replay: &mut Self, indices: u64| {
                let bytes = replay.sizes.cells + indices * size_of::<u64>() as u64;
                replay.send(Phase::Collect, 1, (rank, COORDINATOR), bytes);
            };
            for &leaf in leaves {
                waiting += self.log.cells.get(leaf as usize).map_or(0, |&cells| cells * width);
                if waiting >= CELLS_PER_MESSAGE as u64 {
                    post(self, waiting);
                    waiting = 0;
                }
            }
            if waiting > 0 {
                post(self, waiting);
            }
        }
    }
}
