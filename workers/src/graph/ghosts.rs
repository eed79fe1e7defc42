//! Separator sets by the rule `ghost`: each point goes to every leaf that one of its edges may reach.
//!
//! **Statement.** Let `j` be a point with radius `r_j`, and let `R` be the largest radius in a subproblem. In the
//! density and the overlap graph, an edge between `j` and an owned point of the subproblem has length at most
//! `reach(r_j, R)` ([`Supergraph::reach`]). So `j` goes down to each child whose box and whose side of the separator
//! both meet the ball of that radius around `j`. Every leaf then holds all graph neighbours of its owned points, and no
//! reply is necessary. For the density graph, the radius is `alpha min(r_j, R)`. The minimum prevents the points at a
//! singularity of the density from going to every leaf.
//!
//! **Source.** Separator sets: paper, Section 4.3. **Departure.** The paper takes the points whose balls cross the
//! separator. Here, a point goes to a side if one of its edges may reach that side.
//!
//! **Rounds.** At most one for each shared level. **Work and depth.** At each node, the replication of its points
//! ([`Cost::charge_replication`](septet_geometry::cost::Cost::charge_replication)).

use std::collections::BTreeMap;
use std::ops::Range;

use septet_geometry::cost::Sweep;
use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message, PointBatch, UNKNOWN_RADIUS2};
use septet_protocol::transport::TransportError;

use crate::config::Fault;
use crate::machine::context::Context;
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::{Shared, Subdomain, Way};
use crate::state::table::Table;
use crate::state::tree::{GROUP, Split, Tree, owned_groups};

/// Sends each owned point to the leaves that one of its edges may reach. Returns the ghosts of this rank's leaves.
pub(crate) async fn push_ghosts<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    rule: Supergraph,
) -> Result<Ghosts, TransportError> {
    let edges = EdgeReach { supergraph: rule, fault: cx.config().fault };
    let mut push = GhostPush::new(subdomain, edges);
    push.push_owned(cx, table);
    while cx.exchange().await? {
        push.pass_on(cx, table);
    }
    for (node, sweep) in push.sweeps {
        let mut cost = cx.shared_cost();
        let items = sweep.items();
        cost.charge_replication(sweep);
        cx.charge(Account::member(Phase::Sets, node), cost, items);
    }
    Ok(push.ghosts)
}

/// A point on its way down the tree.
#[derive(Clone, Copy)]
struct MovingPoint<P> {
    position: P,
    radius2: f64,
    /// The leaf that owns the point, if it lies below the current node.
    own_leaf: Option<NodeId>,
}

impl<P: Point> MovingPoint<P> {
    fn of(table: &Table<P>, point: u32, own_leaf: Option<NodeId>) -> Self {
        let at = point as usize;
        MovingPoint { position: table.positions()[at], radius2: table.radii2()[at], own_leaf }
    }
}

/// The destinations of a point.
#[derive(Default)]
struct Routes {
    /// Leaves of this rank.
    leaves: Vec<usize>,
    /// Ways out of the path.
    ways: Vec<Way>,
}

impl Routes {
    fn is_empty(&self) -> bool {
        self.leaves.is_empty() && self.ways.is_empty()
    }
}

/// The points of a subproblem that the edges of a point may reach.
#[derive(Clone, Copy)]
struct EdgeReach {
    supergraph: Supergraph,
    /// A planted fault, which may change the reach.
    fault: Option<Fault>,
}

impl EdgeReach {
    /// Returns `true` if a point may have an edge to an owned point of the child on `side`. `max2` is the largest
    /// squared radius in that child.
    fn enters<P: Point>(self, split: &Split<P>, side: usize, max2: f64, x: &MovingPoint<P>) -> bool {
        if self.fault.is_some_and(|fault| fault.keeps_home(x.position)) {
            return false;
        }
        let reach = self.fault.map_or(1.0, Fault::spread) * self.supergraph.reach(x.radius2, max2);
        split.reaches(x.position, reach * reach * (1.0 + 1e-12), side)
    }
}

/// A walk of points through the part of the tree that one rank holds, with its own counts.
struct GhostWalk<'a, P> {
    subdomain: &'a Subdomain<P>,
    edges: EdgeReach,
    counts: GhostCounts,
}

/// The points that visited each node in a walk.
struct GhostCounts {
    /// For each shared node of the path.
    shared: Vec<Sweep>,
    /// For each inner node of this rank's subtree.
    local: Vec<Sweep>,
}

impl GhostCounts {
    /// Returns the counts of the nodes that points visited. A group of points visits few nodes of a large subtree.
    fn of_visited<P: Point>(self, subdomain: &Subdomain<P>) -> Vec<(NodeId, Sweep)> {
        let shared = subdomain.path().iter().map(Shared::id).zip(self.shared);
        let local = subdomain.inner_ids().iter().copied().zip(self.local);
        shared.chain(local).filter(|(_, sweep)| sweep.items() > 0).collect()
    }
}

impl<'a, P: Point> GhostWalk<'a, P> {
    fn new(subdomain: &'a Subdomain<P>, edges: EdgeReach) -> Self {
        let counts = GhostCounts {
            shared: vec![Sweep::default(); subdomain.path().len()],
            local: vec![Sweep::default(); subdomain.inner_ids().len()],
        };
        GhostWalk { subdomain, edges, counts }
    }

    /// Returns the destinations of a point from position `start` of the path.
    fn routes(&mut self, start: usize, x: &MovingPoint<P>) -> Routes {
        let mut routes = Routes::default();
        let (subdomain, edges, shared_sweeps) = (self.subdomain, self.edges, &mut self.counts.shared);
        let reach = |level: usize, shared: &Shared<P>| {
            shared_sweeps[level].visit();
            let max2 = |side: usize| shared.summaries().map_or(UNKNOWN_RADIUS2, |s| s[side].max_radius2);
            [0, 1].map(|side| {
                let is_own = x.own_leaf.is_some() && side == shared.mine();
                is_own || edges.enters(shared.split(), side, max2(side), x)
            })
        };
        let arrives = subdomain.follow(start, reach, |way| routes.ways.push(way));
        if let Some(tree) = subdomain.tree().filter(|_| arrives) {
            self.down(tree, x, &mut routes.leaves);
        }
        routes
    }

    /// Appends the leaves of a subtree that a point reaches, except its own leaf.
    fn down(&mut self, tree: &Tree<P>, x: &MovingPoint<P>, leaves: &mut Vec<usize>) {
        match tree {
            Tree::Leaf(at) => {
                if x.own_leaf != Some(self.subdomain.leaves()[*at].id()) {
                    leaves.push(*at);
                }
            }
            Tree::Node(inner) => {
                let own_side = x.own_leaf.map(|leaf| inner.id().side_of(leaf));
                self.counts.local[inner.number()].visit();
                for (side, child) in inner.children().iter().enumerate() {
                    let is_own = own_side == Some(side);
                    if is_own || self.edges.enters(inner.split(), side, inner.max_radius2()[side], x) {
                        let own_leaf = x.own_leaf.filter(|_| is_own);
                        self.down(child, &MovingPoint { own_leaf, ..*x }, leaves);
                    }
                }
            }
        }
    }
}

/// Points that leave this rank, by node and receiver.
type Batches<P> = BTreeMap<(NodeId, Rank), PointBatch<P>>;

/// One rank's part in the descent of all points.
struct GhostPush<'a, P> {
    subdomain: &'a Subdomain<P>,
    edges: EdgeReach,
    ghosts: Ghosts,
    /// The points that visited each node.
    sweeps: BTreeMap<NodeId, Sweep>,
}

impl<'a, P: Point> GhostPush<'a, P> {
    fn new(subdomain: &'a Subdomain<P>, edges: EdgeReach) -> Self {
        let ghosts = Ghosts::of_leaves(subdomain.leaves().len());
        GhostPush { subdomain, edges, ghosts, sweeps: BTreeMap::new() }
    }

    /// Sends owned points to the other leaves that they reach.
    fn push_owned(&mut self, cx: &mut Context<P>, table: &Table<P>) {
        let (subdomain, edges) = (self.subdomain, self.edges);
        let groups = owned_groups(subdomain.leaves());
        // A walk has a count for each node of the subtree, so groups of small leaves share one.
        let walk_of = |(_, points): &(usize, Range<u32>)| points.start as usize / GROUP;
        let walks: Vec<_> = groups.chunk_by(|a, b| walk_of(a) == walk_of(b)).collect();
        let walked = cx.map(&walks, |groups| {
            let mut walk = GhostWalk::new(subdomain, edges);
            let mut found = Vec::new();
            for (at, points) in *groups {
                for point in points.clone() {
                    let x = MovingPoint::of(table, point, Some(subdomain.leaves()[*at].id()));
                    let routes = walk.routes(0, &x);
                    if !routes.is_empty() {
                        found.push((point, routes));
                    }
                }
            }
            (found, walk.counts.of_visited(subdomain))
        });
        let mut batches = Batches::new();
        for (found, counts) in walked {
            self.count(counts);
            for (point, routes) in found {
                self.place(cx.rank(), table, point, routes, &mut batches);
            }
        }
        send(cx, batches);
    }

    /// Receives the points of other ranks. Forwards those that leave the path.
    fn pass_on(&mut self, cx: &mut Context<P>, table: &mut Table<P>) {
        let mut batches = Batches::new();
        for (node, points) in cx.take(|m: &mut Message<P>| match &mut m.body {
            Body::Ghosts(points) => Some((m.node, std::mem::take(points))),
            _ => None,
        }) {
            let Some((start, points)) = self.subdomain.receive(cx, node, points, Body::Ghosts) else {
                continue;
            };
            let indices = table.intern_all(&points);
            let mut walk = GhostWalk::new(self.subdomain, self.edges);
            for point in indices {
                let routes = walk.routes(start, &MovingPoint::of(table, point, None));
                self.place(cx.rank(), table, point, routes, &mut batches);
            }
            self.count(walk.counts.of_visited(self.subdomain));
        }
        send(cx, batches);
    }

    /// Adds the counts of a walk.
    fn count(&mut self, counts: Vec<(NodeId, Sweep)>) {
        for (id, sweep) in counts {
            self.sweeps.entry(id).or_default().join(&sweep);
        }
    }

    /// Adds a point to the ghosts of the leaves that it reaches, and to the batches that leave this rank.
    fn place(&mut self, own: Rank, table: &Table<P>, point: u32, routes: Routes, batches: &mut Batches<P>) {
        for leaf in routes.leaves {
            self.ghosts.push(leaf, point);
        }
        for way in routes.ways {
            table.export(point, batches.entry(self.subdomain.beyond(way, own)).or_default());
        }
    }
}

fn send<P: Point>(cx: &mut Context<P>, batches: Batches<P>) {
    cx.route(batches.into_iter().map(|(receiver, batch)| (receiver, Body::Ghosts(batch))));
}
