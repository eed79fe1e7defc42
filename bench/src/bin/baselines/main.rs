//! Compares the counts of the paper's algorithm with baselines: sphere separators with k-d planes, the descent with
//! the bottom-up correction, and the recursion with incremental insertion. Writes three tables as Markdown and CSV.
//! See `bench/README.md`.

mod correction;
mod cuts;
mod insertion;
mod plan;
mod table;

use std::error::Error;
use std::path::Path;

use plan::Plan;
use table::Table;

const USAGE: &str = "baselines DIRECTORY [SIZES=2^12,2^14,2^16] [SEEDS=2] [WORKERS=16] \
                     [KINDS=uniform,graded,clusters,slab,sphere] [DIMENSIONS=2,3]";

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some(directory) = args.first() else { return Err(USAGE.into()) };
    let directory = Path::new(directory);
    std::fs::create_dir_all(directory)?;
    let plan = Plan::parse(&args[1..])?;
    write(directory, "correction", &correction::table(&plan)?)?;
    write(directory, "insertion", &insertion::table(&plan)?)?;
    write(directory, "cuts", &cuts::table(&plan)?)
}

fn write(directory: &Path, name: &str, table: &Table) -> Result<(), Box<dyn Error>> {
    std::fs::write(directory.join(name).with_extension("md"), table.markdown())?;
    std::fs::write(directory.join(name).with_extension("csv"), table.csv())?;
    println!("{}", table.markdown());
    Ok(())
}
