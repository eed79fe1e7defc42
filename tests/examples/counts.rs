//! Counts a run of the paper's algorithm, and asserts bounds on its counts as a test would.

use std::error::Error;

use septet::Points;
use septet::generate::{generate, parse_sample};
use septet::spec::Workers;

fn main() -> Result<(), Box<dyn Error>> {
    let sample = generate(&parse_sample("well-spaced:4000")?, &mut |_, _, _| {})?;
    let Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };

    let mut spec = septet::Spec::default();
    spec.machine.workers = Workers::Leaves;
    spec.recursion.spacing = sample.spacing.map(|spacing| spacing.lipschitz);
    let run = septet::simulate(points, &spec)?;

    let paper = run.ledger.totals.paper;
    println!("work {}, depth {}, {} workers", paper.work, paper.depth, run.settled.workers);
    for phase in &run.ledger.phases {
        println!("{:>16} {:>10} operations", phase.phase.name(), phase.work);
    }
    septet::assert_counts!(run, levels_over_leaf(1.5, 2.0), no_repair());
    Ok(())
}
