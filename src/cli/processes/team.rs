//! The processes of a command, and their common errors.

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
        Team { processes: Processes::new(wire), transport }
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

impl From<Ended> for Failure {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Refused(refused) => Failure::split(Code::of(refused.code), &refused.message),
            Ended::Wire(error) => Failure::new(Code::Machine, error.to_string())
                .help("see the messages of that process, and the limits of memory"),
        }
    }
}
