//! The baseline of the descent: balls corrected node by node, from the leaves up.
//!
//! **Statement** (the divide and conquer that Frieze, Miller and Teng 1993 make faster). When both children of a
//! node have the nearest neighbours of their own points, the balls that cross the node's separator look for
//! nearer points on the other side, by a descent below that child. A node waits for its children.
//!
//! **Work and depth.** A node of height `h` takes a descent of up to `h` levels, node after node on the way up:
//! O(log^2 n) depth in all, where one descent of all balls from the root takes O(log n). The radii are the same.
//! No ball needs the punt: on its way up it has shrunk before it meets many leaves.
//!
//! **Rounds.** One pass of messages for each shared level, the deepest first; up to `2 h'` rounds a pass for `h'`
//! shared levels.

use std::ops::Range;

use septet_geometry::point::Point;
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::transport::TransportError;

use crate::config::WorkerConfig;
use crate::machine::context::Context;
use crate::neighbours::ask::Ask;
use crate::neighbours::descent::{Descent, Pending};
use crate::neighbours::router::QueryRouter;
use crate::neighbours::tallies::Tallies;
use crate::neighbours::walk::{Ground, Probe};
use crate::state::subdomain::{Inner, Subdomain, Tree, Way, leaf_number};
use crate::state::table::Table;

const ASK: Ask = Ask { phase: Phase::Neighbours, wanted: 1, probe: false, own_leaf: true };

/// The level whose nodes correct their balls first. No node below it is shared, since groups lose a rank with every
/// level.
pub(crate) fn first_level(config: &WorkerConfig) -> u32 {
    config.workers.saturating_sub(1).min(NodeId::DEEPEST)
}

/// Corrects the radii of all home points: first at the nodes of this rank's own subtree, then at the shared nodes,
/// one pass a level.
pub(crate) async fn correct_bottom_up<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    let first = first_level(&cx.config);
    for level in (0..=first).rev() {
        cx.enter(Phase::Neighbours)?;
        if let Some((_, tree)) = subdomain.tree.as_ref().filter(|_| level == first) {
            correct(cx, subdomain, table, tree);
        }
        let mut descent = Descent::new(subdomain, ASK, &[]);
        if subdomain.tree.is_some() {
            cross(cx, subdomain, table, level, &mut descent);
        }
        while cx.exchange().await? {
            descent.receive(cx, table)?;
        }
        descent.land_pass(cx, level).shrink(&mut table.radii2);
    }
    Ok(())
}

/// Sends the balls that cross the shared node of a level to its other side.
fn cross<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    level: u32,
    descent: &mut Descent<P>,
) {
    let Some(at) = subdomain.path.iter().position(|shared| shared.id.level() == level) else { return };
    let shared = &subdomain.path[at];
    let out = Way { level: at, side: 1 - shared.mine };
    let mut forwards = QueryRouter::new(cx.rank, ASK);
    for owned in 0..table.owned {
        let (centre, radius2) = (table.positions[owned as usize], table.radii2[owned as usize]);
        let goes = shared.split.reaches(centre, radius2, out.side);
        descent.visit(shared.id, goes);
        if goes {
            let leaf = u64::from(leaf_number(&subdomain.leaves, owned));
            descent.forward(&mut forwards, &[out], leaf, Pending::of_owned(owned, centre, radius2));
        }
    }
    forwards.send(cx);
}

/// Corrects the balls of a subtree's nodes, children first; returns its home points.
fn correct<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    tree: &Tree<P>,
) -> Range<u32> {
    let inner = match tree {
        Tree::Leaf(at) => return subdomain.leaves[*at].owned(),
        Tree::Node(inner) => inner,
    };
    let owned_points = [0, 1].map(|side| correct(cx, subdomain, table, &inner.children[side]));
    correct_node(cx, subdomain, table, inner, &owned_points);
    owned_points[0].start..owned_points[1].end
}

/// Corrects the balls of both children of a node.
fn correct_node<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    inner: &Inner<P>,
    owned_points: &[Range<u32>; 2],
) {
    let mut walk = Ground { subdomain, table, blocks: &[], recorded: false }.walk(ASK);
    let mut nearer = Vec::new();
    let mut found = NeighbourList::default();
    for (side, range) in owned_points.iter().enumerate() {
        for owned in range.clone() {
            let (centre, radius2) = (table.positions[owned as usize], table.radii2[owned as usize]);
            let goes = inner.split.reaches(centre, radius2, 1 - side);
            walk.visit_local(inner.number, goes);
            if goes {
                found.clear();
                walk.down(&inner.children[1 - side], &Probe { centre, radius2, owned: None }, &mut found);
                nearer.extend(found.distances2().iter().map(|&d2| (owned, d2)));
            }
        }
    }
    let mut tallies = Tallies::default();
    tallies.add(subdomain, &walk.into_counts(), cx);
    tallies.charge_pass(cx, inner.id.level());
    for (owned, d2) in nearer {
        let radius2 = &mut table.radii2[owned as usize];
        *radius2 = radius2.min(d2);
    }
}
