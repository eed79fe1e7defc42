//! The supergraph of a rank's owned points: separator sets, then the graph within them.
//!
//! **Statement** (paper, Sections 4.3 to 4.5). The supergraph joins each point to every point that may be its neighbour
//! in the Delaunay triangulation. Each rank finds the edges of its owned points by one of three rules.
//! 1. *Ghosts* ([`crate::graph::ghosts`]): points go to the leaves that their edges may reach.
//! 2. *Reverse edges* ([`crate::graph::reverse`]), for graphs of nearest neighbours: points announce themselves to
//!    their nearest neighbours.
//! 3. *Sets* ([`crate::graph::separator_sets`], [`crate::graph::own_spheres`]): the recursion of the paper, on the
//!    separators of the partition tree or on separators that are drawn for the sets.
//!
//! **Rounds.** The rounds of the rule. **Work and depth.** By rule 1, all pairs
//! of an owned point and a member of the same leaf.

use std::ops::Range;

use septet_geometry::graph::{Supergraph, graph_direct};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::transport::TransportError;

use crate::config::{Fault, SetRule};
use crate::graph::edges::{Edges, edges_of};
use crate::graph::ghosts::push_ghosts;
use crate::graph::own_spheres::own_recursion;
use crate::graph::reverse::reverse_edges;
use crate::graph::separator_sets::set_recursion;
use crate::machine::context::Context;
use crate::neighbours::results::CompletedLists;
use crate::state::ghosts::Ghosts;
use crate::state::subdomain::{Shared, Subdomain};
use crate::state::table::Table;
use crate::state::tree::{GROUP, Leaf, Split, Tree};

/// The supergraph of the owned points.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    /// The neighbours of each owned point.
    neighbours: Lists<u32>,
    /// The ghosts of each leaf under rule 1. Empty under the other rules.
    ghosts: Ghosts,
    /// The edges that count at an owned point, as pairs of ids. Empty unless the run keeps them.
    edges: Vec<u64>,
    /// Node and id of each member of the sets in which this rank compared all pairs. Empty unless the run keeps them.
    sets: Vec<[u64; 2]>,
}

impl Graph {
    /// Takes the edges that count at an owned point, as pairs of ids.
    pub(crate) fn take_edges(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.edges)
    }

    /// Takes the members of the sets in which this rank compared all pairs, with the node of each.
    pub(crate) fn take_sets(&mut self) -> Vec<[u64; 2]> {
        std::mem::take(&mut self.sets)
    }

    /// Returns the neighbours of each owned point, and the ghosts of each leaf.
    pub(crate) fn into_parts(self) -> (Lists<u32>, Ghosts) {
        (self.neighbours, self.ghosts)
    }
}

/// Finds the supergraph of the owned points. For graphs of nearest neighbours, `nearest` contains the nearest
/// neighbours of these points.
pub(crate) async fn supergraph<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    rule: Supergraph,
    nearest: Option<CompletedLists>,
) -> Result<Graph, TransportError> {
    cx.enter(Phase::Sets)?;
    count_crossings(cx, subdomain, table, rule);
    charge_seeds(cx, subdomain);
    let mut sets = Vec::new();
    let (neighbours, ghosts) = match (cx.config().graph.sets, nearest) {
        (SetRule::Ghost, None) => {
            let mut ghosts = push_ghosts(cx, subdomain, table, rule).await?;
            cx.enter(Phase::Graph)?;
            // The order of ghosts has no influence on lists and stars, so the machine does not sort them. Here, the same
            // order on all ranks makes the counts equal.
            let at = |i: u32| table.positions()[i as usize];
            ghosts.sort_by(|&a, &b| lex_cmp(&at(a), &at(b)));
            (graph_of_leaves(cx, subdomain, table, rule, &ghosts), ghosts)
        }
        (SetRule::Ghost, Some(nearest)) => {
            let reverse = reverse_edges(cx, subdomain, table, nearest).await?;
            cx.enter(Phase::Graph)?;
            (reverse.unite(cx, subdomain, table), Ghosts::default())
        }
        (SetRule::Own, _) if cx.config().fault != Some(Fault::OldSpheres) => {
            let neighbours;
            (neighbours, sets) = own_recursion(cx, subdomain, table, rule).await?;
            cx.enter(Phase::Graph)?;
            (neighbours, Ghosts::default())
        }
        (SetRule::Both | SetRule::Own | SetRule::Smaller, _) => {
            let neighbours;
            (neighbours, sets) = set_recursion(cx, subdomain, table, rule).await?;
            cx.enter(Phase::Graph)?;
            (neighbours, Ghosts::default())
        }
    };
    let edges = count_edges(cx, subdomain, table, &neighbours);
    while cx.exchange().await? {}
    Ok(Graph { neighbours, ghosts, edges, sets })
}

/// Charges each node for a comparison of the smallest points of its two children. On the way down, the machine passes each
/// leaf a point that is smaller than its own points, if there is one. The local hulls start with these points.
fn charge_seeds<P: Point>(cx: &mut Context<P>, subdomain: &Subdomain<P>) {
    let shared = subdomain.path().iter().filter(|shared| shared.first() == cx.rank()).map(Shared::id);
    let nodes: Vec<NodeId> = shared.chain(subdomain.inner_ids().iter().copied()).collect();
    for node in nodes {
        let mut cost = cx.own_cost();
        cost.map(&[node.child(0), node.child(1)], |_| ());
        cx.charge(Account::leader(Phase::Sets, node), cost, 0);
    }
}

/// Counts the balls of owned points that cross each separator above them. The owned points below a node are
/// consecutive.
pub(crate) fn count_crossings<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    rule: Supergraph,
) {
    let points = 0..table.owned_len() as usize;
    let radii: Vec<f64> =
        table.radii2()[points.clone()].iter().map(|&r2| rule.separator_radius(r2)).collect();
    let shared = subdomain.path().iter();
    let mut splits: Vec<Divided<P>> = shared
        .map(|shared| Divided { id: shared.id(), split: shared.split(), points: points.clone() })
        .collect();
    if let Some(tree) = subdomain.tree() {
        splits_below(tree, subdomain.leaves(), &mut splits);
    }
    let groups: Vec<Divided<P>> = splits
        .into_iter()
        .flat_map(|Divided { id, split, points }| {
            let end = points.end;
            points.step_by(GROUP).map(move |start| Divided {
                id,
                split,
                points: start..end.min(start + GROUP),
            })
        })
        .collect();
    let counted = cx.map(&groups, |Divided { id, split, points }| {
        let centres = table.positions()[points.clone()].iter().copied();
        let balls = centres.zip(radii[points.clone()].iter().copied());
        (*id, split.separator().count_crossing(balls))
    });
    for (id, [inside, outside]) in counted {
        let facts = cx.facts(id);
        facts.crossing_inside += inside;
        facts.crossing_outside += outside;
    }
}

/// A split, and owned points below its node.
struct Divided<'a, P> {
    id: NodeId,
    split: &'a Split<P>,
    points: Range<usize>,
}

/// Appends the splits of a subtree, in preorder, each with the owned points below it. Returns the owned points of the
/// subtree.
fn splits_below<'a, P>(
    tree: &'a Tree<P>,
    leaves: &[Leaf<P>],
    splits: &mut Vec<Divided<'a, P>>,
) -> Range<usize> {
    match tree {
        Tree::Leaf(at) => leaves[*at].indices(),
        Tree::Node(inner) => {
            let slot = splits.len();
            splits.push(Divided { id: inner.id(), split: inner.split(), points: 0..0 });
            let [interior, exterior] =
                [0, 1].map(|side| splits_below(&inner.children()[side], leaves, splits));
            debug_assert_eq!(interior.end, exterior.start, "leaves are not in the order of the tree");
            splits[slot].points = interior.start..exterior.end;
            interior.start..exterior.end
        }
    }
}

/// Finds the graph neighbours of each leaf's owned points, by all pairs with the members of the leaf. Lists are empty once
/// the run stops.
fn graph_of_leaves<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    rule: Supergraph,
    ghosts: &Ghosts,
) -> Lists<u32> {
    let (site, leaves, meter) = (cx.site(), subdomain.leaves(), cx.own_cost());
    let stop = cx.config().stop.clone();
    let indices: Vec<usize> = (0..leaves.len()).collect();
    let results = cx.map(&indices, |&at| {
        let leaf = &leaves[at];
        let _span = site.subproblem(Phase::Graph, leaf.id(), "leaf graph", leaf.owned_len());
        let owned: Vec<u32> = leaf.owned().collect();
        let members = ghosts.members(at, leaf);
        let (mut cost, mut growth) = (meter.fresh(), stop.growth());
        if stop.is_raised() {
            return (Lists::of_empty(owned.len()), cost, 0, growth);
        }
        let lists = graph_direct(rule, table.positions(), table.radii2(), &owned, &members, &mut cost);
        stop.admits(&mut growth, lists.bytes());
        (lists, cost, members.len() as u64, growth)
    });
    let mut neighbours = Lists::default();
    for (leaf, (lists, cost, members, _)) in leaves.iter().zip(results) {
        cx.charge(Account::member(Phase::Graph, leaf.id()), cost, members * leaf.owned_len());
        cx.facts(leaf.id()).members += members;
        neighbours.append(lists);
    }
    neighbours
}

/// Counts each edge once, at its smaller end. Returns the edges that count here, if the run keeps them.
fn count_edges<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    neighbours: &Lists<u32>,
) -> Vec<u64> {
    let mut kept = Vec::new();
    for leaf in subdomain.leaves() {
        let mut edges = Edges::default();
        for point in leaf.owned() {
            let list = &neighbours[point as usize];
            edges.add(table, point, list);
            if cx.config().shown.with_edges {
                let counted = edges_of(table, point, list).filter(|edge| edge.1);
                kept.extend(counted.flat_map(|edge| edge.0));
            }
        }
        edges.enter(leaf.id(), cx);
    }
    kept
}
