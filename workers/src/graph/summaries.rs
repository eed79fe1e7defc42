//! What every subproblem holds (largest radius, lexicographically smallest point): up the tree to the
//! root, and down to the members. The radii prune the separator sets; the smallest points seed stars.

use septet_geometry::cost::Cost;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message, PointBatch, Summary};
use septet_protocol::transport::TransportError;

use crate::machine::collectives::{Reduction, Rising};
use crate::machine::context::Context;
use crate::state::frame;
use crate::state::subdomain::{Group, Leaf, Subdomain, Tree};
use crate::state::table::Table;

/// Summarises the home points, and learns what the children of all shared nodes hold.
pub(crate) async fn summaries<P: Point>(
    cx: &mut Context<P>,
    subdomain: &mut Subdomain<P>,
    table: &mut Table<P>,
    frame: &mut PointBatch<P>,
) -> Result<(), TransportError> {
    cx.enter(Phase::Summaries)?;
    frame::report(cx, table, &subdomain.leaves, frame);
    if let Some((root, own)) = own_summary(cx, subdomain, table) {
        send_up(cx, subdomain, root, own);
    }
    let (mut reduction, mut owners) = (Reduction::default(), frame::FrameOwners::default());
    while cx.exchange().await? {
        owners.receive(cx, table, frame);
        let arrived = cx.take(|m: &mut Message<P>| match &m.body {
            Body::Summary(summary) => Some(Rising { node: m.node, round: m.round, value: summary.clone() }),
            _ => None,
        });
        let joined = reduction.join(&subdomain.led, arrived, |group, both, _| join_children(cx, group, both));
        for (node, own) in joined {
            send_up(cx, subdomain, node, own);
        }
        for (node, children) in cx.take(|m| match &m.body {
            Body::Children(children) => Some((m.node, children.clone())),
            _ => None,
        }) {
            if let Some(shared) = subdomain.path.iter_mut().find(|s| s.id == node) {
                shared.summaries = Some(children);
            }
        }
    }
    Ok(())
}

/// Joins the summaries of a node's children, and sends them to the members of the node's group.
fn join_children<P: Point>(cx: &mut Context<P>, group: &Group, both: [Summary<P>; 2]) -> Summary<P> {
    let _span = cx.site().subproblem(Phase::Summaries, group.node, "join summaries", group.child.population);
    let mut cost = Cost::ZERO;
    let own = cost.reduce(&both, both[0].clone(), |best, s| join_summaries(&best, s));
    cx.charge(Account::leader(Phase::Summaries, group.node), cost, 0);
    let both = Box::new(both);
    cx.broadcast(group, 0, || Body::Children(both.clone()));
    own
}

/// The summary of this rank's own tree; none if it has no point.
fn own_summary<P: Point>(
    cx: &mut Context<P>,
    subdomain: &mut Subdomain<P>,
    table: &Table<P>,
) -> Option<(NodeId, Summary<P>)> {
    let mut charges = Vec::new();
    for leaf in &mut subdomain.leaves {
        let radii = &table.radii2[leaf.start as usize..leaf.end as usize];
        let mut cost = Cost::ZERO;
        leaf.max_radius2 = cost.reduce(radii, 0.0, |m: f64, &r| m.max(r));
        charges.push((leaf.id, cost, radii.len() as u64));
    }
    let (root, tree) = subdomain.tree.as_mut()?;
    let (max_radius2, smallest) = summarise(tree, &subdomain.leaves, table, &mut charges);
    for (node, cost, items) in charges {
        cx.charge(Account::member(Phase::Summaries, node), cost, items);
    }
    (smallest != u32::MAX).then(|| {
        let mut point = PointBatch::default();
        table.export(smallest, &mut point);
        (*root, Summary { max_radius2, smallest: point })
    })
}

/// Sends the summary of a node to its parent's leader.
fn send_up<P: Point>(cx: &mut Context<P>, subdomain: &Subdomain<P>, node: NodeId, summary: Summary<P>) {
    let parent = node.parent();
    if let Some(shared) = subdomain.path.iter().find(|s| Some(s.id) == parent) {
        cx.send(shared.leader, node, 0, Body::Summary(summary));
    }
}

/// Largest squared radius and smallest point of a subtree, kept at its inner nodes.
fn summarise<P: Point>(
    tree: &mut Tree<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
    charges: &mut Vec<(NodeId, Cost, u64)>,
) -> (f64, u32) {
    match tree {
        Tree::Leaf(at) => {
            let leaf = &leaves[*at];
            let rank =
                |&a: &u32, &b: &u32| lex_cmp(&table.positions[a as usize], &table.positions[b as usize]);
            (leaf.max_radius2, leaf.owned().min_by(rank).unwrap_or(u32::MAX))
        }
        Tree::Node(inner) => {
            for side in 0..2 {
                let (max2, smallest) = summarise(&mut inner.children[side], leaves, table, charges);
                inner.max_radius2[side] = max2;
                inner.smallest[side] = smallest;
            }
            let both = [0usize, 1];
            let mut cost = Cost::ZERO;
            let start = (inner.max_radius2[0], inner.smallest[0]);
            let joined = cost.reduce(&both, start, |(max2, best), &i| {
                let other = inner.smallest[i];
                let position = |n: u32| table.positions[n as usize];
                let smaller = lex_cmp(&position(other), &position(best)).is_lt();
                (max2.max(inner.max_radius2[i]), if smaller { other } else { best })
            });
            // A leader's reduction over two children charges the same two items.
            charges.push((inner.id, cost, 0));
            joined
        }
    }
}

/// The summary of two disjoint sets.
fn join_summaries<P: Point>(a: &Summary<P>, b: &Summary<P>) -> Summary<P> {
    let smaller = match (a.smallest.positions.first(), b.smallest.positions.first()) {
        (Some(x), Some(y)) if lex_cmp(y, x).is_lt() => b,
        (None, Some(_)) => b,
        _ => a,
    };
    Summary { max_radius2: a.max_radius2.max(b.max_radius2), smallest: smaller.smallest.clone() }
}
