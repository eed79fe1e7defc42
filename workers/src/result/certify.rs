//! Check, splaying and certificate, until rank 0 decides that the result passes or fails.

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::outcome::Outcome;
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::result::merge::{OwnedCells, Pass, Results, merge};
use crate::splaying::fallback::gather;
use crate::splaying::splay::splay;
use crate::stars::check::{certificate, check};
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

/// The final decision of rank 0 on the stars.
#[derive(Debug)]
pub(crate) struct Certified {
    passed: bool,
    owned_cells: OwnedCells,
}

impl Certified {
    /// Returns `true` if the certificate passed.
    pub(crate) fn has_passed(&self) -> bool {
        self.passed
    }

    /// Returns the cells that belong to this rank.
    pub(crate) fn owned_cells(&self) -> &OwnedCells {
        &self.owned_cells
    }
}

/// Checks and splays the stars, gathers open regions if splaying does not suffice, and repeats this until rank 0 decides.
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
        let results = Results::new(subdomain, StarsView::new(table, stars), supergraph);
        let (outcome, owned_cells) = merge(cx, results, &agreement, Pass { number, rounds }).await?;
        if matches!(outcome, Outcome::Passed | Outcome::Failed) {
            return Ok(Certified { passed: outcome == Outcome::Passed, owned_cells });
        }
        gathered = gather(cx, table, stars, &agreement, outcome).await?;
        number += 1;
    }
}
