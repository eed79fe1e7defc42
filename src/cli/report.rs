//! `septet report`.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::page::{Page, PageError};
use clap::Args;

use super::errors::{Code, Failure};
use super::files;
use super::progress::Talk;

/// Options of `septet report`.
#[derive(Debug, Args)]
#[command(after_help = "\
The first whole report gives the pictures of one run; runs of several sizes give the plots against the laws. The first
report of a mesh gives the mesh, cut by a plane, if the report has a picture (`septet mesh --view`).

Examples:
  septet simulate sample:well-spaced:1e5 --workers 64 --json run.json && septet report run.json -o report.html
  septet report run.json runs.jsonl -o report.html --svg figures
  septet mesh part.poly --json part.json && septet report part.json -o part.html")]
pub struct ReportArgs {
    /// Reports of runs and meshes (`--json`) or sweeps (one run a line), `-` for standard input
    #[arg(required = true, value_name = "RUNS")]
    runs: Vec<PathBuf>,
    /// The page, `-` for standard output
    #[arg(short, long, value_name = "FILE.html|-", required_unless_present = "svg")]
    output: Option<PathBuf>,
    /// Write every figure by itself as SVG into this directory
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// Reads the runs, writes the page.
pub fn run(args: &ReportArgs, talk: &Talk) -> Result<(), Failure> {
    for input in &args.runs {
        let texts: Vec<&Path> = args.output.as_deref().into_iter().collect();
        files::check(Some(input), &[], &texts)?;
    }
    let texts = args.runs.iter().map(|path| Ok((path.display().to_string(), text_of(path)?)));
    let texts: Vec<(String, String)> = texts.collect::<Result<_, Failure>>()?;
    talk.check();
    let page = Page::of(&texts).map_err(|error| bad(&error))?;
    if let Some(directory) = &args.svg {
        write_figures(&page.figures(), directory, talk)?;
    }
    if let Some(output) = &args.output {
        let html = page
            .html()
            .map_err(|e| Failure::new(Code::Failed, format!("the page cannot be written: {e}")))?;
        files::write_text(output, &html)?;
        talk.note(format!("  wrote {} ({} bytes)", output.display(), html.len()));
    }
    Ok(())
}

fn bad(error: &PageError) -> Failure {
    Failure::new(Code::Input, error.to_string()).help(
        "give what `septet simulate --json` or `septet mesh --json` wrote, or a sweep with one run a line",
    )
}

fn text_of(path: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    let read = if path.as_os_str() == "-" {
        std::io::stdin().lock().read_to_string(&mut text).map(|_| text)
    } else {
        fs::read_to_string(path)
    };
    read.map_err(|e| Failure::new(Code::Input, format!("{}: {e}", path.display())))
}

/// Writes figures, each with its name, into a directory, which is made if there is none.
pub fn write_figures(figures: &[(String, String)], directory: &Path, talk: &Talk) -> Result<(), Failure> {
    let failed = |e: std::io::Error| Failure::new(Code::Failed, format!("{}: {e}", directory.display()));
    fs::create_dir_all(directory).map_err(failed)?;
    for (name, text) in figures {
        files::write_text(&directory.join(name), text)?;
    }
    talk.note(format!("  wrote {} figures to {}", figures.len(), directory.display()));
    Ok(())
}
