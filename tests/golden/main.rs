//! Compares the outputs and counts of all cases with committed files.
//!
//! `cargo test --test golden [-- FILTER]` runs the cases whose names contain FILTER and reports which differ from
//! `outputs.txt` and `counts.txt`, with the first difference. With `SEPTET_GOLDEN=write` it writes these files instead. Outputs
//! are hashes; counts are lines of the ledger, field by field, or sums and hashes by phase for the larger runs.

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
use store::Store;

/// Smallest number of cases with refused draws in which groups must draw again.
const RETRYING: usize = 10;

/// The options of the command line.
struct Options {
    filter: Option<String>,
    list: bool,
    write: bool,
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
        Options {
            filter,
            skipped,
            list,
            write: env::var_os("SEPTET_GOLDEN").is_some_and(|value| value == "write"),
        }
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

/// The record of a case, and the seconds that it took.
#[derive(Default)]
struct Finished {
    record: Record,
    seconds: f64,
}

/// Runs the cases on all cores, and returns their records in the order of the cases.
fn records(selected: &[&Case]) -> Vec<Finished> {
    let finished: Vec<Mutex<Finished>> = selected.iter().map(|_| Mutex::default()).collect();
    let queue = Mutex::new(selected.iter().zip(&finished));
    let next = || queue.lock().unwrap().next();
    let work = || {
        while let Some((case, place)) = next() {
            let begun = Instant::now();
            let mut record = Record::default();
            (case.run)(&mut record);
            *place.lock().unwrap() = Finished { record, seconds: begun.elapsed().as_secs_f64() };
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
    for (case, Finished { record, seconds }) in selected.iter().zip(records(selected)) {
        retrying += usize::from(case.retries && record.retries > 0);
        let differences = if options.write {
            store.replace(&case.name, &record);
            Vec::new()
        } else {
            store.differences(&case.name, &record)
        };
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
