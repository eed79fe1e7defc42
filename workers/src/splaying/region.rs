//! The triangulation of unresolved stars that are gathered on the coordinator.

use std::collections::BTreeMap;

use septet_geometry::complex::INFINITE;
use septet_geometry::cost::{Cost, Sweep};
use septet_geometry::hull::StarBuilder;
use septet_geometry::incremental::{Incremental, insertion_order};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::ledger::Account;
use septet_protocol::message::{Body, PointBatch, UNKNOWN_RADIUS2, is_wanted};
use septet_protocol::outcome::Outcome;

use crate::machine::collectives::Reports;
use crate::machine::context::Context;
use crate::share::Certificate;

/// The points that the ranks have sent in a gathering.
#[derive(Debug)]
pub(crate) struct Region<P> {
    points: PointBatch<P>,
    reports: Reports,
}

impl<P> Default for Region<P> {
    fn default() -> Self {
        Region { points: PointBatch::default(), reports: Reports::default() }
    }
}

impl<P: Point> Region<P> {
    /// Takes the points of a round. Once every rank has sent its points, triangulates them, and sends every unresolved
    /// star its neighbours among them.
    pub(crate) fn receive(&mut self, cx: &mut Context<P>, outcome: Outcome, certificate: &mut Certificate) {
        let mut batches = cx.take(|m| match &mut m.body {
            Body::Gather(points) => Some(std::mem::take(points)),
            _ => None,
        });
        for points in &mut batches {
            self.points.append(points);
        }
        if self.reports.complete(batches.len(), cx.config().ranks()) {
            let points = std::mem::take(&mut self.points);
            let members = members_of(&points);
            certificate.note_gathered(reason(outcome), members.len() as u64);
            reply(cx, &points, &members);
        }
    }
}

fn reason(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::GatherAll => "the whole set was triangulated at once",
        _ => "unresolved stars were gathered and triangulated at once",
    }
}

/// A point of the region.
#[derive(Clone, Copy)]
struct Member {
    /// The position in the batch.
    at: usize,
    /// Whether the star is unresolved.
    unresolved: bool,
}

/// Returns the points of the region in the order of their ids, without duplicates. A point is unresolved if one of
/// its copies is unresolved. The number of copies depends on the ranks, so the caller charges a sort of the result.
fn members_of<P: Point>(region: &PointBatch<P>) -> Vec<Member> {
    let mut places: BTreeMap<u64, Member> = BTreeMap::new();
    for at in 0..region.len() {
        let member = places.entry(region.ids[at]).or_insert(Member { at, unresolved: false });
        member.unresolved |= is_wanted(region.radii2[at]);
    }
    places.into_values().collect()
}

/// A reply to one rank: its unresolved points, the number of neighbours of each, and the neighbours.
struct Neighbourhoods<P> {
    vertices: Vec<u64>,
    counts: Vec<u32>,
    points: PointBatch<P>,
}

impl<P> Default for Neighbourhoods<P> {
    fn default() -> Self {
        Neighbourhoods { vertices: Vec::new(), counts: Vec::new(), points: PointBatch::default() }
    }
}

impl<P: Point> Neighbourhoods<P> {
    /// Adds the neighbours of an unresolved point. Points are positions among the members.
    fn push(&mut self, region: &PointBatch<P>, members: &[Member], vertex: u32, around: &[u32]) {
        self.vertices.push(region.ids[members[vertex as usize].at]);
        self.counts.push(around.len() as u32);
        for &v in around {
            let at = members[v as usize].at;
            self.points.push(region.ids[at], region.positions[at], region.owners[at], UNKNOWN_RADIUS2);
        }
    }
}

/// Triangulates the members, and sends each owner the neighbours of its unresolved points.
fn reply<P: Point>(cx: &mut Context<P>, region: &PointBatch<P>, members: &[Member]) {
    let mut cost = cx.own_cost();
    cost.sort(&mut members.to_vec(), |a, b| region.ids[a.at].cmp(&region.ids[b.at]));
    let points: Vec<P> = cost.map(members, |member| region.positions[member.at]);
    if P::DIM > 3 {
        reply_by_stars(cx, region, members, &points, cost);
        return;
    }
    let (order, mut on_curve) = (insertion_order(&points), cost.sweep());
    on_curve.visit_all(&points);
    cost.charge_sort(on_curve);
    let stop = cx.config().stop.clone();
    let mut growth = stop.growth();
    let go_on = &mut |bytes| stop.admits(&mut growth, bytes);
    let Ok(delaunay) = Incremental::build_while(points, Some(&order), go_on) else {
        return;
    };
    delaunay.charge(&mut cost);
    let (mut links, mut ends) = (cost.sweep(), cost.sweep());
    let mut batches: BTreeMap<Rank, Neighbourhoods<P>> = BTreeMap::new();
    let mut link: Vec<P::Facet> = Vec::new();
    for (vertex, member) in (0u32..).zip(members).filter(|(_, member)| member.unresolved) {
        let around = if P::IS_WEIGHTED && delaunay.is_hidden(vertex) {
            links.visit();
            finite_of(delaunay.cover_of(vertex).as_ref().to_vec(), &mut ends)
        } else {
            delaunay.link_of(vertex, &mut link);
            around_of::<P>(links.visit_all(&link), &mut ends)
        };
        let batch = batches.entry(region.owners[member.at]).or_default();
        batch.push(region, members, vertex, &around);
    }
    cost.charge_sweep(links);
    cost.charge_sort(ends);
    send(cx, batches, cost, members.len() as u64);
}

/// Builds the unresolved stars among all members, and sends each owner their neighbours: [`reply`] in dimensions 4 to 6, where
/// there is no kernel.
fn reply_by_stars<P: Point>(
    cx: &mut Context<P>,
    region: &PointBatch<P>,
    members: &[Member],
    points: &[P],
    mut cost: Cost,
) {
    let (stop, mut builder) = (cx.config().stop.clone(), StarBuilder::default());
    let mut growth = stop.growth();
    let mut batches: BTreeMap<Rank, Neighbourhoods<P>> = BTreeMap::new();
    let numbers: Vec<u32> = (0..points.len() as u32).collect();
    let unresolved: Vec<u32> = numbers.iter().copied().filter(|&v| members[v as usize].unresolved).collect();
    let mut bytes = 0;
    cost.map_nested(&unresolved, |&vertex, own| {
        if !stop.admits(&mut growth, bytes) {
            return;
        }
        let mut link: Vec<P::Facet> = Vec::new();
        builder.build(points, vertex, &numbers, own);
        builder.facets(&mut link);
        let mut ends = own.sweep();
        let around = around_of::<P>(&link, &mut ends);
        own.charge_sort(ends);
        bytes += 4 * around.len() as u64;
        let batch = batches.entry(region.owners[members[vertex as usize].at]).or_default();
        batch.push(region, members, vertex, &around);
    });
    if !stop.admits(&mut growth, bytes) {
        return;
    }
    send(cx, batches, cost, members.len() as u64);
}

/// Returns the finite vertices of a link, in order. Counts all vertices of its facets.
fn around_of<P: Point>(link: &[P::Facet], ends: &mut Sweep) -> Vec<u32> {
    finite_of(link.iter().flat_map(AsRef::as_ref).copied().collect(), ends)
}

/// Returns the finite vertices of a list, in order. Counts all of the list.
fn finite_of(mut around: Vec<u32>, ends: &mut Sweep) -> Vec<u32> {
    ends.visit_all(&around);
    around.sort_unstable();
    around.dedup();
    around.retain(|&v| v != INFINITE);
    around
}

/// Charges the region and sends the replies.
fn send<P: Point>(cx: &mut Context<P>, batches: BTreeMap<Rank, Neighbourhoods<P>>, cost: Cost, members: u64) {
    cx.charge(Account::leader(Phase::Fallback, NodeId::ROOT), cost, members);
    let body = |Neighbourhoods { vertices, counts, points }| Body::Region {
        vertices: Bulk(vertices),
        counts: Bulk(counts),
        points,
    };
    cx.send_each(0, batches.into_iter().map(|(rank, batch)| (rank, body(batch))));
}
