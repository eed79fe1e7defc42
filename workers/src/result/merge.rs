//! The merged triangulation: results up the tree, node by node; cells to where they are written.
//!
//! A cell belongs to its lexicographically smallest vertex, so the union of the leaves' cells has none
//! twice. What goes up the tree is each subproblem's merged result: counts and the certificate's clauses.
//! The cells themselves travel once, from their worker to the coordinator.

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::incremental::MARKS;
use septet_geometry::measure::Diameters;
use septet_geometry::point::{Point, Simplex, lex_cmp};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{COORDINATOR, NodeId, Phase};
use septet_protocol::message::{Body, Merged, Message};

use crate::config::{Task, map_in};
use crate::direct::border::ones;
use crate::direct::piece::{Piece, smallest_of};
use crate::partition::leader::by_node;
use crate::schedule::Outcome;
use crate::stars::check::Disagreement;
use crate::state::subdomain::Tree;
use crate::worker::{Worker, finite_cell};

/// Indices in a message of cells before it is sent.
pub const CELLS_PER_MESSAGE: usize = 1 << 20;

/// Across a facet of a piece's cell: outer space.
pub const HULL: u32 = u32::MAX;

/// Across a facet of a piece's cell: a cell of another piece. Numbers of cells are smaller.
pub const SEAM: u32 = MARKS;

impl<P: Point> Worker<P> {
    pub(crate) fn begin_merge(&mut self) {
        let phase = self.exchange.merge_phase();
        self.exchange.merges += 1;
        let disagreements = self.finish_check();
        if let Some(own) = self.stars.piece().map(Piece::merged) {
            self.merge_up(phase, &[own], &disagreements);
            return;
        }
        let groups = self.home_groups();
        let results = map_in(&self.pool, &groups, |(_, homes)| {
            let (mut sum, mut sweep) = (Merged::default(), Sweep::default());
            let (mut diameters, mut owned) = (Diameters::default(), Vec::with_capacity(homes.len()));
            for home in homes.clone() {
                let (star, cells) = self.merge_star(home, &mut diameters, &mut sweep);
                sum.join(&star);
                owned.push(cells);
            }
            (sum, sweep, owned)
        });
        self.exchange.owned.clear();
        let mut merged = vec![(Merged::default(), Sweep::default()); self.subdomain.leaves.len()];
        for ((at, _), (sum, sweep, owned)) in groups.into_iter().zip(results) {
            self.exchange.owned.extend(owned);
            merged[at].0.join(&sum);
            merged[at].1.join(&sweep);
        }
        for (leaf, (_, sweep)) in self.subdomain.leaves.iter().zip(&merged) {
            let mut cost = Cost::ZERO;
            cost.swept(*sweep);
            self.ledger.charge(phase, leaf.id, cost, sweep.items());
        }
        let merged: Vec<Merged> = merged.into_iter().map(|m| m.0).collect();
        self.merge_up(phase, &merged, &disagreements);
    }

    /// Merges the leaves' results up this worker's own subtree and sends what comes of it.
    fn merge_up(&mut self, phase: Phase, leaves: &[Merged], disagreements: &[Disagreement]) {
        let Some((root, tree)) = &self.subdomain.tree else { return };
        let mut charges = Vec::new();
        let mut all = merge_tree(tree, leaves, &mut charges);
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
        self.exchange.cells = all.cells;
        self.send_merged(root, all);
    }

    /// What a star contributes; and a bit for each of its first 64 facets, set where the cell belongs to its vertex.
    pub(crate) fn merge_star(
        &self,
        home: u32,
        diameters: &mut Diameters,
        sweep: &mut Sweep,
    ) -> (Merged, u64) {
        let positions = self.table.positions.as_slice();
        let (at, link) = (positions[home as usize], self.stars.link(home));
        let (mut finite, mut smallest_of, mut hull_facets) = (0u64, 0u64, 0u64);
        let (mut has_smaller, mut owned, mut bit) = (false, 0, 1u64);
        // Of every facet each vertex is looked at.
        sweep.visit_lanes(P::DIM * link.len());
        sweep.each(link, |facet| {
            let (is_smallest, is_finite) = look_at_facet(positions, &at, facet);
            has_smaller |= !is_smallest;
            finite += u64::from(is_finite);
            let is_owned = u64::from(is_smallest && is_finite);
            smallest_of += is_owned;
            owned |= bit * is_owned;
            // Behind the last there is none.
            bit <<= 1;
            hull_facets += u64::from(is_smallest && !is_finite);
        });
        let repaired = self.exchange.repaired.contains(&home);
        let known = self.supergraph().separator_radius(self.table.radii2[home as usize]);
        let provable =
            !repaired && finite == link.len() as u64 && diameters.are_at_most(positions, home, link, known);
        let merged = Merged {
            repaired: u64::from(repaired),
            stars: u64::from(finite > 0),
            cells: smallest_of,
            hull_facets,
            minima: u64::from(!has_smaller),
            local: u64::from(provable),
            ..Merged::default()
        };
        (merged, owned)
    }

    fn send_merged(&mut self, node: NodeId, merged: Merged) {
        match node.parent() {
            None => self.out.send(COORDINATOR, node, 0, Body::Merged(merged)),
            Some(parent) => {
                if let Some(shared) = self.subdomain.path.iter().find(|s| s.id == parent) {
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
        if self.config.task != Task::Delaunay && self.config.until.is_none() {
            self.send_selected();
        } else if self.known.outcome == Outcome::Passed && self.config.until.is_none() {
            if self.config.view > 0 {
                self.see_piece();
                self.send_view();
            }
            self.send_cells();
        }
        // The ledger follows in the next step, when the cells are billed.
        self.out.send(self.rank, NodeId::ROOT, 0, Body::Outcome(0));
    }

    /// Pictures show radii and stars of a piece too.
    fn see_piece(&mut self) {
        if let Some(piece) = self.stars.piece() {
            let radii2 = piece.nearest_edges();
            self.table.with_radii();
            self.table.radii2[..radii2.len()].copy_from_slice(&radii2);
            self.stars.show();
        }
    }

    fn send_cells(&mut self) {
        if !self.config.counted {
            let piece = self.stars.take_piece();
            if self.table.home > 0 {
                self.send_piece(piece);
            }
            return;
        }
        let (mut cells, mut homes) = (Vec::new(), Vec::new());
        let (mut sent, all) = (0, self.exchange.cells as usize * (P::DIM + 1));
        for at in 0..self.subdomain.leaves.len() {
            if cells.is_empty() {
                // Leaves are far smaller than what is left of a message that is full.
                cells.reserve_exact((all - sent.min(all)).min(CELLS_PER_MESSAGE + CELLS_PER_MESSAGE / 8));
            }
            let (leaf, positions) = (self.subdomain.leaves[at].id.0, self.table.positions.as_slice());
            let before = sent + cells.len();
            for home in self.subdomain.leaves[at].home() {
                let (x, link) = (positions[home as usize], self.stars.link(home));
                // Most cells belong to another vertex. Merging has told which, of as many as there are bits.
                let (first, rest) = link.split_at(link.len().min(u64::BITS as usize));
                let told = ones(self.exchange.owned[home as usize]).map(|at| &first[at]);
                let looked = rest.iter().filter(|facet| look_at_facet(positions, &x, facet) == (true, true));
                for cell in told.chain(looked).filter_map(|facet| finite_cell::<P>(home, facet)) {
                    cells.extend(cell.as_ref().iter().map(|&v| self.table.ids[v as usize]));
                    if self.config.with_leaves {
                        homes.push(leaf);
                    }
                }
            }
            // Leaves are small: their cells stay together, so that how many messages there are is told by the
            // leaves' counts.
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

    /// The cells that belong to this worker, with their adjacency.
    fn send_piece(&mut self, piece: Option<Piece<P>>) {
        let (rows, open) = match piece {
            Some(piece) => piece.into_rows(),
            None => self.glued(),
        };
        let body = Body::Piece {
            leaf: self.subdomain.leaves.first().map_or(NodeId::ROOT, |l| l.id).0,
            ids: Bulk(std::mem::take(&mut self.table.ids)),
            rows: Bulk(rows),
            open: Bulk(open),
        };
        self.out.send(COORDINATOR, NodeId::ROOT, 0, body);
    }

    /// The same from stars that were written out: facets are matched. What has no partner here is marked as
    /// another piece's, although it may be the hull's.
    fn glued(&self) -> (Vec<u32>, Vec<u32>) {
        let positions = &self.table.positions;
        let mut cells = Vec::new();
        for home in 0..self.table.home {
            let own = self.stars.link(home).iter().filter_map(|facet| finite_cell::<P>(home, facet));
            own.filter(|cell| smallest_of(positions, cell) == home)
                .for_each(|c| cells.extend_from_slice(c.as_ref()));
        }
        let corners = P::DIM + 1;
        let mut facets: Vec<(P::Facet, u32)> = (0..cells.len())
            .map(|entry| {
                let mut facet = P::Facet::splat(0);
                let cell = &cells[entry / corners * corners..][..corners];
                let others = cell.iter().enumerate().filter(|&(slot, _)| slot != entry % corners);
                facet.as_mut().iter_mut().zip(others).for_each(|(to, (_, &v))| *to = v);
                facet.as_mut().sort_unstable();
                (facet, entry as u32)
            })
            .collect();
        facets.sort_unstable();
        let mut neighbours = vec![SEAM; cells.len()];
        for pair in facets.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, a), (_, b)] = pair {
                neighbours[a as usize] = b / corners as u32;
                neighbours[b as usize] = a / corners as u32;
            }
        }
        let across = || neighbours.chunks_exact(corners);
        let open = (0..).zip(across()).filter(|(_, across)| across.contains(&SEAM)).map(|(cell, _)| cell);
        let rows = cells.chunks_exact(corners).zip(across());
        (rows.flat_map(|(cell, across)| cell.iter().chain(across)).copied().collect(), open.collect())
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

/// Two questions of a facet of a home point's link: is no finite vertex of it lexicographically smaller than the point, and
/// are all its vertices finite? The first is told by first coordinates, unless the least is the point's own.
#[inline]
fn look_at_facet<P: Point>(positions: &[P], at: &P, facet: &P::Facet) -> (bool, bool) {
    let (mut least, mut is_finite) = (f64::INFINITY, true);
    for &v in facet.as_ref() {
        let x = positions.get(v as usize).map_or(f64::INFINITY, |x| x.coord(0));
        least = if x < least { x } else { least };
        is_finite &= v != INFINITE;
    }
    let first = at.coord(0);
    (least > first || (least == first && has_none_smaller(positions, at, facet)), is_finite)
}

/// Is none of a facet's finite vertices lexicographically smaller than a point?
fn has_none_smaller<P: Point>(positions: &[P], at: &P, facet: &P::Facet) -> bool {
    let is_smaller = |&v: &u32| v != INFINITE && lex_cmp(&positions[v as usize], at).is_lt();
    !facet.as_ref().iter().any(is_smaller)
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

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    /// Asks of every facet, infinite ones too, of some points, against what the order of the points says.
    fn facets_are_told_by_the_order<P: Point>(points: &[P], facets: &[P::Facet]) {
        for at in points {
            for facet in facets {
                let finite: Vec<&P> = facet.as_ref().iter().filter_map(|&v| points.get(v as usize)).collect();
                let is_smallest = finite.iter().all(|x| !lex_cmp(*x, at).is_lt());
                let expected = (is_smallest, finite.len() == P::DIM);
                assert_eq!(look_at_facet(points, at, facet), expected, "{at:?} {facet:?}");
            }
        }
    }

    /// The corners of the unit cube and infinity: many first coordinates are equal.
    #[test]
    fn facets_in_space() {
        let points: Vec<DVec3> =
            (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        let vertices = || (0..8u32).chain([INFINITE]);
        let pairs = vertices().flat_map(|a| vertices().map(move |b| (a, b)));
        let facets: Vec<[u32; 3]> = pairs.flat_map(|(a, b)| vertices().map(move |c| [a, b, c])).collect();
        facets_are_told_by_the_order(&points, &facets);
    }

    #[test]
    fn facets_in_the_plane() {
        let points: Vec<DVec2> = (0..4).map(|i| DVec2::new(f64::from(i & 1), f64::from(i >> 1))).collect();
        let vertices = || (0..4u32).chain([INFINITE]);
        let facets: Vec<[u32; 2]> = vertices().flat_map(|a| vertices().map(move |b| [a, b])).collect();
        facets_are_told_by_the_order(&points, &facets);
    }
}
