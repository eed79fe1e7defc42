//! Neighbourhood balls: radii inside every leaf, then the descent; nearest neighbours (Section 4.3), and
//! the k nearest where the supergraph is that of Section 4.5.

use std::collections::BTreeMap;

use septet_geometry::blocks::Blocks;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::graph::Supergraph;
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::{nearest_direct, nearest_in_blocks};
use septet_geometry::point::{Point, dist2};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};

use crate::config::{Correction, SetRule, map_in};
use crate::neighbours::done::Done;
use crate::neighbours::query::{Ask, Ball};
use crate::state::table::Table;
use crate::worker::Worker;

/// A ball with a radius above this multiple of its leaf's median probes first.
const PUNT_RADIUS: f64 = 4.0;

impl<P: Point> Worker<P> {
    /// Radii inside every leaf.
    pub(crate) fn begin_radii(&mut self) {
        let (table, site, fault) = (&self.table, self.out.site(), self.config.fault);
        let results = map_in(&self.pool, &self.subdomain.leaves, |leaf| {
            let _span = site.subproblem(Phase::Radii, leaf.id, "leaf radii", leaf.home_len());
            let members: Vec<u32> = leaf.home().collect();
            let mut cost = Cost::ZERO;
            let all = |_| f64::INFINITY;
            let nearest = nearest_direct(&table.positions, &members, &members, 1, all, &mut cost);
            let cost = fault.and_then(|fault| fault.charge_of_radii(&members)).unwrap_or(cost);
            (nearest.kth2, cost)
        });
        let mut radii2 = Vec::with_capacity(self.table.home as usize);
        for (leaf, (nearest2, cost)) in self.subdomain.leaves.iter().zip(results) {
            self.ledger.charge(Phase::Radii, leaf.id, cost, leaf.home_len() * leaf.home_len());
            radii2.extend(nearest2);
        }
        self.table.radii2[..radii2.len()].copy_from_slice(&radii2);
    }

    /// The punt: balls far larger than their leaf's median.
    pub(crate) fn begin_probe(&mut self) {
        let balls = self.balls(|worker, home| worker.table.radii2[home as usize], true);
        self.launch(Ask { wanted: 1, probe: true, own_leaf: false }, &balls, None);
    }

    /// Balls of home points; of all, or of those that probe.
    fn balls(&self, radius2: impl Fn(&Self, u32) -> f64, large_only: bool) -> Vec<Ball> {
        let mut balls = Vec::new();
        for (at, leaf) in self.subdomain.leaves.iter().enumerate() {
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
        for (home, nearest2, _) in self.land(phase).iter() {
            let radius2 = &mut self.table.radii2[home as usize];
            *radius2 = radius2.min(nearest2);
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
        let k = self.k();
        let site = self.out.site();
        let results = map_in(&self.pool, &self.subdomain.leaves, |leaf| {
            let _span = site.subproblem(Phase::KnnRadii, leaf.id, "leaf lists", leaf.home_len());
            let blocks = Blocks::of(&self.table.positions[leaf.start as usize..leaf.end as usize]);
            let mut cost = Cost::ZERO;
            let nearest = nearest_in_blocks(&blocks, leaf.start, k, &mut cost);
            (blocks, nearest, cost)
        });
        for (leaf, (blocks, nearest, cost)) in self.subdomain.leaves.iter().zip(results) {
            self.ledger.charge(Phase::KnnRadii, leaf.id, cost, leaf.home_len() * leaf.home_len());
            self.exchange.knn.push(nearest);
            self.exchange.blocks.push(blocks);
        }
    }

    /// The punt of the k-nearest balls.
    pub(crate) fn begin_knn_probe(&mut self) {
        // The lists stay for the balls that follow: only radii come of a probe.
        let radii = self.knn_radii2();
        let balls = self.balls(|_, home| radii[home as usize], true);
        let wanted = self.k() as u32;
        let nearest = std::mem::take(&mut self.exchange.knn);
        self.launch(Ask { wanted, probe: true, own_leaf: false }, &balls, Some(&nearest));
        self.exchange.knn = nearest;
    }

    /// Squared radii of the k-nearest balls of all home points in their leaves.
    fn knn_radii2(&self) -> Vec<f64> {
        self.exchange.knn.iter().flat_map(|leaf| &leaf.kth2).copied().collect()
    }

    /// All k-nearest balls. A ball starts from its own leaf's list alone: what a probe found is found
    /// again, so that no leaf answers twice; only the radius it gave is kept.
    pub(crate) fn begin_knn(&mut self) {
        let mut radii = self.knn_radii2();
        let nearest = std::mem::take(&mut self.exchange.knn);
        for (home, kth2, _) in self.land(Phase::KnnProbe).iter() {
            let radius2 = &mut radii[home as usize];
            *radius2 = radius2.min(kth2);
        }
        let balls = self.balls(|_, home| radii[home as usize], false);
        let wanted = self.k() as u32;
        self.launch(Ask { wanted, probe: false, own_leaf: false }, &balls, Some(&nearest));
    }

    /// Keeps the k-nearest lists as graph neighbours, and their radii.
    pub(crate) fn finish_knn(&mut self) {
        if !matches!(self.supergraph(), Supergraph::Knn { .. }) {
            return;
        }
        let done = self.land(Phase::Knn);
        self.exchange.blocks = Vec::new();
        for (home, kth2, _) in done.iter() {
            self.table.radii2[home as usize] = kth2;
        }
        // By other rules the recursion finds the edges.
        if self.config.sets == SetRule::Ghost {
            self.send_reverse(done);
        }
    }

    /// The other end of every edge: `j` is told that it is among the nearest of `i`. Each worker gets `i` once.
    /// Keeps the lists of all `i` until they are united with what is told.
    fn send_reverse(&mut self, done: Done) {
        let mut batches: BTreeMap<Rank, Telling<P>> = BTreeMap::new();
        let leaf_of = self.leaf_numbers();
        let mut other_leaves = Vec::new();
        let mut recorder = self.recorder.take();
        self.sets.told = vec![Sweep::default(); self.subdomain.leaves.len()];
        let nearest = done.by_home(self.table.home);
        let (table, sets, homes) = (&self.table, &mut self.sets, leaf_of.len());
        // Of home points, all of the same length.
        let (positions, radii2) = (&table.positions[..homes], &table.radii2[..homes]);
        for (leaf, number) in self.subdomain.leaves.iter().zip(0u32..) {
            let mut edges = Sweep::default();
            for home in leaf.home() {
                let own = positions[home as usize];
                edges.each(nearest[home as usize], |&j| {
                    if let Some(&x) = positions.get(j as usize) {
                        let to = leaf_of[j as usize];
                        sets.tell((j, home), to, dist2(x, own), radii2[j as usize]);
                        if recorder.is_some() {
                            other_leaves.push(to);
                        }
                    } else {
                        let batch = batches.entry(table.owners[j as usize]).or_default();
                        batch.tell(table, home, table.ids[j as usize]);
                    }
                });
                if let Some(recorder) = &mut recorder {
                    recorder.reverse(number, &mut other_leaves);
                }
            }
            let mut cost = Cost::ZERO;
            cost.swept(edges);
            self.ledger.charge(Phase::Sets, leaf.id, cost, edges.items());
        }
        self.recorder = recorder;
        self.sets.nearest = done;
        for (to, Telling { points, counts, targets, .. }) in batches {
            let body = Body::Reverse { points, counts: Bulk(counts), targets: Bulk(targets) };
            self.out.send(to, NodeId::ROOT, 0, body);
        }
    }

    /// The leaf of each home point.
    fn leaf_numbers(&self) -> Vec<u32> {
        let mut leaf_of = Vec::with_capacity(self.table.home as usize);
        for (at, leaf) in (0u32..).zip(&self.subdomain.leaves) {
            leaf_of.extend(leaf.home().map(|_| at));
        }
        leaf_of
    }

    pub(crate) fn on_reverse(&mut self, inbox: &mut Vec<Message<P>>) {
        let mut received = Vec::new();
        inbox.retain_mut(|m| match &mut m.body {
            Body::Reverse { points, counts, targets } => {
                let lists = (std::mem::take(&mut counts.0), std::mem::take(&mut targets.0));
                received.push((std::mem::take(points), lists));
                false
            }
            _ => true,
        });
        if received.is_empty() {
            return;
        }
        let leaf_of = self.leaf_numbers();
        for (points, (counts, targets)) in received {
            // The sender's own points.
            let numbers = self.table.receive_all(&points);
            let tellers = numbers.into_iter().zip(counts);
            let tellers = tellers.flat_map(|(number, count)| std::iter::repeat_n(number, count as usize));
            for (number, target) in tellers.zip(targets) {
                if let Some(home) = self.table.find_home(target) {
                    let [x, other] = [home, number].map(|i| self.table.positions[i as usize]);
                    let radius2 = self.table.radii2[home as usize];
                    self.sets.tell((home, number), leaf_of[home as usize], dist2(x, other), radius2);
                }
            }
        }
    }
}

impl<P: Point> Worker<P> {
    /// The edges of every leaf's points from both ends, each once: those that were told and are not known are sorted
    /// by the point they are told to.
    pub(crate) fn unite_reverse(&mut self) {
        let (told, leaf_of) = (std::mem::take(&mut self.sets.told), self.leaf_numbers());
        let done = std::mem::take(&mut self.sets.nearest);
        let nearest = done.by_home(self.table.home);
        let items = nearest.iter().map(|list| list.len()).sum::<usize>() + self.sets.reverse.len();
        // Delivery to the leaves; within each the order is charged.
        let mut unknown = vec![Vec::new(); self.subdomain.leaves.len()];
        for edge in std::mem::take(&mut self.sets.reverse) {
            unknown[leaf_of[edge.0 as usize] as usize].push(edge);
        }
        let mut united = Lists::with_capacity(self.table.home as usize, items);
        for ((leaf, unknown), told) in self.subdomain.leaves.iter().zip(unknown).zip(told) {
            let mut cost = Cost::ZERO;
            cost.delivered(told);
            let own = cost.sorted_by_place(
                &unknown,
                |edge| (edge.0 - leaf.start) as usize,
                leaf.home_len() as usize,
            );
            let homes: Vec<u32> = leaf.home().collect();
            let mut rest = own.as_slice();
            cost.map_nested(&homes, |&home, inner| {
                let (segment, others) = rest.split_at(rest.iter().take_while(|edge| edge.0 == home).count());
                rest = others;
                let mut added = Sweep::default();
                added.visit_lanes(segment.len());
                inner.swept_inside(added);
                united.push_two(nearest[home as usize], segment.iter().map(|edge| edge.1));
            });
            self.ledger.charge(Phase::Graph, leaf.id, cost, 0);
            self.ledger.facts(leaf.id).members += leaf.home_len();
        }
        self.adjacency = united;
    }
}

/// What one worker is told of other ends of edges.
#[derive(Default)]
struct Telling<P: Point> {
    points: PointBatch<P>,
    counts: Vec<u32>,
    targets: Vec<u64>,
    last: Option<u32>,
}

impl<P: Point> Telling<P> {
    /// Tells a point there of a home point. Those of one home point come together.
    fn tell(&mut self, table: &Table<P>, home: u32, target: u64) {
        if self.last != Some(home) {
            self.last = Some(home);
            table.export(home, &mut self.points);
            self.counts.push(0);
        }
        if let Some(count) = self.counts.last_mut() {
            *count += 1;
        }
        self.targets.push(target);
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
