//! Rank 0 gathers what the exchange leaves open.
//!
//! **Statement.** The region is the vertices that hold a cell which another star lacks, with their links; or all points, if
//! that was not enough. Rank 0 triangulates it, and each of these vertices gets its neighbours there. Then the exchange
//! goes on ([`crate::splaying::splay`]), in which it proposes what the others lack.
//!
//! **Rounds.** Two: the region to rank 0, the neighbours back.

use std::collections::BTreeSet;

use septet_geometry::complex::INFINITE;
use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::message::{Body, Message, OF_A_LINK, PointBatch, WANTED};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::coordinator::{Certificate, Region};
use crate::machine::context::Context;
use crate::splaying::pending::Gathered;
use crate::stars::check::Agreement;
use crate::stars::owned::Stars;
use crate::state::table::Table;

/// Gathers what the last check found unresolved, or everything. Returns the neighbours that home stars get.
pub(crate) async fn gather<P: Point>(
    cx: &mut Context<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    (agreement, outcome): (&Agreement, Outcome),
    certificate: &mut Certificate,
) -> Result<Vec<Gathered>, TransportError> {
    cx.enter(Phase::Fallback)?;
    stars.write_out(table);
    let wanted: BTreeSet<u32> = if outcome == Outcome::GatherAll {
        (0..table.owned).collect()
    } else {
        // Stars that lack a cell hear of it later: the set must not depend on where points are at home.
        agreement.disagreements.iter().map(|d| d.owned).collect()
    };
    if !cx.is_coordinator() {
        cx.to_coordinator(Body::Gather(region(table, stars, &wanted)));
    }
    let (mut gathered, mut whole) = (Vec::new(), Region::default());
    while cx.exchange().await? {
        if cx.is_coordinator() {
            whole.receive(cx, outcome, certificate);
        }
        take_neighbours(cx, table, &mut gathered);
    }
    Ok(gathered)
}

/// The points whose stars are wanted, and the others of their links.
fn region<P: Point>(table: &Table<P>, stars: &Stars<P>, wanted: &BTreeSet<u32>) -> PointBatch<P> {
    let mut batch = PointBatch::default();
    let mut push = |v: u32, role: f64| {
        let i = v as usize;
        batch.push(table.ids[i], table.positions[i], table.owners[i], role);
    };
    let mut links = BTreeSet::new();
    for &owned in wanted {
        push(owned, WANTED);
        links.extend(stars.link(owned).iter().flat_map(AsRef::as_ref).copied());
    }
    links.remove(&INFINITE);
    links.difference(wanted).for_each(|&v| push(v, OF_A_LINK));
    batch
}

/// Takes the neighbours of home points in the region.
fn take_neighbours<P: Point>(cx: &mut Context<P>, table: &mut Table<P>, gathered: &mut Vec<Gathered>) {
    for ((vertices, counts), points) in cx.take(|m: &mut Message<P>| match &mut m.body {
        Body::Region { vertices, counts, points } => {
            let stars = (std::mem::take(&mut vertices.0), std::mem::take(&mut counts.0));
            Some((stars, std::mem::take(points)))
        }
        _ => None,
    }) {
        let numbers = table.intern_all(&points);
        let mut at = 0;
        for (id, count) in vertices.into_iter().zip(counts) {
            let end = (at + count as usize).min(numbers.len());
            if let Some(owned) = table.find(id).filter(|&h| table.is_owned(h)) {
                gathered.extend(numbers[at..end].iter().map(|&v| (owned, v)));
            }
            at = end;
        }
    }
}
