//! A condensed ledger as plain numbers, for the wire.
//!
//! The words of the rows come first, after their number. Then follow the phases, whether the facts of nodes are rows, and the
//! folds, passes, work and levels, each list after its length. The lengths within a fold follow from the phases. The last
//! word is the hash of the others.

use std::collections::BTreeMap;

use septet_geometry::cost::Price;

use super::CondensedLedger;
use crate::ledger::fold::{Fold, PhaseSet, Plan};
use crate::ledger::levels::{LevelSums, Ratios};
use crate::ledger::part::LedgerPart;
use crate::ledger::words::{Reader, hashed};

impl Ratios {
    const LEN: usize = 4;

    fn parts(&self) -> [u64; Self::LEN] {
        [self.count, self.largest.to_bits(), self.sum as u64, (self.sum >> 64) as u64]
    }

    fn from_parts([count, largest, low, high]: [u64; Self::LEN]) -> Option<Self> {
        let largest = f64::from_bits(largest);
        let sum = u128::from(high) << 64 | u128::from(low);
        (largest >= 0.0 && largest.is_finite()).then_some(Ratios { count, largest, sum })
    }
}

impl LevelSums {
    /// Appends the sums as words.
    fn push_words(&self, out: &mut Vec<u64>) {
        out.extend([
            self.nodes,
            self.leaves,
            self.spheres,
            self.planes,
            self.curves,
            self.points,
            self.largest,
        ]);
        out.extend(self.split.parts());
        out.extend(self.separator.parts());
        out.extend([self.attempts, self.largest_attempts, self.separator_points]);
        out.extend([self.edges, self.members, self.max_degree, self.punts, self.pairs]);
        out.push(self.deepest.len() as u64);
        out.extend(self.deepest.iter().flat_map(|(phase, depth)| [*phase as u64, *depth]));
    }

    fn read(words: &mut Reader<'_>) -> Option<Self> {
        let [nodes, leaves, spheres, planes, curves, points, largest] = words.take()?;
        let split = Ratios::from_parts(words.take()?)?;
        let separator = Ratios::from_parts(words.take()?)?;
        let [attempts, largest_attempts, separator_points] = words.take()?;
        let [edges, members, max_degree, punts, pairs] = words.take()?;
        let ([phases], mut deepest) = (words.take()?, BTreeMap::new());
        for _ in 0..phases {
            let (phase, [depth]) = (words.phase()?, words.take()?);
            insert_new(&mut deepest, phase, depth)?;
        }
        Some(LevelSums {
            nodes,
            leaves,
            spheres,
            planes,
            curves,
            points,
            largest,
            split,
            separator,
            attempts,
            largest_attempts,
            separator_points,
            edges,
            members,
            max_degree,
            punts,
            pairs,
            deepest,
        })
    }
}

/// Adds an entry of a list. Returns `None` if the list has another one with this key.
fn insert_new<K: Ord, V>(list: &mut BTreeMap<K, V>, key: K, value: V) -> Option<()> {
    list.insert(key, value).is_none().then_some(())
}

impl CondensedLedger {
    /// Returns the ledger as words.
    pub fn to_words(&self) -> Vec<u64> {
        let plan = Plan::of(self.phases);
        let rows = self.part.to_words();
        let mut out = vec![rows.len() as u64];
        out.extend(rows);
        out.extend([self.phases.bits(), u64::from(self.keeps_nodes)]);
        out.push(self.folds.len() as u64);
        for (node, fold) in &self.folds {
            out.push(node.0);
            fold.push_words(&plan, &mut out);
        }
        out.push(self.passes.len() as u64);
        for ((level, node), cost) in &self.passes {
            out.extend([u64::from(*level), node.0]);
            out.extend(cost.to_parts());
        }
        out.push(self.work.len() as u64);
        out.extend(self.work.iter().flat_map(|(phase, work)| [*phase as u64, *work]));
        out.push(self.tree.levels.len() as u64);
        for (level, sums) in &self.tree.levels {
            out.push(u64::from(*level));
            sums.push_words(&mut out);
        }
        hashed(out)
    }

    /// Returns the ledger in these words, or `None` if they are not exactly one ledger or their hash is wrong.
    pub fn from_words(words: &[u64]) -> Option<Self> {
        let mut rest = Reader::checked(words)?;
        let [rows] = rest.take()?;
        let part = LedgerPart::from_words(rest.slice(rows)?)?;
        let [phases, keeps_nodes, folds] = rest.take()?;
        let phases = PhaseSet::from_bits(phases)?;
        let keeps_nodes = [false, true].into_iter().find(|flag| u64::from(*flag) == keeps_nodes)?;
        let mut ledger = CondensedLedger { part, phases, keeps_nodes, ..CondensedLedger::default() };
        let plan = Plan::of(phases);
        for _ in 0..folds {
            let (node, fold) = (rest.node()?, Fold::read(&plan, &mut rest)?);
            insert_new(&mut ledger.folds, node, fold)?;
        }
        let [passes] = rest.take()?;
        for _ in 0..passes {
            let key = (rest.small()?, rest.node()?);
            insert_new(&mut ledger.passes, key, Price::from_parts(rest.take()?))?;
        }
        let [phases] = rest.take()?;
        for _ in 0..phases {
            let (phase, [work]) = (rest.phase()?, rest.take()?);
            insert_new(&mut ledger.work, phase, work)?;
        }
        let [levels] = rest.take()?;
        for _ in 0..levels {
            let (level, sums) = (rest.small()?, LevelSums::read(&mut rest)?);
            insert_new(&mut ledger.tree.levels, level, sums)?;
        }
        rest.is_empty().then_some(ledger)
    }
}
