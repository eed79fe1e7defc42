//! Evaluations on machines of several sizes.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec2;
use septet_geometry::cost::Cost;
use septet_geometry::evaluation::{Words, alone};
use septet_protocol::ledger::LedgerPart;
use septet_protocol::transport::Delivery;

use super::*;
use crate::config::{Task, WorkerConfig};
use crate::hosts::host::{Host, Job};
use crate::input::{Rows, Source};
use crate::partition::leader::Plan;
use crate::share::merged_ledger;

/// Intervals of numbers that are halved until they are short. The left half of an interval is divided more often.
struct Halving {
    ends: Vec<u64>,
    levels: u32,
}

impl Evaluation for Halving {
    fn count(&self) -> u64 {
        self.ends.len() as u64
    }

    fn first(&self, range: Range<u64>) -> Items {
        let mut items = Items::default();
        for &end in &self.ends[range.start as usize..range.end as usize] {
            items.push(|words| [0, end].write(words));
        }
        items
    }

    fn evaluate(&self, item: &[u64], made: &mut Made) {
        let [from, to] = <[u64; 2]>::of(item);
        made.lane(|own| own.sequential((to - from) as usize, (), |(), _| ()));
        if to - from < 3 + from / 4 {
            made.results.push(|words| [from, to].write(words));
            return;
        }
        let half = from.midpoint(to);
        for part in [[from, half], [half, to]] {
            made.next.push(|words| part.write(words));
        }
    }

    fn stops(&self, progress: &Progress) -> bool {
        progress.levels == self.levels
    }
}

/// The source of a run that has a rule, or none.
struct Ruled<'a>(Option<&'a dyn Evaluation>);

impl Source<DVec2> for Ruled<'_> {
    fn block(&self, _block: u32, _blocks: u32) -> Rows<DVec2> {
        Rows::default()
    }

    fn evaluation(&self) -> Option<&dyn Evaluation> {
        self.0
    }
}

/// Runs a machine without a transport. Messages arrive in reverse order.
fn run(rule: Option<&dyn Evaluation>, workers: u32) -> Result<(Evaluated, LedgerPart), TransportError> {
    let task = Task::Evaluation { phase: Phase::Octree };
    let config = Arc::new(WorkerConfig { task, workers, ..WorkerConfig::plain() });
    let job = Job { config, source: &Ruled(rule), plan: &Plan::new() };
    let mut host = Host::<DVec2>::new(0..=workers, &job, &None);
    let mut wire = host.begin()?;
    while !host.is_done() {
        let active = host.busy() || !wire.is_empty();
        wire.reverse();
        wire = host.turn(Delivery { inbox: wire, active })?;
    }
    let shares = host.into_shares();
    let ledger = merged_ledger(shares.iter().map(|share| &share.ledger.part), None);
    let mut all = Evaluated::default();
    for share in shares {
        all.append(share.evaluated);
    }
    Ok((all, ledger))
}

#[test]
fn results_and_charges_do_not_depend_on_the_ranks() {
    for levels in [1, 4, 100] {
        let rule = Halving { ends: (0..40).map(|i| i * i % 97).collect(), levels };
        let meter = Cost::of_subproblem(false);
        let expected = alone(&rule, |items| Made::of(&rule, items.iter(), &meter));
        assert_eq!(expected.rest.is_empty(), levels == 100);
        let (_, one) = run(Some(&rule), 1).unwrap();
        for workers in [1, 2, 3, 16, 50] {
            let (evaluated, ledger) = run(Some(&rule), workers).unwrap();
            assert_eq!(evaluated, expected, "{workers} workers");
            assert_eq!(ledger.charges, one.charges, "{workers} workers");
            assert_eq!((ledger.balance, ledger.nodes), (0, one.nodes.clone()), "{workers} workers");
        }
    }
}

#[test]
fn a_source_without_a_rule_is_refused() {
    let Err(TransportError::WorkerFailed { reason, .. }) = run(None, 3) else { panic!() };
    assert_eq!(reason, "the source has no rule to evaluate");
}

/// Few items for many ranks: some ranks have none, and the last levels have one item only.
#[test]
fn blocks_are_equal_on_every_level() {
    let rule = Halving { ends: vec![1000], levels: 100 };
    let (_, ledger) = run(Some(&rule), 4).unwrap();
    let worked =
        |rank: Rank| ledger.ranks.iter().filter(move |(key, _)| key.rank == rank).map(|(_, t)| t.work);
    let works: Vec<u64> = (1..=4).map(|rank| worked(rank).sum()).collect();
    assert!(works.iter().all(|&work| work > 500), "{works:?}");
    assert_eq!(worked(0).sum::<u64>(), 0);
}
