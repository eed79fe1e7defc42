//! The processes of a command, and their common errors.

use septet_protocol::checksum::checksum;
use septet_protocol::message::PROTOCOL_VERSION;
use septet_protocol::wire::{Ended, Processes, Wire};

use crate::errors::{Code, Failure};

/// The processes of a command.
pub struct Team<'a> {
    /// The processes.
    pub processes: Processes<'a>,
    /// The name of the connection in reports: `processes` or `mpi`.
    pub transport: &'static str,
}

impl<'a> Team<'a> {
    /// Creates the team that a wire connects.
    pub fn new(wire: &'a mut dyn Wire, transport: &'static str) -> Self {
        Team { processes: Processes::over(wire), transport }
    }

    /// Returns `true` on the process that prints.
    pub fn is_first(&self) -> bool {
        self.processes.process() == 0
    }

    /// Returns the value of this process if no process failed, and the first failure otherwise.
    pub fn agree<T>(&mut self, own: Result<T, Failure>) -> Result<T, Failure> {
        Ok(self.processes.agree(own, |failure| (failure.code as u8, failure.text()))?)
    }

    /// Runs a step on the first process only. All processes return its failure.
    pub fn first_only<T>(&mut self, step: impl FnOnce() -> Result<T, Failure>) -> Result<Option<T>, Failure> {
        let own = if self.is_first() { step().map(Some) } else { Ok(None) };
        self.agree(own)
    }
}

/// Refuses processes that run another program than the first one, or other arguments.
///
/// # Errors
/// Fails on all processes if one differs from the first.
pub(super) fn check_same(team: &mut Team<'_>) -> Result<(), Failure> {
    let program = std::env::current_exe().and_then(std::fs::read).map_or(0, |bytes| checksum(&bytes));
    let arguments: Vec<u8> =
        std::env::args_os().skip(1).flat_map(|a| [a.as_encoded_bytes(), b"\n"].concat()).collect();
    let own = (u64::from(PROTOCOL_VERSION), program, checksum(&arguments));
    let all = team.processes.all_gather(&own).map_err(Ended::from)?;
    let other = |differs: &dyn Fn(&(u64, u64, u64)) -> bool| all.iter().position(differs);
    if let Some(process) = other(&|&(version, program, _)| (version, program) != (all[0].0, all[0].1)) {
        let message = format!("process {process} runs another build of the program than process 0");
        return Err(Failure::new(Code::Machine, message).help("start the same program on all processes"));
    }
    if let Some(process) = other(&|&(.., arguments)| arguments != all[0].2) {
        let message = format!("process {process} has other arguments than process 0");
        return Err(Failure::new(Code::Usage, message).help("give all processes the same arguments"));
    }
    Ok(())
}

impl From<Ended> for Failure {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Refused(refused) => Failure::of_text(Code::of(refused.code), &refused.message),
            Ended::Wire(error) => Failure::new(Code::Machine, error.to_string())
                .help("see whether the system ended that process, for example because memory ran out"),
        }
    }
}
