//! Balls corrected node by node, from the leaves up.
//!
//! **Statement.** Assume that for each child of a node, the nearest neighbours of its points within the child are
//! known. The balls that cross the separator of the node then search for nearer points on the other side, by a descent
//! from the child on that side. A node waits for its children.
//!
//! **Source.** The divide-and-conquer algorithm that Frieze, Miller and Teng (1993) accelerate. Both are here: the
//! baseline, in which balls go down level by level, and the acceleration ([`crate::neighbours::stages`]).
//!
//! **Work and depth.** Without the acceleration, a node of height `h` needs a descent of up to `h` levels. The nodes on a path to the root
//! follow in sequence, so the total depth is O(log^2 n). One descent of all balls from the root takes O(log n) and
//! yields the same radii. Balls do not need the punt ([`crate::neighbours::descent`]), because they have shrunk at
//! lower nodes before they meet many leaves.
//!
//! **Rounds.** One pass of messages for each shared level, the deepest level first. With `h'` shared levels, a pass
//! takes up to `2 h'` rounds. The acceleration also decides before each pass.

use std::ops::Range;

use septet_geometry::point::Point;
use septet_geometry::selection::NeighbourList;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::Crossings;
use septet_protocol::transport::TransportError;

use crate::config::WorkerConfig;
use crate::machine::context::Context;
use crate::neighbours::descent::{Descent, WaitingBall};
use crate::neighbours::router::QueryRouter;
use crate::neighbours::search::Search;
use crate::neighbours::stages::{Crossed, March, decide};
use crate::neighbours::tallies::Tallies;
use crate::neighbours::walk::{MovingBall, SearchSpace};
use crate::state::subdomain::{Subdomain, Way};
use crate::state::table::Table;
use crate::state::tree::{Inner, Tree, leaf_number};

const SEARCH: Search =
    Search { phase: Phase::Neighbours, wanted: 1, probe: false, own_leaf: true, everywhere: false };

/// Returns the level at which the correction starts. A group loses at least one rank with each level, so no node below
/// this level is shared.
pub(crate) fn first_level(config: &WorkerConfig) -> u32 {
    config.workers.saturating_sub(1).min(NodeId::DEEPEST)
}

/// Corrects the radii of all owned points, first at the nodes of the rank's own subtree, then at the shared nodes with
/// one pass for each level.
pub(crate) async fn correct_bottom_up<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    let first = first_level(cx.config());
    let mut own_height = 0;
    for level in (0..=first).rev() {
        cx.enter(Phase::Neighbours)?;
        if let Some(tree) = subdomain.tree().filter(|_| level == first) {
            own_height = correct(cx, subdomain, table, tree).height;
        }
        let at = subdomain.path().iter().position(|shared| shared.id().level() == level);
        let crossed = at.map(|at| {
            let height = own_height + (subdomain.path().len() - at) as u64;
            let balls = crossing(subdomain, table, at);
            (*subdomain.path()[at].group(), Crossings { balls, height })
        });
        let march = decide(cx, subdomain, crossed).await?;
        let mut descent = Descent::new(subdomain, SEARCH, &[]);
        if let Some(at) = at.filter(|_| subdomain.tree().is_some()) {
            cross(cx, subdomain, table, at, &mut descent);
        }
        while cx.exchange().await? {
            descent.receive(cx, table)?;
        }
        descent.finish_pass(cx, level, march).shrink(table.owned_radii2_mut());
    }
    Ok(())
}

/// Returns the number of owned balls that cross the separator of the shared node at position `at` of the path.
fn crossing<P: Point>(subdomain: &Subdomain<P>, table: &Table<P>, at: usize) -> u64 {
    let shared = &subdomain.path()[at];
    let crosses = |&point: &u32| {
        let (centre, radius2) = (table.positions()[point as usize], table.radii2()[point as usize]);
        shared.split().reaches(centre, radius2, 1 - shared.mine())
    };
    table.owned().filter(crosses).count() as u64
}

/// Sends the balls that cross the separator of the shared node at position `at` of the path to the other side of the
/// separator.
fn cross<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    at: usize,
    descent: &mut Descent<P>,
) {
    let shared = &subdomain.path()[at];
    let out = Way { level: at, side: 1 - shared.mine() };
    let mut router = QueryRouter::new(cx.rank(), SEARCH);
    for point in table.owned() {
        let (centre, radius2) = (table.positions()[point as usize], table.radii2()[point as usize]);
        let crosses = shared.split().reaches(centre, radius2, out.side);
        descent.visit(shared.id(), crosses);
        if crosses {
            let leaf = u64::from(leaf_number(subdomain.leaves(), point));
            descent.forward(&mut router, &[out], leaf, WaitingBall::of_owned(point, centre, radius2));
        }
    }
    router.send(cx);
}

/// A subtree whose balls are corrected.
struct Corrected {
    /// Its owned points.
    owned: Range<u32>,
    /// The number of levels below its root.
    height: u64,
}

/// Corrects the balls at the nodes of a subtree, children first.
fn correct<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    tree: &Tree<P>,
) -> Corrected {
    let inner = match tree {
        Tree::Leaf(at) => return Corrected { owned: subdomain.leaves()[*at].owned(), height: 0 },
        Tree::Node(inner) => inner,
    };
    let children = [0, 1].map(|side| correct(cx, subdomain, table, &inner.children()[side]));
    correct_node(cx, subdomain, table, inner, &children);
    let [inside, outside] = children;
    Corrected { owned: inside.owned.start..outside.owned.end, height: 1 + inside.height.max(outside.height) }
}

/// Corrects the balls at a node whose children are corrected.
fn correct_node<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    inner: &Inner<P>,
    children: &[Corrected; 2],
) {
    let mut walk = SearchSpace { subdomain, table, blocks: &[] }.walk(SEARCH);
    let mut nearer = Vec::new();
    let mut crossings = Crossings { balls: 0, height: 1 + children[0].height.max(children[1].height) };
    let mut found = NeighbourList::default();
    let population = u64::from(children[1].owned.end - children[0].owned.start);
    for (side, child) in children.iter().enumerate() {
        for point in child.owned.clone() {
            let (centre, radius2) = (table.positions()[point as usize], table.radii2()[point as usize]);
            let crosses = inner.split().reaches(centre, radius2, 1 - side);
            walk.visit_local(inner.number(), crosses);
            if crosses {
                crossings.balls += 1;
                found.clear();
                let ball = MovingBall { centre, radius2, own_leaf: None };
                walk.down(&inner.children()[1 - side], &ball, &mut found);
                nearer.extend(found.distances2().iter().map(|&d2| (point, d2)));
            }
        }
    }
    let mut tallies = Tallies::default();
    tallies.add(cx, Phase::Neighbours, &walk.into_counts());
    let march = March::of::<P>(cx.config(), Crossed { population, crossings });
    cx.facts(inner.id()).punts += u64::from(march == March::Punt);
    tallies.charge_pass(cx, inner.id().level(), march);
    for (point, d2) in nearer {
        let radius2 = &mut table.owned_radii2_mut()[point as usize];
        *radius2 = radius2.min(d2);
    }
}
