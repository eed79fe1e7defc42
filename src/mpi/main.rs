//! The program septet-mpi: the command line of septet on the processes that `mpirun` or `srun` starts.
//!
//! The hidden option `--self-test` tests the wire instead; see [`self_test`].

use std::process::ExitCode;

use septet_mpi::{MpiWire, launch, self_test};

fn main() -> ExitCode {
    launch::run(|wire| match self_test::asked() {
        Some(test) => self_test::run(&test, wire),
        None => command(wire),
    })
}

fn command(_: &mut MpiWire) -> ExitCode {
    // TO DO: this line becomes `septet_cli::run_over(wire)`, and Cargo.toml depends on septet-cli.
    eprintln!("septet-mpi: only --self-test works in this version");
    ExitCode::from(2)
}
