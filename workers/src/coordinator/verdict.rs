//! The verdict on a certificate.
//!
//! **Statement.** The stars of all points agree, every point has a star, and one point alone has no smaller
//! neighbour: then the stars form one triangulation.

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::{Body, Merged};
use septet_protocol::transport::TransportError;

use super::leader_of;
use crate::machine::context::Context;
use crate::partition::Group;
use crate::partition::leader::by_node;
use crate::schedule::Outcome;

/// Joins the results of the root's children, and broadcasts the verdict of pass `pass`. Returns the joined result.
pub(super) async fn merge<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    pass: u32,
) -> Result<Option<Merged>, TransportError> {
    cx.enter(Phase::Merge)?;
    let charged = if pass > 0 { Phase::Certificate } else { Phase::Merge };
    let mut leader = leader_of::<P>(led);
    let population = led.first().map_or(0, |root| root.child.population);
    let mut found = None;
    while cx.exchange().await? {
        let site = cx.site();
        let (_, ledger, inbox) = cx.parts();
        let below = by_node(inbox, |m| match m.body {
            Body::Merged(merged) => Some((m.round, merged)),
            _ => None,
        });
        let mut whole = None;
        for (child, all) in below {
            for (round, merged) in all {
                if child == NodeId::ROOT {
                    whole = Some(merged);
                } else if let Some((_, joined)) = leader.on_merged(child, merged, charged, site, ledger) {
                    ledger.tally(round, Phase::Merge).merged += 1;
                    whole = Some(joined);
                }
            }
        }
        if let Some(whole) = whole {
            let outcome = judge(whole, population, pass);
            for rank in 1..=cx.config.workers {
                cx.send(rank, NodeId::ROOT, 0, Body::Outcome(outcome.number()));
            }
            found = Some(whole);
        }
    }
    Ok(found)
}

/// The verdict on the merged result of pass `pass`.
pub(super) fn judge(merged: Merged, population: u64, pass: u32) -> Outcome {
    let passed = merged.stars == population && merged.disagreements == 0 && merged.minima == 1;
    match (passed, pass) {
        (true, _) => Outcome::Passed,
        (false, 0) => Outcome::GatherUnresolved,
        (false, 1) => Outcome::GatherAll,
        _ => Outcome::Failed,
    }
}
