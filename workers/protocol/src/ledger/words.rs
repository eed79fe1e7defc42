//! A part of the ledger as plain numbers, for the wire.
//!
//! A head of seven words holds the numbers of rows, the hash of the edges and the balance. Rows follow, map by map, each
//! in the order of its keys. The last word is the hash of the others. The first word of a charge holds the phase (bits 0
//! to 7), the role (bits 8 to 15) and the level of a pass or the number of a step (bits 32 to 63).

use septet_geometry::cost::Price;

use super::part::{
    Account, Charge, LedgerPart, LinkKey, NodeFacts, NodeKind, RankKey, RankTally, Role, Traffic,
};
use super::round::{RoundKey, RoundTally};
use crate::checksum::checksum;
use crate::ids::{NodeId, Phase, Rank};

/// Words of a charge: phase and role, node, items and the parts of the price.
const CHARGE_WORDS: usize = 3 + Price::PARTS;

impl NodeFacts {
    const LEN: usize = 15;

    fn parts(&self) -> [u64; Self::LEN] {
        [
            self.population,
            self.inside,
            self.attempts,
            self.kind.number(),
            self.crossing_inside,
            self.crossing_outside,
            self.members,
            self.edges,
            self.separator,
            self.max_degree,
            self.visits,
            self.punts,
            self.pairs,
            self.set_inside,
            self.set_crossing,
        ]
    }

    fn from_parts(p: &[u64; Self::LEN]) -> Option<Self> {
        let &[population, inside, attempts, kind, ..] = p;
        let &[_, _, _, _, crossing_inside, crossing_outside, members, edges, ..] = p;
        let &[.., separator, max_degree, visits, punts, pairs, set_inside, set_crossing] = p;
        let kind = NodeKind::from_number(kind)?;
        Some(NodeFacts {
            population,
            inside,
            attempts,
            kind,
            crossing_inside,
            crossing_outside,
            members,
            set_inside,
            set_crossing,
            edges,
            separator,
            max_degree,
            visits,
            punts,
            pairs,
        })
    }
}

/// Words that are read from the front. A number of rows is not trusted: each row that is read needs its words.
pub(super) struct Reader<'a>(&'a [u64]);

impl<'a> Reader<'a> {
    /// Reads words whose last one is the hash of the others. Returns `None` if it is not.
    pub(super) fn checked(words: &'a [u64]) -> Option<Self> {
        let (&hash, words) = words.split_last()?;
        (hash == checksum(bytemuck::cast_slice(words))).then_some(Reader(words))
    }

    /// Returns `true` if all words have been read.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Reads the next `count` words.
    pub(super) fn slice(&mut self, count: u64) -> Option<&'a [u64]> {
        let (words, rest) = self.0.split_at_checked(usize::try_from(count).ok()?)?;
        self.0 = rest;
        Some(words)
    }

    /// Reads the next `N` words.
    pub(super) fn take<const N: usize>(&mut self) -> Option<[u64; N]> {
        let (row, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*row)
    }

    pub(super) fn phase(&mut self) -> Option<Phase> {
        let [number] = self.take()?;
        Phase::from_number(u8::try_from(number).ok()?)
    }

    /// Reads the id of a node.
    pub(super) fn node(&mut self) -> Option<NodeId> {
        let [node] = self.take()?;
        node_of(node)
    }

    pub(super) fn small(&mut self) -> Option<u32> {
        let [word] = self.take()?;
        u32::try_from(word).ok()
    }

    fn rank(&mut self) -> Option<Rank> {
        self.small()
    }

    fn charge(&mut self) -> Option<(Account, Charge)> {
        let [first, node, items, cost @ ..] = self.take::<CHARGE_WORDS>()?;
        Some((Account::from_words(first, node)?, Charge { cost: Price::from_parts(cost), items }))
    }
}

/// Returns the node with this id. Ids begin with 1.
fn node_of(id: u64) -> Option<NodeId> {
    (id > 0).then_some(NodeId(id))
}

/// Appends the hash of words, which [`Reader::checked`] checks.
pub(super) fn hashed(mut words: Vec<u64>) -> Vec<u64> {
    words.push(checksum(bytemuck::cast_slice(&words)));
    words
}

impl Role {
    /// Returns the role as a number, and the level of a pass or the number of a step, otherwise 0.
    fn numbers(self) -> [u32; 2] {
        match self {
            Role::Member => [0, 0],
            Role::Leader => [1, 0],
            Role::Pass(level) => [2, level],
            Role::Step(step) => [3, step],
        }
    }

    fn from_numbers(role: u32, number: u32) -> Option<Self> {
        match (role, number) {
            (0, 0) => Some(Role::Member),
            (1, 0) => Some(Role::Leader),
            (2, level) => Some(Role::Pass(level)),
            (3, step) => Some(Role::Step(step)),
            _ => None,
        }
    }
}

impl Account {
    /// Returns the word that holds phase and role.
    fn first_word(&self) -> u64 {
        let [role, number] = self.role.numbers();
        u64::from(number) << 32 | u64::from(role) << 8 | self.phase as u64
    }

    fn from_words(first: u64, node: u64) -> Option<Self> {
        let role = Role::from_numbers(first as u32 >> 8, (first >> 32) as u32)?;
        Some(Account { role, phase: Phase::from_number(first as u8)?, node: node_of(node)? })
    }
}

impl LedgerPart {
    /// Returns the part as words.
    pub fn to_words(&self) -> Vec<u64> {
        let mut out = vec![
            self.rounds.len() as u64,
            self.charges.len() as u64,
            self.nodes.len() as u64,
            self.edge_hash,
            self.links.len() as u64,
            self.ranks.len() as u64,
            self.balance,
        ];
        for (key, tally) in &self.rounds {
            out.extend([u64::from(key.round), key.phase as u64]);
            out.extend(tally.values());
        }
        for (account, charge) in &self.charges {
            out.extend([account.first_word(), account.node.0, charge.items]);
            out.extend(charge.cost.to_parts());
        }
        for (node, facts) in &self.nodes {
            out.push(node.0);
            out.extend(facts.parts());
        }
        for (key, moved) in &self.links {
            out.extend([key.phase as u64, u64::from(key.from), u64::from(key.to)]);
            out.extend(moved.values());
        }
        for (key, tally) in &self.ranks {
            out.extend([u64::from(key.round), key.phase as u64, u64::from(key.rank), tally.work]);
            out.extend(tally.sent.values());
            out.extend(tally.received.values());
        }
        hashed(out)
    }

    /// Returns the part in these words, or `None` if they are not exactly one part or their hash is wrong.
    pub fn from_words(words: &[u64]) -> Option<Self> {
        let mut rest = Reader::checked(words)?;
        let [rounds, charges, nodes, edge_hash, links, ranks, balance] = rest.take()?;
        let mut part = LedgerPart { edge_hash, balance, ..LedgerPart::default() };
        for _ in 0..rounds {
            let key = RoundKey { round: rest.small()?, phase: rest.phase()? };
            part.rounds.insert(key, RoundTally::from_values(rest.take()?));
        }
        for _ in 0..charges {
            let (account, charge) = rest.charge()?;
            part.charges.insert(account, charge);
        }
        for _ in 0..nodes {
            part.nodes.insert(rest.node()?, NodeFacts::from_parts(&rest.take()?)?);
        }
        for _ in 0..links {
            let key = LinkKey { phase: rest.phase()?, from: rest.rank()?, to: rest.rank()? };
            part.links.insert(key, Traffic::from_values(rest.take()?));
        }
        for _ in 0..ranks {
            let key = RankKey { round: rest.small()?, phase: rest.phase()?, rank: rest.rank()? };
            let [work] = rest.take()?;
            let [sent, received] = [rest.take()?, rest.take()?].map(Traffic::from_values);
            part.ranks.insert(key, RankTally { work, sent, received });
        }
        rest.is_empty().then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part with rows in every map survives its words. A part that is cut, or names an unknown phase, does not.
    #[test]
    fn a_part_survives_its_words() {
        let mut part = LedgerPart::default();
        let cost = Price::from_parts([4, 3, 2, 1, 5]);
        part.bill(
            RankKey { round: 7, phase: Phase::Partition, rank: 2 },
            5,
            Traffic { messages: 1, bytes: 40, points: 3 },
        );
        part.facts(NodeId(6)).kind = NodeKind::Plane;
        part.charge(Account::member(Phase::Graph, NodeId(6)), cost, 9);
        part.charge(Account::leader(Phase::Graph, NodeId(6)), cost, 0);
        part.charge(Account::pass(2, NodeId(6)), cost, 1);
        part.charge(Account::step(Phase::Repair, 70_000, NodeId(6)), cost, 1);
        (part.edge_hash, part.balance) = (77, 78);
        let words = part.to_words();
        assert_eq!(LedgerPart::from_words(&words), Some(part));
        for cut in 0..words.len() {
            assert_eq!(LedgerPart::from_words(&words[..cut]), None);
        }
        assert_eq!(words[..7], [1, 4, 1, 77, 1, 2, 78]);
        // The first charge follows the head and one round.
        let (phase, leader) = (7 + 1, 7 + 13 + CHARGE_WORDS);
        assert_eq!(words[leader], Phase::Graph as u64 | 1 << 8);
        for (at, word) in [(phase, 99), (leader, 9 << 8), (leader, 1 << 32 | 1 << 8)] {
            let mut unknown = words.clone();
            unknown[at] = word;
            assert_eq!(LedgerPart::from_words(&unknown), None);
            let (hash, others) = unknown.split_last_mut().unwrap();
            *hash = checksum(bytemuck::cast_slice(others));
            assert_eq!(LedgerPart::from_words(&unknown), None, "although the hash is right");
        }
        for bit in 0..64 * words.len() {
            let mut flipped = words.clone();
            flipped[bit / 64] ^= 1 << (bit % 64);
            assert_eq!(LedgerPart::from_words(&flipped), None, "bit {bit}");
        }
    }
}
