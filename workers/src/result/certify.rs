//! Checks, splays and certifies the stars until rank 0 decides that the result passes or fails.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::coordinator::Certificate;
use crate::machine::context::Context;
use crate::result::merge::{OwnedCells, Pass, Results, merge};
use crate::splaying::fallback::gather;
use crate::splaying::splay::splay;
use crate::stars::check::{certificate, check};
use crate::stars::owned::{Stars, StarsView};
use crate::state::subdomain::Subdomain;
use crate::state::table::Table;

/// Properties of the run that are equal on all ranks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instance {
    /// The number of points of all ranks.
    pub(crate) population: u64,
    /// The supergraph of the stars.
    pub(crate) supergraph: Supergraph,
}

/// The final decision of the coordinator on the stars.
#[derive(Debug)]
pub(crate) struct Certified {
    instance: Instance,
    passed: bool,
    owned_cells: OwnedCells,
    certificate: Certificate,
}

impl Certified {
    /// Returns the properties of the run.
    pub(crate) fn instance(&self) -> Instance {
        self.instance
    }

    /// Returns `true` if the certificate passed.
    pub(crate) fn has_passed(&self) -> bool {
        self.passed
    }

    /// Returns the cells that belong to this rank.
    pub(crate) fn owned_cells(&self) -> &OwnedCells {
        &self.owned_cells
    }

    /// Returns the certificate. It is empty except on the coordinator.
    pub(crate) fn into_certificate(self) -> Certificate {
        self.certificate
    }
}

/// Checks, splays and certifies the stars. If the certificate does not pass, gathers the open regions and repeats these
/// steps until the decision of the coordinator is final.
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
        agreement = self::certificate(cx, subdomain, table, stars).await?;
        let results = Results::new(subdomain, StarsView::new(table, stars), supergraph);
        let pass = Pass { number, rounds, population };
        let (outcome, owned_cells, whole) = merge(cx, results, &agreement, pass).await?.into_parts();
        certificate.add(whole);
        if matches!(outcome, Outcome::Passed | Outcome::Failed) {
            let passed = outcome == Outcome::Passed;
            return Ok(Certified { instance, passed, owned_cells, certificate });
        }
        gathered = gather(cx, table, stars, &agreement, outcome, &mut certificate).await?;
        number += 1;
    }
}
