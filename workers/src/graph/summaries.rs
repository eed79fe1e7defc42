//! The summary of each subproblem: the largest radius and the lexicographically smallest point among its owned points.
//!
//! **Statement.** Summaries go up the tree. The leader of a node joins the summaries of the two children and sends both
//! summaries to the members of its group. The radii prune the separator sets. The smallest points seed the stars.
//!
//! **Rounds.** One for each shared level on the way up. The members receive the summaries from their leader in as many
//! rounds as the tree of the group is high ([`crate::machine::group_tree`]).
//!
//! **Work and depth.** One reduction over the points of each leaf, and one over the two children of each inner node.

use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message, PointBatch, Summary};
use septet_protocol::transport::TransportError;

use crate::machine::collectives::{Reduction, Rising};
use crate::machine::context::Context;
use crate::state::frame;
use crate::state::subdomain::{Group, Subdomain};
use crate::state::table::Table;
use crate::state::tree::{Leaf, Tree};

/// Summarises the owned points, and stores the summaries of the children of all nodes on the path.
pub(crate) async fn summaries<P: Point>(
    cx: &mut Context<P>,
    subdomain: &mut Subdomain<P>,
    table: &mut Table<P>,
    frame: &mut PointBatch<P>,
) -> Result<(), TransportError> {
    cx.enter(Phase::Summaries)?;
    frame::report(cx, table, frame);
    if let Some((root, own)) = own_summary(cx, subdomain, table) {
        cx.contribute_up(subdomain.groups(), root, Body::Summary(own));
    }
    let (mut reduction, mut owners) = (Reduction::default(), frame::FrameOwners::default());
    while cx.exchange().await? {
        owners.receive(cx, table, frame);
        let arrived = cx.take(|m: &mut Message<P>| match &m.body {
            Body::Summary(summary) => Some(Rising { node: m.node, round: m.round, value: summary.clone() }),
            _ => None,
        });
        let joined =
            reduction.join(subdomain.led(), arrived, |group, both, _| join_children(cx, group, both));
        for (node, own) in joined {
            cx.contribute_up(subdomain.groups(), node, Body::Summary(own));
        }
        for (node, children) in cx.take(|m| match &m.body {
            Body::Children(children) => Some((m.node, children.clone())),
            _ => None,
        }) {
            if let Some(shared) = subdomain.shared(node) {
                cx.pass_down(shared.group(), || Body::Children(children.clone()));
            }
            subdomain.set_summaries(node, children);
        }
    }
    Ok(())
}

/// Joins the summaries of a node's children, and sends both summaries to the members of the node's group.
fn join_children<P: Point>(cx: &mut Context<P>, group: &Group, both: [Summary<P>; 2]) -> Summary<P> {
    let _span = cx.site().subproblem(Phase::Summaries, group.node, "join summaries", group.child.population);
    let mut cost = cx.own_cost();
    let own = cost.reduce(&both, both[0].clone(), |best, s| join_summaries(&best, s));
    cx.charge(Account::leader(Phase::Summaries, group.node), cost, 0);
    let both = Box::new(both);
    cx.broadcast(group, || Body::Children(both.clone()));
    own
}

/// Summarises this rank's subtree. Returns the root and the summary of the subtree, or `None` if this rank owns no
/// point.
fn own_summary<P: Point>(
    cx: &mut Context<P>,
    subdomain: &mut Subdomain<P>,
    table: &Table<P>,
) -> Option<(NodeId, Summary<P>)> {
    let root = subdomain.root();
    let (tree, leaves) = subdomain.tree_mut()?;
    for leaf in &mut *leaves {
        let radii = &table.radii2()[leaf.indices()];
        let mut cost = cx.own_cost();
        leaf.set_max_radius2(cost.reduce(radii, 0.0, |m: f64, &r| m.max(r)));
        cx.charge(Account::member(Phase::Summaries, leaf.id()), cost, radii.len() as u64);
    }
    let Extremes { max_radius2, smallest } = summarise(cx, tree, leaves, table);
    (smallest != u32::MAX).then(|| {
        let mut point = PointBatch::default();
        table.export(smallest, &mut point);
        (root, Summary { max_radius2, smallest: point })
    })
}

/// The largest squared radius and the smallest point of a set of owned points.
#[derive(Clone, Copy)]
struct Extremes {
    max_radius2: f64,
    /// `u32::MAX` if the set is empty.
    smallest: u32,
}

/// Summarises a subtree. Stores in each inner node the summaries of its children.
fn summarise<P: Point>(
    cx: &mut Context<P>,
    tree: &mut Tree<P>,
    leaves: &[Leaf<P>],
    table: &Table<P>,
) -> Extremes {
    let positions = table.positions();
    let compare = |&a: &u32, &b: &u32| lex_cmp(&positions[a as usize], &positions[b as usize]);
    match tree {
        Tree::Leaf(at) => {
            let leaf = &leaves[*at];
            let smallest = leaf.owned().min_by(compare).unwrap_or(u32::MAX);
            Extremes { max_radius2: leaf.max_radius2(), smallest }
        }
        Tree::Node(inner) => {
            let both = [0, 1].map(|side| summarise(cx, &mut inner.children_mut()[side], leaves, table));
            for (side, child) in both.iter().enumerate() {
                inner.set_summary(side, child.max_radius2, child.smallest);
            }
            let mut cost = cx.own_cost();
            let joined = cost.reduce(&both, both[0], |best, child| Extremes {
                max_radius2: best.max_radius2.max(child.max_radius2),
                smallest: if compare(&child.smallest, &best.smallest).is_lt() {
                    child.smallest
                } else {
                    best.smallest
                },
            });
            // A leader charges the same reduction over two children.
            cx.charge(Account::member(Phase::Summaries, inner.id()), cost, 0);
            joined
        }
    }
}

/// Joins the summaries of two disjoint sets.
fn join_summaries<P: Point>(a: &Summary<P>, b: &Summary<P>) -> Summary<P> {
    let smaller = match (a.smallest.positions.first(), b.smallest.positions.first()) {
        (Some(x), Some(y)) if lex_cmp(y, x).is_lt() => b,
        (None, Some(_)) => b,
        _ => a,
    };
    Summary { max_radius2: a.max_radius2.max(b.max_radius2), smallest: smaller.smallest.clone() }
}
