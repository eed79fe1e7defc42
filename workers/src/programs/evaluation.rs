//! A rule of the caller at items.

use septet_geometry::point::Point;
use septet_protocol::ids::Phase;
use septet_protocol::transport::TransportError;

use crate::evaluation::evaluate;
use crate::input::Source;
use crate::machine::context::Context;
use crate::result::collect::collect_counts;
use crate::share::Share;

/// Evaluates the rule of the source in a phase.
pub(super) async fn evaluation<P: Point>(
    cx: &mut Context<P>,
    source: &dyn Source<P>,
    phase: Phase,
) -> Result<Share<P>, TransportError> {
    let Some(rule) = source.evaluation() else {
        let reason = "the source has no rule to evaluate".to_string();
        return Err(TransportError::WorkerFailed { rank: cx.rank(), reason });
    };
    let evaluated = evaluate(cx, rule, phase).await?;
    collect_counts(cx, Share { evaluated, ..Share::new(cx.rank()) }).await
}
