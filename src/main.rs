//! The command line of septet.

fn main() -> std::process::ExitCode {
    septet_cli::main()
}
