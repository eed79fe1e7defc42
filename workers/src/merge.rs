//! The merged triangulation: results up the tree, node by node; cells to where they are written.
//!
//! A cell belongs to its lexicographically smallest vertex, so the union of the leaves' cells has none
//! twice. What goes up the tree is each subproblem's merged result: counts and the certificate's clauses.
//! The cells themselves travel once, from their worker to the coordinator.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::measure::circumradius2;
use septet_geometry::point::{Point, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::message::{Body, Merged, Message};

use crate::choice::ALPHAS;
use crate::config::map_in;
use crate::leader::by_node;
use crate::schedule::Outcome;
use crate::tree::Tree;
use crate::worker::{Worker, finite_cell};

/// Indices in a message of cells before it is sent.
pub const CELLS_PER_MESSAGE: usize = 1 << 20;

impl<P: Point> Worker<P> {
    pub(crate) fn begin_merge(&mut self) {
        let phase = self.exchange.merge_phase();
        self.exchange.merges += 1;
        let disagreements = self.finish_check();
        let groups = self.home_groups();
        let results = map_in(&self.pool, &groups, |(_, homes)| {
            let (mut sum, mut sweep) = (Merged::default(), Sweep::default());
            for home in homes.clone() {
                sum.join(&self.merge_star(home, &mut sweep));
            }
            (sum, sweep)
        });
        let mut merged = vec![(Merged::default(), Sweep::default()); self.leaves.len()];
        for ((at, _), (sum, sweep)) in groups.into_iter().zip(results) {
            merged[at].0.join(&sum);
            merged[at].1.join(&sweep);
        }
        for (leaf, (_, sweep)) in self.leaves.iter().zip(&merged) {
            let mut cost = Cost::ZERO;
            cost.swept(*sweep);
            self.ledger.charge(phase, leaf.id, cost, sweep.items());
        }
        let merged: Vec<Merged> = merged.into_iter().map(|m| m.0).collect();
        let Some((root, tree)) = &self.tree else { return };
        let mut charges = Vec::new();
        let mut all = merge_tree(tree, &merged, &mut charges);
        let root = *root;
        let tally = self.ledger.tally(self.out.round(), Phase::Merge);
        tally.merged += charges.len() as u64;
        for (node, cost) in charges {
            self.ledger.charge(phase, node, cost, 0);
        }
        // Fingerprints that differ although the lists agree would be a collision in the lists.
        let unexplained = if disagreements.is_empty() { self.agreement.differing } else { 0 };
        all.disagreements += disagreements.len() as u64 + unexplained;
        all.exchange_rounds = u64::from(self.exchange.rounds);
        self.send_merged(root, all);
    }

    /// What a star contributes.
    pub(crate) fn merge_star(&self, home: u32, sweep: &mut Sweep) -> Merged {
        let positions = &self.table.positions;
        let at = positions[home as usize];
        let smaller = |v: u32| lex_cmp(&positions[v as usize], &at).is_lt();
        let mut own = Merged::default();
        let mut has_smaller = false;
        let mut largest2: f64 = 0.0;
        sweep.each(self.stars.link(home), |facet| {
            let below = facet.as_ref().iter().any(|&v| v != INFINITE && smaller(v));
            has_smaller |= below;
            if let Some(cell) = finite_cell::<P>(home, facet) {
                own.stars = 1;
                own.cells += u64::from(!below);
                let mut corners = [at; 4];
                for (corner, &v) in corners.iter_mut().zip(cell.as_ref()) {
                    *corner = positions[v as usize];
                }
                largest2 = largest2.max(circumradius2(&corners[..=P::DIM]));
            } else {
                own.hull_facets += u64::from(!below);
                largest2 = f64::INFINITY;
            }
        });
        let known = match self.supergraph() {
            // The piece's triangulation knows no k-nearest ball: the largest alpha that is tried.
            Supergraph::Knn { .. } if !self.config.counted => Supergraph::Density { alpha: ALPHAS[3] },
            supergraph => supergraph,
        };
        let known = known.separator_radius(self.table.radii2[home as usize]);
        own.minima = u64::from(!has_smaller);
        own.repaired = u64::from(self.exchange.repaired.contains(&home));
        let provable = largest2.is_finite() && 4.0 * largest2 <= known * known;
        own.local = u64::from(own.repaired == 0 && provable);
        own
    }

    fn send_merged(&mut self, node: NodeId, merged: Merged) {
        match node.parent() {
            None => self.out.send(COORDINATOR, node, 0, Body::Merged(merged)),
            Some(parent) => {
                if let Some(shared) = self.path.iter().find(|s| s.id == parent) {
                    self.out.send(shared.leader, node, 0, Body::Merged(merged));
                }
            }
        }
    }

    pub(crate) fn on_merge(&mut self, inbox: &mut Vec<Message<P>>) {
        let phase = if self.exchange.merges > 1 { Phase::Certificate } else { Phase::Merge };
        let below = by_node(inbox, |m| match m.body {
            Body::Merged(merged) => Some((m.round, merged)),
            _ => None,
        });
        for (child, all) in below {
            for (round, merged) in all {
                let joined = self.leader.on_merged(child, merged, phase, self.out.site(), &mut self.ledger);
                if let Some((node, own)) = joined {
                    self.ledger.tally(round, Phase::Merge).merged += 1;
                    self.send_merged(node, own);
                }
            }
        }
        let known = &mut self.known;
        inbox.retain(|m| match m.body {
            Body::Outcome(n) => {
                known.outcome = Outcome::from_number(n).unwrap_or_default();
                false
            }
            _ => true,
        });
    }

    /// Sends the cells this worker owns, as rows of ids, then its ledger.
    pub(crate) fn begin_collect(&mut self) {
        if self.config.until == Some(Phase::Neighbours) {
            // The answers of a descent are landed, and charged, by the phase that uses them: here this one.
            self.shrink(Phase::Neighbours);
        }
        if self.known.outcome == Outcome::Passed && self.config.until.is_none() {
            self.send_cells();
            self.send_view();
        }
        // The ledger follows in the next step, when the cells are billed.
        self.out.send(self.rank, NodeId::ROOT, 0, Body::Outcome(0));
    }

    fn send_cells(&mut self) {
        let (mut cells, mut homes) = (Vec::new(), Vec::new());
        let mut sent = 0;
        for at in 0..self.leaves.len() {
            let leaf = self.leaves[at].id.0;
            let before = sent + cells.len();
            for home in self.leaves[at].home() {
                let x = self.table.positions[home as usize];
                for facet in self.stars.link(home) {
                    let Some(cell) = finite_cell::<P>(home, facet) else { continue };
                    let is_smallest = |&v: &u32| lex_cmp(&x, &self.table.positions[v as usize]).is_lt();
                    if facet.as_ref().iter().all(is_smallest) {
                        cells.extend(cell.as_ref().iter().map(|&v| self.table.ids[v as usize]));
                        if self.config.with_leaves {
                            homes.push(leaf);
                        }
                    }
                }
                // Leaves of a counted run are small: their cells stay together, so that how many messages
                // there are is told by the leaves' counts.
                if !self.config.counted && cells.len() >= CELLS_PER_MESSAGE {
                    sent += cells.len();
                    self.post_cells(std::mem::take(&mut cells), std::mem::take(&mut homes));
                }
            }
            let own = (sent + cells.len() - before) / (P::DIM + 1);
            if let Some(recorder) = &mut self.recorder {
                recorder.log.cells.push(own as u64);
            }
            if cells.len() >= CELLS_PER_MESSAGE {
                sent += cells.len();
                self.post_cells(std::mem::take(&mut cells), std::mem::take(&mut homes));
            }
        }
        if !cells.is_empty() {
            self.post_cells(cells, homes);
        }
    }

    fn post_cells(&mut self, cells: Vec<u64>, leaves: Vec<u64>) {
        let body = Body::Cells { cells: Bulk(cells), leaves: Bulk(leaves) };
        self.out.send(COORDINATOR, NodeId::ROOT, 0, body);
    }

    pub(crate) fn on_collect(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut asked = false;
        inbox.retain(|m| {
            let own = matches!(m.body, Body::Outcome(_));
            asked |= own;
            !own
        });
        if asked {
            if let Some(log) = self.take_tasks() {
                self.out.send(COORDINATOR, NodeId::ROOT, 0, Body::Tasks(Box::new(log)));
            }
            if let Some(fault) = self.config.fault {
                fault.distort(&mut self.ledger);
            }
            let words = self.ledger.to_words();
            self.out.send(COORDINATOR, NodeId::ROOT, 0, Body::Ledger(Bulk(words)));
        }
    }
}

/// Merges a worker's own subtree, one charge an inner node.
fn merge_tree<P: Point>(tree: &Tree<P>, leaves: &[Merged], charges: &mut Vec<(NodeId, Cost)>) -> Merged {
    match tree {
        Tree::Leaf(at) => leaves[*at],
        Tree::Node(inner) => {
            let both = [0, 1].map(|side| merge_tree(&inner.children[side], leaves, charges));
            let mut cost = Cost::ZERO;
            let all = cost.reduce(&both, Merged::default(), |mut sum, m| {
                sum.join(m);
                sum
            });
            charges.push((inner.id, cost));
            all
        }
    }
}
