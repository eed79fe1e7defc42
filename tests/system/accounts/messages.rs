//! The references of a cost trace against the messages of the run: a row whose data came in a message follows a row of the
//! sender.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use septet_core::generate::Kind;
use septet_core::run::{CostRow, CostTrace};
use septet_core::spec::{Alpha, Correction, Graph, Neighbours, Repair, SeparatorSets, Task, Workers};
use septet_core::{Spec, run_on};
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message};

use super::traced;
use crate::common::observed::Observed;
use crate::common::sets::{plane, space};

/// The envelope of a message between two ranks, and the phase in which it was sent.
#[derive(Clone, Copy, Debug)]
struct Sent {
    phase: Phase,
    from: Rank,
    to: Rank,
    node: NodeId,
    round: u32,
    /// Whether the message announces edges of a graph of nearest neighbours.
    is_announcement: bool,
}

impl Sent {
    fn of<P: Point>(phase: Phase, message: &Message<P>) -> Self {
        let Message { from, to, node, round, ref body, .. } = *message;
        Sent { phase, from, to, node, round, is_announcement: matches!(body, Body::Reverse { .. }) }
    }
}

type Log = Rc<RefCell<Vec<Sent>>>;

/// The rows of each rank in each phase, and which rows follow which.
struct Rows<'a> {
    all: &'a [CostRow],
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
        Rows { all: rows, of_rank, before }
    }

    /// Returns the rows of a rank in the phase of a message for the nodes and rounds that `counts` accepts.
    fn find(&self, phase: Phase, rank: Rank, counts: impl Fn(NodeId, u32) -> bool) -> Vec<usize> {
        let all = self.of_rank.get(&(phase, rank)).into_iter().flatten().copied();
        let counts = |at: &usize| {
            let row = &self.all[*at];
            row.node.zip(row.round).is_some_and(|(node, round)| counts(node, round))
        };
        all.filter(counts).collect()
    }

    /// Returns `true` if a row follows another.
    fn follows(&self, row: usize, at: usize) -> bool {
        self.before[row][at / 64] >> (at % 64) & 1 == 1
    }

    /// Panics unless each of the later rows follows one of the earlier rows. Returns whether there are rows on both ends.
    fn assert_order(&self, Ends { earlier, later }: &Ends, sent: &Sent) -> bool {
        for &row in later {
            assert!(
                earlier.is_empty() || earlier.iter().any(|&at| self.follows(row, at)),
                "{sent:?}: row {row} {:?} follows none of {earlier:?}",
                self.all[row]
            );
        }
        !earlier.is_empty() && !later.is_empty()
    }

    /// Panics unless each of the later rows follows all earlier rows. Returns whether there are rows on both ends.
    fn assert_all_before(&self, Ends { earlier, later }: &Ends, sent: &Sent) -> bool {
        for &row in later {
            let missing = earlier.iter().find(|&&at| !self.follows(row, at));
            assert_eq!(missing, None, "{sent:?}: row {row} {:?} does not follow it", self.all[row]);
        }
        !earlier.is_empty() && !later.is_empty()
    }
}

/// The rows that a message connects: work of the sender, and work of the receiver that uses its result.
struct Ends {
    earlier: Vec<usize>,
    later: Vec<usize>,
}

/// Returns the phases to which the work on messages of a phase is charged. The merge after gathering belongs to the
/// certificate.
fn payers(phase: Phase) -> &'static [Phase] {
    match phase {
        Phase::Merge => &[Phase::Merge, Phase::Certificate],
        _ => Phase::ALL.iter().find(|&&other| other == phase).map_or(&[], std::slice::from_ref),
    }
}

/// Returns the work of the sender in the round of the message, and of the receiver in the next round.
fn of_rounds(rows: &Rows<'_>, sent: &Sent, payer: Phase) -> Ends {
    let Sent { phase, from, to, node, round, .. } = *sent;
    let (is_up, is_step) = (way(phase) == Way::Up, way(phase) == Way::Steps);
    let sends = |at: NodeId| at == node || is_step || is_up && (at.contains(node) || node.contains(at));
    let uses = |at: NodeId| at == node || is_step || is_up && at.contains(node);
    Ends {
        earlier: rows.find(payer, from, |at, charged| charged == round && sends(at)),
        later: rows.find(payer, to, |at, charged| charged == round + 1 && uses(at)),
    }
}

/// Returns the work of the receiver at the node of a message that went down the tree, and the work of the sender at the
/// nearest node above. Phases may charge such work at their end. The bottom-up correction goes down the tree in each of its
/// steps.
fn of_levels(rows: &Rows<'_>, sent: &Sent) -> Vec<Ends> {
    let Sent { phase, from, to, node, .. } = *sent;
    let all_above = rows.find(phase, from, |at, _| at != node && at.contains(node));
    let all_later = rows.find(phase, to, |at, _| at == node);
    let of_step = |all: &[usize], step| -> Vec<usize> {
        all.iter().copied().filter(|&at| rows.all[at].step == step).collect()
    };
    let steps: BTreeSet<Option<u32>> = all_later.iter().map(|&at| rows.all[at].step).collect();
    let ends = steps.into_iter().map(|step| {
        let above = of_step(&all_above, step);
        let nearest = above.iter().filter_map(|&at| rows.all[at].node).max();
        let earlier = above.into_iter().filter(|&at| rows.all[at].node == nearest).collect();
        Ends { earlier, later: of_step(&all_later, step) }
    });
    ends.collect()
}

/// The way of the messages of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Down,
    Up,
    Steps,
    /// Between leaves, or to other ranks.
    Across,
}

/// Returns the way of the messages of a phase. The table of phases states the order of charges; this list states what the
/// programs send, so that the one is checked against the other.
fn way(phase: Phase) -> Way {
    match phase {
        Phase::Partition
        | Phase::Choice
        | Phase::Probe
        | Phase::Neighbours
        | Phase::KnnProbe
        | Phase::Knn
        | Phase::Sets => Way::Down,
        Phase::Summaries | Phase::Merge | Phase::Fallback => Way::Up,
        Phase::Octree
        | Phase::Sizes
        | Phase::Candidates
        | Phase::Conflicts
        | Phase::Completion
        | Phase::OwnSets
        | Phase::Repair
        | Phase::ProbeCells
        | Phase::Independent => Way::Steps,
        Phase::Load
        | Phase::Halo
        | Phase::Pieces
        | Phase::Seam
        | Phase::Radii
        | Phase::KnnRadii
        | Phase::Graph
        | Phase::Hulls
        | Phase::Check
        | Phase::Certificate
        | Phase::Collect
        | Phase::Done => Way::Across,
    }
}

/// Returns the work of the sender of a message in the phase of separator sets, and all work of the receiver on the graph.
/// The graph starts when that phase has ended everywhere.
fn of_graph(rows: &Rows<'_>, sent: &Sent) -> Ends {
    Ends {
        earlier: rows.find(Phase::Sets, sent.from, |_, charged| charged == sent.round),
        later: rows.find(Phase::Graph, sent.to, |_, _| true),
    }
}

/// The phases of these runs that send messages and have rows. An observer sees the messages of probes in phase `repair`,
/// whose rounds they continue.
const PHASES: [Phase; 13] = [
    Phase::Partition,
    Phase::Choice,
    Phase::Probe,
    Phase::Neighbours,
    Phase::Summaries,
    Phase::KnnProbe,
    Phase::Knn,
    Phase::Sets,
    Phase::Check,
    Phase::Repair,
    Phase::Certificate,
    Phase::Fallback,
    Phase::Merge,
];

/// The phases whose messages connect no rows, with the reasons.
const EXEMPT: [(Phase, &str); 2] = [
    (
        Phase::Check,
        "a leaf pays for the comparison of its sums before it sends them, and not after it has others",
    ),
    (Phase::Probe, "few balls of these sets probe"),
];

/// The messages and the rows of runs.
#[derive(Debug, Default)]
struct Found {
    /// The phases in which ranks sent messages.
    sending: BTreeSet<Phase>,
    /// The phases in which ranks made calls.
    charging: BTreeSet<Phase>,
    /// Number of messages with rows on both ends, by phase.
    pairs: BTreeMap<Phase, usize>,
    /// Number of announcements of edges with rows in both phases.
    announced: usize,
}

impl Found {
    /// Checks all messages of a run.
    fn check<P: Point>(&mut self, points: &[P], change: impl Fn(&mut Spec)) {
        let spec = traced(Workers::Count(5)).with(change);
        let log = Log::default();
        let run = run_on(points, (&spec, Task::Simulate), &mut |_| {
            let log = log.clone();
            Box::new(Observed(move |phase, messages: &[Message<P>]| {
                let sent = messages.iter().filter(|m| m.from != m.to).map(|m| Sent::of(phase, m));
                log.borrow_mut().extend(sent);
            }))
        });
        let run = run.unwrap();
        let rows = Rows::new(run.kept.costs.as_ref().unwrap());
        self.charging.extend(rows.of_rank.keys().map(|(phase, _)| phase));
        for sent in log.borrow().iter() {
            self.sending.insert(sent.phase);
            let rounds = payers(sent.phase).iter().map(|&payer| (payer, of_rounds(&rows, sent, payer)));
            let levels = if way(sent.phase) == Way::Down { of_levels(&rows, sent) } else { Vec::new() };
            for (payer, ends) in rounds.chain(levels.into_iter().map(|ends| (sent.phase, ends))) {
                if rows.assert_order(&ends, sent) {
                    *self.pairs.entry(payer).or_default() += 1;
                }
            }
            if sent.phase == Phase::Sets {
                let found = rows.assert_all_before(&of_graph(&rows, sent), sent);
                self.announced += usize::from(found && sent.is_announcement);
            }
        }
    }

    fn pairs_of(&self, phase: Phase) -> usize {
        self.pairs.get(&phase).copied().unwrap_or(0)
    }
}

fn density(spec: &mut Spec) {
    spec.recursion.graph = Graph::Density { alpha: Alpha::Value(2.5) };
}

#[test]
fn rows_follow_the_senders_of_their_data() {
    let mut all = Found::default();
    all.check(&space(Kind::Uniform, 500, 6), |_| {});
    all.check(&plane(Kind::Uniform, 600, 6), |c| c.recursion.sets = SeparatorSets::Both);
    all.check(&space(Kind::Uniform, 500, 6), density);
    all.check(&space(Kind::Uniform, 500, 6), |c| {
        c.recursion.graph = Graph::Knn { k: Neighbours::Count(48) };
    });
    all.check(&space(Kind::Clusters, 500, 6), |c| {
        c.recursion.graph = Graph::Knn { k: Neighbours::Count(12) }
    });
    let small = |c: &mut Spec| c.recursion.graph = Graph::Knn { k: Neighbours::Count(3) };
    all.check(&space(Kind::Uniform, 500, 8), small);
    for repair in [Repair::Probe, Repair::Splay] {
        all.check(&space(Kind::Uniform, 500, 8), |c| {
            small(c);
            c.recursion.repair = repair;
            c.planted.exchange_cap = Some(1);
        });
    }
    assert!(all.announced > 3, "{all:?}");
    let both: Vec<Phase> = all.sending.intersection(&all.charging).copied().collect();
    assert_eq!(both, PHASES);
    for phase in PHASES {
        let exempt = EXEMPT.iter().find(|(exempt, _)| *exempt == phase);
        assert_eq!(all.pairs_of(phase) > 3, exempt.is_none(), "{phase:?}, {exempt:?}: {all:?}");
    }
    let mut bottom_up = Found::default();
    bottom_up.check(&space(Kind::Uniform, 500, 7), |c| {
        density(c);
        c.recursion.neighbours = Correction::BottomUp;
    });
    assert!(bottom_up.pairs_of(Phase::Neighbours) > 3, "{bottom_up:?}");
    let mut stages = Found::default();
    stages.check(&space(Kind::Uniform, 500, 7), |c| {
        density(c);
        c.recursion.neighbours = Correction::Stages;
    });
    assert!(stages.pairs_of(Phase::Neighbours) > 3, "{stages:?}");
    let mut balls = Found::default();
    balls.check(&space(Kind::Uniform, 500, 7), |c| {
        c.recursion.graph = Graph::Overlap { alpha: Alpha::Value(1.5), k: Neighbours::Count(4) };
    });
    for phase in [Phase::Neighbours, Phase::Summaries, Phase::Sets] {
        assert!(balls.pairs_of(phase) > 3, "{phase:?}: {balls:?}");
    }
}
