//! The end of a run: the decision on the certificate, and the result.
//!
//! **Statement.** All ranks have the same totals, so all processes come to the same decision, and return the same error if
//! there is one.

use std::time::Instant;

use septet_geometry::point::Point;
use septet_protocol::ids::{COORDINATOR, Phase};
use septet_protocol::ledger::Ledger;
use septet_protocol::message::{Totals, ViewPart};
use septet_workers::config::{Task as WorkerTask, WorkerConfig};
use septet_workers::input::Loaded;
use septet_workers::share::{Choice, Share, merged_ledger};

use crate::coordinator::Returned;
use crate::error::{Error, Refutation, incomplete};
use crate::result::cost_trace::CostTrace;
use crate::result::outcome::{Accounting, Facts, Kept, LeftOut, Outcome, Selection, SetMember, Settled};
use crate::result::own_counts::OwnCounts;
use crate::result::share::WorkerShare;
use crate::result::view::Album;
use crate::run::hosts::Left;
use crate::run::settings::Settings;

/// Decides on a run that began at `start`, and puts its result together.
///
/// # Errors
/// Fails if the ranks contradict each other, if messages are missing, if the rows cannot be triangulated, or if cells are
/// missing.
pub(super) fn finish<P: Point>(
    settings: &Settings<'_>,
    left: Left<P>,
    start: Instant,
) -> Result<Outcome, Error> {
    let Left { returned: Returned { mut shares, seconds }, placement, is_team } = left;
    let (machine, keep) = (&settings.machine, settings.spec.keep);
    let fault = if is_team { None } else { machine.fault };
    let ledger = merged_ledger(shares.iter().map(|share| &share.ledger.part), fault);
    // One process also knows the messages of the totals.
    let balance = if is_team { 0 } else { ledger.balance };
    let (exponent, refutation) = End::of(&shares, balance)?.decide::<P>(settings)?;
    let (facts, left_out) = facts(settings, &mut shares, (P::DIM, P::IS_WEIGHTED), refutation);
    let is_empty = facts.is_flat() && !is_selection(machine);
    let points = facts.stars;
    let mut outcome = Outcome { left_out, plan: settings.planning, ..Outcome::of_facts(facts, placement) };
    outcome.has_owners = keep.owner && !is_empty;
    outcome.kept.costs = cost_trace(machine)?;
    if !is_empty {
        keep_contents(&mut outcome.kept, machine, &mut shares);
        outcome.times.phases = seconds;
    }
    let views: Vec<ViewPart<P>> = shares.iter_mut().filter_map(|share| share.view.take()).collect();
    if is_team {
        let roots = shares.iter().filter_map(|share| share.ledger.root).collect();
        outcome.own_counts = Some(OwnCounts { ledger, roots, space: P::DIM, fault: machine.fault });
    } else if !is_empty {
        outcome.ledger = Ledger::finish(ledger, points, P::DIM);
    }
    let workers = shares.into_iter().filter(|share| share.rank != COORDINATOR);
    let own = workers.map(|share| WorkerShare::of::<P>(share.rank, share.piece, (exponent, placement)));
    let own = own.collect::<Option<Vec<_>>>().filter(|own| seams_fit(own));
    outcome.shares = own.ok_or_else(|| incomplete("the shares do not fit together".to_string()))?;
    outcome.times.triangulate = start.elapsed().as_secs_f64() - untimed(machine, &outcome.times.phases);
    outcome.kept.picture = (machine.shown.view > 0 && !is_empty)
        .then(|| Album::of(&views).view::<P>(points, machine.shown.view, exponent));
    outcome.times.total = start.elapsed().as_secs_f64();
    Ok(outcome)
}

/// What all ranks have at the end of a run.
#[derive(Clone, Copy)]
struct End<'a> {
    loaded: &'a Loaded,
    totals: &'a Totals,
    /// The balance of all messages, if this process has all ranks; otherwise 0.
    balance: u64,
}

impl<'a> End<'a> {
    /// Takes the end of a run from the shares of some ranks.
    ///
    /// # Errors
    /// Fails if the ranks contradict each other.
    fn of<P>(shares: &'a [Share<P>], balance: u64) -> Result<Self, Error> {
        let global = |share: &Share<P>| {
            let Loaded { survey, population, dimension, sites, .. } = share.loaded;
            (survey, population, dimension, [sites, share.certified.sites], *share.certified.totals)
        };
        let Some(first) = shares.first() else {
            return Err(incomplete("the process returned no share".to_string()));
        };
        let own = global(first);
        if shares.iter().any(|share| global(share) != own) {
            return Err(incomplete("the ranks have different totals of the run".to_string()));
        }
        Ok(End { loaded: &first.loaded, totals: &first.certified.totals, balance })
    }

    /// Returns the exponent of the power of two by which coordinates were multiplied, and the reasons against the certificate,
    /// if there are any. A run without stars has no certificate.
    ///
    /// # Errors
    /// Fails if messages are missing, if the rows cannot be triangulated, or if cells are missing.
    fn decide<P: Point>(self, settings: &Settings<'_>) -> Result<(i32, Option<Refutation>), Error> {
        let machine = &settings.machine;
        let rows = self.check_rows::<P>(settings);
        let has_stars = rows.is_ok()
            && machine.until.is_none()
            && !is_selection(machine)
            && self.loaded.dimension >= P::DIM as isize;
        // A message that changed on its way could make the ranks refuse a valid input.
        if !has_stars && (self.totals.balance != 0 || self.balance != 0) {
            return Err(unbalanced());
        }
        let exponent = rows?;
        let refutation = if has_stars { self.certify(machine)? } else { None };
        if refutation.is_none() && self.balance != 0 {
            return Err(unbalanced());
        }
        Ok((exponent, refutation))
    }

    /// Checks the rows of all processes. Returns the exponent.
    fn check_rows<P: Point>(self, settings: &Settings<'_>) -> Result<i32, Error> {
        let End { loaded: Loaded { survey, population, .. }, totals, .. } = self;
        if survey.repeats_numbers() {
            return Err(Error::Indices { rows: survey.rows, first: survey.first, last: survey.last });
        }
        let exponent = survey.exponent(settings.machine.task.skips_invalid()).map_err(Error::Points)?;
        let counted = population.count + totals.left_out;
        if counted != survey.rows {
            return Err(incomplete(format!("the ranks account for {counted} of {} rows", survey.rows)));
        }
        settings.check::<P>(population.count)?;
        Ok(exponent)
    }

    /// Returns the reasons against the certificate, if there are any.
    ///
    /// # Errors
    /// Fails if cells are missing, if the cells are not those of the certificate, or if the messages do not balance.
    fn certify(self, machine: &WorkerConfig) -> Result<Option<Refutation>, Error> {
        let points = self.loaded.population;
        let Totals { merged, cells, cell_hash, hull_facets, balance, .. } = self.totals;
        let passed = merged.is_certified(points);
        // Shares have no cells if stars disagree.
        let expected = if passed { merged.cells } else { 0 };
        if *cells != expected {
            return Err(incomplete(format!(
                "the shares contain {cells} cells, but the certificate counts {expected}"
            )));
        }
        // Only neighbours show the hull.
        let has_other_hull = machine.has_neighbours() && merged.hull_facets != *hull_facets;
        if passed && (merged.cell_hash != *cell_hash || has_other_hull) {
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
}

/// Returns `true` if the run selects sites.
fn is_selection(machine: &WorkerConfig) -> bool {
    matches!(machine.task, WorkerTask::Independent { .. })
}

/// Returns the error for messages that changed or vanished.
pub(super) fn unbalanced() -> Error {
    incomplete("the messages that the ranks received are not those that were sent".to_string())
}

/// Returns the facts of the run, and the rows of this process that are not vertices. Takes them from the shares.
fn facts<P: Point>(
    settings: &Settings<'_>,
    shares: &mut [Share<P>],
    (space, has_weights): (usize, bool),
    refutation: Option<Refutation>,
) -> (Facts, LeftOut) {
    let mut left_out = LeftOut::default();
    for share in &mut *shares {
        let repeated = std::mem::take(&mut share.loaded.repeated).into_iter();
        left_out.duplicates.extend(repeated.map(|[row, first]| (row, first)));
        left_out.refused.append(&mut share.loaded.refused);
        left_out.hidden.append(&mut share.loaded.hidden);
        left_out.hidden.append(&mut share.piece.hidden);
    }
    left_out.hidden.sort_unstable();
    left_out.duplicates.sort_unstable();
    left_out.refused.sort_unstable();
    // The coordinator has the first share of its process.
    let first = &mut shares[0];
    let (certificate, choice) = (std::mem::take(&mut first.certified), std::mem::take(&mut first.choice));
    let Loaded { survey, population, dimension, .. } = first.loaded;
    let Totals { merged, cells, left_out: others, .. } = *certificate.totals;
    let [stacked, covered] = [first.loaded.sites.hidden, certificate.sites.hidden];
    let points = Accounting {
        input: survey.rows,
        used: population.count.saturating_sub(covered),
        duplicate: others.saturating_sub(survey.refused + stacked),
        refused: survey.refused,
        hidden: has_weights.then_some(stacked + covered),
    };
    let is_empty = dimension < space as isize && !is_selection(&settings.machine);
    let facts = Facts {
        task: settings.task,
        space,
        dimension,
        points,
        stars: population.count,
        cells,
        hull_facets: if refutation.is_none() { merged.hull_facets } else { 0 },
        stars_local: merged.local,
        stars_repaired: merged.repaired,
        exchange_rounds: merged.exchange_rounds,
        fallback: certificate.fallback,
        refutation,
        settled: if is_empty { settled_flat(settings) } else { settled::<P>(settings, choice) },
    };
    (facts, left_out)
}

/// Returns the settings of a run whose points do not span the space.
fn settled_flat(settings: &Settings<'_>) -> Settled {
    let why = if settings.why.is_empty() { NOTHING } else { &settings.why };
    settings.settled(None, why.to_string())
}

/// Returns the settings of a run that made this choice of a supergraph. A run that stops builds no supergraph.
fn settled<P: Point>(settings: &Settings<'_>, choice: Choice) -> Settled {
    if !settings.machine.by_stars::<P>() {
        return settings.settled(None, NO_SUPERGRAPH.to_string());
    }
    let supergraph = choice.supergraph.filter(|_| settings.machine.until.is_none());
    settings.settled(supergraph, choice.why.unwrap_or_else(|| settings.why.clone()))
}

/// The reason why a run of points that do not span the space has no supergraph.
const NOTHING: &str = "nothing to triangulate";

/// The reason why a triangulation has no supergraph to report.
const NO_SUPERGRAPH: &str =
    "triangulate uses no supergraph: the interface exchange finds neighbours by circumspheres";

/// Returns the seconds of a counted run that do not belong to its measured time, which ends before the cells are
/// collected as rows.
fn untimed(machine: &WorkerConfig, phase_seconds: &[(Phase, f64)]) -> f64 {
    let is_collected = |(phase, _): &&(Phase, f64)| {
        machine.counted && machine.until.is_none() && !is_selection(machine) && *phase == Phase::Collect
    };
    phase_seconds.iter().filter(is_collected).map(|(_, seconds)| seconds).sum()
}

/// Orders the charges that the ranks recorded, if the run keeps them.
///
/// # Errors
/// Fails if the record of a rank is missing, for example because the rank runs in another process.
fn cost_trace(machine: &WorkerConfig) -> Result<Option<CostTrace>, Error> {
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

/// Takes the optional contents from the shares.
fn keep_contents<P>(kept: &mut Kept, machine: &WorkerConfig, shares: &mut [Share<P>]) {
    kept.graph = machine.shown.with_edges.then(|| sorted_edges(shares));
    let with_radii = machine.shown.with_edges && machine.until == Some(Phase::Neighbours);
    kept.radii2 = with_radii.then(|| sorted_radii(shares));
    kept.sets = machine.shown.with_sets.then(|| sorted_members(shares));
    kept.selected = is_selection(machine).then(|| united(shares));
}

fn sorted_radii<P>(shares: &[Share<P>]) -> Vec<(u64, f64)> {
    let mut radii2: Vec<(u64, f64)> = shares.iter().flat_map(|share| &share.radii2).copied().collect();
    radii2.sort_unstable_by_key(|(point, _)| *point);
    radii2
}

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

/// Unites the shares of an independent set, and sums the numbers of undecided points in each round.
fn united<P>(shares: &[Share<P>]) -> Selection {
    let mut all = Selection::default();
    for share in shares {
        all.members.extend(share.selected.members.iter().map(|&id| id as usize));
        let (sums, undecided) = (&mut all.undecided, &share.selected.undecided);
        sums.resize(sums.len().max(undecided.len()), 0);
        sums.iter_mut().zip(undecided).for_each(|(sum, count)| *sum += count);
    }
    all.members.sort_unstable();
    all
}

/// Returns `true` if every neighbour on a worker of this process exists.
fn seams_fit(shares: &[WorkerShare]) -> bool {
    let cells = |rank: u32| {
        let at = shares.binary_search_by_key(&rank, |share| share.rank).ok()?;
        Some(shares[at].cell_count())
    };
    shares
        .iter()
        .flat_map(WorkerShare::seam)
        .all(|seam| cells(seam.rank).is_none_or(|n| (seam.cell as usize) < n))
}
