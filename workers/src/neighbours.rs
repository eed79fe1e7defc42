//! Neighbourhood balls: radii inside every leaf, then the descent; nearest neighbours (Section 4.3), and
//! the k nearest where the supergraph is that of Section 4.5.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Marks, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::{Found, keep_nearest, nearest_direct};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::config::{Correction, SetRule, map_in};
use crate::query::{Ask, Ball};
use crate::worker::Worker;

/// A ball with a radius above this multiple of its leaf's median probes first.
const PUNT_RADIUS: f64 = 4.0;

impl<P: Point> Worker<P> {
    /// Radii inside every leaf.
    pub(crate) fn begin_radii(&mut self) {
        let lists = self.leaf_lists(1, Phase::Radii);
        for (radius2, list) in self.table.radii2.iter_mut().zip(lists.iter()) {
            *radius2 = list.first().map_or(f64::INFINITY, |f| f.0);
        }
    }

    /// For every home point, its `k` nearest in its leaf.
    fn leaf_lists(&mut self, k: usize, phase: Phase) -> Lists<Found> {
        let (table, site, fault) = (&self.table, self.out.site(), self.config.fault);
        let results = map_in(&self.pool, &self.leaves, |leaf| {
            let _span = site.subproblem(phase, leaf.id, "leaf lists", leaf.home_len());
            let members: Vec<u32> = leaf.home().collect();
            let mut cost = Cost::ZERO;
            let all = |_| f64::INFINITY;
            let lists = nearest_direct(&table.positions, &members, &members, k, all, &mut cost);
            let cost = fault.and_then(|fault| fault.charge_of_radii(&members)).unwrap_or(cost);
            (lists, cost, (members.len() * members.len()) as u64)
        });
        let mut lists = Lists::default();
        for (leaf, (found, cost, items)) in self.leaves.iter().zip(results) {
            self.ledger.charge(phase, leaf.id, cost, items);
            lists.append(found);
        }
        lists
    }

    /// The punt: balls far larger than their leaf's median.
    pub(crate) fn begin_probe(&mut self) {
        let balls = self.balls(|worker, home| worker.table.radii2[home as usize], true);
        self.launch(Ask { wanted: 1, probe: true, own_leaf: false }, &balls, None);
    }

    /// Balls of home points; of all, or of those that probe.
    fn balls(&self, radius2: impl Fn(&Self, u32) -> f64, large_only: bool) -> Vec<Ball> {
        let mut balls = Vec::new();
        for (at, leaf) in self.leaves.iter().enumerate() {
            let radii: Vec<f64> = leaf.home().map(|h| radius2(self, h)).collect();
            let limit = if large_only { punt_limit(&radii) } else { f64::NEG_INFINITY };
            for (home, &r2) in leaf.home().zip(&radii) {
                if r2 > limit || (large_only && r2 == f64::INFINITY) {
                    balls.push(Ball { home, leaf: at, radius2: r2 });
                }
            }
        }
        balls
    }

    /// The probes' results, then all balls.
    pub(crate) fn begin_neighbours(&mut self) {
        self.shrink(Phase::Probe);
        let balls = self.balls(|worker, home| worker.table.radii2[home as usize], false);
        self.launch(Ask { wanted: 1, probe: false, own_leaf: false }, &balls, None);
    }

    /// Takes nearer neighbours found elsewhere.
    pub(crate) fn shrink(&mut self, phase: Phase) {
        if phase == Phase::Neighbours && self.config.correction == Correction::Naive {
            return self.finish_correction();
        }
        for (home, list) in self.land(phase).iter() {
            let radius2 = &mut self.table.radii2[home as usize];
            for &(d2, _) in list {
                *radius2 = radius2.min(d2);
            }
        }
    }

    fn k(&self) -> usize {
        match self.supergraph() {
            Supergraph::Knn { k } => k as usize,
            _ => 1,
        }
    }

    /// The `k` nearest inside every leaf.
    pub(crate) fn begin_knn_radii(&mut self) {
        self.finish_choice();
        let k = self.k();
        self.adjacency = Lists::default();
        let lists = self.leaf_lists(k, Phase::KnnRadii);
        self.exchange.knn = lists;
    }

    /// Squared distance of the k-th of a list, infinite if it is short.
    fn kth(&self, list: &[Found]) -> f64 {
        let k = self.k();
        if list.len() < k { f64::INFINITY } else { list.iter().map(|f| f.0).fold(0.0, f64::max) }
    }

    /// The punt of the k-nearest balls.
    pub(crate) fn begin_knn_probe(&mut self) {
        let radii: Vec<f64> = self.exchange.knn.iter().map(|list| self.kth(list)).collect();
        // The lists stay for the balls that follow: a probe's own list is looked up when it lands.
        let balls = self.balls(|_, home| radii[home as usize], true);
        let wanted = self.k() as u32;
        self.launch(Ask { wanted, probe: true, own_leaf: false }, &balls, None);
    }

    /// All k-nearest balls. A ball starts from its own leaf's list alone: what a probe found is found
    /// again, so that no leaf answers twice; only the radius it gave is kept.
    pub(crate) fn begin_knn(&mut self) {
        let mut radii: Vec<f64> = self.exchange.knn.iter().map(|list| self.kth(list)).collect();
        let k = self.k();
        for (home, list) in self.land(Phase::KnnProbe).iter() {
            let (at, mut list) = (home as usize, list.to_vec());
            list.extend_from_slice(&self.exchange.knn[at]);
            radii[at] = radii[at].min(keep_nearest(&mut list, k, f64::INFINITY));
        }
        let lists = std::mem::take(&mut self.exchange.knn);
        let balls = self.balls(|_, home| radii[home as usize], false);
        let wanted = self.k() as u32;
        self.launch(Ask { wanted, probe: false, own_leaf: false }, &balls, Some(&lists));
    }

    /// Keeps the k-nearest lists as graph neighbours, and their radii.
    pub(crate) fn finish_knn(&mut self) {
        if !matches!(self.supergraph(), Supergraph::Knn { .. }) {
            return;
        }
        let done = self.land(Phase::Knn);
        let mut adjacency = Lists::default();
        for (home, list) in done.by_home(self.table.home).enumerate() {
            self.table.radii2[home] = self.kth(list);
            adjacency.push(list.iter().map(|f| f.1));
        }
        self.adjacency = adjacency;
        if self.config.sets == SetRule::Ghost {
            self.send_reverse();
        }
    }

    /// The other end of every edge: `j` is told that it is among the nearest of `i`.
    fn send_reverse(&mut self) {
        let mut batches: BTreeMap<Rank, (PointBatch<P>, Vec<u64>)> = BTreeMap::new();
        for leaf in &self.leaves {
            let mut edges = Sweep::default();
            for home in leaf.home() {
                edges.each(&self.adjacency[home as usize], |&j| {
                    if self.table.is_home(j) {
                        self.sets.reverse.push((j, home));
                    } else {
                        let (points, targets) = batches.entry(self.table.owners[j as usize]).or_default();
                        self.table.export(home, points);
                        targets.push(self.table.ids[j as usize]);
                    }
                });
            }
            let mut cost = Cost::ZERO;
            cost.swept(edges);
            self.ledger.charge(Phase::Sets, leaf.id, cost, edges.items());
        }
        if let Some(mut recorder) = self.recorder.take() {
            for &(j, i) in &self.sets.reverse {
                recorder.reverse(self.leaf_number(i), self.leaf_number(j));
            }
            self.recorder = Some(recorder);
        }
        for (to, (points, targets)) in batches {
            let body = Body::Reverse { points, targets: Bulk(targets) };
            self.out.send(to, NodeId::ROOT, 0, body);
        }
    }

    pub(crate) fn on_reverse(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Reverse { points, targets } => {
                received.push((std::mem::take(points), std::mem::take(&mut targets.0)));
                false
            }
            _ => true,
        });
        for (points, targets) in received {
            // The sender's own points.
            let numbers = self.table.receive_all(&points);
            for (number, target) in numbers.into_iter().zip(targets) {
                if let Some(home) = self.table.find_home(target) {
                    self.sets.reverse.push((home, number));
                }
            }
        }
    }
}

impl<P: Point> Worker<P> {
    /// The edges of every leaf's points from both ends, multiple edges deleted: those that were told are sorted
    /// by the point they are told to.
    pub(crate) fn unite_reverse(&mut self) {
        let told = std::mem::take(&mut self.sets.reverse);
        // Delivery to the leaves; within each the order is charged.
        let mut told_to = vec![Vec::new(); self.leaves.len()];
        let mut leaf_of = Vec::with_capacity(self.table.home as usize);
        for (at, leaf) in (0u32..).zip(&self.leaves) {
            leaf_of.extend(leaf.home().map(|_| at));
        }
        for edge in told {
            told_to[leaf_of[edge.0 as usize] as usize].push(edge);
        }
        let mut united = Lists::default();
        let (mut list, mut seen) = (Vec::new(), Marks::new(self.table.positions.len()));
        for (leaf, told) in self.leaves.iter().zip(told_to) {
            let mut cost = Cost::ZERO;
            let own =
                cost.sorted_by_place(&told, |edge| (edge.0 - leaf.start) as usize, leaf.home_len() as usize);
            let homes: Vec<u32> = leaf.home().collect();
            let mut rest = own.as_slice();
            cost.map_nested(&homes, |&home, inner| {
                let (segment, others) = rest.split_at(rest.iter().take_while(|edge| edge.0 == home).count());
                rest = others;
                list.clear();
                list.extend_from_slice(&self.adjacency[home as usize]);
                list.extend(segment.iter().map(|edge| edge.1));
                inner.distinct_numbers(&mut list, &mut seen);
                united.push(list.iter().copied());
            });
            self.ledger.charge(Phase::Graph, leaf.id, cost, 0);
            self.ledger.facts(leaf.id).members += leaf.home_len();
        }
        self.adjacency = united;
    }
}

/// Squared radius above which a ball of this leaf probes.
fn punt_limit(radii2: &[f64]) -> f64 {
    if radii2.is_empty() {
        return f64::INFINITY;
    }
    let mut sorted = radii2.to_vec();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    PUNT_RADIUS * PUNT_RADIUS * median
}
