//! The references of a cost trace against the messages of the run: a row whose data came in a message follows a row of the
//! sender.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use septet_core::config::{Correction, Graph, Neighbours, SeparatorSets, Workers};
use septet_core::generate::Kind;
use septet_core::run::{CostRow, CostTrace};
use septet_core::{Config, run_on};
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase, Rank};
use septet_protocol::message::Message;
use septet_protocol::transport::{Delivery, HostState, Transport, TransportError};
use septet_workers::config::WorkerConfig;
use septet_workers::host::Host;

use super::traced;
use crate::common::sets::{plane, space};

/// The envelope of a message between two ranks, and the phase in which it was sent.
#[derive(Clone, Copy, Debug)]
struct Sent {
    phase: Phase,
    from: Rank,
    to: Rank,
    node: NodeId,
    round: u32,
}

type Log = Rc<RefCell<Vec<Sent>>>;

/// A machine on one thread that notes every message.
struct Noting<P: Point> {
    host: Host<P>,
    size: u32,
    has_begun: bool,
    pending: Vec<Message<P>>,
    log: Log,
}

impl<P: Point> Noting<P> {
    fn new(config: &Arc<WorkerConfig>, log: Log) -> Self {
        let host = Host::new(1..=config.workers, config, &None);
        Noting { host, size: config.workers + 1, has_begun: false, pending: Vec::new(), log }
    }
}

impl<P: Point> Transport<P> for Noting<P> {
    fn size(&self) -> u32 {
        self.size
    }

    fn exchange(&mut self, outbox: Vec<Message<P>>, state: HostState) -> Result<Delivery<P>, TransportError> {
        let busy = state.is_busy()?;
        if !std::mem::replace(&mut self.has_begun, true) {
            self.pending = self.host.begin()?;
        }
        let busy = busy || self.host.busy();
        let mut all = std::mem::take(&mut self.pending);
        all.extend(outbox);
        let phase = self.host.phase();
        let sent = |m: &Message<P>| Sent { phase, from: m.from, to: m.to, node: m.node, round: m.round };
        self.log.borrow_mut().extend(all.iter().filter(|m| m.from != m.to).map(sent));
        let active = busy || !all.is_empty();
        let (inbox, inner) = all.into_iter().partition(|message| message.to == COORDINATOR);
        if !self.host.is_done() {
            self.pending = self.host.turn(Delivery { inbox: inner, active })?;
        }
        Ok(Delivery { inbox, active })
    }
}

/// The rows of each rank in each phase, and which rows follow which.
struct Rows<'a> {
    rows: &'a [CostRow],
    of_rank: BTreeMap<(Phase, Rank), Vec<usize>>,
    /// For each row, a bit for each row before it.
    before: Vec<Vec<u64>>,
}

impl<'a> Rows<'a> {
    fn new(trace: &'a CostTrace) -> Self {
        let rows = trace.rows();
        let mut of_rank: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        let mut before: Vec<Vec<u64>> = Vec::new();
        for (at, row) in rows.iter().enumerate() {
            if let Some(rank) = row.rank {
                of_rank.entry((row.phase, rank)).or_default().push(at);
            }
            let mut bits = vec![0; rows.len().div_ceil(64)];
            for &after in &row.after {
                let after = usize::try_from(after).unwrap();
                bits[after / 64] |= 1 << (after % 64);
                bits.iter_mut().zip(&before[after]).for_each(|(all, bits)| *all |= bits);
            }
            before.push(bits);
        }
        Rows { rows, of_rank, before }
    }

    /// Returns the rows of a rank in the phase of a message for the nodes and rounds that `counts` accepts.
    fn find(&self, phase: Phase, rank: Rank, counts: impl Fn(NodeId, u32) -> bool) -> Vec<usize> {
        let all = self.of_rank.get(&(phase, rank)).into_iter().flatten().copied();
        let counts = |at: &usize| {
            let row = &self.rows[*at];
            row.node.zip(row.round).is_some_and(|(node, round)| counts(node, round))
        };
        all.filter(counts).collect()
    }

    /// Panics unless each of the later rows follows one of the earlier rows.
    fn assert_order(&self, earlier: &[usize], later: &[usize], sent: &Sent) {
        for &row in later {
            let follows = |at: &usize| self.before[row][at / 64] >> (at % 64) & 1 == 1;
            assert!(
                earlier.iter().any(follows),
                "{sent:?}: row {row} {:?} follows none of {earlier:?}",
                self.rows[row]
            );
        }
    }
}

/// The rows that a message connects: work of the sender, and work of the receiver that uses its result.
struct Ends {
    earlier: Vec<usize>,
    later: Vec<usize>,
}

/// Returns the work of the sender in the round of the message, and of the receiver in the next round.
fn of_rounds(rows: &Rows<'_>, sent: &Sent) -> Ends {
    let Sent { phase, from, to, node, round } = *sent;
    let is_up = matches!(phase, Phase::Summaries | Phase::Merge | Phase::Fallback);
    let is_step = matches!(phase, Phase::Repair | Phase::Independent);
    let sends = |at: NodeId| at == node || is_step || is_up && (at.contains(node) || node.contains(at));
    let uses = |at: NodeId| at == node || is_step || is_up && at.contains(node);
    Ends {
        earlier: rows.find(phase, from, |at, charged| charged == round && sends(at)),
        later: rows.find(phase, to, |at, charged| charged == round + 1 && uses(at)),
    }
}

/// Returns the work of the receiver at the node of a message that went down the tree, and the work of the sender at the
/// nearest node above. Phases may charge such work at their end.
fn of_levels(rows: &Rows<'_>, sent: &Sent) -> Ends {
    let Sent { phase, from, to, node, .. } = *sent;
    let above = rows.find(phase, from, |at, _| at != node && at.contains(node));
    let nearest = above.iter().filter_map(|&at| rows.rows[at].node).max();
    Ends {
        earlier: above.into_iter().filter(|&at| rows.rows[at].node == nearest).collect(),
        later: rows.find(phase, to, |at, _| at == node),
    }
}

/// Checks all messages of a run. Returns the number of messages with rows on both ends, by phase.
fn checked<P: Point>(points: &[P], change: impl Fn(&mut Config)) -> BTreeMap<Phase, usize> {
    let config = traced(Workers::Count(5)).with(change);
    let log = Log::default();
    let run = run_on(points, &config, true, &mut |machine| {
        Ok(Box::new(Noting::new(machine, log.clone())) as Box<dyn Transport<P>>)
    });
    let run = run.unwrap();
    let rows = Rows::new(run.costs.as_ref().unwrap());
    let mut pairs = BTreeMap::new();
    for sent in log.borrow().iter() {
        let goes_down = matches!(
            sent.phase,
            Phase::Partition | Phase::Probe | Phase::Neighbours | Phase::KnnProbe | Phase::Knn | Phase::Sets
        );
        let levels = (goes_down && config.correction == Correction::Descent).then(|| of_levels(&rows, sent));
        for Ends { earlier, later } in [of_rounds(&rows, sent)].into_iter().chain(levels) {
            if !earlier.is_empty() && !later.is_empty() {
                rows.assert_order(&earlier, &later, sent);
                *pairs.entry(sent.phase).or_default() += 1;
            }
        }
    }
    pairs
}

#[test]
fn rows_follow_the_senders_of_their_data() {
    let pairs = checked(&space(Kind::Uniform, 500, 6), |_| {});
    println!("{pairs:?}");
    for phase in [Phase::Partition, Phase::Neighbours, Phase::Summaries, Phase::Merge] {
        assert!(pairs.get(&phase).is_some_and(|&pairs| pairs > 3), "{phase:?}: {pairs:?}");
    }
    let pairs = checked(&plane(Kind::Uniform, 600, 6), |c| c.separator_sets = SeparatorSets::Both);
    assert!(pairs.get(&Phase::Sets).is_some_and(|&pairs| pairs > 3), "{pairs:?}");
    checked(&space(Kind::Uniform, 500, 7), |c| c.correction = Correction::BottomUp);
}

#[test]
fn rows_of_repair_follow_the_senders_of_their_data() {
    let points = space(Kind::Uniform, 500, 8);
    let small = |c: &mut Config| c.graph = Graph::Knn { k: Neighbours::Count(3) };
    let pairs = checked(&points, small);
    assert!(pairs.get(&Phase::Repair).is_some_and(|&pairs| pairs > 3), "{pairs:?}");
    let pairs = checked(&points, |c| {
        small(c);
        c.planted.exchange_cap = Some(1);
    });
    assert!(pairs.get(&Phase::Fallback).is_some_and(|&pairs| pairs > 0), "{pairs:?}");
}
