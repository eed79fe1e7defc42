//! Faults of charges: the run is right, but the ledger contains other costs.
//!
//! Most of them change the merged ledger, before it is folded ([`Fault::distort`]). The costs of a subproblem are then
//! complete, so the change is the same for any number of workers.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Price};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::{Account, Charge, LedgerPart, NodeFacts, Role};

use super::Fault;

impl Fault {
    /// Returns the charge that replaces the true charge of the radii within a leaf, if this fault replaces it.
    pub(crate) fn charge_of_radii(self, members: &[u32], meter: &Cost) -> Option<Cost> {
        let mut cost = meter.fresh();
        match self {
            Fault::FreeLoop => drop(cost.map(members, |_| ())),
            Fault::SequentialLeaf => cost.sequential(members.len() * members.len(), (), |(), _| ()),
            _ => return None,
        }
        Some(cost)
    }

    /// Changes the charges of a worker's ledger before the worker sends it ([`Fault::OneClock`]).
    pub(crate) fn distort_worker(self, ledger: &mut LedgerPart) {
        if self != Fault::OneClock {
            return;
        }
        let mut clocks: BTreeMap<(Role, Phase), Price> = BTreeMap::new();
        let of_phases =
            |(account, _): &(&Account, &mut Charge)| matches!(account.role, Role::Member | Role::Leader);
        for (account, Charge { cost, .. }) in ledger.charges.iter_mut().filter(of_phases) {
            let clock = clocks.entry((account.role, account.phase)).or_default();
            clock.then(*cost);
            // The clock determines when a subproblem ends. The work of the subproblem is unchanged.
            let [_, depth, scans, inner_log, _] = clock.to_parts();
            *cost = Price::from_parts([cost.work(), depth, scans, inner_log, cost.exact_tests()]);
        }
    }

    /// Returns `true` if the fault changes charges of the merged ledger. It then needs all rows.
    pub fn needs_rows(self) -> bool {
        matches!(self, Fault::Slow { .. } | Fault::Work { .. } | Fault::Free { .. })
    }

    /// Changes the charges of the merged ledger of a run.
    ///
    /// A law is a function of a number of points. At an inner node, this is the number of its points. The size of a leaf
    /// is bounded, so there it is the number of points of the run, as if the leaf waited for all of them.
    pub(crate) fn distort(self, ledger: &mut LedgerPart) {
        let (Fault::Slow { phase, .. } | Fault::Work { phase, .. } | Fault::Free { phase }) = self else {
            return;
        };
        ledger.join_leaders();
        let LedgerPart { charges, nodes, .. } = ledger;
        let all = nodes.get(&NodeId::ROOT).map_or(1, |root| root.population);
        for (account, charge) in charges.iter_mut().filter(|(account, _)| account.phase == phase) {
            let inner = nodes.get(&account.node).filter(|facts| !facts.is_leaf());
            self.change(&mut charge.cost, inner.map_or(all, |facts: &NodeFacts| facts.population));
        }
    }

    /// Changes the cost of a node. A law has the value for this number of points.
    fn change(self, cost: &mut Price, points: u64) {
        let [work, depth, scans, inner_log, exact] = cost.to_parts();
        *cost = Price::from_parts(match self {
            Fault::Slow { law, factor, .. } => {
                let steps = (factor.value() * law.value(points)).round() as u64;
                [work, depth + steps, scans, inner_log, exact]
            }
            Fault::Work { factor, .. } => {
                [(factor.value() * work as f64).round() as u64, depth, scans, inner_log, exact]
            }
            Fault::Free { .. } => [1, 1, 0, 0, exact],
            _ => return,
        });
    }
}

#[cfg(test)]
mod tests {
    use septet_protocol::ledger::NodeKind;

    use super::*;

    fn steps(count: u64) -> Price {
        Price::from_parts([count, count, 0, 0, 0])
    }

    /// A root of 1,000 points, split into leaves of 600 and 400. The leader of the root works 4 steps.
    fn ledger() -> LedgerPart {
        let mut part = LedgerPart::default();
        let root = part.facts(NodeId::ROOT);
        (root.population, root.kind) = (1000, NodeKind::Sphere);
        part.facts(NodeId(2)).population = 600;
        part.facts(NodeId(3)).population = 400;
        part.charge(Account::member(Phase::Partition, NodeId::ROOT), steps(6), 1000);
        part.charge(Account::leader(Phase::Partition, NodeId::ROOT), steps(4), 0);
        part.charge(Account::member(Phase::Hulls, NodeId(2)), steps(7), 600);
        part.charge(Account::member(Phase::Hulls, NodeId(3)), steps(9), 400);
        part
    }

    /// Returns work and depth of each charge after a fault, in the order of the accounts.
    fn distorted(fault: &str) -> Vec<(u64, u64)> {
        let mut part = ledger();
        fault.parse::<Fault>().unwrap().distort(&mut part);
        part.charges.values().map(|charge| (charge.cost.work(), charge.cost.depth())).collect()
    }

    #[test]
    fn charges_follow_their_laws() {
        assert_eq!(distorted("flood"), [(6, 6), (7, 7), (9, 9), (4, 4)], "no charge is changed");
        assert_eq!(distorted("slow:partition:log"), [(10, 20), (7, 7), (9, 9)]);
        assert_eq!(distorted("slow:partition:log2:0.5"), [(10, 60), (7, 7), (9, 9)]);
        // A leaf waits for all 1,000 points.
        assert_eq!(distorted("slow:hulls:root3:2"), [(10, 10), (7, 27), (9, 29)]);
        assert_eq!(distorted("work:partition:0.5"), [(5, 10), (7, 7), (9, 9)]);
        assert_eq!(distorted("work:hulls:2"), [(10, 10), (14, 7), (18, 9)]);
        assert_eq!(distorted("free:partition"), [(1, 1), (7, 7), (9, 9)]);
        assert_eq!(distorted("free:hulls"), [(10, 10), (1, 1), (1, 1)]);
    }

    #[test]
    fn radii_are_charged_by_loops() {
        let meter = Cost::default();
        let cost =
            |fault: Fault| fault.charge_of_radii(&[4, 5, 6], &meter).map(|cost| (cost.work(), cost.depth()));
        assert_eq!(cost(Fault::FreeLoop), Some((3, 1)));
        assert_eq!(cost(Fault::SequentialLeaf), Some((9, 9)));
        assert_eq!(cost(Fault::OneClock), None);
    }
}
