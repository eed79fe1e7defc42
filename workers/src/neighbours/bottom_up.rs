//! The rival of the descent: balls corrected node by node, from the leaves up.
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

use septet_geometry::found::FoundList;
use septet_geometry::point::Point;

use crate::neighbours::forwards::Forwards;
use crate::neighbours::query::Ask;
use crate::neighbours::walk::Probe;
use crate::schedule::first_level;
use crate::state::subdomain::{Inner, Tree};
use crate::worker::Worker;

const ASK: Ask = Ask { wanted: 1, probe: false, own_leaf: true };

impl<P: Point> Worker<P> {
    /// The pass of one level: nodes of this worker's own piece before the first, shared ones in their turn.
    pub(crate) fn begin_correction(&mut self) {
        let level = self.known.level;
        if level == first_level(&self.config) {
            self.correct_piece();
        } else {
            self.land_correction(level + 1);
        }
        self.ask_afresh(ASK);
        let at = self.subdomain.path.iter().position(|shared| shared.id.level() == level);
        let Some(at) = at.filter(|_| self.subdomain.tree.is_some()) else { return };
        let shared = &self.subdomain.path[at];
        let (id, other, split) = (shared.id, 1 - shared.mine, shared.split.clone());
        let mut forwards = Forwards::new(ASK);
        for home in 0..self.table.home {
            let (centre, radius2) = (self.table.positions[home as usize], self.table.radii2[home as usize]);
            let goes = split.reaches(centre, radius2, other);
            self.engine.visit(id, goes);
            if goes {
                let leaf = u64::from(self.leaf_number(home));
                forwards.add(self, &[(at, other)], centre, radius2, leaf);
                self.engine.await_answer(home, centre, radius2);
            }
        }
        forwards.send(self);
    }

    /// The last pass's results.
    pub(crate) fn finish_correction(&mut self) {
        self.land_correction(self.known.level);
    }

    fn land_correction(&mut self, level: u32) {
        let (charges, done) = self.take_landed();
        for (node, cost, items) in charges {
            self.ledger.charge_correction(level, node, cost, items);
        }
        for (home, nearest2, _) in done.iter() {
            let radius2 = &mut self.table.radii2[home as usize];
            *radius2 = radius2.min(nearest2);
        }
    }

    fn correct_piece(&mut self) {
        if let Some((root, tree)) = self.subdomain.tree.take() {
            self.correct(&tree);
            self.subdomain.tree = Some((root, tree));
        }
    }

    /// Corrects the balls of a subtree's nodes, children first; returns its home points.
    fn correct(&mut self, tree: &Tree<P>) -> std::ops::Range<u32> {
        let inner = match tree {
            Tree::Leaf(at) => return self.subdomain.leaves[*at].home(),
            Tree::Node(inner) => inner,
        };
        let homes = [0, 1].map(|side| self.correct(&inner.children[side]));
        self.correct_node(inner, &homes);
        homes[0].start..homes[1].end
    }

    fn correct_node(&mut self, inner: &Inner<P>, homes: &[std::ops::Range<u32>; 2]) {
        self.ask_afresh(ASK);
        let mut walk = self.walk();
        let mut nearer = Vec::new();
        let mut found = FoundList::default();
        for (side, range) in homes.iter().enumerate() {
            for home in range.clone() {
                let ball = Probe {
                    centre: self.table.positions[home as usize],
                    radius2: self.table.radii2[home as usize],
                    home: None,
                };
                let goes = inner.split.reaches(ball.centre, ball.radius2, 1 - side);
                walk.visit_local(inner.number, goes);
                if goes {
                    found.clear();
                    walk.down(&inner.children[1 - side], &ball, &mut found);
                    nearer.extend(found.distances2().iter().map(|&d2| (home, d2)));
                }
            }
        }
        let counts = walk.into_counts();
        self.count_walk(&counts);
        for (home, d2) in nearer {
            let radius2 = &mut self.table.radii2[home as usize];
            *radius2 = radius2.min(d2);
        }
        let (charges, _) = self.take_landed();
        for (node, cost, items) in charges {
            self.ledger.charge_correction(inner.id.level(), node, cost, items);
        }
    }
}
