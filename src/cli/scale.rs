//! `septet scale`.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use septet_core::generate::Kind;
use septet_core::spec::{Commands, DEFAULT_SEED, Until, Value, Workers};
use septet_lab::experiment::{Job, Journal, JournalError, RunError, Runner, Sweep, SweepError, parse_sizes};

use super::errors::{Code, Failure, caught};
use super::given::{Given, words};
use super::options::{kind, plane_or_space};
use super::progress::Talk;
use super::summary::row;
use super::text::counted;

/// Options of `septet scale`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet scale -n 2^10..2^16,per-octave=8 --seeds 20 -o runs.jsonl
  septet scale -n 2^12..2^22 -d 2 --until neighbours -o tree.jsonl
  septet scale -n 1e4 --workers 1,2,4,8 --weak -o weak.jsonl
  septet scale -n 1e5,1e6 --workers 1,2 --timed -o times.jsonl

Each line of the output describes a run and contains the command that repeats it. To continue an interrupted sweep, \
repeat the command.")]
pub struct ScaleArgs {
    /// Numbers of points, such as `1000,2e4`, `2^10..2^20` or `2^10..2^20,per-octave=8`
    #[arg(short = 'n', long = "points", value_name = "SIZES", allow_hyphen_values = true)]
    sizes: String,
    /// Kinds of sets, separated by commas
    #[arg(long, value_name = "K,..", default_value = "well-spaced", value_delimiter = ',', value_parser = kind)]
    kind: Vec<Kind>,
    /// Dimension
    #[arg(short, long = "dimension", value_name = "2|3", default_value = "3", value_parser = plane_or_space)]
    dimension: usize,
    /// Lipschitz constant of graded kinds
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    lipschitz: Option<f64>,
    /// Numbers of workers, separated by commas; `leaves` means one per leaf of the tree
    #[arg(long, value_name = "P|leaves,..", default_value = "leaves", value_delimiter = ',', value_parser = <Workers as Value>::read, allow_negative_numbers = true)]
    workers: Vec<Workers>,
    /// First seed of the sets and runs
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Number of consecutive seeds
    #[arg(long, value_name = "COUNT", default_value_t = 5)]
    seeds: u64,
    /// Weak scaling: the sizes are points per worker
    #[arg(long)]
    weak: bool,
    /// Also time `triangulate` with the same workers, and the serial kernel, on the same points
    #[arg(long)]
    timed: bool,
    /// Stop every run after this phase
    ///
    /// This allows larger sets, because the local hulls are skipped.
    #[arg(long, value_name = "PHASE", value_parser = words::<Until>())]
    until: Option<Until>,
    #[command(flatten)]
    given: Given<{ Commands::SCALE.bits() }>,
    /// Output file with a line per run; if it already contains runs of this sweep, the sweep is continued
    #[arg(short, long = "output", value_name = "FILE")]
    output: PathBuf,
}

impl ScaleArgs {
    fn sweep(&self, talk: &Talk) -> Result<Sweep, Failure> {
        let sizes = parse_sizes(&self.sizes);
        let sizes = sizes.map_err(|error| Failure::of(Code::Usage, &error, error.remedy()))?;
        let spec = self.given.options().spec()?;
        let spec = spec.with(|c| c.control.cancel = Some(talk.cancel.clone()));
        let sweep = Sweep {
            sizes,
            sizes_text: self.sizes.split_whitespace().collect(),
            kinds: self.kind.clone(),
            dimension: self.dimension,
            lipschitz: self.lipschitz,
            workers: self.workers.clone(),
            first_seed: self.seed,
            seeds: self.seeds,
            weak: self.weak,
            timed: self.timed,
            until: self.until,
            spec,
        };
        sweep.check()?;
        Ok(sweep)
    }
}

/// Runs the subcommand.
pub fn run(args: &ScaleArgs, talk: &Talk) -> Result<(), Failure> {
    let sweep = args.sweep(talk)?;
    septet_core::cores::limit(sweep.spec.machine.thread_count());
    let mut journal = Journal::open(&args.output, &sweep.words())?;
    if journal.dropped > 0 {
        talk.note(format!("note: an incomplete line of {} is dropped", counted(journal.dropped, "byte")));
    }
    let jobs = sweep.jobs();
    let done = journal.done();
    if done > 0 {
        talk.note(format!("{done} of {} runs are already in the file, continuing", jobs.len()));
    }
    let missing: Vec<&Job> =
        jobs.iter().filter(|job| !journal.has(job.program, &sweep.command(job))).collect();
    let made = all(&sweep, &missing, &mut journal, talk);
    let synced = journal.sync();
    talk.clear();
    let there = journal.done();
    let file = args.output.display();
    match made {
        Ok(()) => {
            synced?;
            talk.note(format!("septet: {} in {file}", counted(there as u64, "run")));
            talk.note(row("next", format!("septet fit {file} lists the counts that can be fitted")));
            Ok(())
        }
        Err(failure) if failure.code == Code::Interrupted => {
            let message = format!("interrupted; {there} of {} runs are in {file}", jobs.len());
            Err(Failure::new(Code::Interrupted, message).help("the same command continues the sweep"))
        }
        Err(failure) => Err(failure),
    }
}

fn all(sweep: &Sweep, jobs: &[&Job], journal: &mut Journal, talk: &Talk) -> Result<(), Failure> {
    let total: f64 = jobs.iter().map(|job| cost(job)).sum();
    let (mut runner, mut spent, start) = (Runner::default(), 0.0, Instant::now());
    for (number, job) in jobs.iter().enumerate() {
        let left = left(start.elapsed().as_secs_f64(), spent, total);
        let request = job.request;
        let title =
            format!("run {} of {}: {} {}{left}", number + 1, jobs.len(), request.kind.name(), request.n);
        let position = (1000.0 * spent / total) as u64;
        let line = caught(|| {
            talk.stage(&title, position, Some(1000));
            Ok(runner.run(sweep, job, &mut |_, _, _| talk.check())?)
        })?;
        journal.append(&line)?;
        spent += cost(job);
    }
    Ok(())
}

/// Returns the expected cost of a run, in an arbitrary unit.
fn cost(job: &Job) -> f64 {
    let n = job.request.n.max(2) as f64;
    n * n.log2() + 1000.0
}

/// Formats the estimated remaining time, or nothing in the first second.
fn left(elapsed: f64, spent: f64, total: f64) -> String {
    if spent <= 0.0 || elapsed < 1.0 {
        return String::new();
    }
    let seconds = (elapsed * (total - spent) / spent).round() as u64;
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, s) => format!(", {s} s left"),
        (0, m, s) => format!(", {m}:{s:02} left"),
        (h, m, _) => format!(", {h} h {m:02} left"),
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        Failure::of(Code::Usage, &error, error.remedy()).or_help("see `septet scale --help`")
    }
}

impl From<JournalError> for Failure {
    fn from(error: JournalError) -> Self {
        let code = match &error {
            JournalError::Line { .. } | JournalError::NoSweep { .. } => Code::Input,
            JournalError::OtherSweep { .. } | JournalError::OtherVersion { .. } => Code::Usage,
            _ => Code::Failed,
        };
        Failure::of(code, &error, error.remedy())
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Generate(error) => error.into(),
            RunError::Run(error) => error.into(),
            _ => Failure::of(Code::Failed, &error, error.remedy()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::left;

    #[test]
    fn the_remaining_time_is_proportional_to_the_remaining_work() {
        assert_eq!(left(10.0, 0.0, 100.0), "");
        assert_eq!(left(10.0, 50.0, 100.0), ", 10 s left");
        assert_eq!(left(100.0, 50.0, 100.0), ", 1:40 left");
        assert_eq!(left(100.0, 1.0, 100.0), ", 2 h 45 left");
    }
}
