//! The part of the ledger that one rank keeps.

use std::collections::BTreeMap;

use septet_geometry::cost::Price;
use serde::Serialize;

use super::counts::counts;
use super::round::{RoundKey, RoundTally};
use crate::ids::{NodeId, Phase, Rank};

/// A link between two ranks in a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkKey {
    /// The phase.
    pub phase: Phase,
    /// The sender.
    pub from: Rank,
    /// The receiver.
    pub to: Rank,
}

/// A rank in a round of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RankKey {
    /// The number of the round.
    pub round: u32,
    /// The phase.
    pub phase: Phase,
    /// The rank.
    pub rank: Rank,
}

counts! {
    /// Numbers of messages, bytes and points.
    Traffic:
    /// Messages.
    messages "messages" Sum;
    /// Bytes of the messages.
    bytes "bytes" Sum;
    /// Points in the messages.
    points "points" Sum;
}

/// The work and the messages of one rank in one round of a phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RankTally {
    /// Work charged by the rank before the exchange that ends the round.
    pub work: u64,
    /// Messages that the rank sent.
    pub sent: Traffic,
    /// Messages to the rank.
    pub received: Traffic,
}

impl RankTally {
    /// Adds the counts of another part of the ledger for the same rank and round.
    pub fn add(&mut self, other: &RankTally) {
        self.work += other.work;
        self.sent.add(&other.sent);
        self.received.add(&other.received);
    }
}

/// The role in which a rank works for a subproblem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// A member of the subproblem's group. Members work at the same time.
    Member,
    /// The leader of the group, which works between the steps of its members.
    Leader,
    /// A member during the bottom-up correction of the balls of its ancestor at this level.
    Pass(u32),
    /// A member during this step of a phase in which all subproblems step together.
    Step(u32),
}

/// The account of a charge: a subproblem in a phase, and the role of the rank that works for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Account {
    /// The role.
    pub role: Role,
    /// The phase.
    pub phase: Phase,
    /// The subproblem.
    pub node: NodeId,
}

impl Account {
    /// Returns the account of the members of `node` in `phase`.
    pub fn member(phase: Phase, node: NodeId) -> Self {
        Account { role: Role::Member, phase, node }
    }

    /// Returns the account of the leader of `node` in `phase`.
    pub fn leader(phase: Phase, node: NodeId) -> Self {
        Account { role: Role::Leader, phase, node }
    }

    /// Returns the account of the members of `node` in step `step` of a phase in which all subproblems step together.
    pub fn step(phase: Phase, step: u32, node: NodeId) -> Self {
        Account { role: Role::Step(step), phase, node }
    }

    /// Returns the account of `node` in the bottom-up correction of the balls of its ancestor at `level`.
    pub fn pass(level: u32, node: NodeId) -> Self {
        Account { role: Role::Pass(level), phase: Phase::Neighbours, node }
    }
}

/// The cost of one account, over all ranks that share the subproblem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Charge {
    /// Work, depth and scans.
    pub cost: Price,
    /// Items of the subproblem in this phase: the length of its scans.
    pub items: u64,
}

/// The form of a node of the partition tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum NodeKind {
    /// A leaf.
    #[default]
    Leaf,
    /// A node that a sphere splits.
    Sphere,
    /// A node that a plane splits.
    Plane,
    /// A node that a cut of a Hilbert curve splits.
    Curve,
}

impl NodeKind {
    const ALL: [NodeKind; 4] = [NodeKind::Leaf, NodeKind::Sphere, NodeKind::Plane, NodeKind::Curve];

    /// Returns the number that represents the kind in encoded words and in records.
    pub fn number(self) -> u64 {
        self as u64
    }

    /// Returns the kind that `number` represents, or `None`.
    pub fn from_number(number: u64) -> Option<Self> {
        NodeKind::ALL.get(usize::try_from(number).ok()?).copied()
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// The facts of a node of the partition tree. A node of the recursion on sets with their own separators that is no node of
/// the partition tree has no population.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NodeFacts {
    /// Number of owned points.
    pub population: u64,
    /// Number of owned points inside the separator; 0 for a leaf.
    pub inside: u64,
    /// Number of attempts at a separator.
    pub attempts: u64,
    /// The form of the node.
    pub kind: NodeKind,
    /// Owned points inside the separator whose alpha-ball meets it.
    pub crossing_inside: u64,
    /// Owned points outside the separator whose alpha-ball meets it.
    pub crossing_outside: u64,
    /// Points of the set of a leaf in the graph phase: owned points, ghosts and separator points. If every set has its own
    /// separator, points of the set of any node.
    pub members: u64,
    /// Points of the set inside the set's own separator; 0 if the set is not divided by one.
    #[serde(skip_serializing_if = "is_zero")]
    pub set_inside: u64,
    /// Points of the set whose alpha-ball meets the set's own separator.
    #[serde(skip_serializing_if = "is_zero")]
    pub set_crossing: u64,
    /// Edges of the supergraph whose smaller end a leaf owns.
    pub edges: u64,
    /// Order-free hash of the separator's coefficients. Reports do not have it.
    #[serde(skip)]
    pub separator: u64,
    /// Largest degree of an owned point.
    pub max_degree: u64,
    /// Balls that visited a leaf.
    pub visits: u64,
    /// 1 if the node punts: too many balls cross its separator for a correction in stages. Reports have the sum.
    #[serde(skip)]
    pub punts: u64,
    /// Well-separated pairs of a leaf. Reports have the sum.
    #[serde(skip)]
    pub pairs: u64,
}

impl NodeFacts {
    /// Merges the facts of another rank about the same node: sums the counts of members, and takes the maximum of
    /// every other fact.
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
        self.set_inside += o.set_inside;
        self.set_crossing += o.set_crossing;
        self.edges += o.edges;
        self.visits += o.visits;
        self.punts += o.punts;
        self.pairs += o.pairs;
    }

    /// Returns the number of points of the set, if all its pairs were compared; otherwise 0.
    pub fn compared(&self) -> u64 {
        if self.set_inside > 0 { 0 } else { self.members }
    }

    /// Returns `true` if the node is a leaf of the tree.
    pub fn is_leaf(&self) -> bool {
        self.kind == NodeKind::Leaf
    }
}

/// The part of the ledger that one rank keeps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LedgerPart {
    /// The counts of each round.
    pub rounds: BTreeMap<RoundKey, RoundTally>,
    /// The traffic of each link.
    pub links: BTreeMap<LinkKey, Traffic>,
    /// The work and the messages of each rank, round by round.
    pub ranks: BTreeMap<RankKey, RankTally>,
    /// The charges of each account.
    pub charges: BTreeMap<Account, Charge>,
    /// The facts of each node.
    pub nodes: BTreeMap<NodeId, NodeFacts>,
    /// Order-free hash of all edges of the supergraph.
    pub edge_hash: u64,
    /// The sum of the hashes of the messages that the ranks sent minus the sum of those that they received, modulo
    /// `2^64`. It is 0 in the merged ledger of a run in which every message arrived unchanged.
    pub balance: u64,
}

impl LedgerPart {
    /// Adds a price to an account. The account keeps the largest number of `items`.
    pub fn charge(&mut self, account: Account, cost: Price, items: u64) {
        let entry = self.charges.entry(account).or_default();
        entry.cost.then(cost);
        entry.items = entry.items.max(items);
    }

    /// Returns the charges of the members of each node in a phase, in the order of the nodes.
    pub fn members(&self, phase: Phase) -> impl Iterator<Item = (NodeId, &Charge)> {
        let all = Account::member(phase, NodeId(0))..=Account::member(phase, NodeId(u64::MAX));
        self.charges.range(all).map(|(account, charge)| (account.node, charge))
    }

    /// Returns the charges of the bottom-up correction: the level of the corrected balls' ancestor, the node, the
    /// charge.
    pub fn passes(&self) -> impl Iterator<Item = (u32, NodeId, &Charge)> {
        let charges = self.charges.range(Account::pass(0, NodeId(0))..);
        charges.filter_map(|(account, charge)| match account.role {
            Role::Pass(level) => Some((level, account.node, charge)),
            _ => None,
        })
    }

    /// Returns the charges of a phase in which all subproblems step together: the number of the step, the node, the
    /// charge. They are in the order of the steps.
    pub fn steps(&self, phase: Phase) -> impl Iterator<Item = (u32, NodeId, &Charge)> {
        let charges = self.charges.range(Account::step(Phase::ALL[0], 0, NodeId(0))..);
        charges.filter(move |(account, _)| account.phase == phase).filter_map(|(account, charge)| {
            match account.role {
                Role::Step(step) => Some((step, account.node, charge)),
                _ => None,
            }
        })
    }

    /// Adds the charges of leaders to the charges of the members of the same nodes, because leaders work between the
    /// steps of their members.
    pub fn join_leaders(&mut self) {
        let leaders: Vec<_> =
            self.charges.extract_if(.., |account, _| account.role == Role::Leader).collect();
        for (Account { phase, node, .. }, charge) in leaders {
            self.charges.entry(Account::member(phase, node)).or_default().cost.then(charge.cost);
        }
    }

    /// Returns the facts of a node, so that the caller can add to them.
    pub fn facts(&mut self, node: NodeId) -> &mut NodeFacts {
        self.nodes.entry(node).or_default()
    }

    /// Returns the counts of a round, so that the caller can add to them.
    pub fn tally(&mut self, key: RoundKey) -> &mut RoundTally {
        self.rounds.entry(key).or_default()
    }

    /// Returns the counts of a rank in a round, so that the caller can add to them.
    pub fn rank(&mut self, key: RankKey) -> &mut RankTally {
        self.ranks.entry(key).or_default()
    }

    /// Counts one message in its round, on its link and for both ranks.
    pub fn bill(&mut self, sender: RankKey, to: Rank, moved: Traffic) {
        let RankKey { round, phase, rank: from } = sender;
        self.links.entry(LinkKey { phase, from, to }).or_default().add(&moved);
        self.rank(sender).sent.add(&moved);
        self.rank(RankKey { rank: to, ..sender }).received.add(&moved);
        let tally = self.tally(RoundKey { round, phase });
        tally.messages += moved.messages;
        tally.bytes += moved.bytes;
        tally.points += moved.points;
        tally.largest = tally.largest.max(moved.bytes);
    }

    /// Merges the part of another rank. Ranks work on one account in parallel, so their work is added, and their
    /// depth is the maximum.
    pub fn merge(&mut self, other: &LedgerPart) {
        for (key, tally) in &other.rounds {
            self.rounds.entry(*key).or_default().add(tally);
        }
        for (key, moved) in &other.links {
            self.links.entry(*key).or_default().add(moved);
        }
        for (key, tally) in &other.ranks {
            self.rank(*key).add(tally);
        }
        for (account, charge) in &other.charges {
            let entry = self.charges.entry(*account).or_default();
            entry.cost.join(charge.cost);
            entry.items += charge.items;
        }
        for (node, facts) in &other.nodes {
            self.nodes.entry(*node).or_default().add(facts);
        }
        self.edge_hash = self.edge_hash.wrapping_add(other.edge_hash);
        self.balance = self.balance.wrapping_add(other.balance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up() {
        let mut part = LedgerPart::default();
        let sender = RankKey { round: 7, phase: Phase::Partition, rank: 2 };
        let later = RankKey { round: 8, phase: Phase::Probe, rank: 2 };
        let link = LinkKey { phase: Phase::Partition, from: 2, to: 5 };
        let moved = Traffic { messages: 1, bytes: 40, points: 3 };
        part.bill(sender, 5, moved);
        part.bill(sender, 5, Traffic { bytes: 60, ..moved });
        part.bill(later, 1, moved);
        assert_eq!(part.links[&link], Traffic { messages: 2, bytes: 100, points: 6 });
        assert_eq!(part.ranks[&later], RankTally { sent: moved, ..RankTally::default() });
        let receiver = RankKey { rank: 5, ..sender };
        assert_eq!(part.ranks[&receiver].received, Traffic { messages: 2, bytes: 100, points: 6 });
        part.rank(sender).work += 9;
        assert_eq!(part.rounds[&RoundKey { round: 7, phase: Phase::Partition }].largest, 60);
        let mut both = part.clone();
        both.merge(&part);
        assert_eq!(both.links[&link].bytes, 200);
        assert_eq!((both.ranks[&later].sent.messages, both.ranks[&sender].work), (2, 18));
    }

    /// Parts of three ranks that share the root and own a leaf each merge in any order and any grouping.
    #[test]
    fn merging_is_associative_and_commutative() {
        let part_of = |rank: Rank| {
            let mut part = LedgerPart::default();
            let n = u64::from(rank);
            part.charge(
                Account::member(Phase::Partition, NodeId::ROOT),
                Price::from_parts([3 * n, 9 - n, n, 2, n % 5]),
                10 * n,
            );
            part.charge(
                Account::step(Phase::Repair, rank % 2, NodeId(7)),
                Price::from_parts([n, n, 0, 1, 0]),
                n,
            );
            part.charge(Account::member(Phase::Hulls, NodeId(3 + n)), Price::from_parts([n, 4, 0, 0, 0]), n);
            part.bill(
                RankKey { round: rank % 2, phase: Phase::Graph, rank },
                0,
                Traffic { messages: 1, bytes: n, points: 0 },
            );
            part.facts(NodeId::ROOT).members = n;
            part.edge_hash = u64::MAX - n;
            part
        };
        let merged = |mut a: LedgerPart, b: &LedgerPart| {
            a.merge(b);
            a
        };
        let [a, b, c] = [1, 2, 3].map(part_of);
        let left = merged(merged(a.clone(), &b), &c);
        assert_eq!(left, merged(a.clone(), &merged(b.clone(), &c)));
        assert_eq!(left, merged(c, &merged(b, &a)));
        assert_eq!(left.charges[&Account::member(Phase::Partition, NodeId::ROOT)].items, 60);
    }

    /// The order of accounts, on which the queries by role rely.
    #[test]
    fn members_come_before_leaders_passes_and_steps() {
        let (root, last) = (NodeId::ROOT, NodeId(u64::MAX));
        let accounts = [
            Account::member(Phase::Load, last),
            Account::member(Phase::Done, root),
            Account::leader(Phase::Load, last),
            Account::leader(Phase::Done, root),
            Account::pass(0, last),
            Account::pass(1, root),
            Account::step(Phase::Repair, 1, last),
            Account::step(Phase::Repair, 2, root),
        ];
        assert!(accounts.is_sorted());
    }
}
