//! The supergraph of a rank's home points: separator sets, then the graph in them.
//!
//! **Statement** (paper, Sections 4.3 to 4.5). The supergraph joins a point to all that can be its neighbours in the
//! Delaunay triangulation. Each rank finds the edges of its home points by one of three rules. *Ghosts*
//! ([`crate::graph::ghosts`]): points go to the leaves that their edges can reach. *Reverse edges*
//! ([`crate::graph::reverse`]), for graphs of nearest neighbours: points tell their nearest. *Sets*
//! ([`crate::graph::separator_sets`]): the paper's recursion.
//!
//! **Rounds.** Those of the rule, and one to collect the edges. **Work and depth.** By the first rule, all pairs of a
//! leaf's home points with its members.

use std::ops::Range;

use septet_geometry::cost::Cost;
use septet_geometry::graph::{Supergraph, graph_direct};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::Body;
use septet_protocol::transport::TransportError;

use crate::config::{SetRule, map_in};
use crate::graph::edges::{Edges, edges_of};
use crate::graph::ghosts::push_ghosts;
use crate::graph::reverse::reverse_edges;
use crate::graph::separator_sets::set_recursion;
use crate::machine::context::Context;
use crate::neighbours::results::CompletedLists;
use crate::state::subdomain::{GROUP, Ghosts, Leaf, Split, Subdomain, Tree};
use crate::state::table::Table;

/// The supergraph of the home points.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    /// The neighbours of each.
    pub(crate) neighbours: Lists<u32>,
    /// The points that came to the leaves to be joined to them.
    pub(crate) ghosts: Ghosts,
    /// All edges as pairs of ids, on the coordinator and if asked for.
    pub(crate) edges: Vec<u64>,
}

/// Finds the supergraph of the home points; `nearest` has their nearest neighbours, if it is made of them.
pub(crate) async fn supergraph<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    rule: Supergraph,
    nearest: Option<CompletedLists>,
) -> Result<Graph, TransportError> {
    cx.enter(Phase::Sets)?;
    count_crossings(cx, subdomain, table, rule);
    let (neighbours, ghosts) = match (cx.config.graph.sets, nearest) {
        (SetRule::Ghost, None) => {
            let mut ghosts = push_ghosts(cx, subdomain, table, rule).await?;
            cx.enter(Phase::Graph)?;
            let at = |i: u32| table.positions[i as usize];
            ghosts.sort_by(|&a, &b| lex_cmp(&at(a), &at(b)));
            (graph_of_leaves(cx, subdomain, table, rule, &ghosts), ghosts)
        }
        (SetRule::Ghost, Some(nearest)) => {
            let reverse = reverse_edges(cx, subdomain, table, nearest).await?;
            cx.enter(Phase::Graph)?;
            (reverse.unite(cx, subdomain, table), Ghosts::default())
        }
        (SetRule::Both | SetRule::Smaller, _) => {
            let neighbours = set_recursion(cx, subdomain, table, rule).await?;
            cx.enter(Phase::Graph)?;
            (neighbours, Ghosts::default())
        }
    };
    report_edges(cx, subdomain, table, &neighbours);
    let mut edges = Vec::new();
    while cx.exchange().await? {
        edges.extend(take_edges(cx));
    }
    Ok(Graph { neighbours, ghosts, edges })
}

/// Takes the edges that workers report to the coordinator.
fn take_edges<P: Point>(cx: &mut Context<P>) -> impl Iterator<Item = u64> + use<P> {
    let parts = cx.take(|m| match &mut m.body {
        Body::Edges(Bulk(part)) => Some(std::mem::take(part)),
        _ => None,
    });
    parts.into_iter().flatten()
}

/// Measures every separator against the home points below it, which follow each other.
pub(crate) fn count_crossings<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    rule: Supergraph,
) {
    let owned_points = 0..table.owned as usize;
    let radii: Vec<f64> =
        table.radii2[owned_points.clone()].iter().map(|&r2| rule.separator_radius(r2)).collect();
    let mut splits: Vec<(NodeId, &Split<P>, Range<usize>)> =
        subdomain.path.iter().map(|shared| (shared.id, &shared.split, owned_points.clone())).collect();
    if let Some((_, tree)) = &subdomain.tree {
        splits_below(tree, &subdomain.leaves, &mut splits);
    }
    let groups: Vec<(NodeId, &Split<P>, Range<usize>)> = splits
        .into_iter()
        .flat_map(|(id, split, owned_points)| {
            let end = owned_points.end;
            owned_points.step_by(GROUP).map(move |start| (id, split, start..end.min(start + GROUP)))
        })
        .collect();
    let counted = map_in(&cx.pool, &groups, |(id, split, owned_points)| {
        let centres = table.positions[owned_points.clone()].iter().copied();
        let balls = centres.zip(radii[owned_points.clone()].iter().copied());
        (*id, split.separator.count_crossing(balls))
    });
    for (id, [inside, outside]) in counted {
        let facts = cx.facts(id);
        facts.crossing_inside += inside;
        facts.crossing_outside += outside;
    }
}

/// The splits of a rank's own tree, in preorder, each with the home points below it. Returns those below the tree.
fn splits_below<'a, P>(
    tree: &'a Tree<P>,
    leaves: &[Leaf<P>],
    splits: &mut Vec<(NodeId, &'a Split<P>, Range<usize>)>,
) -> Range<usize> {
    match tree {
        Tree::Leaf(at) => leaves[*at].start as usize..leaves[*at].end as usize,
        Tree::Node(inner) => {
            let place = splits.len();
            splits.push((inner.id, &inner.split, 0..0));
            let [interior, exterior] = [0, 1].map(|side| splits_below(&inner.children[side], leaves, splits));
            debug_assert_eq!(interior.end, exterior.start, "leaves are numbered in the order of the tree");
            let below = interior.start..exterior.end;
            splits[place].2 = below.clone();
            below
        }
    }
}

/// All pairs of every leaf's home points with its members.
fn graph_of_leaves<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    rule: Supergraph,
    ghosts: &Ghosts,
) -> Lists<u32> {
    let (site, leaves) = (cx.site(), &subdomain.leaves);
    let places: Vec<usize> = (0..leaves.len()).collect();
    let results = map_in(&cx.pool, &places, |&at| {
        let leaf = &leaves[at];
        let _span = site.subproblem(Phase::Graph, leaf.id, "leaf graph", leaf.owned_len());
        let owned: Vec<u32> = leaf.owned().collect();
        let members = ghosts.members(at, leaf);
        let mut cost = Cost::ZERO;
        let lists = graph_direct(rule, &table.positions, &table.radii2, &owned, &members, &mut cost);
        (lists, cost, members.len() as u64)
    });
    let mut neighbours = Lists::default();
    for (leaf, (lists, cost, members)) in leaves.iter().zip(results) {
        cx.charge(Account::member(Phase::Graph, leaf.id), cost, members * leaf.owned_len());
        cx.facts(leaf.id).members += members;
        neighbours.append(lists);
    }
    neighbours
}

/// Counts edges once, at their smaller end; sends them to rank 0 if asked for.
fn report_edges<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    neighbours: &Lists<u32>,
) {
    let mut sent = Vec::new();
    for leaf in &subdomain.leaves {
        let mut edges = Edges::default();
        for owned in leaf.owned() {
            let list = &neighbours[owned as usize];
            edges.take(table, owned, list);
            if cx.config.shown.collect_graph {
                let counted = edges_of(table, owned, list).filter(|edge| edge.1);
                sent.extend(counted.flat_map(|edge| edge.0));
            }
        }
        edges.enter(leaf.id, cx);
    }
    if !sent.is_empty() {
        cx.to_coordinator(Body::Edges(Bulk(sent)));
    }
}
