//! Checks of sweeps: the growth of a count.

use crate::experiment::fit::{Conclusion, FitReport, FitRequest, Key, Law, fit};
use crate::experiment::{DepthLine, Line, Splits};
use crate::rows::LevelRow;
use septet_protocol::ledger::RoundRow;

use super::broken::{Broken, describe, nothing, short};
use super::counts::HasCounts;

/// Returns the fit, or an error if the runs do not determine it.
fn answered(lines: &[Line], request: &FitRequest) -> Result<FitReport, Broken> {
    if lines.is_empty() {
        return Err(nothing(request.y.name()));
    }
    let refused = |error: &dyn std::fmt::Display| Broken {
        what: format!("{}: {error}", request.y.name()),
        table: Vec::new(),
        fit: None,
        first: None,
    };
    fit(lines, request).map_err(|error| refused(&error))
}

/// Describes the round with the most bytes in the largest run, of this phase or of any phase.
fn last_round(lines: &[Line], phase: Option<&str>) -> Option<String> {
    let of = |r: &&RoundRow| r.tally.messages > 0 && phase.is_none_or(|phase| r.key.phase.name() == phase);
    let largest = lines.iter().max_by_key(|line| line.n)?;
    largest
        .rounds
        .iter()
        .filter(of)
        .max_by_key(|r| r.tally.bytes)
        .map(|r| describe(r).replace("above the bound", "to check"))
}

fn broken(what: String, lines: &[Line], report: FitReport) -> Broken {
    let first = last_round(lines, report.request.phase.as_deref());
    Broken { what, table: Vec::new(), fit: Some(Box::new(report)), first }
}

/// Returns, for the largest run, the first level whose mean depth differs from the mean of all levels by more
/// than the margin.
fn first_level(lines: &[Line], phase: &str, margin: f64) -> Option<String> {
    let run = lines.iter().max_by_key(|line| line.n)?;
    let mean = |depth: &DepthLine| depth.sum as f64 / depth.nodes.max(1) as f64;
    let levels: Vec<(&LevelRow<Splits>, f64)> =
        run.levels.iter().filter_map(|level| Some((level, mean(level.detail.depth.get(phase)?)))).collect();
    let all = levels.iter().map(|level| level.1).sum::<f64>() / levels.len().max(1) as f64;
    let (level, depth) = levels.into_iter().find(|level| (level.1 - all).abs() > margin * all)?;
    let LevelRow { level, nodes, largest, .. } = level;
    let (depth, all) = (short(depth), short(all));
    Some(format!(
        "level away from the mean: level {level}, {nodes} nodes of at most {largest} points, depth {depth}, mean of levels {all}"
    ))
}

/// Checks that the depth of a level does not depend on its size. In every series of runs, two one-sided tests must
/// show that the slope of depth against log2 of the size is within `margin`. `margin` is a fraction of the mean depth
/// per doubling.
///
/// # Errors
/// Fails if a series is not flat, or if it has too few levels or runs for a decision.
pub fn level_depth_flat(counted: &impl HasCounts, phase: &str, margin: f64) -> Result<(), Broken> {
    let lines = counted.lines();
    let report = answered(&lines, &FitRequest { margin, ..FitRequest::new(Key::LevelDepth, Some(phase)) })?;
    let sloped = report.series.iter().find(|series| series.conclusion != Conclusion::SizeFree);
    match sloped.map(|series| format!("depth of {phase} level by level: {}", series.words)) {
        None => Ok(()),
        Some(what) => {
            let first = first_level(&lines, phase, margin);
            Err(Broken { first, ..broken(what, &lines, report) })
        }
    }
}

/// Checks, in every series, that the count grows like `law`, and that the sizes suffice to exclude all other laws. In
/// addition, the data must exclude every mixture of `law` with a law that grows faster, if the share of that law in the
/// count at the largest size exceeds `share` (see [`NotExcluded`](crate::experiment::fit::NotExcluded)).
///
/// # Errors
/// Fails if the conclusion is different, if a larger share is not excluded, or if the runs do not determine the growth.
pub fn grows_like(
    counted: &impl HasCounts,
    request: &FitRequest,
    law: Law,
    share: f64,
) -> Result<(), Broken> {
    let lines = counted.lines();
    let report = answered(&lines, request)?;
    let (y, expected) = (request.y.name(), law.name());
    let what = report.series.iter().find_map(|series| {
        if series.conclusion != (Conclusion::Law { law }) {
            return Some(format!("{y}, expected {expected}: {}", series.words));
        }
        // The first share is the largest. NaN exceeds every bound.
        let most = series.not_excluded.first().filter(|most| most.share > share || most.share.is_nan())?;
        let (counted, name) = (short(most.share), most.law.name());
        Some(format!(
            "{y}, {expected}: a share of {name} of up to {counted} is not excluded, above {}",
            short(share)
        ))
    });
    match what {
        None => Ok(()),
        Some(what) => Err(broken(what, &lines, report)),
    }
}

/// Checks, in every series, that the exponent of n in the count is at most `most`. The check compares the upper end of
/// its 95 % interval.
///
/// # Errors
/// Fails if the exponent is larger, or if the runs do not determine it.
pub fn exponent(counted: &impl HasCounts, request: &FitRequest, most: f64) -> Result<(), Broken> {
    let lines = counted.lines();
    let report = answered(&lines, request)?;
    let high = |growth: Option<&crate::experiment::fit::Growth>| {
        growth.and_then(|g| g.exponent).map_or(f64::INFINITY, |e| e.high)
    };
    let worst = report.series.iter().map(|s| high(s.growth.as_ref())).fold(f64::NEG_INFINITY, f64::max);
    if worst <= most {
        return Ok(());
    }
    let what = format!("exponent of {}: up to {} above {}", request.y.name(), short(worst), short(most));
    Err(broken(what, &lines, report))
}

/// Checks that the bytes of a phase on a fixed number of workers grow no faster than a separator set, like
/// `n^(1 - 1/d)`. The upper end of the 95 % interval of the exponent of n must be at most `1 - 1/d + slack`.
///
/// # Errors
/// Fails if the exponent is larger, or if the runs do not determine it.
pub fn surface_bytes(counted: &impl HasCounts, phase: &str, slack: f64) -> Result<(), Broken> {
    let lines = counted.lines();
    let dimension = lines.iter().map(|line| line.dimension).min().unwrap_or(3) as f64;
    exponent(&lines, &FitRequest::new(Key::Bytes, Some(phase)), 1.0 - 1.0 / dimension + slack)
}
