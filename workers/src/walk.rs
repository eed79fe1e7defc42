//! Balls on their way through what one worker knows of the tree: its path of shared nodes, and its own piece.

use septet_geometry::blocks::Blocks;
use septet_geometry::columns::Columns;
use septet_geometry::cost::Sweep;
use septet_geometry::found::FoundList;
use septet_geometry::point::Point;
use septet_protocol::ids::NodeId;

use crate::query::Ask;
use crate::tasks::Reach;
use crate::tree::{Bounds, Leaf, Shared, Split, Tree};
use crate::worker::Worker;

/// One walk of balls through what a worker knows of the tree, with its own counters.
pub(crate) struct Walk<'a, P: Point> {
    path: &'a [Shared<P>],
    leaves: &'a [Leaf<P>],
    homes: &'a Columns<P>,
    /// Of each leaf, if there are lists to be found.
    blocks: &'a [Blocks<P>],
    ask: Ask,
    around: Around<P>,
    counts: Counts,
}

/// A ball around all balls of the leaf at hand. Where it does not cross a separator none of them does, which is asked
/// once, of the shared nodes and of the worker's own.
struct Around<P> {
    centre: P,
    radius: f64,
    shared: Vec<Option<bool>>,
    local: Vec<Option<bool>>,
}

impl<P: Point> Around<P> {
    fn enter(&mut self, (low, high): Bounds<P>, largest2: f64) {
        self.centre = low + (high - low) * 0.5;
        // Rounding is far below what is added.
        self.radius = ((high - low).norm2().sqrt() * 0.5 + largest2.sqrt()) * (1.0 + 1e-9);
        self.shared.fill(None);
        self.local.fill(None);
    }
}

/// Does the ball around the balls of a leaf cross a separator?
fn meets<P: Point>(known: &mut Option<bool>, centre: P, radius: f64, split: &Split<P>) -> bool {
    *known.get_or_insert_with(|| split.separator.crosses(centre, radius))
}

/// A ball under way.
#[derive(Clone, Copy)]
pub(crate) struct Probe<P> {
    pub(crate) centre: P,
    pub(crate) radius2: f64,
    /// The leaf where it is at home, if that lies below.
    pub(crate) home: Option<NodeId>,
}

/// What a walk counted.
pub(crate) struct Counts {
    /// For each shared node of the path, the balls that came down and those that went to both sides.
    pub(crate) shared: Vec<(Sweep, Sweep)>,
    /// The same for each inner node of the worker's own piece.
    pub(crate) local: Vec<(Sweep, Sweep)>,
    /// Pairs and visits of each leaf.
    pub(crate) at_leaf: Vec<(Sweep, u64)>,
    pub(crate) reach: Reach,
}

impl<P: Point> Walk<'_, P> {
    /// Balls of this leaf are next, the largest of this squared radius.
    pub(crate) fn start(&mut self, leaf: usize, largest2: f64) {
        self.counts.reach.start(leaf);
        self.around.enter(self.leaves[leaf].bounds, largest2);
    }

    /// What it counted, once it is over.
    pub(crate) fn into_counts(self) -> Counts {
        self.counts
    }

    /// A ball is looked at by an inner node of the worker's own, and goes to both of its sides or not.
    pub(crate) fn visit_local(&mut self, number: usize, both: bool) {
        self.counts.local[number].0.visit();
        if both {
            self.counts.local[number].1.visit();
        }
    }

    /// Which children a ball goes to, if any ball of its leaf `meets` the separator.
    fn sides(&self, id: NodeId, split: &Split<P>, ball: &Probe<P>, meets: bool) -> [bool; 2] {
        match ball.home {
            Some(leaf) => {
                let home = id.side_of(leaf);
                let mut sides = [true; 2];
                sides[1 - home] = meets && split.reaches(ball.centre, ball.radius2, 1 - home);
                sides
            }
            None if self.ask.probe => {
                let mut sides = [false; 2];
                sides[split.side(ball.centre)] = true;
                sides
            }
            None => [0, 1].map(|side| split.reaches(ball.centre, ball.radius2, side)),
        }
    }

    /// Follows the shared nodes from position `start`; collects the ways out of them. Does the ball
    /// reach this worker's own piece?
    pub(crate) fn along_path(
        &mut self,
        start: usize,
        ball: &Probe<P>,
        out: &mut Vec<(usize, usize)>,
    ) -> bool {
        for i in start..self.path.len() {
            let shared = &self.path[i];
            let Around { centre, radius, .. } = self.around;
            let meets = meets(&mut self.around.shared[i], centre, radius, &shared.split);
            let sides = self.sides(shared.id, &shared.split, ball, meets);
            self.counts.shared[i].0.visit();
            if sides[0] && sides[1] {
                self.counts.shared[i].1.visit();
            }
            let goes_on = sides[shared.mine] && shared.goes_on;
            for side in (0..2).filter(|&side| sides[side]) {
                if side != shared.mine || !goes_on {
                    out.push((i, side));
                }
            }
            if !goes_on {
                return false;
            }
        }
        true
    }

    pub(crate) fn down(&mut self, tree: &Tree<P>, ball: &Probe<P>, found: &mut FoundList) {
        match tree {
            Tree::Leaf(at) => self.at_leaf(*at, ball, found),
            Tree::Node(inner) => {
                let here = Probe { home: ball.home.filter(|&leaf| inner.id.contains(leaf)), ..*ball };
                let Around { centre, radius, .. } = self.around;
                let meets = meets(&mut self.around.local[inner.number], centre, radius, &inner.split);
                let sides = self.sides(inner.id, &inner.split, &here, meets);
                self.counts.local[inner.number].0.visit();
                if sides[0] && sides[1] {
                    self.counts.local[inner.number].1.visit();
                }
                for (side, child) in inner.children.iter().enumerate() {
                    if sides[side] {
                        let on_way = here.home.filter(|&leaf| inner.id.side_of(leaf) == side);
                        let before = found.len();
                        self.down(child, &Probe { home: on_way, ..here }, found);
                        if on_way.is_none() {
                            let wanted = self.ask.wanted as usize;
                            self.counts.reach.found(
                                inner.id.child(side),
                                &found.as_slice()[before..],
                                wanted,
                                ball.radius2,
                            );
                        }
                    }
                }
            }
        }
    }

    fn at_leaf(&mut self, at: usize, ball: &Probe<P>, found: &mut FoundList) {
        let leaf = &self.leaves[at];
        if ball.home == Some(leaf.id) && !self.ask.own_leaf {
            return;
        }
        let (pairs, visits) = &mut self.counts.at_leaf[at];
        *visits += 1;
        if let Some(blocks) = self.blocks.get(at) {
            pairs.each_in_blocks(blocks, ball.centre, ball.radius2, leaf.start, found);
            return;
        }
        let homes = leaf.start as usize..leaf.end as usize;
        let mut limit2 = ball.radius2;
        let nearest_only = self.ask.wanted == 1;
        pairs.each_distance(self.homes, homes, ball.centre, limit2, |at, d2| {
            // No two points coincide: distance zero is the centre itself.
            if d2 > 0.0 {
                found.push((d2, leaf.start + at as u32));
                limit2 = if nearest_only { d2 } else { limit2 };
            }
            limit2
        });
    }
}

impl<P: Point> Worker<P> {
    /// A walk that has counted nothing yet.
    pub(crate) fn walk(&self) -> Walk<'_, P> {
        Walk {
            path: &self.path,
            leaves: &self.leaves,
            homes: self.table.columns(),
            blocks: &self.exchange.blocks,
            ask: self.engine.ask(),
            around: Around {
                centre: P::default(),
                radius: f64::INFINITY,
                shared: vec![None; self.path.len()],
                local: vec![None; self.inner_ids.len()],
            },
            counts: Counts {
                shared: vec![Default::default(); self.path.len()],
                local: vec![Default::default(); self.inner_ids.len()],
                at_leaf: vec![Default::default(); self.leaves.len()],
                reach: Reach::new(self.recorder.is_some()),
            },
        }
    }
}
