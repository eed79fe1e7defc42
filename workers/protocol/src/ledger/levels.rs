//! Sums over the nodes of each level of the partition tree.
//!
//! **Statement.** The sums of a tree follow from the sums of any parts of it, and do not depend on the cuts or on the order.
//! All sums are integers. A ratio is rounded to a multiple of `2^-40` before it is added, so a mean of ratios is exact to
//! `2^-41`, up to the rounding of the result.
//!
//! **Bound.** A ratio of a node is at most its number of points, and the nodes of a level have at most `2^64` points. There
//! are at most 63 levels, so a sum of ratios is below `2^(64 + 6 + 40)`, and fits into 128 bits.
//!
//! **Work.** A constant for each node and each charge. A tree has one row of sums for each level.

use std::collections::BTreeMap;

use super::part::{LedgerPart, NodeFacts, NodeKind};
use crate::ids::Phase;

/// Parts of one in which ratios are counted.
const UNITS: f64 = (1u64 << 40) as f64;

/// Largest value and mean of some ratios.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ratios {
    pub(super) count: u64,
    /// 0 if there are none.
    pub(super) largest: f64,
    /// The sum in multiples of `2^-40`.
    pub(super) sum: u128,
}

impl Ratios {
    /// Adds a ratio. It must not be negative.
    fn add(&mut self, ratio: f64) {
        let sum = (ratio * UNITS).round() as u128;
        self.join(&Ratios { count: 1, largest: ratio, sum });
    }

    /// Adds other ratios.
    fn join(&mut self, other: &Ratios) {
        self.count += other.count;
        self.largest = self.largest.max(other.largest);
        self.sum += other.sum;
    }

    /// Returns the largest ratio, or `None` if there are none.
    pub fn largest(&self) -> Option<f64> {
        (self.count > 0).then_some(self.largest)
    }

    /// Returns the mean, or `None` if there are no ratios.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum as f64 / UNITS / self.count as f64)
    }
}

/// The sums over the nodes of a level. Facts of separators are those of split nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelSums {
    /// Number of nodes.
    pub nodes: u64,
    /// Number of leaves among them.
    pub leaves: u64,
    /// Number of nodes split by a sphere.
    pub spheres: u64,
    /// Number of nodes split by a plane.
    pub planes: u64,
    /// Number of nodes split by a cut of a Hilbert curve.
    pub curves: u64,
    /// Owned points.
    pub points: u64,
    /// Owned points of the largest node.
    pub largest: u64,
    /// Size of the larger side over the number of owned points.
    pub split: Ratios,
    /// Number of points whose balls meet the separator, over `m^(1 - 1/d)` for m owned points.
    pub separator: Ratios,
    /// Attempts at the separators.
    pub attempts: u64,
    /// Largest number of attempts at a separator.
    pub largest_attempts: u64,
    /// Points whose balls meet a separator.
    pub separator_points: u64,
    /// Edges of the supergraph ([`NodeFacts::edges`]).
    pub edges: u64,
    /// Points of the sets in which all pairs were compared ([`NodeFacts::compared`]).
    pub members: u64,
    /// Largest degree of a point.
    pub max_degree: u64,
    /// Nodes that punt ([`NodeFacts::punts`]).
    pub punts: u64,
    /// Well-separated pairs of leaves ([`NodeFacts::pairs`]).
    pub pairs: u64,
    /// Largest depth of a node in each phase.
    pub(super) deepest: BTreeMap<Phase, u64>,
}

impl LevelSums {
    /// Returns the largest depth of a node in a phase; 0 without charges.
    pub fn deepest(&self, phase: Phase) -> u64 {
        self.deepest.get(&phase).copied().unwrap_or(0)
    }

    /// Returns the largest depth of a node in each phase that charged nodes, in order.
    pub fn depths(&self) -> impl Iterator<Item = (Phase, u64)> {
        self.deepest.iter().map(|(&phase, &depth)| (phase, depth))
    }

    /// Adds the depth of a node in a phase.
    fn add_depth(&mut self, phase: Phase, depth: u64) {
        let deepest = self.deepest.entry(phase).or_default();
        *deepest = depth.max(*deepest);
    }

    /// Adds a node.
    fn add(&mut self, facts: &NodeFacts, space: usize) {
        self.members += facts.compared();
        if facts.population == 0 {
            // A set that is no node of the partition tree.
            return;
        }
        self.nodes += 1;
        self.points += facts.population;
        self.largest = self.largest.max(facts.population);
        self.edges += facts.edges;
        self.max_degree = self.max_degree.max(facts.max_degree);
        self.punts += facts.punts;
        self.pairs += facts.pairs;
        match facts.kind {
            NodeKind::Leaf => {
                self.leaves += 1;
                return;
            }
            NodeKind::Sphere => self.spheres += 1,
            NodeKind::Plane => self.planes += 1,
            NodeKind::Curve => self.curves += 1,
        }
        let points = facts.population.max(1) as f64;
        let larger = facts.inside.max(facts.population.saturating_sub(facts.inside));
        let crossing = facts.crossing_inside + facts.crossing_outside;
        self.split.add(larger as f64 / points);
        self.separator.add(crossing as f64 / points.powf(1.0 - 1.0 / space as f64));
        self.attempts += facts.attempts;
        self.largest_attempts = self.largest_attempts.max(facts.attempts);
        self.separator_points += crossing;
    }

    /// Adds the sums of other nodes.
    pub(super) fn join(&mut self, other: &LevelSums) {
        self.nodes += other.nodes;
        self.leaves += other.leaves;
        self.spheres += other.spheres;
        self.planes += other.planes;
        self.curves += other.curves;
        self.points += other.points;
        self.largest = self.largest.max(other.largest);
        self.split.join(&other.split);
        self.separator.join(&other.separator);
        self.attempts += other.attempts;
        self.largest_attempts = self.largest_attempts.max(other.largest_attempts);
        self.separator_points += other.separator_points;
        self.edges += other.edges;
        self.members += other.members;
        self.max_degree = self.max_degree.max(other.max_degree);
        self.punts += other.punts;
        self.pairs += other.pairs;
        for (&phase, &depth) in &other.deepest {
            self.add_depth(phase, depth);
        }
    }
}

/// The sums over the nodes of a partition tree, by level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeSums {
    pub(super) levels: BTreeMap<u32, LevelSums>,
}

impl TreeSums {
    /// Returns the levels that have nodes, from the root down.
    pub fn levels(&self) -> impl Iterator<Item = (u32, &LevelSums)> {
        self.levels.iter().filter(|(_, sums)| sums.nodes > 0).map(|(level, sums)| (*level, sums))
    }

    /// Returns the sums over all levels.
    pub fn total(&self) -> LevelSums {
        let mut total = LevelSums::default();
        self.levels.values().for_each(|sums| total.join(sums));
        total
    }

    /// Adds the nodes of a part, whose charges are settled, for points with `space` coordinates.
    pub(super) fn add_rows(&mut self, part: &LedgerPart, space: usize) {
        for (node, facts) in &part.nodes {
            self.levels.entry(node.level()).or_default().add(facts, space);
        }
        for phase in Phase::ALL {
            for (node, charge) in part.members(phase) {
                self.levels.entry(node.level()).or_default().add_depth(phase, charge.cost.depth());
            }
        }
    }

    /// Adds the sums of other nodes.
    pub(super) fn join(&mut self, other: &TreeSums) {
        for (level, sums) in &other.levels {
            self.levels.entry(*level).or_default().join(sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use septet_geometry::cost::Price;

    use super::*;
    use crate::ids::NodeId;
    use crate::ledger::part::Account;

    /// A part with the facts and the charges of the nodes that `is_in` accepts. Their ratios have many digits.
    fn part(is_in: impl Fn(u64) -> bool) -> LedgerPart {
        let mut part = LedgerPart::default();
        for node in (1..512).filter(|&node| is_in(node)) {
            let population = 1000 + node * 7919 % 997;
            *part.facts(NodeId(node)) = NodeFacts {
                population,
                inside: population / 3 + node % 5,
                attempts: 1 + node % 3,
                kind: [NodeKind::Sphere, NodeKind::Plane, NodeKind::Leaf][(node / 2 % 3) as usize],
                crossing_inside: node % 101,
                crossing_outside: node % 37,
                members: node % 53,
                edges: node % 211,
                max_degree: node % 29,
                ..NodeFacts::default()
            };
            let cost = Price::from_parts([node, node % 17, 0, 0, 0]);
            part.charge(Account::member(Phase::Merge, NodeId(node)), cost, 1);
        }
        part
    }

    fn sums(parts: &[LedgerPart]) -> TreeSums {
        let mut all = TreeSums::default();
        for part in parts {
            let mut own = TreeSums::default();
            own.add_rows(part, 3);
            all.join(&own);
        }
        all
    }

    #[test]
    fn sums_do_not_depend_on_parts_or_order() {
        let whole = sums(&[part(|_| true)]);
        for classes in [2, 3, 7, 64] {
            let parts: Vec<LedgerPart> =
                (0..classes).map(|class| part(|node| node * 31 % classes == class)).collect();
            assert_eq!(sums(&parts), whole);
            assert_eq!(sums(&parts.into_iter().rev().collect::<Vec<_>>()), whole);
        }
        assert_eq!(whole.levels().count(), 9);
    }

    #[test]
    fn sums_are_those_of_the_facts() {
        let part = part(|_| true);
        let total = sums(std::slice::from_ref(&part)).total();
        let split = part.nodes.values().filter(|facts| !facts.is_leaf());
        let ratios: Vec<f64> = split
            .clone()
            .map(|f| f.inside.max(f.population - f.inside) as f64 / f.population as f64)
            .collect();
        assert_eq!(total.nodes, 511);
        assert_eq!(total.nodes - total.leaves, ratios.len() as u64);
        assert_eq!(total.split.largest(), ratios.iter().copied().reduce(f64::max));
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!((total.split.mean().unwrap() - mean).abs() < 1e-12);
        let crossing: u64 = split.map(|f| f.crossing_inside + f.crossing_outside).sum();
        assert_eq!(total.separator_points, crossing);
        assert_eq!(total.edges, part.nodes.values().map(|f| f.edges).sum::<u64>());
        assert_eq!((total.deepest(Phase::Merge), total.deepest(Phase::Hulls)), (16, 0));
        assert_eq!(Ratios::default().mean(), None);
    }
}
