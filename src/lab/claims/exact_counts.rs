//! The counts of fixed runs, as integers.
//!
//! A band around a measured value lets small changes of the charges pass. The counts of a run are functions of its points,
//! its seed and its parameters. So the table states them exactly, at seed 1, and any change of any count is a difference.
//!
//! These runs are also made at the seed of the laboratory with two numbers of workers. Their counts must be equal, except
//! for the rounds, which depend on the number of workers.
//!
//! `SEPTET_COUNTS=write cargo test -p septet-lab --lib exact_counts` writes the table after a change of the charges.

use std::collections::BTreeMap;

use septet_core::generate::Kind;
use septet_core::spec::{Correction, SeparatorSets, Workers};
use septet_core::{Outcome, Spec, TrafficTotal};

use super::lab::Lab;
use super::sample::Sample;
use super::{Claim, ClaimError, Figure, Reading, Role};

/// The table: run, phase and counts in each line.
const TABLE: &str = include_str!("exact_counts.txt");

/// The seed of the table.
const SEED: u64 = 1;

/// The numbers of workers: those of the table, and others.
const WORKERS: [u32; 2] = [3, 16];

/// The columns of the table.
const COLUMNS: [&str; 4] = ["work", "depth", "exact tests", "rounds"];

/// Number of columns that do not depend on the number of workers.
const FREE_OF_WORKERS: usize = 3;

/// The row of all phases together.
const TOTAL: &str = "total";

pub(super) const CLAIMS: &[Claim] = &[Claim {
    name: "exact-counts",
    role: Role::Test,
    statistics: None,
    source: "Theorem 4.4, on the machine",
    statement: "work, depth, exact tests and rounds are functions of points, seed and parameters",
    reading: Reading::AsPrinted,
    experiment: "Six runs with 3 workers at seed 1: work, depth, exact tests and rounds of each phase and of all phases \
                 together, against a table of integers. The same runs at the seed of the laboratory with 3 and with 16 \
                 workers: work, depth and exact tests",
    bound: "0 counts that differ from the table, or between numbers of workers: counts have no tolerance",
    check: exact_counts,
}];

/// A run with a table.
struct Case {
    name: &'static str,
    sample: Sample,
    sets: SeparatorSets,
}

const fn case(name: &'static str, kind: Kind, (n, d): (u64, usize)) -> Case {
    Case { name, sample: Sample { kind, n, d, lipschitz: None }, sets: SeparatorSets::Ghost }
}

/// The runs. Their sizes are the same for every extent, because the table holds for one size.
static CASES: [Case; 6] = [
    case("uniform-2d", Kind::Uniform, (3000, 2)),
    case("uniform-3d", Kind::Uniform, (2000, 3)),
    Case { sets: SeparatorSets::Both, ..case("uniform-3d-both", Kind::Uniform, (2000, 3)) },
    case("body", Kind::Body, (2000, 3)),
    case("grid", Kind::Grid, (1000, 3)),
    case("sphere", Kind::Sphere, (1000, 3)),
];

/// The counts of a run, by phase.
type Counts = BTreeMap<String, [u64; COLUMNS.len()]>;

fn exact_counts(lab: &mut Lab) -> Result<Vec<Figure>, ClaimError> {
    let mut figures = Vec::new();
    for case in &CASES {
        let found = counted(lab, case, SEED, WORKERS[0])?;
        let columns = &COLUMNS[..];
        figures.push(figure(
            "from the table",
            case,
            SEED,
            &differences(&found, &stated(TABLE, case.name), columns),
        ));
        let seed = lab.seed();
        let few = if seed == SEED { found } else { counted(lab, case, seed, WORKERS[0])? };
        let many = counted(lab, case, seed, WORKERS[1])?;
        let columns = &COLUMNS[..FREE_OF_WORKERS];
        figures.push(figure("between 3 and 16 workers", case, seed, &differences(&few, &many, columns)));
    }
    Ok(figures)
}

fn figure(from: &str, case: &Case, seed: u64, differences: &[String]) -> Figure {
    let first = differences.first().map_or_else(String::new, |first| format!("; the first: {first}"));
    let on = format!("{} ({})", case.sample.name(), case.name);
    Figure::at_most(format!("counts that differ {from}{first}"), on, seed, differences.len() as f64, 0.0)
}

/// Returns the counts of a run. Everything that the laboratory may vary, except the planted fault, is fixed.
fn counted(lab: &mut Lab, case: &Case, seed: u64, workers: u32) -> Result<Counts, ClaimError> {
    let run = lab.run(case.sample, seed, |spec| {
        spec.with(|c| {
            c.machine.workers = Workers::Count(workers);
            c.recursion.graph = Spec::default().recursion.graph;
            c.recursion.neighbours = Correction::Descent;
            c.recursion.sets = case.sets;
        })
    })?;
    Ok(counts_of(&run))
}

fn counts_of(run: &Outcome) -> Counts {
    let row = |work, depth, exact_tests, rounds| [work, depth, exact_tests, rounds];
    let phases = run.ledger.phases.iter().map(|total| {
        (total.phase.name().to_owned(), row(total.work, total.depth, total.exact_tests, total.rounds))
    });
    let (sum, traffic) = (run.ledger.totals.sum(), TrafficTotal::of(&run.ledger));
    let total = (TOTAL.to_owned(), row(sum.work, sum.depth, sum.exact_tests, traffic.rounds));
    phases.chain([total]).collect()
}

/// Returns the rows of a run in the table. A line that is not a row states nothing, so the phase of the run has no row.
fn stated(table: &str, run: &str) -> Counts {
    let row = |line: &str| {
        let (name, rest) = line.split_once(' ')?;
        let (phase, numbers) = rest.split_once(' ')?;
        let numbers: Option<Vec<u64>> = numbers.split(' ').map(|number| number.parse().ok()).collect();
        (name == run).then_some((phase.to_owned(), numbers?.try_into().ok()?))
    };
    table.lines().filter_map(row).collect()
}

/// Returns the differences between two runs in the first `columns`. A phase that only one of them has is a difference.
fn differences(found: &Counts, expected: &Counts, columns: &[&str]) -> Vec<String> {
    let mut all = Vec::new();
    for (phase, counts) in found {
        let Some(others) = expected.get(phase) else {
            all.push(format!("{phase} is not expected"));
            continue;
        };
        let pairs = columns.iter().zip(counts.iter().zip(others));
        let unequal = pairs.filter(|(_, (count, other))| count != other);
        all.extend(unequal.map(|(name, (count, other))| format!("{name} of {phase}: {count}, not {other}")));
    }
    let missing = expected.keys().filter(|phase| !found.contains_key(*phase));
    all.extend(missing.map(|phase| format!("{phase} is missing")));
    all
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::super::LabOptions;
    use super::*;

    /// The file of the table.
    const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/claims/exact_counts.txt");

    /// Returns the table of all runs.
    fn table() -> String {
        let mut lab = Lab::new(LabOptions::default(), |_| {});
        let mut text = format!("# run phase {}\n", COLUMNS.map(|name| name.replace(' ', "-")).join(" "));
        for case in &CASES {
            for (phase, counts) in counted(&mut lab, case, SEED, WORKERS[0]).unwrap() {
                let numbers = counts.map(|count| count.to_string()).join(" ");
                writeln!(text, "{} {phase} {numbers}", case.name).unwrap();
            }
        }
        text
    }

    #[test]
    fn the_file_has_the_exact_counts() {
        let found = table();
        if std::env::var_os("SEPTET_COUNTS").is_some_and(|value| value == "write") {
            std::fs::write(FILE, found).unwrap();
        } else {
            let changed: Vec<&str> =
                found.lines().filter(|line| TABLE.lines().all(|old| old != *line)).collect();
            assert_eq!(found, TABLE, "SEPTET_COUNTS=write writes {FILE}; these lines differ: {changed:#?}");
        }
    }

    #[test]
    fn every_difference_is_named() {
        let table = "# run phase work depth exact-tests rounds\na hulls 5 4 3 2\nb hulls 1 1 1 1\na check 9 9 9 9\na x 1\n";
        let expected = stated(table, "a");
        assert_eq!(expected.len(), 2, "a line without counts states nothing");
        assert_eq!(differences(&expected, &expected, &COLUMNS), [""; 0]);
        let found = stated("a hulls 6 4 3 1\na merge 1 1 1 1\n", "a");
        let all = differences(&found, &expected, &COLUMNS);
        assert_eq!(
            all,
            [
                "work of hulls: 6, not 5",
                "rounds of hulls: 1, not 2",
                "merge is not expected",
                "check is missing"
            ]
        );
        assert_eq!(differences(&found, &expected, &COLUMNS[..FREE_OF_WORKERS]).len(), 3);
    }
}
