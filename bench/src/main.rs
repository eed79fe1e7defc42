//! Times generation, one run phase by phase, and the check of its result: `septet-bench KIND N
//! [simulate|triangulate] [workers|leaves] [threads] [supergraph] [d] [verify]`.

use std::time::Instant;

use septet::config::{GraphKind, Transport, Workers};
use septet::geometry::point::Point;
use septet::model::Points;
use septet::verify::{VerifyOptions, verify};
use septet::{Config, Run, simulate, triangulate};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.to_string());
    let dimension = word(6, "3");
    let spec = format!("{}:{},d={dimension}", word(0, "uniform"), word(1, "100000"));
    let request = septet::generate::parse_sample(&spec).expect("a known kind");
    let start = Instant::now();
    let set = septet::generate::generate(&request, &mut |_, _, _| {}).expect("points");
    println!("generate {:.2} s, {:?}", start.elapsed().as_secs_f64(), set.notes);
    let threads: usize = word(4, "2").parse().expect("threads");
    let config = Config {
        workers: match word(3, "2").as_str() {
            "leaves" => Workers::Leaves,
            p => Workers::Count(p.parse().expect("workers")),
        },
        threads,
        transport: Transport::Channel { threads },
        graph: match word(5, "density").as_str() {
            "knn" => GraphKind::Knn,
            "overlap" => GraphKind::Overlap,
            _ => GraphKind::Density,
        },
        spacing: set.spacing.map(|s| s.lipschitz),
        ..Config::default()
    };
    let counted = word(2, "triangulate") == "simulate";
    println!("{spec} n {} counted {counted} workers {:?}", set.points.len(), config.workers);
    let check = word(7, "verify") == "verify";
    match &set.points {
        Points::Plane(points) => report(points, &config, counted, check),
        Points::Space(points) => report(points, &config, counted, check),
    }
}

fn report<P: Point>(points: &[P], config: &Config, counted: bool, check: bool) {
    let run = if counted { simulate(points, config) } else { triangulate(points, config) };
    let run = run.expect("a result");
    if check {
        let coordinates: &[f64] = bytemuck::cast_slice(points);
        let options = VerifyOptions { perturbed: true, ..VerifyOptions::default() };
        let start = Instant::now();
        let verdict = verify(&run.view(coordinates), &options, &mut |_, _, _| {});
        assert!(verdict.passed(), "the result is wrong: {verdict:?}");
        println!("verify {:.2} s, {} ties", start.elapsed().as_secs_f64(), verdict.ties);
    }
    print(&run);
}

fn print(run: &Run) {
    println!(
        "triangulate {:.2} s, total {:.2} s, cells {}, {:?} ({})",
        run.triangulate_seconds,
        run.total_seconds,
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
        septet::memory::peak_rss().unwrap_or(0) >> 20
    );
    for total in &run.ledger.phases {
        let seconds: f64 = run.phase_seconds.iter().filter(|s| s.0 == total.phase).map(|s| s.1).sum();
        println!(
            "{:<15} {seconds:8.3} s  rounds {:4} messages {:8} bytes {:12} work {:13} depth {:6} critical {:6}",
            total.phase.name(),
            total.rounds,
            total.messages,
            total.bytes,
            total.work,
            total.depth,
            total.critical_depth
        );
    }
    for (phase, seconds) in &run.phase_seconds {
        print!("{} {seconds:.2}  ", phase.name());
    }
    println!();
    println!("paper {:?} repair {:?}", run.ledger.paper, run.ledger.repair);
    let leaves = run.ledger.part.nodes.values().filter(|f| f.is_leaf()).count();
    let level = run.ledger.part.nodes.keys().map(|n| n.level()).max().unwrap_or(0);
    let members: u64 = run.ledger.part.nodes.values().map(|f| f.members).sum();
    println!(
        "leaves {leaves} levels {level} members/n {:.2}",
        members as f64 / run.points.used.max(1) as f64
    );
}
