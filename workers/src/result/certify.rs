//! Check, exchange and certificate, until rank 0 is satisfied.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::result::merge::{OwnedCells, Pass, Results, merge};
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

/// Stars on which rank 0 has given its last verdict.
#[derive(Debug)]
pub(crate) struct Certified {
    /// The verdict: passed or failed.
    pub(crate) outcome: Outcome,
    /// The cells that belong to this rank.
    pub(crate) cells_here: OwnedCells,
}

/// Checks the stars and lets them exchange what they miss, with what is gathered if that does not suffice, until rank 0
/// gives its last verdict.
pub(crate) async fn certify<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    Instance { population, supergraph }: Instance,
) -> Result<Certified, TransportError> {
    let mut agreement = check(cx, subdomain, table, stars).await?;
    let mut gathered = Vec::new();
    let mut number = 0;
    loop {
        let rounds = splay(cx, subdomain, table, stars, &agreement, gathered, population).await?;
        agreement = certificate(cx, subdomain, table, stars).await?;
        let results = Results { subdomain, chart: Chart { table, stars }, supergraph };
        let (outcome, cells_here) = merge(cx, results, &agreement, Pass { number, rounds }).await?;
        if matches!(outcome, Outcome::Passed | Outcome::Failed) {
            return Ok(Certified { outcome, cells_here });
        }
        gathered = gather(cx, table, stars, &agreement, outcome).await?;
        number += 1;
    }
}
