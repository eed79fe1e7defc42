//! The end of a run: the decision on the certificate, and the result.

use std::time::{Duration, Instant};

use septet_geometry::point::Point;
use septet_protocol::ids::{Phase, Rank};
use septet_protocol::ledger::Ledger;
use septet_protocol::message::{PointSum, Totals, ViewPart};
use septet_workers::config::WorkerConfig;
use septet_workers::share::{Choice, PieceRows, Share};

use crate::coordinator::{Collected, unbalanced};
use crate::error::{Error, Refutation, incomplete};
use crate::input::Prepared;
use crate::result::canonical::{Export, OwnedRows, Store};
use crate::result::cost_trace::CostTrace;
use crate::result::pieces::Pieces;
use crate::result::point_owner::point_owner;
use crate::result::run::{Run, SetMember, Settled};
use crate::result::view::Album;
use crate::run::settings::Settings;

/// The times of a run.
pub(crate) struct Times {
    /// The start of the call.
    pub(crate) call: Instant,
    /// The time from the start of the call to the settings.
    pub(crate) preparing: Duration,
    /// The start of the machine.
    pub(crate) machine: Instant,
}

/// Returns the result for points that do not span the space: there are no cells and no counts.
pub(crate) fn flat_result(space: usize, input: &Prepared, settings: &Settings, call: Instant) -> Run {
    let seconds = call.elapsed().as_secs_f64();
    let settled = settled_flat(settings);
    let costs = settings.machine.cost_log.take().map(CostTrace::of);
    let point_owner = settings.machine.shown.with_owned.then(|| input.all_of_one());
    Run {
        costs,
        point_owner,
        triangulate_seconds: seconds,
        total_seconds: seconds,
        ..empty(space, input, settled)
    }
}

/// Returns the settings of a run whose points do not span the space.
pub(super) fn settled_flat(settings: &Settings) -> Settled {
    let why = if settings.why.is_empty() { NOTHING } else { &settings.why };
    settings.settled(None, why.to_string())
}

/// Returns the settings of a run that made this choice of a supergraph.
pub(super) fn settled(settings: &Settings, choice: Choice) -> Settled {
    if !settings.machine.counted {
        return settings.settled(None, NO_SUPERGRAPH.to_string());
    }
    settings.settled(choice.supergraph, choice.why.unwrap_or_else(|| settings.why.clone()))
}

/// Returns the seconds of a counted run that do not belong to its measured time, which ends before the cells are
/// collected as rows.
pub(super) fn untimed(machine: &WorkerConfig, phase_seconds: &[(Phase, f64)]) -> f64 {
    let is_collected = |(phase, _): &&(Phase, f64)| machine.counted && *phase == Phase::Collect;
    phase_seconds.iter().filter(is_collected).map(|(_, seconds)| seconds).sum()
}

fn empty(space: usize, input: &Prepared, settled: Settled) -> Run {
    Run::empty(space, input.dimension, input.accounting.clone(), settled)
}

/// Returns the reasons against the certificate, if there are any. All processes of a run have the same totals, and come to
/// the same decision.
///
/// # Errors
/// Fails if cells are missing, if the cells are not those of the certificate, or if the messages do not balance.
pub(crate) fn certify(totals: &Totals, points: PointSum, counted: bool) -> Result<Option<Refutation>, Error> {
    let Totals { merged, cells, cell_hash, hull_facets, balance, .. } = totals;
    let passed = merged.is_certified(points);
    // Shares have no cells if stars disagree.
    let expected = if passed { merged.cells } else { 0 };
    if *cells != expected {
        return Err(incomplete(format!(
            "the shares contain {cells} cells, but the certificate counts {expected}"
        )));
    }
    // Rows of ids have no adjacency, and therefore no hull facets.
    if passed && (merged.cell_hash != *cell_hash || !counted && merged.hull_facets != *hull_facets) {
        return Err(incomplete("the cells of the shares are not those of the certificate".to_string()));
    }
    if passed && *balance != 0 {
        return Err(unbalanced());
    }
    let refutation = Refutation {
        disagreements: merged.disagreements,
        minima: merged.minima,
        stars: merged.stars,
        points: points.count,
        foreign: merged.point_hash != points.hash,
    };
    Ok((!passed).then_some(refutation))
}

/// Orders the charges that the ranks recorded, if the run keeps them.
///
/// # Errors
/// Fails if the record of a rank is missing, for example because the rank runs in another process.
pub(crate) fn cost_trace(machine: &WorkerConfig) -> Result<Option<CostTrace>, Error> {
    let Some(charges) = machine.cost_log.take() else { return Ok(None) };
    let (arrived, ranks) = (charges.len(), machine.ranks());
    if arrived != ranks as usize {
        let reason = format!(
            "{arrived} of {ranks} ranks recorded their charges: a cost trace needs all ranks in one process"
        );
        return Err(incomplete(reason));
    }
    Ok(Some(CostTrace::of(charges)))
}

/// Puts the result together.
///
/// # Errors
/// Fails if the subdomain triangulations do not fit together.
pub(crate) fn finish<P: Point>(
    collected: Collected<P>,
    settings: &Settings,
    times: &Times,
) -> Result<Run, Error> {
    let Collected { input, mut shares, ledger, certified, choice, seconds: phase_seconds } = collected;
    let population = input.population.count;
    let machine = &settings.machine;
    let merged = certified.totals.merged;
    let with_owner = machine.shown.with_leaves;
    let store = if machine.counted {
        Store::Rows(OwnedRows::of(&mut shares, with_owner))
    } else {
        let take = |share: &mut Share<P>| share.piece.take().map(|piece| (share.rank, piece));
        let pieces: Vec<(Rank, PieceRows)> = shares.iter_mut().filter_map(take).collect();
        // Shares have no cells if stars disagree.
        let hull_facets = if pieces.is_empty() { 0 } else { merged.hull_facets };
        let joined = Pieces::join(P::DIM + 1, pieces, hull_facets);
        Store::Pieces(joined.ok_or_else(|| incomplete("the pieces do not fit together".to_string()))?)
    };
    let elapsed = (times.preparing + times.machine.elapsed()).as_secs_f64();
    let triangulate_seconds = elapsed - untimed(machine, &phase_seconds);
    let views: Vec<ViewPart<P>> = shares.iter_mut().filter_map(|share| share.view.take()).collect();
    // Shares have no points if stars disagree.
    let has_owners = machine.shown.with_owned && merged.is_certified(input.population);
    let owners = has_owners.then(|| {
        let reason = || incomplete("the workers do not hold each point once".to_string());
        point_owner(input.accounting.input as usize, &shares, population).ok_or_else(reason)
    });
    let picture = (machine.shown.view > 0)
        .then(|| Album::of(&views).view::<P>(population, machine.shown.view, input.exponent));
    Ok(Run {
        export: Export::new(P::DIM, store, with_owner),
        point_owner: owners.transpose()?,
        graph: machine.shown.with_edges.then(|| sorted_edges(&shares)),
        sets: machine.shown.with_sets.then(|| sorted_members(&shares)),
        hull_facets: merged.hull_facets,
        stars_local: merged.local,
        stars_repaired: merged.repaired,
        exchange_rounds: merged.exchange_rounds,
        fallback: certified.fallback,
        ledger: Ledger::finish(ledger, population, P::DIM),
        picture,
        phase_seconds,
        triangulate_seconds,
        total_seconds: times.call.elapsed().as_secs_f64(),
        ..empty(P::DIM, &input, settled(settings, choice))
    })
}

/// The reason why a run of points that do not span the space has no supergraph.
const NOTHING: &str = "nothing to triangulate";

/// The reason why a triangulation has no supergraph to report.
const NO_SUPERGRAPH: &str =
    "triangulate uses no supergraph: the interface exchange finds neighbours by circumspheres";

fn sorted_members<P>(shares: &[Share<P>]) -> Vec<SetMember> {
    let pairs = shares.iter().flat_map(|share| &share.sets);
    let mut members: Vec<SetMember> = pairs.map(|&[node, point]| SetMember { node, point }).collect();
    members.sort_unstable();
    members
}

fn sorted_edges<P>(shares: &[Share<P>]) -> Vec<(u64, u64)> {
    let ends = shares.iter().flat_map(|share| share.edges.chunks_exact(2));
    let mut edges: Vec<(u64, u64)> = ends.map(|e| (e[0].min(e[1]), e[0].max(e[1]))).collect();
    edges.sort_unstable();
    edges
}
