//! Starts `septet-mpi` with `mpirun`.

use std::process::{Command, Output};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_septet-mpi");

/// Settings of Open MPI for a machine with few cores, as environment variables. Other libraries ignore them.
pub const SETTINGS: [(&str, &str); 6] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("OMPI_MCA_hwloc_base_binding_policy", "none"),
    ("OMPI_MCA_mpi_yield_when_idle", "1"),
    ("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe"),
];

/// Returns the command that runs `septet-mpi` on this number of processes.
pub fn mpirun(processes: u32, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("MPIRUN").unwrap_or("mpirun".into()));
    command.args(["-n", &processes.to_string(), PROGRAM]).args(arguments).envs(SETTINGS);
    command
}

pub fn run(command: &mut Command) -> Output {
    command.output().unwrap_or_else(|error| panic!("{command:?}: {error}; install openmpi-bin"))
}
