//! `septet report`.

use std::fs;
use std::path::{Path, PathBuf};

use crate::page::{Page, PageError};
use clap::Args;

use super::errors::{Code, Failure};
use super::files;
use super::input;
use super::progress::Talk;
use super::summary::{row, written};
use super::text::{counted, name};

/// Options of `septet report`.
#[derive(Debug, Args)]
#[command(after_help = "\
The page shows the pictures of the first run report. For runs of several sizes, it plots the counts with the growth \
laws. It shows the first mesh with a cutting plane, if its report contains a picture (`septet mesh --view`).

Examples:
  septet report run.json -o report.html
  septet report run.json runs.jsonl -o report.html --svg figures
  septet report part.json -o part.html

Reports are written by `septet simulate --json` and `septet mesh --json`, sweeps by `septet scale`.")]
pub struct ReportArgs {
    /// Reports of runs and meshes, or sweeps, each also .gz; `-` for standard input
    #[arg(required = true, value_name = "RUNS")]
    runs: Vec<PathBuf>,
    /// HTML page to write, `-` for standard output
    #[arg(short, long, value_name = "FILE.html|-", required_unless_present = "svg")]
    output: Option<PathBuf>,
    /// Write every figure as an SVG file into this directory
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

/// Reads the runs and writes the page.
pub fn run(args: &ReportArgs, talk: &Talk) -> Result<(), Failure> {
    for input in &args.runs {
        let texts: Vec<&Path> = args.output.as_deref().into_iter().collect();
        files::check(&[input], &[], &texts)?;
    }
    let texts = args.runs.iter().map(|path| Ok((path.display().to_string(), input::text_of(path, talk)?)));
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
        for line in written(std::slice::from_ref(output)) {
            talk.note(line);
        }
    }
    Ok(())
}

fn bad(error: &PageError) -> Failure {
    Failure::new(Code::Input, error.to_string())
        .help("give a file from `septet simulate --json`, `septet mesh --json` or `septet scale`")
}

/// Writes named figures into a directory, which is created if it does not exist.
pub fn write_figures(figures: &[(String, String)], directory: &Path, talk: &Talk) -> Result<(), Failure> {
    let failed = |e: std::io::Error| {
        Failure::new(Code::Failed, format!("{}: cannot be created: {e}", directory.display()))
    };
    fs::create_dir_all(directory).map_err(failed)?;
    for (file, text) in figures {
        files::write_text(&directory.join(file), text)?;
    }
    let number = counted(figures.len() as u64, "figure");
    talk.note(row("wrote", format!("{number} in {}", name(directory))));
    Ok(())
}
