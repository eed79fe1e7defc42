//! Check, exchange and certificate, until rank 0 is satisfied.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::coordinator::Certificate;
use crate::machine::context::Context;
use crate::result::merge::{MergedResult, OwnedCells, Pass, Results, merge};
use crate::splaying::fallback::gather;
use crate::splaying::splay::splay;
use crate::stars::check::{certificate, check};
use crate::stars::owned::{Chart, Stars};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// What every rank knows of the point set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instance {
    /// Number of points of all ranks.
    pub(crate) population: u64,
    /// The supergraph of the stars.
    pub(crate) supergraph: Supergraph,
}

/// The outcome of certification.
#[derive(Debug)]
pub(crate) struct Certified {
    /// The last decision of the coordinator: passed or failed.
    pub(crate) outcome: Outcome,
    /// The cells that belong to this rank.
    pub(crate) cells_here: OwnedCells,
    /// The certificate, on the coordinator.
    pub(crate) certificate: Certificate,
}

/// Checks the stars, splays them and certifies them. If the certificate does not pass, gathers what is unresolved and
/// repeats, until the coordinator's decision is final.
pub(crate) async fn certify<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    Instance { population, supergraph }: Instance,
) -> Result<Certified, TransportError> {
    let mut agreement = check(cx, subdomain, table, stars).await?;
    let (mut gathered, mut certificate) = (Vec::new(), Certificate::default());
    let mut number = 0;
    loop {
        let rounds = splay(cx, subdomain, table, stars, &agreement, gathered, population).await?;
        agreement = self::certificate(cx, subdomain, table, stars).await?;
        let results = Results { subdomain, chart: Chart { table, stars }, supergraph };
        let pass = Pass { number, rounds, population };
        let MergedResult { outcome, cells_here, whole } = merge(cx, results, &agreement, pass).await?;
        certificate.add(whole);
        if matches!(outcome, Outcome::Passed | Outcome::Failed) {
            return Ok(Certified { outcome, cells_here, certificate });
        }
        gathered = gather(cx, table, stars, (&agreement, outcome), &mut certificate).await?;
        number += 1;
    }
}
