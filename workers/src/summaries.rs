//! What every subproblem holds (largest radius, lexicographically smallest point): up the tree to the
//! root, and down to the members. The radii prune the separator sets; the smallest points seed stars.

use septet_geometry::cost::Cost;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::message::{Body, Message, PointBatch, Summary};

use crate::leader::by_node;
use crate::table::Table;
use crate::tree::{Leaf, Tree};
use crate::worker::Worker;

impl<P: Point> Worker<P> {
    pub(crate) fn begin_summaries(&mut self) {
        self.shrink(Phase::Neighbours);
        self.report_frame();
        let mut charges = Vec::new();
        for leaf in &mut self.leaves {
            let radii = &self.table.radii2[leaf.start as usize..leaf.end as usize];
            let mut cost = Cost::ZERO;
            leaf.max_radius2 = cost.reduce(radii, 0.0, |m: f64, &r| m.max(r));
            charges.push((leaf.id, cost, radii.len() as u64));
        }
        let Some((root, tree)) = &mut self.tree else { return };
        let (max2, smallest) = summarise(tree, &self.leaves, &self.table, &mut charges);
        let root = *root;
        for (node, cost, items) in charges {
            self.ledger.charge(Phase::Summaries, node, cost, items);
        }
        if smallest == u32::MAX {
            return;
        }
        let mut point = PointBatch::default();
        self.table.export(smallest, &mut point);
        self.send_summary(root, Summary { max_radius2: max2, smallest: point });
    }

    /// Tells the coordinator which points of the frame are at home here.
    pub(crate) fn report_frame(&mut self) {
        let mut homes = PointBatch::default();
        for at in self.table.homes_among(&self.frame.ids.0) {
            self.table.export(at, &mut homes);
            let leaf = self.leaf_number(at);
            if let Some(recorder) = &mut self.recorder {
                recorder.log.frame.push(leaf);
            }
        }
        if !homes.is_empty() {
            self.out.send(COORDINATOR, NodeId::ROOT, 0, Body::Frame(homes));
        }
    }

    /// Learns where the points of the frame are at home.
    pub(crate) fn learn_frame(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut frames = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Frame(frame) => {
                frames.push(std::mem::take(frame));
                false
            }
            _ => true,
        });
        for frame in frames {
            for (&id, &owner) in frame.ids.iter().zip(&frame.owners.0) {
                self.table.set_owner(id, owner);
            }
            self.frame = frame;
        }
    }

    fn send_summary(&mut self, node: NodeId, summary: Summary<P>) {
        let parent = node.parent();
        if let Some(shared) = self.path.iter().find(|s| Some(s.id) == parent) {
            self.out.send(shared.leader, node, 0, Body::Summary(summary));
        }
    }

    pub(crate) fn on_summaries(&mut self, inbox: &mut Vec<Message<P>>) {
        self.learn_frame(inbox);
        let below = by_node(inbox, |m| match &mut m.body {
            Body::Summary(summary) => Some(summary.clone()),
            _ => None,
        });
        for (child, all) in below {
            for summary in all {
                let up = self.leader.on_summary(child, summary, &mut self.out, &mut self.ledger);
                if let Some((node, own)) = up {
                    self.send_summary(node, own);
                }
            }
        }
        let down = by_node(inbox, |m| match &m.body {
            Body::Children(children) => Some(children.clone()),
            _ => None,
        });
        for (node, children) in down.into_iter().flat_map(|(n, all)| all.into_iter().map(move |c| (n, c))) {
            if let Some(shared) = self.path.iter_mut().find(|s| s.id == node) {
                shared.summaries = Some(children);
            }
        }
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
            (leaf.max_radius2, leaf.home().min_by(rank).unwrap_or(u32::MAX))
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
