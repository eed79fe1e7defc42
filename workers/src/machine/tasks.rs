//! The record of the messages between leaves, which one worker keeps while it runs the whole tree.
//!
//! The record is a measurement: it influences no decision and no charge. See [`septet_protocol::tasks`].

use std::collections::{BTreeMap, BTreeSet, HashSet};

use septet_geometry::point::Point;
use septet_geometry::selection::{Neighbour, NeighbourList};
use septet_geometry::separator::{DrawKey, is_sample};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::tasks::{SampleRow, SentCells, TaskLog};

/// Number of blocks of the input. The record is exact for machines whose number of workers divides this number.
pub const BLOCKS: u32 = 4096;

/// The counts for a leaf and a node that is not on the path to the leaf: the balls or points of the leaf that reach
/// the node, the entries of the lists found there, and the distinct points in these lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reaching {
    balls: u64,
    entries: u64,
    points: HashSet<u32>,
}

impl Reaching {
    fn join(&mut self, other: Reaching) {
        self.balls += other.balls;
        self.entries += other.entries;
        self.points.extend(other.points);
    }
}

/// The counts of the balls and points that reached nodes, by leaf and node.
pub(crate) type Reached = BTreeMap<(u32, NodeId), Reaching>;

/// The step of splaying, whether the message is an objection, the leaf of the sender, and the leaf of the receiver.
type Announcements = (u32, bool, u32, u32);

/// The nodes that one walk of balls reached. Empty unless the run records tasks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reach {
    /// The leaf of the current ball.
    origin: u32,
    pub(crate) reached: Option<Reached>,
}

impl Reach {
    pub(crate) fn new(wanted: bool) -> Self {
        Reach { origin: 0, reached: wanted.then(Reached::new) }
    }

    pub(crate) fn start(&mut self, leaf: usize) {
        self.origin = leaf as u32;
    }

    /// Records a point, or a ball without a result, at a node.
    pub(crate) fn visit(&mut self, node: NodeId) {
        if let Some(reached) = &mut self.reached {
            reached.entry((self.origin, node)).or_default().balls += 1;
        }
    }

    /// Records a ball at a node, with the points that it finds below it.
    pub(crate) fn found(
        &mut self,
        node: NodeId,
        below: impl Iterator<Item = Neighbour>,
        wanted: usize,
        radius2: f64,
    ) {
        if let Some(reached) = &mut self.reached {
            let mut nearest = NeighbourList::default();
            below.for_each(|found| nearest.push(found));
            nearest.keep_nearest(wanted, radius2);
            let entry = reached.entry((self.origin, node)).or_default();
            entry.balls += 1;
            entry.entries += nearest.len() as u64;
            entry.points.extend(nearest.positions());
        }
    }
}

/// The record during the run.
#[derive(Debug, Default)]
pub(crate) struct Recorder {
    pub(crate) log: TaskLog,
    reverse: BTreeMap<(u32, u32), u64>,
    senders: BTreeMap<(u32, u32, u32), u64>,
    reach: BTreeMap<(Phase, u32, NodeId), Reaching>,
    /// Numbers of cells and of conflicts, and the ids of the points in them.
    sent: BTreeMap<Announcements, (u64, u64, BTreeSet<u64>)>,
    checks: u32,
}

/// Counts positions in the input by block.
fn by_block(places: impl Iterator<Item = u32>, population: u64) -> Vec<(u32, u32)> {
    let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
    for place in places {
        *counts.entry(block_of(place, population)).or_default() += 1;
    }
    counts.into_iter().collect()
}

/// Returns the block of a position: the last block that begins at or before it.
fn block_of(place: u32, population: u64) -> u32 {
    // Block b begins at floor(n b / B): the largest b with n b < (place + 1) B.
    let (n, b) = (u128::from(population.max(1)), u128::from(BLOCKS));
    (((u128::from(place) + 1) * b - 1) / n) as u32
}

/// Counts, by block, the samples of one attempt at a node.
pub(crate) fn record_samples<P: Point>(
    key: DrawKey,
    population: u64,
    members: &[u32],
    points: &[P],
    all: u64,
) -> SampleRow {
    let drawn = members.iter().zip(points).filter(|&(_, &x)| is_sample(key, population, x));
    (key.node, key.attempt, by_block(drawn.map(|m| *m.0), all))
}

impl Recorder {
    /// Records the tree: the blocks of the points of every leaf, and the samples of every attempt.
    pub(crate) fn grown(
        &mut self,
        samples: &mut Vec<SampleRow>,
        leaves: &[(NodeId, Vec<u32>)],
        population: u64,
    ) {
        self.log.population = population;
        self.log.blocks = BLOCKS;
        self.log.samples.append(samples);
        self.log.samples.sort_unstable();
        self.log.leaves = leaves.iter().map(|l| l.0.0).collect();
        let blocks = |l: &(NodeId, Vec<u32>)| by_block(l.1.iter().copied(), population);
        self.log.first_blocks = leaves.iter().map(blocks).collect();
    }

    pub(crate) fn reached(&mut self, phase: Phase, reached: Reached) {
        for ((leaf, node), here) in reached {
            self.reach.entry((phase, leaf, node)).or_default().join(here);
        }
    }

    /// Records the edges of one point of leaf `from`, which are sent to the leaves of their other ends. `to` lists
    /// these leaves.
    pub(crate) fn reverse(&mut self, from: u32, to: &mut Vec<u32>) {
        to.sort_unstable();
        to.retain(|&leaf| leaf != from);
        for leaf in to.iter() {
            *self.reverse.entry((from, *leaf)).or_default() += 1;
        }
        to.dedup();
        let mut before = from;
        for leaf in to.drain(..) {
            *self.senders.entry((from, leaf, before)).or_default() += 1;
            before = leaf;
        }
    }

    /// Records a proposal or objection from a star of leaf `from` to a star of leaf `to`, with the points in conflict.
    pub(crate) fn sent(
        &mut self,
        (step, objection): (u32, bool),
        (from, to): (u32, u32),
        named: impl Iterator<Item = u64>,
        conflicts: u64,
    ) {
        if from != to {
            let entry = self.sent.entry((step, objection, from, to)).or_default();
            entry.0 += 1;
            entry.1 += conflicts;
            entry.2.extend(named);
        }
    }

    /// Records the sums that the stars of two leaves must agree on in one check: sums of keys, and numbers of pairs.
    pub(crate) fn checked(&mut self, sums: BTreeMap<(u32, u32), (u128, u64)>) {
        let check = self.checks;
        self.checks += 1;
        let rows = sums.into_iter().filter(|(_, sum)| *sum != (0, 0));
        self.log
            .agreement
            .extend(rows.map(|((a, b), (sum, pairs))| (check, a, b, sum as u64, (sum >> 64) as u64, pairs)));
    }

    /// Takes the complete record.
    pub(crate) fn finish(&mut self) -> TaskLog {
        let mut log = std::mem::take(&mut self.log);
        log.reverse = std::mem::take(&mut self.reverse).into_iter().map(|((a, b), n)| (a, b, n)).collect();
        let senders = std::mem::take(&mut self.senders).into_iter();
        log.senders = senders.map(|((from, to, before), n)| (from, to, before, n)).collect();
        let reach = std::mem::take(&mut self.reach);
        let row = |((phase, leaf, node), here): ((Phase, u32, NodeId), Reaching)| {
            (phase, leaf, node.0, here.balls, here.entries, here.points.len() as u64)
        };
        log.reach = reach.into_iter().map(row).collect();
        let sent = std::mem::take(&mut self.sent).into_iter();
        log.exchange = sent
            .map(|((step, objection, from, to), (cells, conflicts, points))| {
                let points = points.into_iter().collect();
                SentCells { step, objection, from, to, cells, conflicts, points }
            })
            .collect();
        log
    }
}
