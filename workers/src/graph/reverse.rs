//! The edges of a graph of nearest neighbours, from both ends.
//!
//! **Statement.** Two points are joined if one is among the nearest neighbours of the other. Each point has a list
//! of its nearest neighbours and announces itself to all of them. It then unites its list with the points that
//! announced themselves to it. A list contains every point that is at most as far away as its last point, so the
//! distance shows whether a point is in the list.
//!
//! **Source.** Paper, Section 4.5.
//!
//! **Rounds.** One. **Work and depth.** Announcing takes one vector step over the lists. Uniting takes a delivery to
//! the leaves, a sort of the new edges, and one vector step over the points.

use std::collections::BTreeMap;

use septet_geometry::cost::Sweep;
use septet_geometry::lists::Lists;
use septet_geometry::point::{Point, dist2};
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, Message, PointBatch};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::neighbours::results::CompletedLists;
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// The edges of the owned points, from both ends.
pub(crate) struct BothEnds {
    /// The nearest neighbours of each owned point.
    nearest: CompletedLists,
    announced: AnnouncedEdges,
}

/// An edge of an owned point.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// The owned point.
    point: u32,
    /// The other end.
    other: u32,
}

/// The edges that were announced to the owned points.
struct AnnouncedEdges {
    /// For each owned point, the index of its leaf.
    leaf_of: Vec<u32>,
    /// The announced edges whose other end is not in the list of the owned point.
    new: Vec<Edge>,
    /// For each leaf, the number of edges announced to its points.
    at_leaf: Vec<Sweep>,
}

impl AnnouncedEdges {
    fn none<P>(subdomain: &Subdomain<P>) -> Self {
        let at_leaf = vec![Sweep::default(); subdomain.leaves().len()];
        AnnouncedEdges { leaf_of: subdomain.leaf_numbers(), new: Vec::new(), at_leaf }
    }

    /// Adds an edge of squared length `distance2`. The list of its owned point extends to the squared radius `radius2`.
    #[inline]
    fn add(&mut self, edge: Edge, distance2: f64, radius2: f64) {
        self.at_leaf[self.leaf_of[edge.point as usize] as usize].visit();
        if distance2 > radius2 {
            self.new.push(edge);
        }
    }
}

/// Announces each point to its nearest neighbours. Each rank receives a point at most once.
pub(crate) async fn reverse_edges<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    nearest: CompletedLists,
) -> Result<BothEnds, TransportError> {
    let mut announced = AnnouncedEdges::none(subdomain);
    let announcements = announce(cx, subdomain, table, &nearest, &mut announced);
    let body = |Announcement { points, counts, targets, .. }| Body::Reverse {
        points,
        counts: Bulk(counts),
        targets: Bulk(targets),
    };
    cx.send_each(0, announcements.into_iter().map(|(to, announcement)| (to, body(announcement))));
    while cx.exchange().await? {
        for Announcement { points, counts, targets, .. } in take_announcements(cx) {
            // The sender owns all these points.
            let others = table.receive_all(&points).into_iter().zip(counts);
            let others = others.flat_map(|(other, count)| std::iter::repeat_n(other, count as usize));
            for (other, target) in others.zip(targets) {
                if let Some(point) = table.find_owned(target) {
                    let [x, y] = [point, other].map(|i| table.positions()[i as usize]);
                    announced.add(Edge { point, other }, dist2(x, y), table.radii2()[point as usize]);
                }
            }
        }
    }
    Ok(BothEnds { nearest, announced })
}

/// Announces the owned points to each other. Returns the announcements to other ranks.
fn announce<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &Table<P>,
    nearest: &CompletedLists,
    announced: &mut AnnouncedEdges,
) -> BTreeMap<Rank, Announcement<P>> {
    let mut announcements: BTreeMap<Rank, Announcement<P>> = BTreeMap::new();
    let nearest = nearest.by_owned(table.owned_len());
    // Both slices have the same length, one entry for each owned point.
    let (positions, radii2) = (table.owned_positions(), &table.radii2()[..table.owned_len() as usize]);
    for leaf in subdomain.leaves() {
        let mut edges = Sweep::default();
        for point in leaf.owned() {
            let own = positions[point as usize];
            edges.each(nearest[point as usize], |&j| {
                if let Some(&x) = positions.get(j as usize) {
                    let edge = Edge { point: j, other: point };
                    announced.add(edge, dist2(x, own), radii2[j as usize]);
                } else {
                    let announcement = announcements.entry(table.owners()[j as usize]).or_default();
                    announcement.add(table, point, table.ids()[j as usize]);
                }
            });
        }
        let mut cost = cx.own_cost();
        cost.charge_sweep(edges);
        cx.charge(Account::member(Phase::Sets, leaf.id()), cost, edges.items());
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

impl BothEnds {
    /// Unites the edges from both ends, each edge once. Edges that are not in the lists are sorted by their owned
    /// points.
    pub(crate) fn unite<P: Point>(
        self,
        cx: &mut Context<P>,
        subdomain: &Subdomain<P>,
        table: &Table<P>,
    ) -> Lists<u32> {
        let BothEnds { nearest, announced } = self;
        let nearest = nearest.by_owned(table.owned_len());
        let items = nearest.iter().map(|list| list.len()).sum::<usize>() + announced.new.len();
        // Delivers the edges to the leaves. The sort within each leaf is charged below.
        let mut new = vec![Vec::new(); subdomain.leaves().len()];
        for edge in announced.new {
            new[announced.leaf_of[edge.point as usize] as usize].push(edge);
        }
        let mut united = Lists::with_capacity(table.owned_len() as usize, items);
        for ((leaf, new), charge_delivery) in subdomain.leaves().iter().zip(new).zip(announced.at_leaf) {
            let mut cost = cx.own_cost();
            cost.charge_delivery(charge_delivery);
            let row = |edge: &Edge| (edge.point - leaf.start()) as usize;
            let own = cost.sort_by_position(&new, row, leaf.owned_len() as usize);
            let points: Vec<u32> = leaf.owned().collect();
            let mut rest = own.as_slice();
            cost.map_nested(&points, |&point, inner| {
                let (segment, others) =
                    rest.split_at(rest.iter().take_while(|edge| edge.point == point).count());
                rest = others;
                let mut added = Sweep::default();
                let segment = added.visit_all(segment);
                inner.charge_sweep(added);
                united.push_two(nearest[point as usize], segment.iter().map(|edge| edge.other));
            });
            cx.charge(Account::member(Phase::Graph, leaf.id()), cost, 0);
            cx.facts(leaf.id()).members += leaf.owned_len();
        }
        united
    }
}

/// The points that one rank announces to another.
#[derive(Default)]
struct Announcement<P: Point> {
    points: PointBatch<P>,
    /// For each point, the number of its targets.
    counts: Vec<u32>,
    /// The ids of the targets of all points.
    targets: Vec<u64>,
    /// The last point added.
    last: Option<u32>,
}

impl<P: Point> Announcement<P> {
    /// Announces an owned point to the point with id `target`. The targets of one point must be added consecutively.
    fn add(&mut self, table: &Table<P>, point: u32, target: u64) {
        if self.last != Some(point) {
            self.last = Some(point);
            table.export(point, &mut self.points);
            self.counts.push(0);
        }
        if let Some(count) = self.counts.last_mut() {
            *count += 1;
        }
        self.targets.push(target);
    }
}
