//! Counts a run of the paper's algorithm, and asserts bounds on its counts as a test would.

use std::error::Error;

use septet::Points;
use septet::generate::{generate, parse_sample};
use septet::options::Workers;

fn main() -> Result<(), Box<dyn Error>> {
    let sample = generate(&parse_sample("well-spaced:4000")?, &mut |_, _, _| {})?;
    let Points::Space(points) = &sample.points else { return Err("a sample in space".into()) };

    let mut options = septet::SimulateOptions::default();
    options.machine.workers = Workers::Leaves;
    options.spacing = sample.spacing.map(|spacing| spacing.lipschitz);
    let run = septet::simulate(points, &options)?;

    let paper = run.ledger.paper;
    println!("work {}, depth {}, {} workers", paper.work, paper.depth, run.settled.workers);
    for phase in &run.ledger.phases {
        println!("{:>16} {:>10} operations", phase.phase.name(), phase.work);
    }
    septet::assert_counts!(run, levels_over_leaf(1.5, 2.0), no_repair());
    Ok(())
}
