//! The totals of all ranks at the end of a run.
//!
//! **Statement.** Every rank counts and hashes the cells of its share, and takes a snapshot of the balance of its messages.
//! The sums of all ranks, with the certificate of the coordinator, are the same on all ranks, so every process that runs
//! ranks comes to the same decision on the result. Before the snapshot, every message of the run has arrived.
//!
//! **Rounds.** `2 t`, with `t` levels of the tree of all ranks; `4 t` with weights. An exchange without messages ends the phase.
//!
//! **Work and depth.** A vector step over the cells. It is not charged.

use septet_geometry::point::Point;
use septet_protocol::message::{Body, SiteTotals, Totals};
use septet_protocol::transport::TransportError;

use crate::machine::context::Context;
use crate::machine::reduction::Reduced;
use crate::share::Share;
use crate::state::rows::{cells_hash, piece_hash};

/// Number of cells that one core hashes in turn.
const CHUNK: usize = 1 << 14;

/// Returns the totals of all ranks, and those of the hidden sites if points have weights.
///
/// # Errors
/// See [`Context::exchange`].
pub(super) async fn totals<P: Point>(
    cx: &mut Context<P>,
    share: &Share<P>,
) -> Result<(Totals, SiteTotals), TransportError> {
    let corners = P::DIM + 1;
    let mut own = *share.certified.totals;
    let loaded = &share.loaded;
    own.left_out = (loaded.refused.len() + loaded.repeated.len() + loaded.hidden.len()) as u64;
    let (piece, width) = (&share.piece, share.piece.width(corners));
    let chunks: Vec<&[u32]> = piece.rows.chunks(width * CHUNK).collect();
    let hashes = cx.map(&chunks, |rows| cells_hash(rows, corners, width));
    own.cells += (piece.rows.len() / width) as u64;
    // A rank without points contributes no hash to the certificate either.
    if !piece.ids.is_empty() {
        let sum = hashes.into_iter().fold(0, u64::wrapping_add);
        own.cell_hash = own.cell_hash.wrapping_add(piece_hash(cx.rank(), sum, &piece.ids));
    }
    own.hull_facets += piece.hull_facets;
    let mut sites = SiteTotals { hidden: piece.hidden.len() as u64, ..SiteTotals::default() };
    if P::IS_WEIGHTED {
        sites = cx.all_reduce(sites).await?;
    }
    own.balance = cx.balance();
    let all = cx.all_reduce(own).await?;
    cx.end_phase().await?;
    Ok((all, sites))
}

impl<P: Point> Reduced<P> for Totals {
    fn join(self, other: Self) -> Self {
        Totals::join(self, other)
    }

    fn into_body(self) -> Body<P> {
        Body::Totals(Box::new(self))
    }

    fn take(body: &mut Body<P>) -> Option<Self> {
        match body {
            Body::Totals(totals) => Some(**totals),
            _ => None,
        }
    }
}
