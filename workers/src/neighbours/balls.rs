//! Nearest-neighbour balls of all points (Section 4.3): radii inside every leaf, then the descent.
//!
//! **Statement.** A ball starts with the distance to the nearest point of its leaf. Balls much larger than their leaf's
//! median probe first; then all descend ([`crate::neighbours::descent`]), and each takes the nearest point found. The
//! baseline corrects them bottom-up instead ([`crate::neighbours::bottom_up`]).
//!
//! **Work and depth.** All pairs of a leaf, and the descent's.
//!
//! **Rounds.** None for the radii inside leaves; those of two descents, or of the passes of the baseline.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::lists::Lists;
use septet_geometry::neighbourhood::nearest_direct;
use septet_geometry::point::{Point, dist2};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::config::{Correction, map_in};
use crate::machine::context::Context;
use crate::neighbours::ask::{Ask, Ball};
use crate::neighbours::bottom_up::correct_bottom_up;
use crate::neighbours::descent::descend;
use crate::neighbours::done::Done;
use crate::state::subdomain::{Leaf, Subdomain};
use crate::state::table::Table;
use crate::worker::Worker;

/// A ball with a radius above this multiple of its leaf's median probes first.
const PUNT_RADIUS: f64 = 4.0;

/// Finds the nearest neighbour of every home point: its squared distance becomes the point's squared radius.
pub(crate) async fn nearest_balls<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    leaf_radii(cx, subdomain, table).await?;
    if cx.config.correction == Correction::Naive {
        return correct_bottom_up(cx, subdomain, table).await;
    }
    let nearest = |phase, probe| Ask { phase, wanted: 1, probe, own_leaf: false };
    cx.enter(Phase::Probe)?;
    let large = large_balls(&subdomain.leaves, &table.radii2);
    let probed = descend(cx, subdomain, table, nearest(Phase::Probe, true), large).await?;
    probed.shrink(&mut table.radii2);
    drop(probed);
    cx.enter(Phase::Neighbours)?;
    let all = all_balls(&subdomain.leaves, &table.radii2);
    let found = descend(cx, subdomain, table, nearest(Phase::Neighbours, false), all).await?;
    found.shrink(&mut table.radii2);
    Ok(())
}

/// Finds the nearest neighbour of every home point inside its leaf.
async fn leaf_radii<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
) -> Result<(), TransportError> {
    cx.enter(Phase::Radii)?;
    let (positions, site, fault) = (&table.positions, cx.site(), cx.config.fault);
    let results = map_in(&cx.pool, &subdomain.leaves, |leaf| {
        let _span = site.subproblem(Phase::Radii, leaf.id, "leaf radii", leaf.home_len());
        let members: Vec<u32> = leaf.home().collect();
        let mut cost = Cost::ZERO;
        let all = |_| f64::INFINITY;
        let nearest = nearest_direct(positions, &members, &members, 1, all, &mut cost);
        let cost = fault.and_then(|fault| fault.charge_of_radii(&members)).unwrap_or(cost);
        (nearest.kth2, cost)
    });
    let mut radii2 = Vec::with_capacity(table.home as usize);
    for (leaf, (nearest2, cost)) in subdomain.leaves.iter().zip(results) {
        cx.ledger.charge(Phase::Radii, leaf.id, cost, leaf.home_len() * leaf.home_len());
        radii2.extend(nearest2);
    }
    table.radii2[..radii2.len()].copy_from_slice(&radii2);
    drop(radii2);
    while cx.exchange().await? {}
    Ok(())
}

/// The balls of all home points, by their squared radii.
pub(crate) fn all_balls<P>(leaves: &[Leaf<P>], radii2: &[f64]) -> Vec<Ball> {
    balls_above(leaves, radii2, |_| f64::NEG_INFINITY)
}

/// The balls that probe: those far larger than their leaf's median.
pub(crate) fn large_balls<P>(leaves: &[Leaf<P>], radii2: &[f64]) -> Vec<Ball> {
    balls_above(leaves, radii2, punt_limit)
}

/// The balls whose squared radius is above the limit of their leaf, or infinite.
fn balls_above<P>(leaves: &[Leaf<P>], radii2: &[f64], limit2: impl Fn(&[f64]) -> f64) -> Vec<Ball> {
    let mut balls = Vec::new();
    for (at, leaf) in leaves.iter().enumerate() {
        let radii2 = &radii2[leaf.start as usize..leaf.end as usize];
        let limit2 = limit2(radii2);
        for (home, &radius2) in leaf.home().zip(radii2) {
            if radius2 > limit2 || radius2 == f64::INFINITY {
                balls.push(Ball { home, leaf: at, radius2 });
            }
        }
    }
    balls
}

/// The squared radius above which a ball of a leaf probes.
fn punt_limit(radii2: &[f64]) -> f64 {
    if radii2.is_empty() {
        return f64::INFINITY;
    }
    let mut sorted = radii2.to_vec();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    PUNT_RADIUS * PUNT_RADIUS * median
}

impl<P: Point> Worker<P> {
    /// The other end of every edge: `j` is told that it is among the nearest of `i`. Each worker gets `i` once.
    /// Keeps the lists of all `i` until they are united with what is told.
    pub(crate) fn send_reverse(&mut self, done: Done) {
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
