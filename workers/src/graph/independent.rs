//! A maximal independent set of the conflict graph, by rounds of local priorities.
//!
//! **Statement** (paper, Section 5: "obtain a maximal independent set of the graph"). The graph is the density graph with
//! alpha 1 of the radii that the points bring along. Some points are in the set from the start ([`crate::config::Task`]); their
//! neighbours are out. In a round every undecided point whose priority is smaller than that of all its undecided
//! neighbours joins, and its neighbours are out. Priorities are a total order ([`priority`]), so the smallest
//! undecided point joins and the rounds end, with every point that is out beside one that is in. *The set is that of
//! the greedy algorithm in the order of priorities*: by induction over that order, a point joins iff none of its
//! neighbours of smaller priority does. So set and rounds are functions of (points, radii, seed).
//!
//! **Source.** Luby (1986); Blelloch, Fineman and Shun (2012): in a random order, fixed before the first round, the
//! rounds are few (`O(log^2 n)` there, `O(log n)` by Fischer and Noever 2018), with high probability.
//!
//! **Messages.** *Ghosts are symmetric*: the graph's expression is, and a leaf holds all neighbours of its home points
//! ([`crate::graph::ghosts`]), so where u is a ghost beside v, v is a ghost beside u at u's owner, which the ghost's record
//! names. A point that joins or leaves is told to the owners of its undecided ghosts.
//!
//! **Rounds of the machine.** One for the neighbours of points that are in from the start; then two a round of the set,
//! for every number of workers: who joined, who left.
//!
//! **Work and depth.** In each round, of every point undecided at its start: its list to find whether it is first, to
//! tell, to find whether it is out, to tell again; and a pack of a leaf's undecided points. So the work is the edges of
//! the undecided points, and the depth a constant for each round. To read a neighbour's state exclusively every edge
//! has a copy of it at either end: telling is the copy-scan that fills them. All leaves go in lockstep, and one that
//! has undecided points left has been charged for every round before, so the longest leaf is the longest chain.
//!
//! **Departures.** Candidates closer than the *smaller* of their sizes join, not farther apart (ARCHITECTURE, The paper,
//! as read). The graph's `<=` is made strict by whoever gives the radii: the float below a square.

use std::collections::BTreeMap;

use septet_geometry::cost::Cost;
use septet_geometry::graph::Supergraph;
use septet_geometry::grid::graph_by_grid;
use septet_geometry::lists::Lists;
use septet_geometry::point::Point;
use septet_geometry::priority::{compare, priority};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message};
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::graph::edges::Edges;
use crate::graph::ghosts::push_ghosts;
use crate::graph::supergraph::count_crossings;
use crate::machine::context::Context;
use crate::state::subdomain::{Ghosts, Leaf, Subdomain};
use crate::state::table::Table;

/// The priority of a point that has none any more.
const DECIDED: u64 = u64::MAX;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Undecided,
    In,
    Out,
}

/// What a worker knows of the set.
#[derive(Debug, Default)]
pub(crate) struct Selection {
    /// The neighbours of each leaf's home points.
    graphs: Vec<Lists<u32>>,
    /// Of every point of the table.
    states: Vec<State>,
    /// Of every point of the table: its priority, or [`DECIDED`].
    priorities: Vec<u64>,
    /// Each leaf's undecided home points, as of the start of the round.
    open: Vec<Vec<u32>>,
    /// How many home points were undecided at the start of each round, as long as there were any.
    undecided: Vec<u64>,
}

impl Selection {
    /// Is any home point undecided?
    pub(crate) fn is_pending(&self) -> bool {
        self.open.iter().any(|open| !open.is_empty())
    }

    fn decide(&mut self, point: u32, state: State) {
        self.states[point as usize] = state;
        self.priorities[point as usize] = DECIDED;
    }
}

/// What half a round does in one leaf.
struct Half {
    /// Points that are decided now.
    decided: Vec<u32>,
    /// Undecided ghosts' owners, and which of these points they are told of.
    told: Vec<(Rank, u32)>,
    /// The points that stay undecided, where the half looks.
    open: Option<Vec<u32>>,
    cost: Cost,
}

/// The conflict graph of the home points: the neighbours of those of each leaf.
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
    // Their order is of no account: lists are only gone through whole.
    ghosts.sort_by(Ord::cmp);
    let graphs = conflicts_of_leaves(cx, &subdomain.leaves, table, rule, &ghosts);
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
    let places: Vec<usize> = (0..leaves.len()).collect();
    let results = map_in(&cx.pool, &places, |&at| {
        let leaf = &leaves[at];
        let _span = site.subproblem(Phase::Graph, leaf.id, "leaf conflicts", leaf.owned_len());
        let members = ghosts.members(at, leaf);
        let mut cost = Cost::ZERO;
        let rows = leaf.owned_len() as usize;
        let lists = graph_by_grid(rule, &table.positions, &table.radii2, &members, rows, &mut cost);
        let mut edges = Edges::default();
        for (owned, list) in leaf.owned().zip(lists.iter()) {
            edges.take(table, owned, list);
        }
        (lists, cost, members.len() as u64, edges)
    });
    let mut graphs = Vec::with_capacity(results.len());
    for (leaf, (lists, cost, members, edges)) in leaves.iter().zip(results) {
        cx.ledger.charge(Phase::Graph, leaf.id, cost, members);
        cx.ledger.facts(leaf.id).members += members;
        edges.enter(leaf.id, &mut cx.ledger);
        graphs.push(lists);
    }
    graphs
}

/// Rounds of local priorities, until no point of any rank is undecided: those that come before all their undecided
/// neighbours join, then the neighbours of those that are in are out.
pub(crate) async fn independent<P: Point>(
    cx: &mut Context<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    graphs: Vec<Lists<u32>>,
    fixed: u64,
) -> Result<Selection, TransportError> {
    cx.enter(Phase::Independent)?;
    let mut selection = Selection::begin(cx.config.seed, leaves, table, graphs, fixed);
    if fixed > 0 {
        selection.leave(cx, leaves, table);
    }
    while cx.exchange_if(selection.is_pending()).await? {
        selection.receive(cx, table);
        selection.join(cx, leaves, table);
        if !cx.exchange_if(selection.is_pending()).await? {
            break;
        }
        selection.receive(cx, table);
        selection.leave(cx, leaves, table);
    }
    Ok(selection)
}

impl Selection {
    /// Nothing is decided but the points that are in from the start.
    fn begin<P: Point>(
        seed: u64,
        leaves: &[Leaf<P>],
        table: &Table<P>,
        graphs: Vec<Lists<u32>>,
        fixed: u64,
    ) -> Self {
        let priorities = table.positions.iter().map(|&x| priority(seed, x)).collect();
        let states = vec![State::Undecided; table.ids.len()];
        let mut selection = Selection { graphs, states, priorities, ..Selection::default() };
        for (at, _) in (0u32..).zip(&table.ids).filter(|&(_, &id)| id < fixed) {
            selection.decide(at, State::In);
        }
        let undecided = |&v: &u32| selection.states[v as usize] == State::Undecided;
        let open = leaves.iter().map(|leaf| leaf.owned().filter(undecided).collect()).collect();
        selection.open = open;
        selection
    }

    /// Takes what was told of other ranks' points.
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

    /// Those that come before all their undecided neighbours join.
    fn join<P: Point>(&mut self, cx: &mut Context<P>, leaves: &[Leaf<P>], table: &Table<P>) {
        let count: u64 = self.open.iter().map(|open| open.len() as u64).sum();
        if count > 0 {
            self.undecided.push(count);
        }
        let halves = self.half(cx, (leaves, table), "join", |leaf, open, lists, cost| {
            let (priorities, positions) = (&self.priorities, &table.positions);
            let first = cost.map_nested(open, |&v, own| {
                let (mine, mut first) = ((priorities[v as usize], positions[v as usize]), true);
                let mut sweep = own.sweep();
                sweep.each(&lists[(v - leaf.start) as usize], |&u| {
                    let other = priorities[u as usize];
                    first &= mine.0 < other || compare(mine, (other, positions[u as usize])).is_lt();
                });
                own.charge_nested_sweep(sweep);
                first
            });
            (first, false)
        });
        self.settle(cx, (leaves, table), halves, State::In);
    }

    /// The neighbours of those that are in are out.
    fn leave<P: Point>(&mut self, cx: &mut Context<P>, leaves: &[Leaf<P>], table: &Table<P>) {
        let halves = self.half(cx, (leaves, table), "leave", |leaf, open, lists, cost| {
            let states = &self.states;
            let out = cost.map_nested(open, |&v, own| {
                let mut out = false;
                let mut sweep = own.sweep();
                sweep.each(&lists[(v - leaf.start) as usize], |&u| out |= states[u as usize] == State::In);
                own.charge_nested_sweep(sweep);
                out
            });
            (out, true)
        });
        self.settle(cx, (leaves, table), halves, State::Out);
    }

    /// Half a round in every leaf that has undecided points: which of them are decided (and whether the round ends
    /// with that), and whom that concerns.
    fn half<P: Point>(
        &self,
        cx: &Context<P>,
        (leaves, table): (&[Leaf<P>], &Table<P>),
        step: &'static str,
        rule: impl Fn(&Leaf<P>, &[u32], &Lists<u32>, &mut Cost) -> (Vec<bool>, bool) + Sync + Send,
    ) -> Vec<(usize, Half)> {
        let places: Vec<usize> = (0..leaves.len()).filter(|&at| !self.open[at].is_empty()).collect();
        let site = cx.site();
        map_in(&cx.pool, &places, |&at| {
            let (leaf, lists) = (&leaves[at], &self.graphs[at]);
            let open = &self.open[at];
            let _span = site.subproblem(Phase::Independent, leaf.id, step, open.len() as u64);
            let mut cost = Cost::ZERO;
            let (flags, ends) = rule(leaf, open, lists, &mut cost);
            let flagged: Vec<(u32, bool)> = open.iter().copied().zip(flags).collect();
            let mut told = Vec::new();
            cost.map_nested(&flagged, |&(v, decided), own| {
                let mut sweep = own.sweep();
                sweep.each(&lists[(v - leaf.start) as usize], |&u| {
                    if decided && u >= table.owned && self.states[u as usize] == State::Undecided {
                        told.push((table.owners[u as usize], v));
                    }
                });
                own.charge_nested_sweep(sweep);
            });
            let open = ends.then(|| {
                let undecided = |&(v, out): &(u32, bool)| !out && self.states[v as usize] == State::Undecided;
                cost.pack(&flagged, undecided).into_iter().map(|(v, _)| v).collect()
            });
            let decided = flagged.into_iter().filter(|f| f.1).map(|f| f.0).collect();
            (at, Half { decided, told, open, cost })
        })
    }

    /// Takes the outcome of half a round, and tells it.
    fn settle<P: Point>(
        &mut self,
        cx: &mut Context<P>,
        (leaves, table): (&[Leaf<P>], &Table<P>),
        halves: Vec<(usize, Half)>,
        state: State,
    ) {
        let mut batches: BTreeMap<Rank, Vec<u64>> = BTreeMap::new();
        for (at, half) in halves {
            let leaf = &leaves[at];
            cx.ledger.charge(Phase::Independent, leaf.id, half.cost, leaf.owned_len());
            for point in half.decided {
                self.decide(point, state);
            }
            for (owner, point) in half.told {
                let (batch, id) = (batches.entry(owner).or_default(), table.ids[point as usize]);
                // One point's ghosts stand together: an owner of several is told once.
                if batch.last() != Some(&id) {
                    batch.push(id);
                }
            }
            if let Some(open) = half.open {
                self.open[at] = open;
            }
        }
        for (owner, ids) in batches {
            let body = if state == State::In { Body::Joined(Bulk(ids)) } else { Body::Left(Bulk(ids)) };
            cx.send(owner, NodeId::ROOT, 0, body);
        }
    }
}

impl Selection {
    /// The members that joined, and how many points were undecided in each round, for rank 0.
    pub(crate) fn into_message<P: Point>(self, table: &Table<P>, fixed: u64) -> Body<P> {
        let owned = table.ids[..table.owned as usize].iter().zip(&self.states);
        let members = owned.filter(|&(&id, &state)| state == State::In && id >= fixed).map(|(&id, _)| id);
        Body::Selected { members: Bulk(members.collect()), undecided: Bulk(self.undecided) }
    }
}

#[cfg(test)]
mod tests;
