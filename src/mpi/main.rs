//! The program septet-mpi: the command line of septet on the processes that `mpirun` or `srun` starts.
//!
//! The hidden option `--self-test` tests the wire instead; see [`self_test`].

mod launch;
mod self_test;

use std::process::ExitCode;

use septet_mpi::{MpiWire, idle, wire};

fn main() -> ExitCode {
    launch::run(|wire| match self_test::asked() {
        Some(test) => self_test::run(&test, wire),
        None => septet_cli::main_of_processes(wire, "mpi"),
    })
}
