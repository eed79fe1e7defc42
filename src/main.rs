//! The command line of septet.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
