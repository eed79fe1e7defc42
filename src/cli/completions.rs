//! `septet completions` and `septet man`, generated from the definitions of the argument parser.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use super::errors::{Code, Failure};

/// Options of `septet completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  septet completions bash > ~/.local/share/bash-completion/completions/septet"
)]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Writes a shell completion script for the program to standard output.
pub fn run(args: &CompletionsArgs, mut program: Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "septet", &mut script);
    put(&script)
}

/// Options of `septet man`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  septet man | man -l -
  septet man --dir ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write a page for each command into this directory: septet.1, septet-mesh.1, ...
    ///
    /// The directory is created if it does not exist.
    #[arg(long, value_name = "DIR")]
    dir: Option<PathBuf>,
}

/// Writes a manual page per command into a directory, or one page with all commands to standard output.
pub fn man(args: &ManArgs, program: Command) -> Result<(), Failure> {
    let Some(directory) = &args.dir else {
        return put(&page(program).map_err(|e| broken(&e))?);
    };
    let written = fs::create_dir_all(directory).and_then(|()| clap_mangen::generate_to(program, directory));
    written.map_err(|e| {
        Failure::new(Code::Failed, format!("{}: cannot be written: {e}", directory.display()))
            .help("choose a directory that you can write to")
    })
}

fn page(mut command: Command) -> std::io::Result<Vec<u8>> {
    command.build();
    let mut page = Vec::new();
    let top = Man::new(command.clone());
    top.render_title(&mut page)?;
    top.render_name_section(&mut page)?;
    top.render_synopsis_section(&mut page)?;
    top.render_description_section(&mut page)?;
    top.render_options_section(&mut page)?;
    top.render_extra_section(&mut page)?;
    for sub in command.get_subcommands().filter(|s| s.get_name() != "help") {
        let man = Man::new(sub.clone());
        let mut part = Vec::new();
        man.render_synopsis_section(&mut part)?;
        man.render_description_section(&mut part)?;
        man.render_options_section(&mut part)?;
        man.render_extra_section(&mut part)?;
        let text = String::from_utf8_lossy(&part).replace(".SH ", ".SS ");
        writeln!(page, ".SH SEPTET {}", sub.get_name().to_uppercase())?;
        page.extend_from_slice(text.as_bytes());
    }
    top.render_version_section(&mut page)?;
    Ok(page)
}

fn put(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(broken(&error)),
        _ => Ok(()),
    }
}

fn broken(error: &std::io::Error) -> Failure {
    Failure::new(Code::Failed, format!("standard output: {error}"))
}
