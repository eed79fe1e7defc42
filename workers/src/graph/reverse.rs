//! The edges of a graph of nearest neighbours, from both ends.
//!
//! **Statement.** Two points are joined if one is among the nearest of the other. Each point knows its own nearest. It
//! announces itself to all of these, and then unites its list with the points that announced themselves to it.
//! A list holds all points as near as its last one, so the distance alone shows whether a point is in it.
//!
//! **Source.** Paper, Section 4.5.
//!
//! **Rounds.** One. **Work and depth.** One vector step over the lists to announce; a delivery to the leaves, a sort of
//! the edges that are new, and one vector step over the points to unite.

use std::collections::BTreeMap;

use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, dist2};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::neighbours::results::CompletedLists;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Both ends of the edges of the home points.
pub(crate) struct Reverse {
    /// The lists of the home points.
    nearest: CompletedLists,
    heard: Received,
}

/// An edge of a home point.
#[derive(Clone, Copy, Debug)]
struct Edge {
    owned: u32,
    other: u32,
}

/// The edges that were announced to the home points.
struct Received {
    /// The position of each home point's leaf.
    leaf_of: Vec<u32>,
    /// Those that are not in the home point's list.
    unknown: Vec<Edge>,
    /// How many came to each leaf.
    came: Vec<Sweep>,
}

impl Received {
    fn nothing<P>(subdomain: &Subdomain<P>) -> Self {
        let came = vec![Sweep::default(); subdomain.leaves.len()];
        Received { leaf_of: subdomain.leaf_numbers(), unknown: Vec::new(), came }
    }

    /// An edge of this squared length comes to a home point whose list reaches so far.
    #[inline]
    fn receive(&mut self, edge: Edge, distance2: f64, radius2: f64) {
        self.came[self.leaf_of[edge.owned as usize] as usize].visit();
        if distance2 > radius2 {
            self.unknown.push(edge);
        }
    }
}

/// Every point announces itself to its nearest. Each rank gets a point once.
pub(crate) async fn reverse_edges<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    nearest: CompletedLists,
) -> Result<Reverse, TransportError> {
    let mut heard = Received::nothing(subdomain);
    let announcements = announce(cx, subdomain, table, &nearest, &mut heard);
    for (to, Announcement { points, counts, targets, .. }) in announcements {
        let body = Body::Reverse { points, counts: Bulk(counts), targets: Bulk(targets) };
        cx.send(to, NodeId::ROOT, 0, body);
    }
    while cx.exchange().await? {
        for Announcement { points, counts, targets, .. } in take_announcements(cx) {
            // The sender's own points.
            let others = table.receive_all(&points).into_iter().zip(counts);
            let others = others.flat_map(|(other, count)| std::iter::repeat_n(other, count as usize));
            for (other, target) in others.zip(targets) {
                if let Some(owned) = table.find_owned(target) {
                    let [x, y] = [owned, other].map(|i| table.positions[i as usize]);
                    heard.receive(Edge { owned, other }, dist2(x, y), table.radii2[owned as usize]);
                }
            }
        }
    }
    Ok(Reverse { nearest, heard })
}

/// Announces the home points to each other; returns what goes to other ranks.
fn announce<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    nearest: &CompletedLists,
    heard: &mut Received,
) -> BTreeMap<Rank, Announcement<P>> {
    let mut announcements: BTreeMap<Rank, Announcement<P>> = BTreeMap::new();
    let mut other_leaves = Vec::new();
    let (nearest, owned_points) = (nearest.by_owned(table.owned), table.owned as usize);
    // Of home points, both of the same length.
    let (positions, radii2) = (&table.positions[..owned_points], &table.radii2[..owned_points]);
    for (leaf, number) in subdomain.leaves.iter().zip(0u32..) {
        let mut edges = Sweep::default();
        for owned in leaf.owned() {
            let own = positions[owned as usize];
            edges.each(nearest[owned as usize], |&j| {
                if let Some(&x) = positions.get(j as usize) {
                    let edge = Edge { owned: j, other: owned };
                    heard.receive(edge, dist2(x, own), radii2[j as usize]);
                    if cx.recorder.is_some() {
                        other_leaves.push(heard.leaf_of[j as usize]);
                    }
                } else {
                    let announcement = announcements.entry(table.owners[j as usize]).or_default();
                    announcement.add(table, owned, table.ids[j as usize]);
                }
            });
            if let Some(recorder) = &mut cx.recorder {
                recorder.reverse(number, &mut other_leaves);
            }
        }
        let mut cost = Cost::ZERO;
        cost.charge_sweep(edges);
        cx.ledger.charge(Phase::Sets, leaf.id, cost, edges.items());
    }
    announcements
}

fn take_announcements<P: Point>(cx: &mut Context<P>) -> Vec<Announcement<P>> {
    cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Reverse { points, counts, targets } => Some(Announcement {
            points: std::mem::take(points),
            counts: std::mem::take(&mut counts.0),
            targets: std::mem::take(&mut targets.0),
            last: None,
        }),
        _ => None,
    })
}

impl Reverse {
    /// The edges of every leaf's points from both ends, each once: those that were not in the lists are sorted by their
    /// home points.
    pub(crate) fn unite<P: Point>(
        self,
        cx: &mut Context<P>,
        subdomain: &Subdomain<P>,
        table: &Table<P>,
    ) -> Lists<u32> {
        let Reverse { nearest: done, heard } = self;
        let nearest = done.by_owned(table.owned);
        let items = nearest.iter().map(|list| list.len()).sum::<usize>() + heard.unknown.len();
        // Delivery to the leaves; within each the order is charged.
        let mut unknown = vec![Vec::new(); subdomain.leaves.len()];
        for edge in heard.unknown {
            unknown[heard.leaf_of[edge.owned as usize] as usize].push(edge);
        }
        let mut united = Lists::with_capacity(table.owned as usize, items);
        for ((leaf, unknown), came) in subdomain.leaves.iter().zip(unknown).zip(heard.came) {
            let mut cost = Cost::ZERO;
            cost.charge_delivery(came);
            let place = |edge: &Edge| (edge.owned - leaf.start) as usize;
            let own = cost.sort_by_position(&unknown, place, leaf.owned_len() as usize);
            let owned_points: Vec<u32> = leaf.owned().collect();
            let mut rest = own.as_slice();
            cost.map_nested(&owned_points, |&owned, inner| {
                let (segment, others) =
                    rest.split_at(rest.iter().take_while(|edge| edge.owned == owned).count());
                rest = others;
                let mut added = Sweep::default();
                added.visit_lanes(segment.len());
                inner.charge_nested_sweep(added);
                united.push_two(nearest[owned as usize], segment.iter().map(|edge| edge.other));
            });
            cx.ledger.charge(Phase::Graph, leaf.id, cost, 0);
            cx.ledger.facts(leaf.id).members += leaf.owned_len();
        }
        united
    }
}

/// What one rank gets of other ends of edges: points, how many targets each has there, and all targets.
#[derive(Default)]
struct Announcement<P: Point> {
    points: PointBatch<P>,
    counts: Vec<u32>,
    targets: Vec<u64>,
    last: Option<u32>,
}

impl<P: Point> Announcement<P> {
    /// Announces a home point to a point there. Those of one home point come together.
    fn add(&mut self, table: &Table<P>, owned: u32, target: u64) {
        if self.last != Some(owned) {
            self.last = Some(owned);
            table.export(owned, &mut self.points);
            self.counts.push(0);
        }
        if let Some(count) = self.counts.last_mut() {
            *count += 1;
        }
        self.targets.push(target);
    }
}
