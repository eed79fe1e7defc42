//! The coordinator's choice of the supergraph, from the stars that the workers sampled.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::{NodeId, Phase};
use septet_protocol::message::Body;
use septet_protocol::transport::TransportError;

use crate::graph::selection::{choose, encode_choice};
use crate::machine::context::Context;

/// Sums the workers' counts of sampled stars; decides when all workers have reported, and broadcasts the choice.
pub(super) async fn decide<P: Point>(
    cx: &mut Context<P>,
    population: u64,
) -> Result<(Supergraph, Option<String>), TransportError> {
    cx.enter(Phase::Choice)?;
    let (mut reports, mut sums, mut choice) = (0, Vec::new(), None);
    while cx.exchange().await? {
        for counts in cx.take(|m| match &mut m.body {
            Body::SampleStars(counts) => Some(std::mem::take(&mut counts.0)),
            _ => None,
        }) {
            reports += 1;
            sums.resize(counts.len().max(sums.len()), 0);
            for (sum, count) in sums.iter_mut().zip(&counts) {
                *sum += count;
            }
        }
        if reports == cx.config.workers {
            reports = 0;
            let (supergraph, why) = choose(cx.config.graph.wanted, sums[0], &sums[1..], population);
            let (kind, parameter) = encode_choice(supergraph);
            for rank in 1..=cx.config.workers {
                cx.send(rank, NodeId::ROOT, 0, Body::Choice { kind, parameter });
            }
            choice = Some((supergraph, Some(why)));
        }
    }
    choice.ok_or_else(|| TransportError::WorkerFailed {
        rank: cx.rank,
        reason: "not all workers reported their sampled stars".to_string(),
    })
}
