//! A part of the ledger as plain numbers, for the wire.
//!
//! A head of seven words holds the numbers of rows and the hash of the edges. Rows follow, map by map, each in the
//! order of its keys. In a charge of a leader, bit 7 of the phase number is set.

use septet_geometry::cost::Cost;

use super::{
    Account, Charge, LedgerPart, LinkKey, NodeFacts, NodeKind, Role, RoundKey, RoundTally, SenderKey, Traffic,
};
use crate::ids::{NodeId, Phase, Rank};

/// The bit of the phase number that marks a charge of a leader.
const LEADER: u64 = 0x80;

/// Words of a charge: phase or level, node, items and the four parts of the cost.
const CHARGE_WORDS: usize = 7;

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

    fn from_parts(p: &[u64; Self::LEN]) -> Self {
        let &[messages, bytes, largest, points, active, merged, separators, retries, control] = p;
        RoundTally { messages, bytes, largest, points, active, merged, separators, retries, control }
    }
}

impl Traffic {
    const LEN: usize = 3;

    fn parts(&self) -> [u64; Self::LEN] {
        [self.messages, self.bytes, self.points]
    }

    fn from_parts(&[messages, bytes, points]: &[u64; Self::LEN]) -> Self {
        Traffic { messages, bytes, points }
    }
}

impl NodeFacts {
    const LEN: usize = 11;

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
        ]
    }

    fn from_parts(p: &[u64; Self::LEN]) -> Option<Self> {
        let &[population, inside, attempts, kind, ..] = p;
        let &[.., crossing_inside, crossing_outside, members, edges, separator, max_degree, visits] = p;
        let kind = NodeKind::from_number(kind)?;
        Some(NodeFacts {
            population,
            inside,
            attempts,
            kind,
            crossing_inside,
            crossing_outside,
            members,
            edges,
            separator,
            max_degree,
            visits,
        })
    }
}

/// Words that are read from the front.
struct Reader<'a>(&'a [u64]);

impl Reader<'_> {
    /// Reads the next `N` words.
    fn take<const N: usize>(&mut self) -> Option<[u64; N]> {
        let (row, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*row)
    }

    fn phase(&mut self) -> Option<Phase> {
        let [number] = self.take()?;
        Phase::from_number(u8::try_from(number).ok()?)
    }

    fn small(&mut self) -> Option<u32> {
        let [word] = self.take()?;
        u32::try_from(word).ok()
    }

    fn rank(&mut self) -> Option<Rank> {
        self.small()
    }

    fn charge(&mut self) -> Option<([u64; 2], Charge)> {
        let [first, node, items, cost @ ..] = self.take::<CHARGE_WORDS>()?;
        Some(([first, node], Charge { cost: Cost::from_parts(cost), items }))
    }
}

/// Returns the account of a charge of a member or a leader.
fn account([number, node]: [u64; 2]) -> Option<Account> {
    let phase = Phase::from_number(u8::try_from(number & !LEADER).ok()?)?;
    let role = if number & LEADER == 0 { Role::Member } else { Role::Leader };
    Some(Account { role, phase, node: NodeId(node) })
}

/// Returns the account of a charge in a pass of the bottom-up correction.
fn pass([level, node]: [u64; 2]) -> Option<Account> {
    Some(Account::pass(u32::try_from(level).ok()?, NodeId(node)))
}

impl LedgerPart {
    /// Returns the part as words.
    pub fn to_words(&self) -> Vec<u64> {
        let passes = self.charges.keys().filter(|account| matches!(account.role, Role::Pass(_))).count();
        let mut out = vec![
            self.rounds.len() as u64,
            (self.charges.len() - passes) as u64,
            self.nodes.len() as u64,
            self.edge_hash,
            self.links.len() as u64,
            self.senders.len() as u64,
            passes as u64,
        ];
        for (key, tally) in &self.rounds {
            out.extend([u64::from(key.round), key.phase as u64]);
            out.extend(tally.parts());
        }
        // Members, leaders, then passes: the order of accounts.
        for (account, charge) in &self.charges {
            let first = match account.role {
                Role::Member => account.phase as u64,
                Role::Leader => account.phase as u64 | LEADER,
                Role::Pass(level) => u64::from(level),
            };
            out.extend([first, account.node.0, charge.items]);
            out.extend(charge.cost.to_parts());
        }
        for (node, facts) in &self.nodes {
            out.push(node.0);
            out.extend(facts.parts());
        }
        for (key, moved) in &self.links {
            out.extend([key.phase as u64, u64::from(key.from), u64::from(key.to)]);
            out.extend(moved.parts());
        }
        for (key, moved) in &self.senders {
            out.extend([u64::from(key.round), key.phase as u64, u64::from(key.from)]);
            out.extend(moved.parts());
        }
        out
    }

    /// Returns the part in these words, or `None` if they are not exactly one part.
    pub fn from_words(words: &[u64]) -> Option<Self> {
        let mut rest = Reader(words);
        let [rounds, charges, nodes, edge_hash, links, senders, passes] = rest.take()?;
        let mut part = LedgerPart { edge_hash, ..LedgerPart::default() };
        for _ in 0..rounds {
            let key = RoundKey { round: rest.small()?, phase: rest.phase()? };
            part.rounds.insert(key, RoundTally::from_parts(&rest.take()?));
        }
        for _ in 0..charges {
            let (words, charge) = rest.charge()?;
            part.charges.insert(account(words)?, charge);
        }
        for _ in 0..passes {
            let (words, charge) = rest.charge()?;
            part.charges.insert(pass(words)?, charge);
        }
        for _ in 0..nodes {
            let [node] = rest.take()?;
            part.nodes.insert(NodeId(node), NodeFacts::from_parts(&rest.take()?)?);
        }
        for _ in 0..links {
            let key = LinkKey { phase: rest.phase()?, from: rest.rank()?, to: rest.rank()? };
            part.links.insert(key, Traffic::from_parts(&rest.take()?));
        }
        for _ in 0..senders {
            let key = SenderKey { round: rest.small()?, phase: rest.phase()?, from: rest.rank()? };
            part.senders.insert(key, Traffic::from_parts(&rest.take()?));
        }
        rest.0.is_empty().then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part with rows in every map survives its words. A part that is cut, or names an unknown phase, does not.
    #[test]
    fn a_part_survives_its_words() {
        let mut part = LedgerPart::default();
        let cost = Cost::from_parts([4, 3, 2, 1]);
        part.bill(
            SenderKey { round: 7, phase: Phase::Partition, from: 2 },
            5,
            Traffic { messages: 1, bytes: 40, points: 3 },
        );
        part.facts(NodeId(6)).kind = NodeKind::Plane;
        part.charge(Account::member(Phase::Graph, NodeId(6)), cost, 9);
        part.charge(Account::leader(Phase::Graph, NodeId(6)), cost, 0);
        part.charge(Account::pass(2, NodeId(6)), cost, 1);
        part.edge_hash = 77;
        let words = part.to_words();
        assert_eq!(LedgerPart::from_words(&words), Some(part));
        for cut in 0..words.len() {
            assert_eq!(LedgerPart::from_words(&words[..cut]), None);
        }
        let mut unknown = words.clone();
        unknown[8] = 99;
        assert_eq!(LedgerPart::from_words(&unknown), None);
        assert_eq!(words[..7], [1, 2, 1, 77, 1, 1, 1]);
        assert_eq!(words[7 + 11 + 7], Phase::Graph as u64 | LEADER);
    }
}
