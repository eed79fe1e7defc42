//! Times the generation of a set, the phases of one run, and the verification of its result.
//!
//! Usage: `septet-bench KIND N [simulate|triangulate] [workers|leaves] [threads] [supergraph] [d] [verify|no]`. The
//! exit code is 2 if an argument is invalid, and 1 if the run fails or its result is wrong.

use std::error::Error;
use std::process::ExitCode;
use std::str::FromStr;
use std::time::Instant;

use septet_core::generate::{Request, generate, parse_sample};
use septet_core::model::Points;
use septet_core::spec::{Alpha, Graph, Neighbours, Workers};
use septet_core::{Outcome, Spec, simulate, triangulate};
use septet_geometry::point::Point;
use septet_verify::{Triangulation, VerifyOptions, verify};

/// The error of the program.
type Failure = Box<dyn Error>;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match setting(&words) {
        Err(failure) => ended(failure.as_ref(), 2),
        Ok(setting) => {
            timed(&setting).map_or_else(|failure| ended(failure.as_ref(), 1), |()| ExitCode::SUCCESS)
        }
    }
}

fn ended(failure: &dyn Error, code: u8) -> ExitCode {
    eprintln!("error: {failure}");
    ExitCode::from(code)
}

/// The arguments.
struct Arguments {
    /// The sample, as text.
    spec: String,
    /// The parsed sample.
    sample: Request,
    config: Spec,
    counted: bool,
    check: bool,
}

/// # Errors
/// Fails if an argument is invalid.
fn setting(words: &[String]) -> Result<Arguments, Failure> {
    const WORDS: usize = 8;
    if let Some(more) = words.get(WORDS) {
        return Err(format!("`{more}`: too many arguments").into());
    }
    let word = |i: usize, default: &'static str| words.get(i).map_or(default, String::as_str);
    let dimension = one_of(word(6, "3"), &[("2", 2), ("3", 3)])?;
    let spec = format!("{}:{},d={dimension}", word(0, "uniform"), word(1, "100000"));
    let threads = number("threads", word(4, "2"))?;
    let workers = match word(3, "2") {
        "leaves" => Workers::Leaves,
        count => Workers::Count(number("workers or `leaves`", count)?),
    };
    let alpha = Alpha::Auto;
    let graphs = [
        ("density", Graph::Density { alpha }),
        ("knn", Graph::Knn { k: Neighbours::Auto }),
        ("overlap", Graph::Overlap { alpha, k: Neighbours::Auto }),
    ];
    let graph = one_of(word(5, "density"), &graphs)?;
    let config = Spec::default().with(|c| {
        c.machine.workers = workers;
        c.machine.threads = Some(threads);
        c.recursion.graph = graph;
    });
    config.check()?;
    Ok(Arguments {
        sample: parse_sample(&spec)?,
        spec,
        config,
        counted: one_of(word(2, "triangulate"), &[("triangulate", false), ("simulate", true)])?,
        check: one_of(word(7, "verify"), &[("verify", true), ("no", false)])?,
    })
}

fn number<T: FromStr>(what: &str, word: &str) -> Result<T, Failure> {
    word.parse().map_err(|_| format!("`{word}`: expected a number of {what}").into())
}

fn one_of<T: Copy>(word: &str, all: &[(&str, T)]) -> Result<T, Failure> {
    let found = all.iter().find(|(name, _)| *name == word).map(|found| found.1);
    let names = || all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    found.ok_or_else(|| format!("`{word}`: expected one of {}", names()).into())
}

/// # Errors
/// Fails if generation or the run fails, or if the result is wrong.
fn timed(setting: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    let set = generate(&setting.sample, &mut |_, _, _| {})?;
    println!("generate {:.2} s, {:?}", start.elapsed().as_secs_f64(), set.notes);
    let config = setting.config.clone().with(|c| c.recursion.spacing = set.spacing.map(|s| s.lipschitz));
    let (n, counted, workers) = (set.points.len(), setting.counted, &config.machine.workers);
    println!("{} n {n} counted {counted} workers {workers:?}", setting.spec);
    match &set.points {
        Points::Plane(points) => report(points, &config, setting),
        Points::Space(points) => report(points, &config, setting),
        Points::Higher(_) => Err("only sets of dimensions 2 and 3".into()),
    }
}

fn report<P: Point>(points: &[P], config: &Spec, setting: &Arguments) -> Result<(), Failure> {
    let run = if setting.counted { simulate(points, config) } else { triangulate(points, config) }?;
    if setting.check {
        let coordinates: &[f64] = bytemuck::cast_slice(points);
        let options = VerifyOptions { perturbed: true, ..VerifyOptions::default() };
        let start = Instant::now();
        let report = verify(
            &Triangulation { dimension: run.space, coordinates, cells: run.cells() },
            &options,
            &mut |_, _, _| {},
        );
        if !report.passed() {
            return Err(format!("the result is wrong: {report:?}").into());
        }
        println!("verify {:.2} s, {} ties", start.elapsed().as_secs_f64(), report.ties);
    }
    print(&run);
    Ok(())
}

fn print(run: &Outcome) {
    println!(
        "triangulate {:.2} s, total {:.2} s, cells {}, {:?} ({})",
        run.times.triangulate,
        run.times.total,
        run.cell_count(),
        run.settled.supergraph,
        run.settled.why
    );
    println!(
        "exchange rounds {} repaired {} local {} fallback {:?} peak {} MB",
        run.exchange_rounds,
        run.stars_repaired,
        run.stars_local,
        run.fallback,
        septet_core::run::memory::peak_rss().unwrap_or(0) >> 20
    );
    for total in &run.ledger.phases {
        let seconds: f64 = run.times.phases.iter().filter(|s| s.0 == total.phase).map(|s| s.1).sum();
        println!(
            "{:<15} {seconds:8.3} s  rounds {:4} messages {:8} bytes {:12} work {:13} exact {:9} depth {:6} critical {:6}",
            total.phase.name(),
            total.rounds,
            total.messages,
            total.bytes,
            total.work,
            total.exact_tests,
            total.depth,
            total.critical_depth
        );
    }
    for (phase, seconds) in &run.times.phases {
        print!("{} {seconds:.2}  ", phase.name());
    }
    println!();
    println!("paper {:?} repair {:?}", run.ledger.totals.paper, run.ledger.totals.repair);
    let leaves = run.ledger.part.nodes.values().filter(|f| f.is_leaf()).count();
    let level = run.ledger.part.nodes.keys().map(|n| n.level()).max().unwrap_or(0);
    let members: u64 = run.ledger.part.nodes.values().map(|f| f.members).sum();
    println!(
        "leaves {leaves} levels {level} members/n {:.2}",
        members as f64 / run.points.used.max(1) as f64
    );
}
