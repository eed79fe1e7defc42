//! Checks, splays and certifies the stars until rank 0 decides that the result passes or fails.

use septet_geometry::point::Point;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::config::Repair;
use crate::machine::context::Context;
use crate::result::certified::Certified;
use crate::result::merge::{Instance, Pass, merge};
use crate::share::Certificate;
use crate::splaying::fallback::gather;
use crate::splaying::pass::{AllPoints, Passed, Start};
use crate::splaying::splay::splay;
use crate::splaying::tell::tell;
use crate::stars::check::{certificate, check};
use crate::stars::owned::{Stars, StarsView};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Checks, splays and certifies the stars. If the certificate does not pass, gathers the open regions and repeats these
/// steps until the decision of the coordinator is final.
pub(super) async fn certify<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    instance: Instance,
) -> Result<Certified, TransportError> {
    let mut agreement = check(cx, subdomain, table, stars).await?;
    let (mut start, mut certificate) = (Start::default(), Certificate::default());
    let mut number = 0;
    loop {
        let all = AllPoints { count: instance.population.count, heaviest: instance.heaviest };
        let Passed { rounds, steps } = match cx.config().graph.repair {
            Repair::Probe => tell(cx, subdomain, table, stars, &agreement, start, all).await?,
            Repair::Splay => splay(cx, subdomain, table, stars, &agreement, start, all).await?,
        };
        agreement = self::certificate(cx, subdomain, table, stars).await?;
        let pass = Pass { number, rounds, instance };
        let view = StarsView::new(table, stars);
        let (outcome, owned_cells, whole) = merge(cx, subdomain, view, &agreement, pass).await?.into_parts();
        certificate.add(whole);
        if matches!(outcome, Outcome::Passed | Outcome::Failed) {
            let passed = outcome == Outcome::Passed;
            return Ok(Certified::new(instance, passed, owned_cells, certificate));
        }
        let gathered = gather(cx, subdomain, table, stars, (&agreement, outcome), &mut certificate).await?;
        start = Start::after_gathering(gathered, steps);
        number += 1;
    }
}
