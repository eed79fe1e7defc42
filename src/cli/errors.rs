//! What went wrong, for people and for scripts: a message, what to do, the line at fault, an exit code.

use septet_core::config::ConfigError;
use septet_core::generate::GenerateError;
use septet_io::read::InputError;
use septet_io::write::OutputError;
use septet_protocol::transport::TransportError;

use super::excerpt::Excerpt;
use super::progress::Talk;

/// Exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// The run failed, or an output cannot be written.
    Failed = 1,
    /// Options that cannot be run.
    Usage = 2,
    /// Bad input data.
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

/// Why the program ends without a result.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub code: Code,
    message: String,
    help: Option<String>,
    excerpt: Option<Box<Excerpt>>,
}

impl Failure {
    /// A failure with a message of one sentence.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Failure { code, message: message.into(), help: None, excerpt: None }
    }

    /// Adds what to do.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The first Ctrl-C.
    pub fn interrupted() -> Self {
        Failure::new(Code::Interrupted, "interrupted; no output was left half-written")
    }

    /// A message whose last clause says what to do.
    fn split(code: Code, message: &str) -> Self {
        match message.rsplit_once("; ") {
            Some((what, help)) => Failure::new(code, what).help(help),
            None => Failure::new(code, message),
        }
    }

    /// Writes the report to standard error.
    pub fn print(&self, talk: &Talk) {
        eprintln!("{} {}", talk.paint("error:", "1;31"), self.message);
        if let Some(excerpt) = &self.excerpt {
            eprintln!("{}", excerpt.draw(talk));
        }
        if let Some(help) = &self.help {
            let indent = if self.excerpt.is_some() { "  " } else { "" };
            eprintln!("{indent}{} {help}", talk.paint("help:", "1;36"));
        }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        let code = match error {
            InputError::OutOfMemory { .. } => Code::Limit,
            _ => Code::Input,
        };
        let mut failure = Failure::split(code, &error.to_string());
        if failure.help.is_none() && matches!(error, InputError::Syntax { .. }) {
            failure.help = Some("correct the file, or say what it is by its ending".into());
        }
        if let Some(line) = error.line() {
            failure.excerpt = Excerpt::of(error.path(), line, error.column()).map(Box::new);
        }
        failure
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        let help = match &error {
            OutputError::UnknownFormat { .. } => {
                return Failure::split(Code::Usage, &error.to_string())
                    .help("end the name of the output in one of the known extensions");
            }
            OutputError::MissingDirectory { .. } => "create the directory first, or choose another",
            OutputError::IsDirectory { .. } => "name a file in it",
            OutputError::NotWritable { .. } => "choose a place where you may write",
            OutputError::Io { .. } | OutputError::Stream { .. } => "is the disk full, or the reader gone?",
            _ => "this is a fault of septet: please report it with the input",
        };
        Failure::new(Code::Failed, error.to_string()).help(help)
    }
}

impl From<ConfigError> for Failure {
    fn from(error: ConfigError) -> Self {
        Failure::new(Code::Usage, error.to_string()).help("see `septet triangulate --help`")
    }
}

impl From<GenerateError> for Failure {
    fn from(error: GenerateError) -> Self {
        match error {
            GenerateError::TooMany { .. } => {
                Failure::new(Code::Limit, error.to_string()).help("ask for fewer points")
            }
            GenerateError::Machine(error) => error.into(),
            GenerateError::Incomplete { .. } => Failure::new(Code::Failed, error.to_string()),
            _ => Failure::new(Code::Usage, error.to_string()).help("see `septet generate --help`"),
        }
    }
}

impl From<septet_core::Error> for Failure {
    fn from(error: septet_core::Error) -> Self {
        use septet_core::Error;
        match error {
            Error::Config(error) => error.into(),
            Error::Points(error) => Failure::new(Code::Input, error.to_string()),
            Error::Sites(error) => Failure::new(Code::Input, error.to_string()),
            Error::Memory { forecast, limit, points } => Failure::new(
                Code::Limit,
                format!("about {forecast} bytes would be needed for {points} points, the limit is {limit}"),
            )
            .help("raise --max-memory, use fewer points, or a larger machine"),
            Error::Machine(TransportError::Stopped) | Error::Interrupted => Failure::interrupted(),
            Error::Machine(_) | Error::Start(_) => Failure::new(Code::Machine, error.to_string())
                .help("run again with -v; if it repeats, report it with the input"),
            Error::Piece { .. } | Error::Baseline(_) => Failure::new(Code::Limit, error.to_string()),
            Error::NotCertified { .. } => Failure::new(Code::Rejected, error.to_string()),
            _ => Failure::new(Code::Failed, error.to_string()),
        }
    }
}
