//! The processes of a command: their values, and their common errors.

use septet_core::Remedy;
use septet_protocol::checksum::checksum;
use septet_protocol::message::PROTOCOL_VERSION;
use septet_protocol::wire::{Alone, Ended, Processes, Wire, WireError};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::errors::{Code, Failure, caught};

/// The processes of a command.
pub struct Team<'a> {
    /// The processes.
    pub processes: Processes<'a>,
    /// The name of the connection in reports: `processes` or `mpi`. `None` for a process alone.
    pub transport: Option<&'static str>,
}

impl<'a> Team<'a> {
    /// Creates the team of a process alone.
    pub fn alone(wire: &'a mut Alone) -> Self {
        Team { processes: Processes::over(wire), transport: None }
    }

    /// Returns `true` for a process alone.
    pub fn is_alone(&self) -> bool {
        self.transport.is_none()
    }

    /// Creates the team that a wire connects.
    pub fn new(wire: &'a mut dyn Wire, transport: &'static str) -> Self {
        Team { processes: Processes::over(wire), transport: Some(transport) }
    }

    /// Returns `true` on the process that prints.
    pub fn is_first(&self) -> bool {
        self.processes.process() == 0
    }

    /// Returns the value of this process if no process failed, and the first failure otherwise.
    pub fn agree<T>(&mut self, own: Result<T, Failure>) -> Result<T, Failure> {
        if self.is_alone() {
            return own;
        }
        Ok(self.processes.agree(own, Failure::described)?)
    }

    /// Runs a step on the first process only. All processes return its failure, or that it was interrupted.
    pub fn first_only<T>(&mut self, step: impl FnOnce() -> Result<T, Failure>) -> Result<Option<T>, Failure> {
        let own = if self.is_first() { caught(step).map(Some) } else { Ok(None) };
        self.agree(own)
    }

    /// Returns the values of all processes, in their order. They travel as JSON, in which the last digit of a float may
    /// change.
    pub fn all_gather<T: Serialize + DeserializeOwned>(&mut self, own: &T) -> Result<Vec<T>, Failure> {
        let malformed =
            |error: serde_json::Error| Failure::new(Code::Machine, format!("a value of a process: {error}"));
        let text = self.agree(serde_json::to_string(own).map_err(malformed))?;
        let texts: Vec<String> = self.processes.all_gather(&text)?;
        texts.iter().map(|text| serde_json::from_str(text).map_err(malformed)).collect()
    }

    /// Refuses processes that run another program than the first one, or other arguments.
    pub fn check_same(&mut self) -> Result<(), Failure> {
        let all = self.all_gather(&Start::of_this_process())?;
        let other = |differs: &dyn Fn(&Start) -> bool| all.iter().position(differs);
        if let Some(process) = other(&|start| start.program != all[0].program) {
            let message = format!("process {process} runs another build of the program than process 0");
            return Err(Failure::new(Code::Machine, message).help("start the same program on all processes"));
        }
        if let Some(process) = other(&|start| start.arguments != all[0].arguments) {
            let message = format!("process {process} has other arguments than process 0");
            return Err(Failure::new(Code::Usage, message).help("give all processes the same arguments"));
        }
        Ok(())
    }
}

/// The program of a process and its arguments.
#[derive(Serialize, Deserialize)]
struct Start {
    /// The version of the protocol, and the hash of the program.
    program: (u16, u64),
    /// The hash of the arguments.
    arguments: u64,
}

impl Start {
    fn of_this_process() -> Self {
        let program = std::env::current_exe().and_then(std::fs::read).map_or(0, |bytes| checksum(&bytes));
        let arguments: Vec<u8> =
            std::env::args_os().skip(1).flat_map(|a| [a.as_encoded_bytes(), b"\n"].concat()).collect();
        Start { program: (PROTOCOL_VERSION, program), arguments: checksum(&arguments) }
    }
}

impl From<Ended> for Failure {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Refused(refused) => {
                Failure::of(Code::of(refused.code), &refused.message, Remedy::received(refused.remedy))
            }
            Ended::Wire(error) => error.into(),
        }
    }
}

impl From<WireError> for Failure {
    fn from(error: WireError) -> Self {
        Failure::new(Code::Machine, error.to_string())
            .help("see whether the system ended that process, for example because memory ran out")
    }
}
