//! Checks of sweeps: how a count grows.

use crate::experiment::fit::{FitReport, Key, Law, Request, Verdict, fit};
use crate::experiment::{DepthLine, LevelLine, Line, RoundLine};

use super::broken::{Broken, nothing, short, told};
use super::counted::Counted;

/// The answer, or a message that says why there is none.
fn answered(lines: &[Line], request: &Request) -> Result<FitReport, Broken> {
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

fn last_round(lines: &[Line], phase: Option<&str>) -> Option<String> {
    let of = |r: &&RoundLine| r.messages > 0 && phase.is_none_or(|phase| r.phase == phase);
    let largest = lines.iter().max_by_key(|line| line.n)?;
    largest
        .rounds
        .iter()
        .filter(of)
        .max_by_key(|r| r.bytes)
        .map(|r| told(r).replace("beyond it", "to look at"))
}

fn broken(what: String, lines: &[Line], report: FitReport) -> Broken {
    let first = last_round(lines, report.request.phase.as_deref());
    Broken { what, table: Vec::new(), fit: Some(Box::new(report)), first }
}

/// In the largest run the first level whose mean depth is off the mean of all by more than the margin.
fn first_level(lines: &[Line], phase: &str, margin: f64) -> Option<String> {
    let run = lines.iter().max_by_key(|line| line.n)?;
    let mean = |depth: &DepthLine| depth.sum as f64 / depth.nodes.max(1) as f64;
    let levels: Vec<(&LevelLine, f64)> =
        run.levels.iter().filter_map(|level| Some((level, mean(level.depth.get(phase)?)))).collect();
    let all = levels.iter().map(|level| level.1).sum::<f64>() / levels.len().max(1) as f64;
    let (level, depth) = levels.into_iter().find(|level| (level.1 - all).abs() > margin * all)?;
    let LevelLine { level, nodes, largest, .. } = level;
    let (depth, all) = (short(depth), short(all));
    Some(format!(
        "level off the mean: level {level}, {nodes} nodes of at most {largest} points, depth {depth}, mean of levels {all}"
    ))
}

/// The depth of a level does not depend on its size: two one-sided tests find the slope of depth against log2 of
/// the size within `margin`, a share of the mean depth per doubling, of every series of runs.
///
/// # Errors
/// A series that is not found flat; also one with too few levels or seeds to tell.
pub fn level_depth_flat(counted: &impl Counted, phase: &str, margin: f64) -> Result<(), Broken> {
    let lines = counted.lines();
    let report = answered(&lines, &Request { margin, ..Request::new(Key::LevelDepth, Some(phase)) })?;
    let sloped = report.series.iter().find(|series| series.verdict != Verdict::SizeFree);
    match sloped.map(|series| format!("depth of {phase} level by level: {}", series.words)) {
        None => Ok(()),
        Some(what) => {
            let first = first_level(&lines, phase, margin);
            Err(Broken { first, ..broken(what, &lines, report) })
        }
    }
}

/// The count grows like this law, and the sizes tell it apart from all others of the list, in every series.
///
/// # Errors
/// Another verdict, or a question that these runs do not answer.
pub fn grows_like(counted: &impl Counted, request: &Request, law: Law) -> Result<(), Broken> {
    let lines = counted.lines();
    let report = answered(&lines, request)?;
    let other = report.series.iter().find(|series| series.verdict != Verdict::Law { law });
    match other.map(|s| format!("{}, expected {}: {}", request.y.name(), law.name(), s.words)) {
        None => Ok(()),
        Some(what) => Err(broken(what, &lines, report)),
    }
}

/// The exponent of n in the count, the upper end of its 95 % interval: at most `most`, in every series.
///
/// # Errors
/// A larger one, or a question that these runs do not answer.
pub fn exponent(counted: &impl Counted, request: &Request, most: f64) -> Result<(), Broken> {
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

/// Bytes of the phase on a fixed number of workers grow like what crosses a separator: the exponent of n, with its
/// 95 % interval, is at most `1 - 1/d + slack`.
///
/// # Errors
/// A larger exponent, or a question that these runs do not answer.
pub fn surface_bytes(counted: &impl Counted, phase: &str, slack: f64) -> Result<(), Broken> {
    let lines = counted.lines();
    let dimension = lines.iter().map(|line| line.dimension).min().unwrap_or(3) as f64;
    exponent(&lines, &Request::new(Key::Bytes, Some(phase)), 1.0 - 1.0 / dimension + slack)
}
