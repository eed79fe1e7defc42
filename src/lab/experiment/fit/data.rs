//! Converts lines to numbers: selects the count, the abscissa and the runs, and refuses mixtures of different
//! quantities.

use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

use septet_protocol::ids::{ByGroup, Group, Phase};
use septet_protocol::ledger::{Count, PhaseTotal, RoundTally};
use serde::Serialize;
use thiserror::Error;

use septet_core::Remedy;
use septet_core::spec::{self, Words};

use super::super::line::{Line, Program, RunOptions, Splits};
use crate::rows::{LevelRow, PhaseRow};

/// A count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Key {
    /// Number of levels of the tree below the root.
    Levels,
    /// Number of leaves of the tree.
    Leaves,
    /// Mean number of attempts at a separator per split.
    Attempts,
    /// Number of edges of the supergraph.
    Edges,
    /// Largest degree of the supergraph.
    MaxDegree,
    /// Number of points of all leaves, ghosts included, divided by the number of points.
    Replication,
    /// Number of rounds of splaying.
    ExchangeRounds,
    /// Longest chain of a phase, with each scan counted as 1.
    Depth,
    /// Longest chain of a phase, with a scan of m items counted as `ceil(log2 m)`.
    DepthLogScan,
    /// Operations of a phase.
    Work,
    /// Tests of a phase that needed exact arithmetic.
    ExactTests,
    /// Rounds of a phase.
    Rounds,
    /// Messages of a phase.
    Messages,
    /// Bytes of a phase.
    Bytes,
    /// Measured seconds of a phase.
    Seconds,
    /// Mean depth of a phase per split, by level, against the mean size of the level's nodes.
    LevelDepth,
    /// Another count of the rounds of a phase: the sum over the rounds, or the largest value.
    #[serde(untagged)]
    Rounded(#[cfg_attr(feature = "schema", schemars(with = "String"))] &'static Count),
}

/// The counts of rounds that no other key has.
fn of_rounds() -> impl Iterator<Item = &'static Count> {
    RoundTally::COUNTS.iter().filter(|count| KEYS.iter().all(|(_, name)| *name != count.name))
}

/// The keys and their names.
const KEYS: [(Key, &str); 16] = [
    (Key::Levels, "levels"),
    (Key::Leaves, "leaves"),
    (Key::Attempts, "attempts"),
    (Key::Edges, "edges"),
    (Key::MaxDegree, "max-degree"),
    (Key::Replication, "replication"),
    (Key::ExchangeRounds, "exchange-rounds"),
    (Key::Depth, "depth"),
    (Key::DepthLogScan, "depth-log-scan"),
    (Key::Work, "work"),
    (Key::ExactTests, "exact-tests"),
    (Key::Rounds, "rounds"),
    (Key::Messages, "messages"),
    (Key::Bytes, "bytes"),
    (Key::Seconds, "seconds"),
    (Key::LevelDepth, "level-depth"),
];

impl Key {
    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Key::Rounded(count) => count.name,
            key => KEYS.iter().find(|(known, _)| *known == key).map_or("", |(_, name)| name),
        }
    }

    /// Returns the names of all counts of phases.
    pub fn names_of_phases() -> impl Iterator<Item = &'static str> {
        let of_phases = KEYS.iter().filter(|(key, _)| key.of_phase()).map(|(_, name)| *name);
        of_phases.chain(of_rounds().map(|count| count.name))
    }

    /// Returns `true` if the count belongs to a phase and not to a whole run.
    pub fn of_phase(self) -> bool {
        use Key::{Bytes, Depth, DepthLogScan, ExactTests, LevelDepth, Messages, Rounds, Seconds, Work};
        let counted = matches!(self, Depth | DepthLogScan | Work | ExactTests | LevelDepth);
        counted || matches!(self, Rounds | Messages | Bytes | Seconds | Key::Rounded(_))
    }

    /// Returns `true` if the count depends on the number of workers.
    pub fn of_machine(self) -> bool {
        matches!(self, Key::Rounds | Key::Messages | Key::Bytes | Key::Seconds | Key::Rounded(_))
    }

    /// Returns `true` if rows are weighted by 1 / y^2, because the count grows like a power of n.
    pub fn is_relative(self) -> bool {
        use Key::{Bytes, Edges, Leaves, Messages, Seconds, Work};
        matches!(self, Leaves | Edges | Work | Messages | Bytes | Seconds)
    }
}

impl FromStr for Key {
    type Err = FitError;

    fn from_str(name: &str) -> Result<Self, FitError> {
        let found = KEYS.iter().find(|(_, known)| *known == name).map(|(key, _)| *key);
        let rounded = || of_rounds().find(|count| count.name == name).map(Key::Rounded);
        found.or_else(rounded).ok_or_else(|| {
            let known: Vec<&str> =
                KEYS.iter().map(|(_, name)| *name).chain(of_rounds().map(|count| count.name)).collect();
            FitError::UnknownKey { name: name.to_string(), known: known.join(", ") }
        })
    }
}

/// The abscissa of a count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Abscissa {
    /// The number of distinct points.
    #[default]
    #[serde(rename = "n")]
    Points,
    /// The number of distinct points divided by the largest permitted number of points in a leaf.
    #[serde(rename = "n/leaf")]
    PointsOverLeaf,
}

impl FromStr for Abscissa {
    type Err = FitError;

    fn from_str(name: &str) -> Result<Self, FitError> {
        match name {
            "n" => Ok(Abscissa::Points),
            "n/leaf" => Ok(Abscissa::PointsOverLeaf),
            _ => Err(FitError::UnknownAbscissa { name: name.to_string() }),
        }
    }
}

/// The default margin of the equivalence tests: 5 % of the mean. For depth by level, it limits the change per
/// doubling. For growth, it limits the change over the range of sizes. Over n = 2^10 to 2^20, a count proportional to
/// log n changes by 6.7 % of its mean per doubling.
pub const MARGIN: f64 = 0.05;

/// A request for a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FitRequest {
    /// The count.
    pub y: Key,
    /// The abscissa.
    pub x: Abscissa,
    /// The phase, or a group that counts work: `paper`, `repair` or `selection`.
    pub phase: Option<String>,
    /// Margin of the equivalence tests. For `level-depth`, it is a fraction of the mean depth per doubling. For all
    /// other counts, it is a fraction of the mean over the whole range of sizes.
    pub margin: f64,
    /// Number of times that the seeds are resampled; 0 for no resampling.
    pub resamples: u32,
}

impl FitRequest {
    /// Returns a request for a count against n, with the margin of 5 %.
    pub fn new(y: Key, phase: Option<&str>) -> FitRequest {
        let phase = phase.map(str::to_string);
        FitRequest { y, x: Abscissa::Points, phase, margin: MARGIN, resamples: 0 }
    }
}

/// A reason why a request cannot be answered.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// There are no lines.
    #[error("there are no runs")]
    NoRuns,
    /// There is no such count.
    #[error("there is no count `{name}`")]
    UnknownKey {
        /// The unknown name.
        name: String,
        /// All names.
        known: String,
    },
    /// The abscissa is neither n nor n/leaf.
    #[error("`{name}` is not an abscissa")]
    UnknownAbscissa {
        /// The unknown name.
        name: String,
    },
    /// The count requires a phase.
    #[error("`{key}` of a whole run mixes the paper's phases with repair and with reading and collecting")]
    Mixes {
        /// The count.
        key: &'static str,
        /// The phases of the lines.
        phases: String,
    },
    /// No line has the phase.
    #[error("no run has a phase `{phase}`")]
    UnknownPhase {
        /// The unknown name.
        phase: String,
        /// The phases of the lines.
        phases: String,
    },
    /// A phase was given for a count that has no phases.
    #[error("`{key}` is a count of the run, not of a phase")]
    NoPhase {
        /// The count.
        key: &'static str,
    },
    /// A group of phases was given for a count by level.
    #[error("`level-depth` requires a single phase")]
    OnePhase,
    /// The margin is out of range.
    #[error("the margin is {margin}, but it must be a fraction of the mean, between 0 and 1")]
    Margin {
        /// The requested margin.
        margin: f64,
    },
    /// There are fewer sizes than a curve needs.
    #[error("{series}: {sizes} sizes do not determine a curve, which requires at least {least}")]
    TooFewSizes {
        /// The runs.
        series: String,
        /// Number of sizes.
        sizes: usize,
        /// Number of sizes required.
        least: usize,
    },
    /// There are fewer levels or runs than the equivalence test requires.
    #[error(
        "{series}: {levels} split levels of {runs} runs do not determine a slope, which requires 3 runs with 2 levels"
    )]
    TooFewLevels {
        /// The runs.
        series: String,
        /// Number of levels.
        levels: usize,
        /// Number of runs.
        runs: usize,
    },
    /// A size has too few runs for resampling.
    #[error("{series}: {seeds} seeds at size {size:.0} are too few to resample")]
    TooFewSeeds {
        /// The runs.
        series: String,
        /// The size.
        size: f64,
        /// Number of seeds.
        seeds: usize,
        /// Number of seeds required.
        least: usize,
    },
    /// No line has this count.
    #[error("no line has `{key}`: the runs stopped before it, did not need it, or were not counted")]
    Nothing {
        /// The count.
        key: &'static str,
    },
    /// Speed-up is requested for runs that were not timed.
    #[error("no line is a timed triangulation")]
    NotTimed,
    /// Speed-up is requested, but there is no serial run on the same points.
    #[error(
        "no serial run of {set} in these lines: speed-up is relative to the best serial program, never to one \
         worker"
    )]
    NoSerial {
        /// Kind, dimension, number of points, and seed.
        set: String,
    },
}

impl FitError {
    /// Returns what to do.
    pub fn remedy(&self) -> Option<Remedy> {
        Some(match self {
            Self::NoRuns => Remedy::of("write some with `septet scale`"),
            Self::UnknownKey { known, .. } => Remedy::of("the counts are ").and(known),
            Self::UnknownAbscissa { .. } => Remedy::of("choose n or n/leaf"),
            Self::Mixes { phases, .. } => {
                Remedy::of("choose a {phase}: paper (all of the paper's), repair, selection, or one of ")
                    .and(phases)
            }
            Self::UnknownPhase { phases, .. } => Remedy::of("the phases are ").and(phases),
            Self::NoPhase { .. } => Remedy::of("omit {phase}"),
            Self::OnePhase => Remedy::of("choose partition, neighbours, summaries or merge"),
            Self::TooFewSeeds { least, .. } => {
                let remedy = Remedy::of("run the sweep with ").set("seeds", least);
                remedy.then(" or more, or omit {resample}")
            }
            Self::NotTimed | Self::NoSerial { .. } => {
                Remedy::of("create one with `septet scale` and {timed}")
            }
            Self::Margin { .. }
            | Self::TooFewSizes { .. }
            | Self::TooFewLevels { .. }
            | Self::Nothing { .. } => return None,
        })
    }
}

/// The value of a count in one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measurement {
    /// Number of points requested. It identifies runs of the same size.
    pub(super) asked: u64,
    pub(super) seed: u64,
    pub(super) x: f64,
    pub(super) y: f64,
}

/// Lists the phases of the lines that count work, in order.
pub(super) fn phases(lines: &[Line]) -> String {
    let rows = lines.iter().flat_map(|line| &line.phases).filter(|row| row.group().counts_work());
    let phases: BTreeSet<Phase> = rows.map(|row| row.total.phase).collect();
    phases.into_iter().map(Phase::name).collect::<Vec<_>>().join(", ")
}

/// Returns the group of phases with this name, if its phases count work. A group hides a phase with its name.
fn group(name: &str) -> Option<Group> {
    let groups = ByGroup::<()>::default();
    groups.each().into_iter().map(|(group, ())| group).find(|group| group.name() == name)
}

/// Returns an error for requests that mix different quantities or are meaningless.
pub(super) fn check(lines: &[Line], request: &FitRequest) -> Result<(), FitError> {
    if lines.is_empty() {
        return Err(FitError::NoRuns);
    }
    let key = request.y.name();
    if !(request.margin > 0.0 && request.margin < 1.0) {
        return Err(FitError::Margin { margin: request.margin });
    }
    match (&request.phase, request.y.of_phase()) {
        (None, true) => return Err(FitError::Mixes { key, phases: phases(lines) }),
        (Some(_), false) => return Err(FitError::NoPhase { key }),
        (None, false) => return Ok(()),
        (Some(_), true) => {}
    }
    let phase = request.phase.as_deref().unwrap_or_default();
    if group(phase).is_some() {
        return if request.y == Key::LevelDepth { Err(FitError::OnePhase) } else { Ok(()) };
    }
    if lines.iter().any(|line| line.phase(phase).is_some()) {
        return Ok(());
    }
    Err(FitError::UnknownPhase { phase: phase.to_string(), phases: phases(lines) })
}

/// Groups lines that belong to one curve: those with the same [`series_name`]. Of several lines with the same size and
/// seed, the first is kept.
pub(super) fn series(lines: &[Line], request: &FitRequest) -> BTreeMap<String, Vec<Line>> {
    let mut series: BTreeMap<String, Vec<Line>> = BTreeMap::new();
    let mut seen: BTreeSet<(String, u64, u64)> = BTreeSet::new();
    for line in lines.iter().filter(|line| line.program == Program::Simulate) {
        let name = series_name(line, request.y);
        if seen.insert((name.clone(), line.asked, line.seed)) {
            series.entry(name).or_default().push(line.clone());
        }
    }
    series
}

/// Returns the name of the group of a run for this count. The name contains the kind, the dimension and the Lipschitz
/// constant of the set. It also contains the options of the algorithm, unless their values are defaults. It contains
/// workers, threads and the transport only if the count depends on them. It contains neither size nor seed.
pub(crate) fn series_name(line: &Line, key: Key) -> String {
    let machine = key.of_machine();
    let s = &line.settings;
    let kind = if line.kind.is_empty() { "points" } else { &line.kind };
    let mut parts = vec![kind.to_string(), format!("{}D", line.dimension)];
    parts.extend(s.lipschitz.map(|lipschitz| format!("lipschitz {lipschitz}")));
    if machine && s.weak {
        parts.push("weak".to_string());
    } else if machine {
        let workers = if s.workers.is_empty() { line.workers.to_string() } else { s.workers.clone() };
        parts.push(format!("{workers} workers"));
    }
    if key == Key::Seconds {
        parts.push(format!("{} threads", s.threads));
        parts.extend(s.text("transport"));
    }
    parts.extend(options_in_name(s));
    parts.join(", ")
}

/// Returns the options of the algorithm in the name of a group.
fn options_in_name(settings: &RunOptions) -> Vec<String> {
    let until = settings.until.map(|until| format!("until {}", until.name()));
    spec::series_name(true, |row| settings.text(row.key)).into_iter().chain(until).collect()
}

/// Returns the value of the count in a line, or `None` if the line does not contain the count.
pub(super) fn value(line: &Line, request: &FitRequest) -> Option<Measurement> {
    let tree = &line.tree;
    let splits = tree.nodes - tree.leaves;
    let y = match request.y {
        Key::Levels => f64::from(tree.levels),
        Key::Leaves => tree.leaves as f64,
        Key::Attempts => (splits > 0).then(|| tree.attempts as f64 / splits as f64)?,
        Key::Edges => line.graph?.edges as f64,
        Key::MaxDegree => line.graph?.max_degree as f64,
        Key::Replication => line.graph?.replication,
        Key::ExchangeRounds => line.end?.exchange_rounds as f64,
        _ => of_phase(line, request)?,
    };
    Some(Measurement { asked: line.asked, seed: line.seed, x: size(line, request.x), y })
}

fn size(line: &Line, x: Abscissa) -> f64 {
    match x {
        Abscissa::Points => line.n as f64,
        Abscissa::PointsOverLeaf => line.n as f64 / line.leaf.max(1) as f64,
    }
}

fn of_phase(line: &Line, request: &FitRequest) -> Option<f64> {
    let name = request.phase.as_deref()?;
    let group = group(name);
    let total = match group {
        // Even a run in which no stars disagree has a total of repair, because it has a certificate.
        Some(group) => Some((*line.totals.get(group)?)?.total),
        None => None,
    };
    let belongs = |phase: Phase| group.map_or(phase.name() == name, |group| phase.group() == group);
    let members: Vec<&PhaseRow> = line.phases.iter().filter(|row| belongs(row.total.phase)).collect();
    if members.is_empty() {
        return None;
    }
    let sum = |f: fn(&PhaseTotal) -> u64| members.iter().map(|row| f(&row.total)).sum::<u64>() as f64;
    Some(match request.y {
        // The longest chain of a group is not the sum over its phases. It is taken from the ledger.
        Key::Depth => total.map_or_else(|| sum(|p| p.depth), |g| g.depth as f64),
        Key::DepthLogScan => total.map_or_else(|| sum(|p| p.depth_log_scan), |g| g.depth_log_scan as f64),
        Key::Work => sum(|p| p.work),
        Key::ExactTests => sum(|p| p.exact_tests),
        Key::Rounds => sum(|p| p.rounds),
        Key::Messages => sum(|p| p.messages),
        Key::Bytes => sum(|p| p.bytes),
        Key::Seconds => members.iter().map(|p| p.seconds).sum(),
        Key::Rounded(count) => {
            let rounds = line.rounds.iter().filter(|row| belongs(row.key.phase));
            let counts = rounds.filter_map(|row| row.tally.get(count.name));
            counts.reduce(|all, one| count.join.of(all, one))? as f64
        }
        _ => return None,
    })
}

/// Returns log2 of the mean size and the mean depth for each split level of a run.
pub(super) fn levels(line: &Line, phase: &str) -> Vec<(f64, f64)> {
    let row = |level: &LevelRow<Splits>| {
        let depth = level.detail.depth.get(phase).filter(|d| d.nodes > 0)?;
        let size = level.detail.split_points as f64 / level.detail.splits.max(1) as f64;
        Some((size.log2(), depth.sum as f64 / depth.nodes as f64))
    };
    line.levels.iter().filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use septet_core::spec::{Setting, Until};

    use super::*;

    #[test]
    fn runs_with_other_options_belong_to_other_series() {
        let name_of = |change: fn(&mut RunOptions)| {
            let mut settings = RunOptions::default();
            change(&mut settings);
            options_in_name(&settings).join(", ")
        };
        let option = |key: &str, value: &str| {
            let options = [(key.to_owned(), Setting::Text(value.to_owned()))];
            options_in_name(&RunOptions { options: options.into(), ..RunOptions::default() }).join(", ")
        };
        assert_eq!(name_of(|_| {}), "");
        assert_eq!(option("supergraph", "auto"), "");
        assert_eq!(option("supergraph", "density"), "density");
        assert_eq!(option("constants", "counting"), "");
        assert_eq!(option("constants", "timing"), "constants for timing");
        assert_eq!(option("samples", "400"), "samples 400");
        assert_eq!(option("tries", "5"), "tries 5");
        assert_eq!(option("leaf", "60"), "leaf 60");
        assert_eq!(name_of(|s| s.until = Some(Until::Partition)), "until partition");
    }
}
