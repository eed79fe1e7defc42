//! Counts the paper's recursion for all constants of the partition tree, and the insertion baseline on the same sets.
//! Writes the rows as CSV and their tables as Markdown. See `bench/README.md`.
//!
//! All settings run at every size but the largest, where only the default and the best settings run. The CSV file is
//! also the journal: a repeated command skips the rows that the file already has.

mod journal;
mod measure;
mod report;
mod setting;

use std::error::Error;
use std::path::Path;

use journal::{Journal, Key};
use measure::Sets;
use septet_lab::experiment::parse_sizes;
use setting::{Method, Setting};

const USAGE: &str = "constants DIRECTORY [SIZES=2^14,2^16,2^18] [DIMENSION=3] [SEEDS=1] [KIND=well-spaced]";

/// Number of best settings that run at the largest size, for spheres and for planes.
const BEST: usize = 3;

/// The arguments.
struct Plan {
    sizes: Vec<u64>,
    seeds: u64,
    sets: Sets,
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some(directory) = words.first() else { return Err(USAGE.into()) };
    let directory = Path::new(directory);
    std::fs::create_dir_all(directory)?;
    let mut plan = parse(&words[1..])?;
    let mut journal = Journal::open(&directory.join("constants.csv"))?;
    let default = plan.sets.default_setting()?;
    let Some((&largest, smaller)) = plan.sizes.split_last() else { return Err(USAGE.into()) };
    let mut all = setting::grid();
    all.extend([default, default.by_planes(), Setting::insertion()].into_iter().filter(|s| !s.is_in_grid()));
    for &n in smaller {
        fill(&mut journal, &mut plan.sets, &all, n, plan.seeds)?;
    }
    let mut few = vec![default, default.by_planes(), Setting::insertion()];
    if let Some(&n) = smaller.last() {
        for method in [Method::Spheres, Method::Planes] {
            few.extend(journal.best(method, n, BEST));
        }
    }
    fill(&mut journal, &mut plan.sets, &few, largest, plan.seeds)?;
    let text = report::markdown(&journal, default, &few, &plan.sizes);
    std::fs::write(directory.join("constants.md"), &text)?;
    print!("{text}");
    Ok(())
}

/// Parses the arguments in order. Missing arguments have defaults.
fn parse(words: &[String]) -> Result<Plan, Box<dyn Error>> {
    let word = |at: usize, default: &'static str| words.get(at).map_or(default, String::as_str);
    let dimension = word(1, "3").parse()?;
    Ok(Plan {
        sizes: parse_sizes(word(0, "2^14,2^16,2^18"))?,
        seeds: word(2, "1").parse()?,
        sets: Sets::new(word(3, "well-spaced").parse()?, dimension),
    })
}

/// Runs the settings that the journal does not have.
fn fill(
    journal: &mut Journal,
    sets: &mut Sets,
    settings: &[Setting],
    n: u64,
    seeds: u64,
) -> Result<(), Box<dyn Error>> {
    for seed in 1..=seeds {
        for &setting in settings {
            let key = Key { setting, n, seed };
            if !journal.has(key) {
                eprintln!("{setting}, {n} points, seed {seed}");
                journal.push(key, sets.measure(key)?)?;
            }
        }
    }
    Ok(())
}
