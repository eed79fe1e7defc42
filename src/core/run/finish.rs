//! The end of a run: the certificate judged, the result put together.

use std::sync::OnceLock;
use std::time::Instant;

use septet_geometry::graph::Supergraph;
use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::ledger::Ledger;
use septet_protocol::transport::TransportError;
use septet_workers::config::WorkerConfig;

use crate::coordinator::Collected;
use crate::error::{Error, Refutation};
use crate::input::prepare::Prepared;
use crate::result::canonical::{Cells, Given};
use crate::result::pieces::Pieces;
use crate::result::run::{Run, Settled, Store};

/// The parameters of a machine, and its supergraph.
pub(crate) fn settled(machine: &WorkerConfig, supergraph: Option<Supergraph>, why: String) -> Settled {
    Settled { workers: machine.workers, leaf: machine.tree.leaf, supergraph, why, counted: machine.counted }
}

/// The result for points that span less than the space: no cells, nothing run.
pub(crate) fn flat_result<P: Point>(
    input: usize,
    ready: &Prepared<'_, P>,
    machine: &WorkerConfig,
    why: String,
    start: Instant,
) -> Run {
    let seconds = start.elapsed().as_secs_f64();
    let why = if why.is_empty() { "nothing to triangulate".to_string() } else { why };
    Run {
        space: P::DIM,
        dimension: ready.dimension,
        points: ready.accounting(input),
        store: Store::Rows(Given::new(P::DIM, Vec::new(), Cells::default())),
        canonical: OnceLock::new(),
        graph: None,
        hull_facets: 0,
        stars_local: 0,
        stars_repaired: 0,
        exchange_rounds: 0,
        fallback: None,
        ledger: Ledger::default(),
        plan: None,
        refutation: None,
        picture: None,
        settled: settled(machine, None, why),
        tasks: None,
        phase_seconds: Vec::new(),
        triangulate_seconds: seconds,
        total_seconds: seconds,
    }
}

/// What the stars lack of a certificate, if anything.
///
/// # Errors
/// If not everything that was announced has arrived.
pub(crate) fn certify(
    collected: &Collected,
    population: u64,
    dimension: usize,
    workers: u32,
) -> Result<Option<Refutation>, Error> {
    let merged = &collected.merged;
    let passed = merged.stars == population && merged.disagreements == 0 && merged.minima == 1;
    let pieces: usize = collected.pieces.iter().map(|p| p.piece.rows.len() / 2).sum();
    let cells: usize = collected.cells.iter().map(Vec::len).sum();
    let rows = ((cells + pieces) / (dimension + 1)) as u64;
    // Stars that do not agree send no cells.
    let expected = if passed { merged.cells } else { 0 };
    if rows != expected || collected.parts != workers {
        let parts = collected.parts;
        let reason = format!("{rows} of {expected} cells and {parts} of {workers} ledgers arrived");
        return Err(TransportError::WorkerFailed { rank: COORDINATOR, reason }.into());
    }
    let refutation = Refutation {
        disagreements: merged.disagreements,
        minima: merged.minima,
        stars: merged.stars,
        points: population,
    };
    Ok((!passed).then_some(refutation))
}

pub(crate) fn finish<P: Point>(
    input: usize,
    ready: &Prepared<'_, P>,
    collected: Collected,
    machine: &WorkerConfig,
    why: String,
    start: Instant,
) -> Result<Run, Error> {
    let population = ready.positions.len() as u64;
    let merged = collected.merged;
    let (with_owner, exponent) = (machine.shown.with_leaves, ready.exponent);
    let (store, triangulate_seconds) = if machine.counted {
        // Cells of a counted run come as rows; what is measured ends before they do.
        let collecting: f64 = collected.seconds.iter().filter(|s| s.0 == Phase::Collect).map(|s| s.1).sum();
        let seconds = start.elapsed().as_secs_f64() - collecting;
        let beside = Cells {
            rows: Vec::new(),
            owner: with_owner.then_some(collected.owner),
            leaf: with_owner.then_some(collected.leaves),
        };
        (Store::Rows(Given::new(P::DIM, collected.cells, beside)), seconds)
    } else {
        // Stars that do not agree send no cells.
        let hull_facets = if collected.pieces.is_empty() { 0 } else { merged.hull_facets };
        let joined = Pieces::join(P::DIM + 1, collected.pieces, hull_facets);
        let pieces = joined.ok_or_else(|| TransportError::WorkerFailed {
            rank: COORDINATOR,
            reason: "the pieces do not fit together".to_string(),
        })?;
        (Store::Pieces(pieces, with_owner), start.elapsed().as_secs_f64())
    };
    let why = if machine.counted { collected.why.unwrap_or(why) } else { NO_SUPERGRAPH.to_string() };
    Ok(Run {
        space: P::DIM,
        dimension: P::DIM as isize,
        points: ready.accounting(input),
        store,
        canonical: OnceLock::new(),
        graph: machine.shown.collect_graph.then(|| sorted_edges(&collected.edges)),
        hull_facets: merged.hull_facets,
        stars_local: merged.local,
        stars_repaired: merged.repaired,
        exchange_rounds: merged.exchange_rounds,
        fallback: collected.fallback,
        ledger: Ledger::finish(collected.ledger, population),
        plan: None,
        refutation: None,
        picture: (machine.shown.view > 0)
            .then(|| collected.album.view::<P>(population, machine.shown.view, exponent)),
        settled: settled(machine, collected.supergraph.filter(|_| machine.counted), why),
        tasks: None,
        phase_seconds: collected.seconds,
        triangulate_seconds,
        total_seconds: start.elapsed().as_secs_f64(),
    })
}

/// Why a triangulation has no supergraph to report.
const NO_SUPERGRAPH: &str = "pieces look across their seams by their own circumspheres";

fn sorted_edges(flat: &[u64]) -> Vec<(u64, u64)> {
    let mut edges: Vec<(u64, u64)> = flat.chunks_exact(2).map(|e| (e[0].min(e[1]), e[0].max(e[1]))).collect();
    edges.sort_unstable();
    edges
}
