use septet_geometry::cost::Price;

use super::*;
use crate::checksum::checksum;
use crate::ids::Flow;
use crate::ledger::part::{Charge, NodeFacts, NodeKind};
use crate::ledger::{Ledger, RankKey, Traffic};

/// A generator of numbers below a bound.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }

    fn charge(&mut self) -> Charge {
        let parts = [1 + self.below(100), self.below(40), self.below(4), self.below(3), self.below(9)];
        Charge { cost: Price::from_parts(parts), items: 1 + self.below(50) }
    }
}

/// The roots of the subtrees of the ranks. Rank 4 holds a leaf at level 1.
const ROOTS: [NodeId; 4] = [NodeId(8), NodeId(9), NodeId(5), NodeId(3)];

/// Adds a node's charges in all roles.
fn charge_node(part: &mut LedgerPart, node: NodeId, numbers: &mut Numbers) {
    let mut add = |account: Account, numbers: &mut Numbers| {
        if numbers.below(4) > 0 {
            let Charge { cost, items } = numbers.charge();
            part.charge(account, cost, items);
        }
    };
    for phase in Phase::ALL.into_iter().filter(|phase| *phase != Phase::Neighbours) {
        add(Account::member(phase, node), numbers);
        add(Account::leader(phase, node), numbers);
        if phase.flow() == Flow::Steps {
            let step = numbers.below(5) as u32;
            add(Account::step(phase, step, node), numbers);
        }
    }
    for level in 0..=node.level() {
        add(Account::pass(level, node), numbers);
    }
}

/// The parts of four ranks. All charge the shared nodes above their subtrees, and each the nodes of its own subtree.
fn parts(seed: u64) -> Vec<LedgerPart> {
    let mut numbers = Numbers(seed);
    let mut parts = vec![LedgerPart::default(); ROOTS.len()];
    for (rank, (part, root)) in parts.iter_mut().zip(ROOTS).enumerate() {
        for node in (1..64).map(NodeId).filter(|node| node.contains(root) || root.contains(*node)) {
            charge_node(part, node, &mut numbers);
            *part.facts(node) = NodeFacts {
                population: 5000 / node.0,
                inside: 1700 / node.0,
                kind: if node.level() < 5 { NodeKind::Sphere } else { NodeKind::Leaf },
                attempts: node.0 % 4,
                crossing_inside: numbers.below(9),
                members: numbers.below(90),
                edges: numbers.below(300),
                ..NodeFacts::default()
            };
        }
        let rank = rank as u32;
        let sender = RankKey { round: 1 + rank % 2, phase: Phase::Hulls, rank };
        part.bill(sender, 0, Traffic { messages: 1, bytes: 8, points: 0 });
    }
    parts
}

fn phases(parts: &[LedgerPart]) -> PhaseSet {
    parts.iter().map(PhaseSet::of).fold(PhaseSet::default(), PhaseSet::union)
}

/// Condenses the part of each process, which runs two ranks.
fn condensed(parts: &[LedgerPart], keeps_nodes: bool) -> Vec<CondensedLedger> {
    let phases = phases(parts);
    let of_process = |(ranks, roots): (&[LedgerPart], &[NodeId])| {
        merged(ranks).condense(&Condensing { roots, phases, space: 3, keeps_nodes })
    };
    parts.chunks(2).zip(ROOTS.chunks(2)).map(of_process).collect()
}

fn merged(parts: &[LedgerPart]) -> LedgerPart {
    let mut all = LedgerPart::default();
    for part in parts {
        all.merge(part);
    }
    all
}

fn assert_equal(found: &Ledger, expected: &Ledger) {
    assert_eq!(found.totals, expected.totals);
    assert_eq!(found.phases, expected.phases);
    assert_eq!(found.critical_path, expected.critical_path);
    assert_eq!(found.tree, expected.tree);
    assert_eq!(found.part.rounds, expected.part.rounds);
}

#[test]
fn condensed_parts_fold_as_the_merged_parts() {
    for seed in 0..30 {
        let parts = parts(seed);
        let expected = Ledger::finish(merged(&parts), 1000, 3);
        assert!(expected.totals.paper.depth > 100 && !expected.critical_path.is_empty());
        for keeps_nodes in [true, false] {
            let sent = condensed(&parts, keeps_nodes);
            assert!(sent.iter().all(|own| own.part.charges.keys().all(|a| a.node.level() < 3)));
            assert!(sent.iter().any(|own| !own.passes.is_empty()));
            let arrived = sent.iter().map(|own| CondensedLedger::from_words(&own.to_words()).unwrap());
            let arrived: Vec<_> = arrived.collect();
            assert!(arrived == sent);
            let backwards = CondensedLedger::united(arrived.iter().rev().cloned()).unwrap();
            let united = CondensedLedger::united(arrived).unwrap();
            assert!(united == backwards);
            assert_equal(&Ledger::of_condensed(united, 1000, 3), &expected);
        }
    }
}

#[test]
fn a_ledger_without_subtrees_folds_as_its_rows() {
    let part = merged(&parts(7));
    let phases = PhaseSet::of(&part);
    let expected = Ledger::finish(part.clone(), 1000, 2);
    for roots in [&[][..], &[NodeId::ROOT]] {
        let condensing = Condensing { roots, phases, space: 2, keeps_nodes: false };
        let own = part.clone().condense(&condensing);
        assert_eq!(own.part.charges.is_empty(), !roots.is_empty());
        assert_equal(&Ledger::of_condensed(own, 1000, 2), &expected);
    }
}

/// Charges and facts in the subtree of another rank are found, wherever they are.
#[test]
fn counts_of_a_foreign_subtree_are_refused() {
    let united =
        |parts: &[LedgerPart], keeps_nodes| CondensedLedger::united(condensed(parts, keeps_nodes)).map(drop);
    for node in [8, 16, 35].map(NodeId) {
        let mut charged = parts(3);
        assert_eq!(united(&charged, false), Ok(()));
        charged[2].charge(Account::member(Phase::Hulls, node), Price::from_parts([1, 1, 0, 0, 0]), 1);
        let shared = Err(LedgerError::Shared { node });
        assert_eq!([true, false].map(|keeps| united(&charged, keeps)), [shared, shared]);
        let mut known = parts(3);
        known[2].facts(node).visits = 1;
        assert_eq!([true, false].map(|keeps| united(&known, keeps)), [Ok(()), shared]);
    }
}

#[test]
fn subtrees_that_overlap_and_other_phases_are_refused() {
    let all = parts(5);
    let phases = phases(&all);
    let of = |roots: &[NodeId], phases, keeps_nodes| {
        LedgerPart::default().condense(&Condensing { roots, phases, space: 3, keeps_nodes })
    };
    let united = |a, b| CondensedLedger::united([a, b]).map(drop);
    let [four, eight] = [NodeId(4), NodeId(8)];
    assert_eq!(united(of(&[four], phases, true), of(&[NodeId(5)], phases, true)), Ok(()));
    for inner in [four, eight] {
        let shared = Err(LedgerError::Shared { node: inner });
        assert_eq!(united(of(&[four], phases, true), of(&[inner], phases, true)), shared);
    }
    let none = PhaseSet::default();
    for (other, keeps_nodes) in [(none, true), (phases, false)] {
        assert_eq!(united(of(&[], phases, true), of(&[], other, keeps_nodes)), Err(LedgerError::Mixed));
    }
    let rows = CondensedLedger { part: all[0].clone(), ..of(&[], none, true) };
    assert_eq!(CondensedLedger::united([rows]).map(drop), Err(LedgerError::Mixed));
}

#[test]
fn words_that_changed_are_refused() {
    let words = condensed(&parts(1), false).swap_remove(0).to_words();
    for cut in 0..words.len() {
        assert!(CondensedLedger::from_words(&words[..cut]).is_none(), "{cut}");
    }
    for bit in (0..64 * words.len()).step_by(7) {
        let mut flipped = words.clone();
        flipped[bit / 64] ^= 1 << (bit % 64);
        assert!(CondensedLedger::from_words(&flipped).is_none(), "bit {bit}");
    }
}

/// Lengths that do not fit are refused although the hash is right, and no length causes a large allocation or a panic.
#[test]
fn lengths_that_do_not_fit_are_refused() {
    let own = condensed(&parts(1), false).swap_remove(0);
    let words = own.to_words();
    let rehashed = |mut words: Vec<u64>| {
        let (hash, others) = words.split_last_mut().unwrap();
        *hash = checksum(bytemuck::cast_slice(others));
        words
    };
    let rows = own.part.to_words().len();
    // The number of words of the rows, the phases, the flag, and the number of folds.
    for at in [0, rows + 1, rows + 2, rows + 3] {
        for word in [words[at] + 2, words[at].wrapping_sub(1), 1 << 40, u64::MAX] {
            let mut changed = words.clone();
            changed[at] = word;
            assert!(CondensedLedger::from_words(&rehashed(changed)).is_none(), "{at}: {word}");
        }
    }
    for at in 0..words.len() - 1 {
        let mut changed = words.clone();
        changed[at] = u64::MAX;
        // A count may be any number, so some of these words are a ledger.
        drop(CondensedLedger::from_words(&rehashed(changed)));
    }
    // The rows of levels come last, each after its level. Two of them are of the same level.
    let mut twice = words.clone();
    // The level, 23 sums, and the depth of each phase after the number of phases.
    let row = |level: u32| 1 + 23 + 1 + 2 * own.tree.levels[&level].depths().count();
    let last = words.len() - 1 - row(5);
    assert_eq!([words[last], words[last - row(4)]], [5, 4]);
    twice[last] = 4;
    assert!(CondensedLedger::from_words(&rehashed(twice)).is_none());
    for extra in [0, 1] {
        let mut longer = words.clone();
        longer.push(extra);
        assert!(CondensedLedger::from_words(&rehashed(longer)).is_none(), "{extra}");
    }
}
