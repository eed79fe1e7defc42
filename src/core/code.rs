//! The exit codes of the program, which are also the statuses of the library for C.

use septet_protocol::transport::TransportError;

use crate::error::Error;

/// The kind of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// The reader of standard output closed the pipe. The program ends silently.
    ReaderGone = 0,
    /// The run failed, or an output cannot be written.
    Failed = 1,
    /// The options are invalid.
    Usage = 2,
    /// The input data are invalid.
    Input = 3,
    /// A verification or claim failed.
    Rejected = 4,
    /// A limit was reached.
    Limit = 5,
    /// A worker or the transport failed.
    Machine = 6,
    /// Interrupted.
    Interrupted = 130,
}

impl Code {
    /// Returns the code of this number.
    pub fn of(number: u8) -> Self {
        let all = [Code::ReaderGone, Code::Usage, Code::Input, Code::Rejected, Code::Limit, Code::Machine];
        let found = all.into_iter().chain([Code::Interrupted]).find(|code| *code as u8 == number);
        found.unwrap_or(Code::Failed)
    }
}

impl Error {
    /// Returns the exit code of the program.
    pub fn code(&self) -> Code {
        match self {
            Error::Points(_) | Error::Sites(_) | Error::Indices { .. } => Code::Input,
            Error::Periodic(periodic) if periodic.is_of_point() => Code::Input,
            Error::Spec(_) | Error::Periodic(_) => Code::Usage,
            Error::Memory { .. } | Error::Exceeded { .. } | Error::Piece { .. } | Error::Baseline(_) => {
                Code::Limit
            }
            Error::Machine(TransportError::Stopped) | Error::Interrupted => Code::Interrupted,
            Error::Machine(_) | Error::Start(_) => Code::Machine,
            Error::NotCertified { .. } => Code::Rejected,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_name_codes() {
        for code in [Code::ReaderGone, Code::Failed, Code::Usage, Code::Input, Code::Rejected] {
            assert_eq!(Code::of(code as u8), code);
        }
        for code in [Code::Limit, Code::Machine, Code::Interrupted] {
            assert_eq!(Code::of(code as u8), code);
        }
        assert_eq!(Code::of(77), Code::Failed);
    }
}
