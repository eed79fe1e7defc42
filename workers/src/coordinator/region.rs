//! Unresolved stars, gathered on rank 0 and triangulated at once.

use std::collections::BTreeMap;

use septet_geometry::complex::INFINITE;
use septet_geometry::incremental::{Incremental, insertion_order};
use septet_geometry::point::Point;
use septet_protocol::codec::Bulk;
use septet_protocol::ids::{NodeId, Phase, Rank};
use septet_protocol::message::{Body, PointBatch};
use septet_protocol::transport::TransportError;

use super::share::Certified;
use crate::machine::context::Context;
use crate::schedule::Outcome;

/// Triangulates the points that the workers send, and returns to every unresolved star its neighbours among them.
pub(super) async fn gather<P: Point>(
    cx: &mut Context<P>,
    outcome: Outcome,
    certified: &mut Certified,
) -> Result<(), TransportError> {
    cx.enter(Phase::Fallback)?;
    let (mut reports, mut region) = (0, PointBatch::default());
    while cx.exchange().await? {
        for mut points in cx.take(|m| match &mut m.body {
            Body::Gather(points) => Some(std::mem::take(points)),
            _ => None,
        }) {
            reports += 1;
            region.append(&mut points);
        }
        if reports == cx.config.workers {
            reports = 0;
            let region = std::mem::take(&mut region);
            let members = members_of(&region);
            certified.note_gathered(reason(outcome), members.len() as u64);
            answer(cx, &region, &members);
        }
    }
    Ok(())
}

fn reason(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::GatherAll => "the whole set was triangulated at once",
        _ => "unresolved stars were gathered and triangulated at once",
    }
}

/// A point of the region: its place in the batch, and whether its star is unresolved.
#[derive(Clone, Copy)]
struct Member {
    at: usize,
    unresolved: bool,
}

/// The points of the region, each once, by their ids. A point is unresolved if one of its copies is.
fn members_of<P: Point>(region: &PointBatch<P>) -> Vec<Member> {
    let mut places: BTreeMap<u64, Member> = BTreeMap::new();
    for at in 0..region.len() {
        let member = places.entry(region.ids[at]).or_insert(Member { at, unresolved: false });
        member.unresolved |= region.radii2[at] > 0.0;
    }
    places.into_values().collect()
}

/// What one rank receives: its unresolved points, the number of neighbours of each, and the neighbours.
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

fn answer<P: Point>(cx: &mut Context<P>, region: &PointBatch<P>, members: &[Member]) {
    let points: Vec<P> = members.iter().map(|member| region.positions[member.at]).collect();
    let order = insertion_order(&points);
    let stop = &cx.config.stop;
    let Ok(delaunay) = Incremental::build_while(points, Some(&order), &mut || !stop.is_raised()) else {
        return;
    };
    let mut batches: BTreeMap<Rank, Neighbourhoods<P>> = BTreeMap::new();
    let mut link: Vec<P::Facet> = Vec::new();
    for (vertex, member) in (0u32..).zip(members).filter(|(_, member)| member.unresolved) {
        delaunay.link_of(vertex, &mut link);
        let mut around: Vec<u32> = link.iter().flat_map(AsRef::as_ref).copied().collect();
        around.sort_unstable();
        around.dedup();
        around.retain(|&v| v != INFINITE);
        let batch = batches.entry(region.owners[member.at]).or_default();
        batch.vertices.push(region.ids[member.at]);
        batch.counts.push(around.len() as u32);
        for v in around {
            let at = members[v as usize].at;
            batch.points.push(region.ids[at], region.positions[at], region.owners[at], f64::INFINITY);
        }
    }
    for (rank, Neighbourhoods { vertices, counts, points }) in batches {
        let body = Body::Region { vertices: Bulk(vertices), counts: Bulk(counts), points };
        cx.send(rank, NodeId::ROOT, 0, body);
    }
}
