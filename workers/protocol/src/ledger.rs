//! The ledger: typed events folded into rounds, phases, subproblems and a critical path.
//!
//! Every rank keeps a [`LedgerPart`]: what its handlers were charged ([`Cost`] by subproblem and phase),
//! what its meter saw leave (messages and bytes by round and phase), and what its leaders decided. Parts
//! are merged by sums and maxima, which do not depend on order; [`Ledger::finish`] folds them.

mod fold;

use std::collections::BTreeMap;

use septet_geometry::cost::Cost;

use crate::ids::{NodeId, Phase, Rank};

/// What is counted in a round besides messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoundTally {
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Length of the longest message.
    pub largest: u64,
    /// Points shipped.
    pub points: u64,
    /// Subproblems whose leader acted.
    pub active: u64,
    /// Results merged from two children.
    pub merged: u64,
    /// Separators drawn.
    pub separators: u64,
    /// Separators drawn again.
    pub retries: u64,
    /// Bytes received by the coordinator that are neither reading nor merging.
    pub control: u64,
}

impl RoundTally {
    const LEN: usize = 9;

    fn parts(&self) -> [u64; Self::LEN] {
        [
            self.messages,
            self.bytes,
            self.largest,
            self.points,
            self.active,
            self.merged,
            self.separators,
            self.retries,
            self.control,
        ]
    }

    fn from_parts(p: &[u64]) -> Self {
        RoundTally {
            messages: p[0],
            bytes: p[1],
            largest: p[2],
            points: p[3],
            active: p[4],
            merged: p[5],
            separators: p[6],
            retries: p[7],
            control: p[8],
        }
    }

    /// Adds what another rank saw of the same round.
    pub fn add(&mut self, other: &RoundTally) {
        self.messages += other.messages;
        self.bytes += other.bytes;
        self.largest = self.largest.max(other.largest);
        self.points += other.points;
        self.active += other.active;
        self.merged += other.merged;
        self.separators += other.separators;
        self.retries += other.retries;
        self.control += other.control;
    }
}

/// Numbers of messages, bytes and points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Points shipped in them.
    pub points: u64,
}

impl Traffic {
    const LEN: usize = 3;

    /// Adds what else was counted.
    pub fn add(&mut self, other: &Traffic) {
        self.messages += other.messages;
        self.bytes += other.bytes;
        self.points += other.points;
    }

    fn parts(&self) -> [u64; Self::LEN] {
        [self.messages, self.bytes, self.points]
    }

    fn from_parts(p: &[u64]) -> Self {
        Traffic { messages: p[0], bytes: p[1], points: p[2] }
    }
}

/// Marks a leader's charges among the phases' numbers until the fold.
pub(crate) const LEADER: u8 = 0x80;

/// The cost of one phase of one subproblem, over all ranks that share it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Charge {
    /// Work, depth and scans.
    pub cost: Cost,
    /// Items of the subproblem in this phase: the length of its scans.
    pub items: u64,
}

/// What became of a subproblem of the partition tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeFacts {
    /// Home points.
    pub population: u64,
    /// Home points inside the separator, 0 for a leaf.
    pub inside: u64,
    /// Attempts made.
    pub attempts: u64,
    /// 0 leaf, 1 sphere, 2 plane.
    pub kind: u64,
    /// Home points whose alpha-ball meets the separator, interior side.
    pub crossing_inside: u64,
    /// The same, exterior side.
    pub crossing_outside: u64,
    /// Points of the subproblem's set in the graph phase (home, ghosts, separator points), leaves only.
    pub members: u64,
    /// Edges of the graph with the smaller end at home here, leaves only.
    pub edges: u64,
    /// Order-free hash of the separator's coefficients.
    pub separator: u64,
    /// Largest degree of a home point.
    pub max_degree: u64,
    /// Balls that visited this leaf.
    pub visits: u64,
}

impl NodeFacts {
    const LEN: usize = 11;

    fn parts(&self) -> [u64; Self::LEN] {
        [
            self.population,
            self.inside,
            self.attempts,
            self.kind,
            self.crossing_inside,
            self.crossing_outside,
            self.members,
            self.edges,
            self.separator,
            self.max_degree,
            self.visits,
        ]
    }

    fn from_parts(p: &[u64]) -> Self {
        NodeFacts {
            population: p[0],
            inside: p[1],
            attempts: p[2],
            kind: p[3],
            crossing_inside: p[4],
            crossing_outside: p[5],
            members: p[6],
            edges: p[7],
            separator: p[8],
            max_degree: p[9],
            visits: p[10],
        }
    }

    /// Adds what another rank knows of the same node: facts that the leader states are maxima, counts
    /// over members are sums.
    pub fn add(&mut self, o: &NodeFacts) {
        self.population = self.population.max(o.population);
        self.inside = self.inside.max(o.inside);
        self.attempts = self.attempts.max(o.attempts);
        self.kind = self.kind.max(o.kind);
        self.separator = self.separator.max(o.separator);
        self.max_degree = self.max_degree.max(o.max_degree);
        self.crossing_inside += o.crossing_inside;
        self.crossing_outside += o.crossing_outside;
        self.members += o.members;
        self.edges += o.edges;
        self.visits += o.visits;
    }

    /// Is the node a leaf of the tree?
    pub fn is_leaf(&self) -> bool {
        self.kind == 0
    }
}

/// One rank's part of the ledger.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LedgerPart {
    /// By phase number and round.
    pub rounds: BTreeMap<(u32, u8), RoundTally>,
    /// What left, by phase number, sender and receiver.
    pub links: BTreeMap<(u8, Rank, Rank), Traffic>,
    /// What left, by round, phase number and sender.
    pub senders: BTreeMap<(u32, u8, Rank), Traffic>,
    /// By phase number and node.
    pub charges: BTreeMap<(u8, NodeId), Charge>,
    /// Where balls are corrected node by node: by level of the correcting node, and node its descent visits.
    pub corrections: BTreeMap<(u32, NodeId), Charge>,
    /// By node.
    pub nodes: BTreeMap<NodeId, NodeFacts>,
    /// Order-free hash of all graph edges.
    pub edge_hash: u64,
}

impl LedgerPart {
    /// Charges a share of a phase of a subproblem: members of a group work at the same time.
    pub fn charge(&mut self, phase: Phase, node: NodeId, cost: Cost, items: u64) {
        let entry = self.charges.entry((phase as u8, node)).or_default();
        entry.cost.then(cost);
        entry.items = entry.items.max(items);
    }

    /// Charges what the leader of a subproblem does for it, between its members' steps: added to the
    /// members' charge when the ledger is folded.
    pub fn charge_leader(&mut self, phase: Phase, node: NodeId, cost: Cost) {
        self.charges.entry((phase as u8 | LEADER, node)).or_default().cost.then(cost);
    }

    /// Charges what the correction of the balls of an ancestor of `node`, at this level, does at `node`.
    pub fn charge_correction(&mut self, level: u32, node: NodeId, cost: Cost, items: u64) {
        let entry = self.corrections.entry((level, node)).or_default();
        entry.cost.then(cost);
        entry.items = entry.items.max(items);
    }

    /// The facts of a node, to be filled in.
    pub fn facts(&mut self, node: NodeId) -> &mut NodeFacts {
        self.nodes.entry(node).or_default()
    }

    /// The tally of a round.
    pub fn tally(&mut self, round: u32, phase: Phase) -> &mut RoundTally {
        self.rounds.entry((round, phase as u8)).or_default()
    }

    /// Counts one message in the round, on its link and for its sender.
    pub fn bill(
        &mut self,
        round: u32,
        phase: Phase,
        from: Rank,
        to: Rank,
        moved: Traffic,
    ) -> &mut RoundTally {
        self.links.entry((phase as u8, from, to)).or_default().add(&moved);
        self.senders.entry((round, phase as u8, from)).or_default().add(&moved);
        let tally = self.tally(round, phase);
        tally.messages += moved.messages;
        tally.bytes += moved.bytes;
        tally.points += moved.points;
        tally.largest = tally.largest.max(moved.bytes);
        tally
    }

    /// Merges another rank's part: shares of one subproblem are beside each other.
    pub fn merge(&mut self, other: &LedgerPart) {
        for (key, tally) in &other.rounds {
            self.rounds.entry(*key).or_default().add(tally);
        }
        for (key, moved) in &other.links {
            self.links.entry(*key).or_default().add(moved);
        }
        for (key, moved) in &other.senders {
            self.senders.entry(*key).or_default().add(moved);
        }
        for (key, charge) in &other.charges {
            let entry = self.charges.entry(*key).or_default();
            entry.cost.join(charge.cost);
            entry.items += charge.items;
        }
        for (key, charge) in &other.corrections {
            let entry = self.corrections.entry(*key).or_default();
            entry.cost.join(charge.cost);
            entry.items += charge.items;
        }
        for (node, facts) in &other.nodes {
            self.nodes.entry(*node).or_default().add(facts);
        }
        self.edge_hash = self.edge_hash.wrapping_add(other.edge_hash);
    }

    /// The part as plain numbers, for the wire.
    pub fn to_words(&self) -> Vec<u64> {
        let mut out = vec![
            self.rounds.len() as u64,
            self.charges.len() as u64,
            self.nodes.len() as u64,
            self.edge_hash,
            self.links.len() as u64,
            self.senders.len() as u64,
            self.corrections.len() as u64,
        ];
        for ((round, phase), tally) in &self.rounds {
            out.extend([u64::from(*round), u64::from(*phase)]);
            out.extend(tally.parts());
        }
        for ((phase, node), charge) in &self.charges {
            out.extend([u64::from(*phase), node.0, charge.items]);
            out.extend(charge.cost.to_parts());
        }
        for ((level, node), charge) in &self.corrections {
            out.extend([u64::from(*level), node.0, charge.items]);
            out.extend(charge.cost.to_parts());
        }
        for (node, facts) in &self.nodes {
            out.push(node.0);
            out.extend(facts.parts());
        }
        for ((phase, from, to), moved) in &self.links {
            out.extend([u64::from(*phase), u64::from(*from), u64::from(*to)]);
            out.extend(moved.parts());
        }
        for ((round, phase, from), moved) in &self.senders {
            out.extend([u64::from(*round), u64::from(*phase), u64::from(*from)]);
            out.extend(moved.parts());
        }
        out
    }

    /// The part in these numbers; `None` if they are not one.
    pub fn from_words(words: &[u64]) -> Option<Self> {
        let mut part = LedgerPart::default();
        let (head, mut rest) = words.split_at_checked(7)?;
        part.edge_hash = head[3];
        for _ in 0..head[0] {
            let (row, tail) = rest.split_at_checked(2 + RoundTally::LEN)?;
            let key = (u32::try_from(row[0]).ok()?, u8::try_from(row[1]).ok()?);
            part.rounds.insert(key, RoundTally::from_parts(&row[2..]));
            rest = tail;
        }
        for _ in 0..head[1] {
            let (row, tail) = rest.split_at_checked(7)?;
            let cost = Cost::from_parts([row[3], row[4], row[5], row[6]]);
            let key = (u8::try_from(row[0]).ok()?, NodeId(row[1]));
            part.charges.insert(key, Charge { cost, items: row[2] });
            rest = tail;
        }
        for _ in 0..head[6] {
            let (row, tail) = rest.split_at_checked(7)?;
            let cost = Cost::from_parts([row[3], row[4], row[5], row[6]]);
            part.corrections
                .insert((u32::try_from(row[0]).ok()?, NodeId(row[1])), Charge { cost, items: row[2] });
            rest = tail;
        }
        for _ in 0..head[2] {
            let (row, tail) = rest.split_at_checked(1 + NodeFacts::LEN)?;
            part.nodes.insert(NodeId(row[0]), NodeFacts::from_parts(&row[1..]));
            rest = tail;
        }
        for _ in 0..head[4] {
            let (row, tail) = rest.split_at_checked(3 + Traffic::LEN)?;
            let key = (u8::try_from(row[0]).ok()?, rank(row[1])?, rank(row[2])?);
            part.links.insert(key, Traffic::from_parts(&row[3..]));
            rest = tail;
        }
        for _ in 0..head[5] {
            let (row, tail) = rest.split_at_checked(3 + Traffic::LEN)?;
            let key = (u32::try_from(row[0]).ok()?, u8::try_from(row[1]).ok()?, rank(row[2])?);
            part.senders.insert(key, Traffic::from_parts(&row[3..]));
            rest = tail;
        }
        rest.is_empty().then_some(part)
    }
}

fn rank(word: u64) -> Option<Rank> {
    Rank::try_from(word).ok()
}

pub use fold::{Ledger, PathStep, PhaseTotal, Total};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_survives_its_numbers_and_parts_add_up() {
        let mut part = LedgerPart::default();
        let moved = Traffic { messages: 1, bytes: 40, points: 3 };
        part.bill(7, Phase::Partition, 2, 5, moved);
        part.bill(7, Phase::Partition, 2, 5, Traffic { bytes: 60, ..moved });
        part.bill(8, Phase::Probe, 2, 1, moved);
        part.facts(NodeId(6)).edges = 4;
        part.charge(Phase::Graph, NodeId(6), Cost::ZERO, 9);
        assert_eq!(
            part.links[&(Phase::Partition as u8, 2, 5)],
            Traffic { messages: 2, bytes: 100, points: 6 }
        );
        assert_eq!(part.senders[&(8, Phase::Probe as u8, 2)], moved);
        assert_eq!(part.rounds[&(7, Phase::Partition as u8)].largest, 60);
        let words = part.to_words();
        assert_eq!(LedgerPart::from_words(&words), Some(part.clone()));
        assert_eq!(LedgerPart::from_words(&words[..words.len() - 1]), None);
        let mut both = part.clone();
        both.merge(&part);
        assert_eq!(both.links[&(Phase::Partition as u8, 2, 5)].bytes, 200);
        assert_eq!(both.senders[&(8, Phase::Probe as u8, 2)].messages, 2);
    }
}
