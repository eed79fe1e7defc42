//! Neighbourhood balls: radii inside every leaf, then the descent; nearest neighbours (Section 4.3), and
//! the k nearest where the supergraph is that of Section 4.5.

use septet_geometry::blocks::Blocks;
use septet_geometry::cost::Cost;
use septet_geometry::graph::Supergraph;
use septet_geometry::neighbourhood::{nearest_direct, nearest_in_blocks};
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;

use crate::config::{Correction, SetRule, map_in};
use crate::neighbours::done::Done;
use crate::neighbours::query::{Ask, Ball};
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

    /// Keeps the radii of the k-nearest lists, and returns the lists if the supergraph is made of them.
    pub(crate) fn finish_knn(&mut self) -> Option<Done> {
        if !matches!(self.supergraph(), Supergraph::Knn { .. }) {
            return None;
        }
        let done = self.land(Phase::Knn);
        self.exchange.blocks = Vec::new();
        for (home, kth2, _) in done.iter() {
            self.table.radii2[home as usize] = kth2;
        }
        // By other rules the recursion finds the edges.
        (self.config.sets == SetRule::Ghost).then_some(done)
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
