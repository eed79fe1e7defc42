//! Failures of the program: a message, help, the offending input line, and an exit code.

use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};

use septet_core::generate::{GenerateError, Kind};
use septet_core::spec::SpecError;
use septet_io::read::{InputError, ListError};
use septet_io::write::OutputError;
use septet_protocol::transport::TransportError;

use super::excerpt::Excerpt;
use super::progress::Talk;
use super::text::{bytes, printable, suggestion};

/// Exit codes.
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

    /// Returns the message and, on a line of its own, the help.
    pub fn text(&self) -> String {
        format!("{}\n{}", self.message, self.help.as_deref().unwrap_or_default())
    }

    /// Creates the failure with the text of another one ([`Failure::text`]), or with a message that ends with its help after a
    /// semicolon.
    pub fn of_text(code: Code, text: &str) -> Self {
        match text.rsplit_once('\n') {
            Some((message, "")) => Failure::new(code, message),
            Some((message, help)) => Failure::new(code, message).help(help),
            None => Failure::split(code, text),
        }
    }

    /// Adds the next step for the user.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
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

    /// Splits a message at its last semicolon: the clause after it becomes the help.
    pub fn split(code: Code, message: &str) -> Self {
        match message.rsplit_once("; ") {
            Some((what, help)) => Failure::new(code, what).help(help),
            None => Failure::new(code, message),
        }
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
        of_file(&error, &error.to_string())
    }
}

/// Returns the failure for a file that cannot be read.
fn of_file(error: &InputError, message: &str) -> Failure {
    let mut failure = Failure::split(Code::of(error.exit_code()), message);
    if failure.help.is_none() && matches!(error, InputError::Syntax { .. }) {
        failure.help = Some("correct the file, or give it the extension of its format".into());
    }
    if let Some(line) = error.line() {
        failure.excerpt = Excerpt::of(error.path(), line, error.column()).map(Box::new);
    }
    failure
}

impl From<ListError> for Failure {
    fn from(error: ListError) -> Self {
        let message = error.to_string();
        match &error {
            ListError::File { error, .. } | ListError::List { error } => of_file(error, &message),
            ListError::Entry { list, line, .. } => {
                let excerpt = Excerpt::of(list, *line, None).map(Box::new);
                Failure { excerpt, ..Failure::split(Code::of(error.exit_code()), &message) }
            }
            _ => Failure::split(Code::of(error.exit_code()), &message),
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        let message = error.to_string();
        match &error {
            OutputError::Stream { source } if source.kind() == ErrorKind::BrokenPipe => {
                Failure::new(Code::ReaderGone, message)
            }
            _ => match error.remedy() {
                Some(remedy) => Failure::new(Code::of(error.exit_code()), message).help(remedy),
                None => Failure::split(Code::of(error.exit_code()), &message),
            },
        }
    }
}

impl From<SpecError> for Failure {
    fn from(error: SpecError) -> Self {
        Failure::new(Code::Usage, error.to_string()).help("see the options in the command's `--help`")
    }
}

impl From<GenerateError> for Failure {
    fn from(error: GenerateError) -> Self {
        match error {
            GenerateError::TooMany { .. } => {
                Failure::new(Code::Limit, error.to_string()).help("reduce the number of points")
            }
            GenerateError::Machine(error) => error.into(),
            GenerateError::Incomplete { .. } => Failure::new(Code::Failed, error.to_string()),
            GenerateError::UnknownKind { ref name } => {
                let near = suggestion(name, Kind::all().map(Kind::name));
                Failure::new(Code::Usage, error.to_string())
                    .help(format!("{near}see `septet generate --help`"))
            }
            _ => Failure::new(Code::Usage, error.to_string()).help("see `septet generate --help`"),
        }
    }
}

impl From<septet_core::Error> for Failure {
    fn from(error: septet_core::Error) -> Self {
        use septet_core::Error;
        match error {
            Error::Spec(error) => error.into(),
            Error::Points(error) => Failure::new(Code::Input, error.to_string()),
            Error::Sites(error) => Failure::new(Code::Input, error.to_string()),
            Error::Indices { .. } => Failure::new(Code::Input, error.to_string()),
            Error::Memory { forecast, limit, points } => Failure::new(
                Code::Limit,
                format!(
                    "{points} points need about {} of memory ({forecast} bytes), but the limit is {} ({limit} bytes)",
                    bytes(forecast),
                    bytes(limit)
                ),
            )
            .help("raise --max-memory, or reduce the number of points"),
            Error::Machine(TransportError::Stopped) | Error::Interrupted => Failure::interrupted(),
            Error::Machine(_) | Error::Start(_) => Failure::new(Code::Machine, error.to_string())
                .help("run it again with -v; if it fails again, please report it with the input"),
            Error::Piece { .. } | Error::Baseline(_) => Failure::new(Code::Limit, error.to_string()),
            Error::NotCertified { .. } => Failure::new(Code::Rejected, error.to_string()),
            _ => Failure::new(Code::Failed, error.to_string()),
        }
    }
}
