//! Ghosts: every point goes to each leaf that an edge of it can reach.
//!
//! **Statement.** An edge of the density or overlap graph between `j` and a home point of a subproblem
//! with largest radius `R` is no longer than `reach(r_j, R)` ([`Supergraph::reach`]). So `j` goes down to
//! every child whose side of the separator, and whose box, its ball of that radius meets. Then a leaf
//! holds all graph neighbours of its home points, and nothing has to return. For the density graph that is
//! `alpha min(r_j, R)`: the minimum of both keeps the points of a singularity from going everywhere.
//!
//! **Source.** Separator sets: paper, Section 4.3. **Departure.** The paper takes the points whose balls cross the
//! separator; here a point goes to the side that an edge of it can reach.
//!
//! **Rounds.** At most one a shared level. **Work and depth.** One vector step over the balls at a node.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::map_in;
use crate::machine::context::Context;
use crate::machine::tasks::Reach;
use crate::state::subdomain::{Entry, GROUP, Ghosts, Shared, Split, Subdomain, Tree, Way};
use crate::state::table::Table;

/// Sends every home point to the leaves that an edge of it can reach, and takes in those of other ranks.
pub(crate) async fn push_ghosts<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    rule: Supergraph,
) -> Result<Ghosts, TransportError> {
    let mut pushing = Pushing::new(subdomain, rule);
    pushing.push_owned(cx, table);
    while cx.exchange().await? {
        pushing.pass_on(cx, table);
    }
    for (node, sweep) in pushing.sweeps {
        let mut cost = Cost::ZERO;
        let items = sweep.items();
        cost.charge_sweep(sweep);
        cx.ledger.charge(Phase::Sets, node, cost, items);
    }
    Ok(pushing.ghosts)
}

/// A point under way: position, squared radius, and its home leaf while on the way there.
#[derive(Clone, Copy)]
struct Pushed<P> {
    position: P,
    radius2: f64,
    owned: Option<NodeId>,
}

impl<P: Point> Pushed<P> {
    fn of(table: &Table<P>, number: u32, owned: Option<NodeId>) -> Self {
        let at = number as usize;
        Pushed { position: table.positions[at], radius2: table.radii2[at], owned }
    }
}

/// Where a point goes: to leaves of this rank, and off its path.
#[derive(Default)]
struct Routes {
    leaves: Vec<usize>,
    ways: Vec<Way>,
}

impl Routes {
    fn is_empty(&self) -> bool {
        self.leaves.is_empty() && self.ways.is_empty()
    }
}

/// One walk of points through what a rank knows of the tree, with its own counters.
struct Walk<'a, P> {
    subdomain: &'a Subdomain<P>,
    rule: Supergraph,
    counts: Counts,
}

/// How many points each node of the path and of the rank's own tree looked at.
struct Counts {
    shared: Vec<Sweep>,
    local: Vec<Sweep>,
    reach: Reach,
}

impl<'a, P: Point> Walk<'a, P> {
    fn new(subdomain: &'a Subdomain<P>, rule: Supergraph, recorded: bool) -> Self {
        let counts = Counts {
            shared: vec![Sweep::default(); subdomain.path.len()],
            local: vec![Sweep::default(); subdomain.inner_ids.len()],
            reach: Reach::new(recorded),
        };
        Walk { subdomain, rule, counts }
    }

    /// From a position on the path, or from the rank's own tree at its end.
    fn from(&mut self, start: usize, x: &Pushed<P>) -> Routes {
        let mut routes = Routes::default();
        let (subdomain, rule, shared_sweeps) = (self.subdomain, self.rule, &mut self.counts.shared);
        let reach = |level: usize, shared: &Shared<P>| {
            shared_sweeps[level].visit();
            let max2 = |side: usize| shared.summaries.as_ref().map_or(f64::INFINITY, |s| s[side].max_radius2);
            [0, 1].map(|side| {
                (x.owned.is_some() && side == shared.mine) || goes(rule, &shared.split, side, max2(side), x)
            })
        };
        let below = subdomain.follow(start, reach, |way| routes.ways.push(way));
        if let Some((_, tree)) = subdomain.tree.as_ref().filter(|_| below) {
            self.down(tree, x, &mut routes.leaves);
        }
        routes
    }

    fn down(&mut self, tree: &Tree<P>, x: &Pushed<P>, leaves: &mut Vec<usize>) {
        match tree {
            Tree::Leaf(at) => {
                if x.owned != Some(self.subdomain.leaves[*at].id) {
                    leaves.push(*at);
                }
            }
            Tree::Node(inner) => {
                let owned = x.owned.map(|leaf| inner.id.side_of(leaf));
                self.counts.local[inner.number].visit();
                for (side, child) in inner.children.iter().enumerate() {
                    let on_way = owned == Some(side);
                    if on_way || goes(self.rule, &inner.split, side, inner.max_radius2[side], x) {
                        let owned = x.owned.filter(|_| on_way);
                        if !on_way {
                            self.counts.reach.visit(inner.id.child(side));
                        }
                        self.down(child, &Pushed { owned, ..*x }, leaves);
                    }
                }
            }
        }
    }
}

/// Can a point have an edge to a home point of this child, whose largest squared radius is `max2`?
fn goes<P: Point>(rule: Supergraph, split: &Split<P>, side: usize, max2: f64, x: &Pushed<P>) -> bool {
    let reach = rule.reach(x.radius2, max2);
    split.reaches(x.position, reach * reach * (1.0 + 1e-12), side)
}

/// Points that leave, by node and receiver.
type Batches<P> = BTreeMap<(NodeId, Rank), PointBatch<P>>;

/// The descent of all points, as one rank takes part in it.
struct Pushing<'a, P> {
    subdomain: &'a Subdomain<P>,
    rule: Supergraph,
    ghosts: Ghosts,
    /// Points that each node looked at.
    sweeps: BTreeMap<NodeId, Sweep>,
}

impl<'a, P: Point> Pushing<'a, P> {
    fn new(subdomain: &'a Subdomain<P>, rule: Supergraph) -> Self {
        let ghosts = Ghosts::of_leaves(subdomain.leaves.len());
        Pushing { subdomain, rule, ghosts, sweeps: BTreeMap::new() }
    }

    /// Pushes home points to other leaves.
    fn push_owned(&mut self, cx: &mut Context<P>, table: &Table<P>) {
        let (subdomain, rule, recorded) = (self.subdomain, self.rule, cx.recorder.is_some());
        let mut groups = Vec::new();
        for (at, leaf) in subdomain.leaves.iter().enumerate() {
            let owned_points: Vec<u32> = leaf.owned().collect();
            groups.extend(owned_points.chunks(GROUP).map(|c| (at, c.to_vec())));
        }
        let walked = map_in(&cx.pool, &groups, |(at, owned_points)| {
            let mut walk = Walk::new(subdomain, rule, recorded);
            let mut found = Vec::new();
            walk.counts.reach.start(*at);
            for &owned in owned_points {
                let x = Pushed::of(table, owned, Some(subdomain.leaves[*at].id));
                let routes = walk.from(0, &x);
                if !routes.is_empty() {
                    found.push((owned, routes));
                }
            }
            (found, walk.counts)
        });
        let mut batches = Batches::new();
        for (found, counts) in walked {
            self.count(&counts);
            if let (Some(recorder), Some(reached)) = (&mut cx.recorder, counts.reach.reached) {
                recorder.reached(Phase::Sets, reached);
            }
            for (owned, routes) in found {
                self.take(cx.rank, table, (owned, routes), &mut batches);
            }
        }
        send(cx, batches);
    }

    /// Takes in the points that other ranks pushed here, and sends on those that go elsewhere.
    fn pass_on(&mut self, cx: &mut Context<P>, table: &mut Table<P>) {
        let mut batches = Batches::new();
        for (node, points) in cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Ghosts(points) => Some((m.node, std::mem::take(points))),
            _ => None,
        }) {
            let start = match self.subdomain.entry(node, cx.rank) {
                Entry::Relay(holder) => {
                    cx.send(holder, node, 0, Body::Ghosts(points));
                    continue;
                }
                Entry::Here(start) => start,
            };
            let numbers = table.intern_all(&points);
            // Only home points are recorded.
            let mut walk = Walk::new(self.subdomain, self.rule, false);
            for number in numbers {
                let routes = walk.from(start, &Pushed::of(table, number, None));
                self.take(cx.rank, table, (number, routes), &mut batches);
            }
            self.count(&walk.counts);
        }
        send(cx, batches);
    }

    /// Adds the nodes' counts.
    fn count(&mut self, counts: &Counts) {
        let shared = self.subdomain.path.iter().map(|shared| shared.id).zip(&counts.shared);
        let local = self.subdomain.inner_ids.iter().copied().zip(&counts.local);
        for (id, sweep) in shared.chain(local).filter(|(_, sweep)| sweep.items() > 0) {
            self.sweeps.entry(id).or_default().join(sweep);
        }
    }

    /// Makes a point a ghost of the leaves that it reaches, and puts it into the batches that leave.
    fn take(
        &mut self,
        own: Rank,
        table: &Table<P>,
        (point, routes): (u32, Routes),
        batches: &mut Batches<P>,
    ) {
        for leaf in routes.leaves {
            self.ghosts.push(leaf, point);
        }
        for way in routes.ways {
            table.export(point, batches.entry(self.subdomain.beyond(way, own)).or_default());
        }
    }
}

fn send<P: Point>(cx: &mut Context<P>, batches: Batches<P>) {
    for ((node, to), batch) in batches {
        cx.send(to, node, 0, Body::Ghosts(batch));
    }
}
