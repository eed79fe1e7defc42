//! Failures of the program: a message, help, the offending input line, and an exit code.

use std::any::Any;
use std::fmt::{Display, Write as _};
use std::io::{ErrorKind, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

pub use septet_core::Code;
use septet_core::generate::{GenerateError, Kind};
use septet_core::spec::SpecError;
use septet_core::{Door, Error, Remedy};
use septet_io::read::{InputError, ListError};
use septet_io::write::OutputError;
use septet_protocol::transport::TransportError;

use super::excerpt::Excerpt;
use super::progress::{Cancelled, Talk};
use super::text::{bytes, printable, suggestion};

/// The failure of a command.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub code: Code,
    message: String,
    help: Option<String>,
    excerpt: Option<Box<Excerpt>>,
    /// Whether only this process knows the failure, so that it prints it even if it is silent.
    pub is_own: bool,
}

impl Failure {
    /// Creates a failure with a message of one sentence.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Failure { code, message: message.into(), help: None, excerpt: None, is_own: false }
    }

    /// Creates the failure of an error. Its remedy, spelled for the command line, is the help.
    pub fn of(code: Code, error: &impl Display, remedy: Option<Remedy>) -> Self {
        let help = remedy.map(|remedy| remedy.spelled(Door::Shell));
        Failure { help, ..Failure::new(code, error.to_string()) }
    }

    /// Ends a command from within a progress callback. Unwinding removes partial files.
    pub fn unwind(self) {
        resume_unwind(Box::new(self));
    }

    /// Returns the code, the message and the help, for other processes.
    pub fn described(&self) -> (u8, String, String) {
        (self.code as u8, self.message.clone(), Remedy::sent(self.help.as_ref().map(Remedy::plain)))
    }

    /// Adds the next step for the user.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the next step for the user, if the error has no remedy.
    pub fn or_help(self, help: &str) -> Self {
        if self.help.is_some() { self } else { self.help(help) }
    }

    /// Returns the failure after the first Ctrl-C.
    pub fn interrupted() -> Self {
        Failure::new(Code::Interrupted, "interrupted; no partial output was left")
    }

    /// Prefixes the message with the location.
    pub fn in_place(self, place: &str) -> Self {
        Failure { message: format!("{place}: {}", self.message), ..self }
    }

    /// Marks a failure that only one of several processes knows, and prefixes its number.
    #[cfg(unix)]
    pub fn of_process(self, process: u32) -> Self {
        Failure { is_own: true, ..self.in_place(&format!("process {process}")) }
    }

    /// Writes the report to standard error.
    pub fn print(&self, talk: &Talk) {
        let mut text = format!("{} {}\n", talk.paint("error:", "1;31"), printable(&self.message));
        if let Some(excerpt) = &self.excerpt {
            text += &excerpt.draw(talk);
            text.push('\n');
        }
        if let Some(help) = &self.help {
            let indent = if self.excerpt.is_some() { "  " } else { "" };
            let _ = writeln!(text, "{indent}{} {}", talk.paint("help:", "1;36"), printable(help));
        }
        // Nothing can be reported if standard error is closed.
        let _ = std::io::stderr().write_all(text.as_bytes());
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        of_file(&error, &error)
    }
}

/// Returns the failure for a file that cannot be read.
fn of_file(error: &InputError, message: &impl Display) -> Failure {
    let failure = Failure::of(error.exit_code(), message, error.remedy());
    let excerpt = error.line().and_then(|line| Excerpt::of(error.path(), line, error.column()));
    Failure { excerpt: excerpt.map(Box::new), ..failure }
}

impl From<ListError> for Failure {
    fn from(error: ListError) -> Self {
        match &error {
            ListError::File { error: of, .. } | ListError::List { error: of } => of_file(of, &error),
            _ => {
                let line =
                    if let ListError::Entry { list, line, .. } = &error { Some((list, *line)) } else { None };
                let excerpt = line.and_then(|(list, line)| Excerpt::of(list, line, None)).map(Box::new);
                Failure { excerpt, ..Failure::of(error.exit_code(), &error, error.remedy()) }
            }
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match &error {
            OutputError::Stream { source } if source.kind() == ErrorKind::BrokenPipe => {
                Failure::new(Code::ReaderGone, error.to_string())
            }
            _ => Failure::of(error.exit_code(), &error, error.remedy()),
        }
    }
}

impl From<SpecError> for Failure {
    fn from(error: SpecError) -> Self {
        Failure::of(Code::Usage, &error, error.remedy()).or_help("see the options in the command's `--help`")
    }
}

impl From<GenerateError> for Failure {
    fn from(error: GenerateError) -> Self {
        let code = match &error {
            GenerateError::TooMany { .. } => Code::Limit,
            GenerateError::Incomplete { .. } => Code::Failed,
            _ => Code::Usage,
        };
        let failure = Failure::of(code, &error, error.remedy());
        match error {
            GenerateError::Machine(error) => error.into(),
            GenerateError::UnknownKind { name } => {
                let near = suggestion(&name, Kind::all().map(Kind::name));
                let known = failure.help.clone().unwrap_or_default();
                failure.help(format!("{near}{known}"))
            }
            _ => failure.or_help("see `septet generate --help`"),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let of = || Failure::of(error.code(), &error, error.remedy());
        match error {
            Error::Spec(error) => error.into(),
            Error::Memory { forecast, limit, points } => {
                let message = format!(
                    "{points} points need about {} of memory ({forecast} bytes), but the limit is {} ({limit} bytes)",
                    bytes(forecast),
                    bytes(limit)
                );
                Failure { message, ..of() }
            }
            Error::Exceeded { used, limit } => {
                let message = format!(
                    "the run needs {} of memory or more ({used} bytes), but the limit is {} ({limit} bytes)",
                    bytes(used),
                    bytes(limit)
                );
                Failure { message, ..of() }
            }
            Error::Machine(TransportError::Stopped) | Error::Interrupted => Failure::interrupted(),
            Error::Machine(_) | Error::Start(_) => {
                of().help("run it again with -v; if it fails again, please report it with the input")
            }
            _ => of(),
        }
    }
}

/// Runs a step. Returns the failure of a progress callback that ended it.
///
/// # Panics
/// Panics if the step does.
pub fn caught<T>(step: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(step))
        .unwrap_or_else(|payload| Err(failure_of(payload).unwrap_or_else(|other| resume_unwind(other))))
}

/// Returns the failure that ended a progress callback, or the payload of a panic.
pub fn failure_of(payload: Box<dyn Any + Send>) -> Result<Failure, Box<dyn Any + Send>> {
    if payload.is::<Cancelled>() { Ok(Failure::interrupted()) } else { Ok(*payload.downcast()?) }
}
