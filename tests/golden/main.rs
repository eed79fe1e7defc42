//! Compares the outputs and counts of all cases with committed files.
//!
//! `cargo test --test golden [-- FILTER]` runs the cases whose names contain FILTER and reports which differ from
//! `outputs.txt` and `counts.txt`, by run and by output or section. With `SEPTET_GOLDEN=write` it writes these files instead.
//! Outputs are hashes. Counts are one hash for each section of a run, over every field of the ledger.
//!
//! The full text of a case that differs is written to `target/tmp/golden/CASE.txt`. `SEPTET_GOLDEN=explain` writes the text
//! of every case. To see what a commit changes, run it on both commits and compare the files.

mod calls;
mod cases;
mod domains;
mod record;
mod sets;
mod store;

use std::env;
use std::process::ExitCode;
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

use cases::Case;
use record::Record;
use store::{Store, explain};

/// Smallest number of cases with refused draws in which groups must draw again.
const RETRYING: usize = 10;

/// The options of the command line.
struct Options {
    filter: Option<String>,
    list: bool,
    write: bool,
    /// Whether the full text of every case is written.
    explain: bool,
    /// Cases whose names contain one of these words do not run.
    skipped: Vec<String>,
}

impl Options {
    fn read() -> Self {
        let (mut filter, mut skipped, mut list) = (None, Vec::new(), false);
        let mut arguments = env::args().skip(1);
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--skip" => skipped.extend(arguments.next()),
                "--list" => list = true,
                _ if !argument.starts_with('-') && filter.is_none() => filter = Some(argument),
                _ => {}
            }
        }
        let mode = |word: &str| env::var_os("SEPTET_GOLDEN").is_some_and(|value| value == word);
        Options { filter, skipped, list, write: mode("write"), explain: mode("explain") }
    }

    fn selects(&self, case: &Case) -> bool {
        let matches = |word: &String| case.name.contains(word.as_str());
        self.filter.as_ref().is_none_or(matches) && !self.skipped.iter().any(matches)
    }
}

fn main() -> ExitCode {
    let options = Options::read();
    let cases = cases::all();
    let selected: Vec<&Case> = cases.iter().filter(|case| options.selects(case)).collect();
    if options.list {
        for case in &selected {
            println!("{}: test", case.name);
        }
        return ExitCode::SUCCESS;
    }
    match Store::open(options.write) {
        Ok(store) => run(&selected, store, &options, cases.len()),
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The record of a case, where it differs, and the seconds that it took.
#[derive(Default)]
struct Finished {
    record: Record,
    differences: Vec<String>,
    seconds: f64,
}

impl Finished {
    /// Runs a case, and writes its full text if it differs.
    fn of(case: &Case, store: &Store, options: &Options) -> Finished {
        let begun = Instant::now();
        let mut record = Record::default();
        (case.run)(&mut record);
        let mut differences = if options.write { Vec::new() } else { store.differences(&case.name, &record) };
        if options.explain || !differences.is_empty() {
            let text = explain(&case.name, &record).map(|path| format!("full text: {}", path.display()));
            let failed = !differences.is_empty() || text.is_err();
            differences.extend(failed.then(|| text.unwrap_or_else(|error| error)));
        }
        record.text = String::new();
        Finished { record, differences, seconds: begun.elapsed().as_secs_f64() }
    }
}

/// Runs the cases on all cores, and returns their records in the order of the cases.
fn records(selected: &[&Case], store: &Store, options: &Options) -> Vec<Finished> {
    let finished: Vec<Mutex<Finished>> = selected.iter().map(|_| Mutex::default()).collect();
    let queue = Mutex::new(selected.iter().zip(&finished));
    let next = || queue.lock().unwrap().next();
    let work = || {
        while let Some((case, place)) = next() {
            *place.lock().unwrap() = Finished::of(case, store, options);
        }
    };
    thread::scope(|scope| {
        for _ in 1..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
        work();
    });
    finished.into_iter().map(|place| place.into_inner().unwrap()).collect()
}

fn run(selected: &[&Case], mut store: Store, options: &Options, of: usize) -> ExitCode {
    let start = Instant::now();
    let (mut failed, mut retrying) = (0, 0);
    let finished = records(selected, &store, options);
    for (case, Finished { record, differences, seconds }) in selected.iter().zip(finished) {
        retrying += usize::from(case.retries && record.retries > 0);
        if options.write {
            store.replace(&case.name, &record);
        }
        let result = if differences.is_empty() { "ok" } else { "FAILED" };
        println!("test {} ... {result} ({seconds:.1} s)", case.name);
        for difference in &differences {
            println!("    {difference}");
        }
        failed += usize::from(!differences.is_empty());
    }
    let passed = selected.len() - failed;
    if options.filter.is_none() {
        let names: Vec<&str> = selected.iter().map(|case| case.name.as_str()).collect();
        for name in store.retain(&names, options.write) {
            println!("    {name} is in the golden files but not among the cases");
            failed += 1;
        }
        if retrying < RETRYING {
            println!("    groups draw again in {retrying} cases: at least {RETRYING} must");
            failed += 1;
        }
    }
    if let Err(message) = store.close(options.write) {
        println!("    {message}");
        failed += 1;
    }
    let result = if failed == 0 { "ok" } else { "FAILED" };
    println!(
        "\ntest result: {result}. {passed} passed; {failed} failed; 0 ignored; 0 measured; {} filtered out; finished in \
         {:.2}s",
        of - selected.len(),
        start.elapsed().as_secs_f64()
    );
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
