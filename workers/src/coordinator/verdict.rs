//! The verdict on a certificate.
//!
//! **Statement.** The stars of all points agree, every point has a star, and one point alone has no smaller
//! neighbour: then the stars form one triangulation.

use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::{Body, Merged};
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::partition::Group;
use crate::result::merge::{Joining, Pass};

/// Joins the results of the root's children, and broadcasts the verdict of pass `number`. Returns the verdict and the joined result.
pub(super) async fn merge<P: Point>(
    cx: &mut Context<P>,
    led: &[Group],
    number: u32,
) -> Result<(Outcome, Merged), TransportError> {
    cx.enter(Phase::Merge)?;
    let pass = Pass { number, rounds: 0 };
    let population = led.first().map_or(0, |root| root.child.population);
    let (mut joining, mut found) = (Joining::default(), None);
    while cx.exchange().await? {
        let whole = joining.join(cx, led, pass).pop().map(|(_, merged)| merged);
        if let Some(whole) = whole {
            let outcome = judge(whole, population, number);
            for rank in 1..=cx.config.workers {
                cx.send(rank, NodeId::ROOT, 0, Body::Outcome(outcome.number()));
            }
            found = Some((outcome, whole));
        }
    }
    found.ok_or_else(|| TransportError::WorkerFailed {
        rank: cx.rank,
        reason: "not all results reached the root".to_string(),
    })
}

/// The verdict on the merged result of pass `pass`.
fn judge(merged: Merged, population: u64, pass: u32) -> Outcome {
    let passed = merged.stars == population && merged.disagreements == 0 && merged.minima == 1;
    match (passed, pass) {
        (true, _) => Outcome::Passed,
        (false, 0) => Outcome::GatherUnresolved,
        (false, 1) => Outcome::GatherAll,
        _ => Outcome::Failed,
    }
}
