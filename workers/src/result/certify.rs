//! Check, splaying and certificate, until rank 0 decides that the result passes or fails.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::coordinator::Certificate;
use crate::machine::context::Context;
use crate::result::merge::{MergedResult, OwnedCells, Pass, Results, merge};
use crate::splaying::fallback::gather;
use crate::splaying::splay::splay;
use crate::stars::check::{self, check};
use crate::stars::owned::{Stars, StarsView};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Properties of the run that every rank has.
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
    outcome: Outcome,
    /// The cells that belong to this rank.
    owned_cells: OwnedCells,
    /// The certificate, on the coordinator.
    certificate: Certificate,
    /// The instance that was certified.
    instance: Instance,
}

impl Certified {
    /// Returns `true` if the certificate passed.
    pub(crate) fn has_passed(&self) -> bool {
        self.outcome == Outcome::Passed
    }

    /// Returns the cells that belong to this rank.
    pub(crate) fn owned_cells(&self) -> &OwnedCells {
        &self.owned_cells
    }

    /// Returns the instance that was certified.
    pub(crate) fn instance(&self) -> Instance {
        self.instance
    }

    /// Returns the certificate, which is empty on every rank but the coordinator.
    pub(crate) fn into_certificate(self) -> Certificate {
        self.certificate
    }
}

/// Checks and splays the stars, and certifies them. Gathers open regions if splaying does not suffice, and repeats until
/// the coordinator's decision is final.
pub(crate) async fn certify<P: Point>(
    cx: &mut Context<P>,
    subdomain: &Subdomain<P>,
    table: &mut Table<P>,
    stars: &mut Stars<P>,
    instance: Instance,
) -> Result<Certified, TransportError> {
    let Instance { population, supergraph } = instance;
    let mut agreement = check(cx, subdomain, table, stars).await?;
    let (mut gathered, mut certificate) = (Vec::new(), Certificate::default());
    let mut number = 0;
    loop {
        let rounds = splay(cx, subdomain, table, stars, &agreement, gathered, population).await?;
        agreement = check::certificate(cx, subdomain, table, stars).await?;
        let results = Results::new(subdomain, StarsView::new(table, stars), supergraph);
        let pass = Pass { number, rounds, population };
        let MergedResult { outcome, owned_cells, whole } = merge(cx, results, &agreement, pass).await?;
        certificate.add(whole);
        if matches!(outcome, Outcome::Passed | Outcome::Failed) {
            return Ok(Certified { outcome, owned_cells, certificate, instance });
        }
        gathered = gather(cx, table, stars, &agreement, outcome, &mut certificate).await?;
        number += 1;
    }
}
