//! `septet reproduce`.

use std::path::{Path, PathBuf};

use clap::Args;
use septet_core::spec::{Correction, DEFAULT_SEED, Words, cores};
use septet_lab::claims::{
    CheckedClaim, Claim, ClaimError, ClaimJournal, ClaimReport, Extent, Lab, LabOptions, registry, select,
};

use super::effects::excludes;
use super::errors::{Code, Failure};
use super::faults::{FaultArg, fault_or_list, listed as listed_faults};
use super::files;
use super::given::words;
use super::progress::Talk;
use super::text::suggestion;

/// The options that a list of claims does not use.
const NOT_FOR_LISTS: [&str; 9] =
    ["quick", "full", "seed", "neighbours", "threads", "figures", "json", "journal", "fault"];

/// Options of `septet reproduce`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet reproduce --list
  septet reproduce
  septet reproduce levels alpha --seed 7
  septet reproduce --full --journal claims.jsonl --json claims.json
  septet reproduce --fault list
  septet reproduce graph-exact supergraph --fault half-ghosts

Each claim is tested by figures that are measured in runs and compared with fixed bounds. If a claim of the paper is \
false as printed, the corrected claim is tested, and the figure of the printed one is shown below. Illustrations show the \
figures of statements that cannot fail. The exit code is 4 if a claim fails.

With `--fault`, every machine has that fault, and only the claims that fail are printed. A claim whose runs end with an error \
fails. The exit code is 0 if the fault escapes all claims.")]
pub struct ReproduceArgs {
    /// Claims to test [default: all]
    #[arg(value_name = "CLAIM")]
    claims: Vec<String>,
    /// Use small sizes: less than five minutes of processor time (the default)
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// Use ten octaves of sizes and more seeds: hours
    #[arg(long)]
    full: bool,
    /// Explain each claim in two lines, without testing it
    #[arg(long, conflicts_with_all = NOT_FOR_LISTS)]
    list: bool,
    /// First seed of the sets and runs
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Correction of neighbour balls; the claims about its depth fail for `naive`
    #[arg(long, value_parser = words::<Correction>(), default_value = Correction::Descent.name())]
    neighbours: Correction,
    /// Number of threads [default: cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Show all figures of every claim, not only the decisive one
    #[arg(long)]
    figures: bool,
    /// Write results and all figures as JSON, `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Append each checked claim to a file; after an interruption, the same command continues
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,
    /// Plant a fault in every machine and print the claims that fail; `list` lists the faults
    #[arg(long, value_name = "FAULT|list", value_parser = fault_or_list)]
    fault: Option<FaultArg>,
}

/// Runs the subcommand.
pub fn run(args: &ReproduceArgs, talk: &Talk) -> Result<(), Failure> {
    let claims = select(&args.claims).map_err(unknown)?;
    if args.list {
        let text: String = claims.iter().map(|claim| listed(claim)).collect();
        return Ok(files::print(&text)?);
    }
    let fault = match args.fault {
        Some(FaultArg::List) => return Ok(files::print(&listed_faults())?),
        Some(FaultArg::Planted(fault)) => Some(fault),
        None => None,
    };
    let is_json_printed = args.json.as_deref() == Some(Path::new("-"));
    excludes("--figures", args.figures, "--json -", is_json_printed)?;
    let texts: Vec<&Path> = args.json.iter().map(PathBuf::as_path).collect();
    files::check(&[], &[], &texts)?;
    let threads = args.threads.map_or_else(cores, |threads| threads as usize);
    septet_core::cores::limit(threads);
    let extent = if args.full { Extent::Full } else { Extent::Quick };
    let cancel = Some(talk.cancel.clone());
    let correction = args.neighbours;
    let setting = LabOptions { extent, seed: args.seed, threads, correction, fault, cancel };
    let journal = args.journal.as_deref().map(|path| ClaimJournal::open(path, &setting)).transpose()?;
    let show = Show { table: !is_json_printed, figures: args.figures };
    let checked = check(&claims, setting, journal, show, talk)?;
    let report = ClaimReport::of(extent, args.seed, checked).with_fault(fault);
    // Holm's method needs the p-values of all claims.
    for claim in report.claims.iter().filter(|claim| claim.is_statistical()) {
        show.claim(claim, fault.is_some(), talk);
    }
    if let Some(path) = &args.json {
        let mut text = serde_json::to_string_pretty(&report)
            .map_err(|e| Failure::new(Code::Failed, format!("the results cannot be written: {e}")))?;
        text.push('\n');
        files::write_text(path, &text)?;
    }
    talk.note(report.summary());
    result(&report)
}

/// Returns a failure that names the claims that failed, if any.
fn result(report: &ClaimReport) -> Result<(), Failure> {
    if report.passed {
        return Ok(());
    }
    let failed = report.claims.iter().filter(|claim| !claim.passed).map(|claim| claim.name);
    let failed: Vec<&str> = failed.collect();
    Err(Failure::new(Code::Rejected, format!("claims that failed: {}", failed.join(", ")))
        .help("`septet reproduce CLAIM --figures` shows all figures of a claim"))
}

/// The printed parts of the results.
#[derive(Clone, Copy)]
struct Show {
    table: bool,
    /// Whether all figures are printed.
    figures: bool,
}

impl Show {
    fn text(self, text: &str, talk: &Talk) {
        if self.table {
            talk.aside(|| {
                // If the reader has closed the pipe, the exit code still gives the result.
                let _ = files::print(text);
            });
        }
    }

    /// Prints the rows of a claim. A planted fault is expected to make claims fail, so only those claims are printed.
    fn claim(self, claim: &CheckedClaim, planted: bool, talk: &Talk) {
        if planted && claim.passed {
            return;
        }
        self.text(&claim.rows(), talk);
        if self.figures || !claim.passed {
            self.text(&claim.details(!self.figures), talk);
        }
    }
}

/// Checks the claims. Prints those without p-values; the results of the others depend on the p-values of all claims.
fn check(
    claims: &[&'static Claim],
    setting: LabOptions,
    mut journal: Option<ClaimJournal>,
    show: Show,
    talk: &Talk,
) -> Result<Vec<CheckedClaim>, Failure> {
    let at = std::cell::Cell::new((0, ""));
    let total = claims.len() as u64;
    let mut lab = Lab::new(setting, |what| {
        let (done, claim) = at.get();
        talk.stage(&format!("{claim}: {what}"), done, Some(total));
    });
    show.text(&ClaimReport::head(), talk);
    let mut all = Vec::new();
    for (claim, done) in claims.iter().zip(0..) {
        at.set((done, claim.name));
        talk.stage(claim.name, done, Some(total));
        let known = journal.as_ref().and_then(|journal| journal.checked(claim));
        let checked = if let Some(checked) = known {
            checked
        } else {
            let checked = claim.check(&mut lab)?;
            journal.as_mut().map_or(Ok(()), |journal| journal.append(&checked))?;
            checked
        };
        if !checked.is_statistical() {
            show.claim(&checked, lab.options.fault.is_some(), talk);
        }
        all.push(checked);
    }
    talk.clear();
    Ok(all)
}

/// Adds the nearest claim and the list of all claims to the failure for an unknown claim.
fn unknown(error: ClaimError) -> Failure {
    let ClaimError::Unknown { name } = &error else { return error.into() };
    let names: Vec<&str> = registry().map(|claim| claim.name).collect();
    let near = suggestion(name, names.iter().copied());
    let help = format!("{near}the claims are {}; see `septet reproduce --list`", names.join(" "));
    Failure::new(Code::Usage, error.to_string()).help(help)
}

fn listed(claim: &Claim) -> String {
    let [says, checked] = claim.explained();
    format!("{}\n  {says}\n  {checked}\n", claim.name)
}

impl From<ClaimError> for Failure {
    fn from(error: ClaimError) -> Self {
        match error {
            ClaimError::Run(error) => error.into(),
            ClaimError::Fit(error) => error.into(),
            ClaimError::Unknown { .. } => Failure::of(Code::Usage, &error, error.remedy()),
            _ => Failure::of(Code::Failed, &error, error.remedy()),
        }
    }
}
