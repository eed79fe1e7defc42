//! A maximal independent set of the conflict graph, by rounds of local priorities.
//!
//! **Statement** (paper, Section 5: "obtain a maximal independent set of the graph"). The conflict graph is the density
//! graph with alpha 1 for the radii in the input. Some points are in the set from the start ([`crate::config::Task`]),
//! and their neighbours are out. In each round:
//! 1. Every undecided point whose priority is smaller than the priorities of all its undecided neighbours joins the
//!    set.
//! 2. The neighbours of each point that joins are out.
//!
//! Priorities are a total order ([`priority`]), so at least the undecided point of smallest priority joins in every
//! round, and the rounds end. At the end, every point that is out is adjacent to a point of the set. *The greedy
//! algorithm in the order of priorities yields the same set.* Proof: by induction over that order, a point joins if
//! and only if no neighbour of smaller priority joins. QED. The set and the number of rounds are therefore functions
//! of the points, the radii and the seed.
//!
//! **Source.** Luby (1986). Blelloch, Fineman and Shun (2012): if the order is random and fixed before the first round,
//! the number of rounds is `O(log^2 n)` with high probability. Fischer and Noever (2018) show `O(log n)`.
//!
//! **Messages.** *Ghosts are symmetric.* The expression for edges is symmetric, and a leaf holds all neighbours of its
//! owned points ([`crate::graph::ghosts`]). If `u` is a ghost and a neighbour of an owned point `v`, then `v` is a
//! ghost on the rank that owns `u`. The table names that rank. When a point joins or leaves, its rank informs the
//! owners of its undecided ghosts.
//!
//! **Rounds of the machine.** The neighbours of the points that are in from the start take one round. Each round of
//! the algorithm takes two: one for the points that join, and one for the points that leave. The number of rounds
//! does not depend on the number of workers.
//!
//! **Work and depth.** A point that is undecided at the start of a round reads its list four times in the round. The
//! first two reads decide whether it joins and inform its neighbours. The other two do the same for leaving. A pack
//! removes decided points from the list of a leaf. The work is the number of edges of undecided points. The depth of
//! each round is constant. Exclusive reads need a copy of a neighbour's state at each end of an edge. The step that
//! informs the neighbours is the copy-scan that fills these copies. All leaves proceed in lockstep. A leaf with
//! undecided points was charged for every earlier round, so the leaf that takes the most rounds determines the
//! longest chain.
//!
//! **Departures.** Candidates are adjacent if they are closer than the *smaller* of their sizes (the guide,
//! "Section 5: point sets for meshes"). The graph uses `<=`. The caller makes the comparison strict by passing the largest float below
//! the squared size as the squared radius.

use std::collections::BTreeMap;

use septet_geometry::cost::Cost;
use septet_geometry::graph::Supergraph;
use septet_geometry::grid::graph_by_grid;
use septet_geometry::lists::Lists;
use septet_geometry::point::Point;
use septet_geometry::priority::{compare, priority};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message};
use septet_protocol::transport::TransportError;

use crate::graph::edges::Edges;
use crate::graph::ghosts::push_ghosts;
use crate::graph::supergraph::count_crossings;
use crate::machine::context::Context;
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;
use crate::state::tree::Leaf;

/// The priority of a decided point.
const DECIDED: u64 = u64::MAX;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Undecided,
    In,
    Out,
}

/// One rank's part in the selection of the independent set.
#[derive(Debug, Default)]
pub(crate) struct Selection {
    /// For each leaf, the neighbours of its owned points.
    graphs: Vec<Lists<u32>>,
    /// The state of each point of the table.
    states: Vec<State>,
    /// The priority of each point of the table, or [`DECIDED`].
    priorities: Vec<u64>,
    /// For each leaf, its owned points that are undecided at the start of the round.
    open: Vec<Vec<u32>>,
    /// The number of undecided owned points at the start of each round, up to the last round with an undecided point.
    undecided: Vec<u64>,
    /// The number of halves of rounds so far, which is the same on all ranks.
    halves: u32,
}

/// The leaves of a rank and its points.
struct Points<'a, P> {
    leaves: &'a [Leaf<P>],
    table: &'a Table<P>,
}

/// The result of half a round in one leaf.
struct HalfRound {
    /// The index of the leaf.
    leaf: usize,
    /// Points that this half round decides.
    decided: Vec<u32>,
    /// The decided points with undecided ghosts among their neighbours, for the owners of these ghosts.
    informed: Vec<Informed>,
    /// The points that remain undecided. `None` after the first half.
    open: Option<Vec<u32>>,
    cost: Cost,
}

/// A decided point, and a rank that must be informed of it.
struct Informed {
    rank: Rank,
    point: u32,
}

/// Finds the conflict graph: for each leaf, the neighbours of its owned points.
pub(crate) async fn conflict_graphs<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    rule: Supergraph,
) -> Result<Vec<Lists<u32>>, TransportError> {
    cx.enter(Phase::Sets)?;
    count_crossings(cx, subdomain, table, rule);
    let mut ghosts = push_ghosts(cx, subdomain, table, rule).await?;
    cx.enter(Phase::Graph)?;
    // The order of ghosts is irrelevant here, because all lists are read completely.
    ghosts.sort_by(Ord::cmp);
    let graphs = conflicts_of_leaves(cx, subdomain.leaves(), table, rule, &ghosts);
    while cx.exchange().await? {}
    Ok(graphs)
}

fn conflicts_of_leaves<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    rule: Supergraph,
    ghosts: &Ghosts,
) -> Vec<Lists<u32>> {
    let site = cx.site();
    let meter = cx.own_cost();
    let indices: Vec<usize> = (0..leaves.len()).collect();
    let results = cx.map(&indices, |&at| {
        let leaf = &leaves[at];
        let _span = site.subproblem(Phase::Graph, leaf.id(), "leaf conflicts", leaf.owned_len());
        let members = ghosts.members(at, leaf);
        let mut cost = meter.fresh();
        let rows = leaf.owned_len() as usize;
        let lists = graph_by_grid(rule, table.positions(), table.radii2(), &members, rows, &mut cost);
        let mut edges = Edges::default();
        for (point, list) in leaf.owned().zip(lists.iter()) {
            edges.add(table, point, list);
        }
        (lists, cost, members.len() as u64, edges)
    });
    let mut graphs = Vec::with_capacity(results.len());
    for (leaf, (lists, cost, members, edges)) in leaves.iter().zip(results) {
        cx.charge(Account::member(Phase::Graph, leaf.id()), cost, members);
        cx.facts(leaf.id()).members += members;
        edges.enter(leaf.id(), cx);
        graphs.push(lists);
    }
    graphs
}

/// The sites of all ranks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sites {
    /// Sites with smaller ids are members from the start.
    pub(crate) fixed: u64,
    /// Number of sites. No more rounds of local priorities are needed, because each decides the first undecided site.
    pub(crate) population: u64,
}

/// Runs rounds of local priorities until no rank has an undecided point. In the first half of a round, points that
/// precede all their undecided neighbours join. In the second half, the neighbours of points in the set leave.
///
/// # Errors
/// Fails if points remain undecided after as many rounds as there are points, because then a message was damaged.
pub(crate) async fn independent<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    graphs: Vec<Lists<u32>>,
    Sites { fixed, population }: Sites,
) -> Result<Selection, TransportError> {
    cx.enter(Phase::Independent)?;
    let points = &Points { leaves, table };
    let mut selection = Selection::new(cx.config().seed, points, graphs, fixed);
    if fixed > 0 {
        selection.leave(cx, points);
    }
    let mut rounds = 0;
    while cx.exchange_if(selection.is_pending()).await? {
        rounds += 1;
        // A last round may only deliver messages.
        if rounds > population + 2 {
            let reason = "sites remain undecided after as many rounds as there are sites".to_string();
            return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
        }
        selection.receive(cx, table);
        selection.join(cx, points);
        if !cx.exchange_if(selection.is_pending()).await? {
            break;
        }
        selection.receive(cx, table);
        selection.leave(cx, points);
    }
    Ok(selection)
}

impl Selection {
    /// Creates a set that contains the points with ids below `fixed`. All other points are undecided.
    fn new<P: Point>(seed: u64, points: &Points<P>, graphs: Vec<Lists<u32>>, fixed: u64) -> Self {
        let Points { leaves, table } = points;
        let priorities = table.positions().iter().map(|&x| priority(seed, x)).collect();
        let states = vec![State::Undecided; table.ids().len()];
        let mut selection = Selection { graphs, states, priorities, ..Selection::default() };
        for (at, _) in (0u32..).zip(table.ids()).filter(|&(_, &id)| id < fixed) {
            selection.decide(at, State::In);
        }
        let undecided = |&v: &u32| selection.states[v as usize] == State::Undecided;
        let open = leaves.iter().map(|leaf| leaf.owned().filter(undecided).collect()).collect();
        selection.open = open;
        selection
    }

    /// Returns `true` if an owned point is undecided.
    pub(crate) fn is_pending(&self) -> bool {
        self.open.iter().any(|open| !open.is_empty())
    }

    fn decide(&mut self, point: u32, state: State) {
        self.states[point as usize] = state;
        self.priorities[point as usize] = DECIDED;
    }

    /// Receives the decisions on ghosts.
    fn receive<P: Point>(&mut self, cx: &mut Context<P>, table: &Table<P>) {
        for (ids, state) in cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Joined(ids) => Some((std::mem::take(&mut ids.0), State::In)),
            Body::Left(ids) => Some((std::mem::take(&mut ids.0), State::Out)),
            _ => None,
        }) {
            for id in ids {
                if let Some(ghost) = table.find(id).filter(|&at| !table.is_owned(at)) {
                    self.decide(ghost, state);
                }
            }
        }
    }

    /// Runs the first half of a round, in which points that precede all their undecided neighbours join the set.
    fn join<P: Point>(&mut self, cx: &mut Context<P>, points: &Points<P>) {
        let count: u64 = self.open.iter().map(|open| open.len() as u64).sum();
        if count > 0 {
            self.undecided.push(count);
        }
        let halves = self.half(cx, points, State::In, |leaf, open, lists, cost| {
            let (priorities, positions) = (&self.priorities, points.table.positions());
            cost.map_nested(open, |&v, own| {
                let (mine, mut first) = ((priorities[v as usize], positions[v as usize]), true);
                let mut sweep = own.sweep();
                sweep.each(&lists[(v - leaf.start()) as usize], |&u| {
                    let other = priorities[u as usize];
                    first &= mine.0 < other || compare(mine, (other, positions[u as usize])).is_lt();
                });
                own.charge_sweep(sweep);
                first
            })
        });
        self.settle(cx, points, halves, State::In);
    }

    /// Runs the second half of a round, in which neighbours of points in the set leave.
    fn leave<P: Point>(&mut self, cx: &mut Context<P>, points: &Points<P>) {
        let halves = self.half(cx, points, State::Out, |leaf, open, lists, cost| {
            let states = &self.states;
            cost.map_nested(open, |&v, own| {
                let mut out = false;
                let mut sweep = own.sweep();
                sweep.each(&lists[(v - leaf.start()) as usize], |&u| out |= states[u as usize] == State::In);
                own.charge_sweep(sweep);
                out
            })
        });
        self.settle(cx, points, halves, State::Out);
    }

    /// Runs half a round in each leaf with undecided points. `rule` returns, for each undecided point, whether it gets
    /// the state `decision`. The second half also packs the points that remain undecided.
    fn half<P: Point>(
        &self,
        cx: &Context<P>,
        points: &Points<P>,
        decision: State,
        rule: impl Fn(&Leaf<P>, &[u32], &Lists<u32>, &mut Cost) -> Vec<bool> + Sync + Send,
    ) -> Vec<HalfRound> {
        let Points { leaves, table } = points;
        let step = if decision == State::In { "join" } else { "leave" };
        let indices: Vec<usize> = (0..leaves.len()).filter(|&at| !self.open[at].is_empty()).collect();
        let (site, meter) = (cx.site(), cx.own_cost());
        cx.map(&indices, |&at| {
            let (leaf, lists) = (&leaves[at], &self.graphs[at]);
            let open = &self.open[at];
            let _span = site.subproblem(Phase::Independent, leaf.id(), step, open.len() as u64);
            let mut cost = meter.fresh();
            let flags = rule(leaf, open, lists, &mut cost);
            let flagged: Vec<(u32, bool)> = open.iter().copied().zip(flags).collect();
            let mut informed = Vec::new();
            cost.map_nested(&flagged, |&(v, decided), own| {
                let mut sweep = own.sweep();
                sweep.each(&lists[(v - leaf.start()) as usize], |&u| {
                    if decided && !table.is_owned(u) && self.states[u as usize] == State::Undecided {
                        informed.push(Informed { rank: table.owners()[u as usize], point: v });
                    }
                });
                own.charge_sweep(sweep);
            });
            let open = (decision == State::Out).then(|| {
                let undecided = |&(v, out): &(u32, bool)| !out && self.states[v as usize] == State::Undecided;
                cost.pack(&flagged, undecided).into_iter().map(|(v, _)| v).collect()
            });
            let decided = flagged.into_iter().filter(|f| f.1).map(|f| f.0).collect();
            HalfRound { leaf: at, decided, informed, open, cost }
        })
    }

    /// Stores the result of half a round, and informs other ranks.
    fn settle<P: Point>(
        &mut self,
        cx: &mut Context<P>,
        points: &Points<P>,
        halves: Vec<HalfRound>,
        state: State,
    ) {
        let mut batches: BTreeMap<Rank, Vec<u64>> = BTreeMap::new();
        self.halves += 1;
        for half in halves {
            let leaf = &points.leaves[half.leaf];
            let account = Account::step(Phase::Independent, self.halves, leaf.id());
            cx.charge(account, half.cost, leaf.owned_len());
            for point in half.decided {
                self.decide(point, state);
            }
            for Informed { rank, point } in half.informed {
                let (batch, id) = (batches.entry(rank).or_default(), points.table.ids()[point as usize]);
                // The entries of one point are consecutive, so an owner of several ghosts is informed once.
                if batch.last() != Some(&id) {
                    batch.push(id);
                }
            }
            if let Some(open) = half.open {
                self.open[half.leaf] = open;
            }
        }
        let body = |ids| if state == State::In { Body::Joined(Bulk(ids)) } else { Body::Left(Bulk(ids)) };
        cx.send_each(0, batches.into_iter().map(|(owner, ids)| (owner, body(ids))));
    }
}

impl Selection {
    /// Returns the ids of the owned points that joined, without the fixed ones.
    pub(crate) fn members<P: Point>(&self, table: &Table<P>, fixed: u64) -> Vec<u64> {
        let owned = table.owned_ids().iter().zip(&self.states);
        let members = owned.filter(|&(&id, &state)| state == State::In && id >= fixed).map(|(&id, _)| id);
        members.collect()
    }

    /// Returns the number of undecided owned points at the start of each round.
    pub(crate) fn into_undecided(self) -> Vec<u64> {
        self.undecided
    }
}

#[cfg(test)]
mod tests;
