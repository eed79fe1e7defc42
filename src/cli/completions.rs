//! `septet completions` and `septet man`: made from the same definitions as the parser.

use std::io::Write;

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

/// Writes a completion script of the program to standard output.
pub fn run(args: &CompletionsArgs, mut program: Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "septet", &mut script);
    put(&script)
}

/// Writes the manual page to standard output: all subcommands on one page.
pub fn man(program: Command) -> Result<(), Failure> {
    put(&page(program).map_err(|e| broken(&e))?)
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
    out.write_all(bytes).and_then(|()| out.flush()).map_err(|e| broken(&e))
}

fn broken(error: &std::io::Error) -> Failure {
    Failure::new(Code::Failed, format!("standard output: {error}"))
}
