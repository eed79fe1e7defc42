//! What went wrong, for people and for scripts: a message, what to do, the line at fault, an exit code.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents,
    SourceCode, SourceSpan, SpanContents,
};
use septet_core::config::ConfigError;
use septet_core::generate::GenerateError;
use septet_io::read::InputError;
use septet_io::write::OutputError;
use septet_protocol::transport::TransportError;

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
        if self.excerpt.is_some() {
            let mut theme =
                if talk.color() { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
            "error:".clone_into(&mut theme.characters.error);
            let handler = GraphicalReportHandler::new_themed(theme)
                .with_links(false)
                .with_context_lines(1)
                .with_wrap_lines(false);
            let mut text = String::new();
            if handler.render_report(&mut text, self).is_ok() {
                eprintln!("{}", text.trim());
                return;
            }
        }
        eprintln!("{} {}", talk.paint("error:", "1;31"), self.message);
        if let Some(help) = &self.help {
            eprintln!("{} {help}", talk.paint("help:", "1;36"));
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl Diagnostic for Failure {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn std::fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt.as_deref().map(|e| e as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let excerpt = self.excerpt.as_ref()?;
        let (start, length) = excerpt.fault;
        Some(Box::new(std::iter::once(LabeledSpan::new(Some("here".into()), start, length))))
    }
}

/// A few lines of a text file around a fault.
#[derive(Debug)]
struct Excerpt {
    name: String,
    text: String,
    /// Zero-based number of the first line in the file.
    first: usize,
    /// Start and length of the fault in `text`.
    fault: (usize, usize),
}

/// Longest part of a line that is shown.
const SHOWN: usize = 120;

impl Excerpt {
    /// Reads the lines around `line` (from 1); none if the file is no longer there or is not text.
    fn of(path: &Path, line: u64, column: Option<u64>) -> Option<Self> {
        if path.as_os_str() == "-" {
            return None;
        }
        let mut reader = BufReader::new(File::open(path).ok()?);
        let zipped = reader.fill_buf().ok()?.starts_with(&[0x1f, 0x8b]);
        let reader: Box<dyn Read> =
            if zipped { Box::new(MultiGzDecoder::new(reader)) } else { Box::new(reader) };
        let line = usize::try_from(line).ok()?.checked_sub(1)?;
        let first = line.saturating_sub(1);
        let mut text = String::new();
        let mut fault = None;
        for (number, raw) in (first..=line + 1).zip(BufReader::new(reader).split(b'\n').skip(first)) {
            let Ok(raw) = raw else { break };
            let clean: String =
                String::from_utf8_lossy(&raw).chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            let shown: String = clean.chars().take(SHOWN).collect();
            if number == line {
                let within = column.map_or(0, |c| c as usize - 1).min(shown.trim_end().len());
                let within = (0..=within).rev().find(|&i| shown.is_char_boundary(i)).unwrap_or(0);
                let rest = shown[within..].trim_end();
                let word = rest.find([' ', '\t', ',', ';']).filter(|&l| column.is_some() && l > 0);
                fault = Some((text.len() + within, word.unwrap_or(rest.len())));
            }
            text.push_str(shown.trim_end());
            text.push('\n');
        }
        Some(Excerpt { name: path.display().to_string(), text, first, fault: fault? })
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, before, after)?;
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            inner.data(),
            *inner.span(),
            inner.line() + self.first,
            inner.column(),
            inner.line_count(),
        )))
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
            Error::Piece { .. } | Error::Rival(_) => Failure::new(Code::Limit, error.to_string()),
            Error::NotCertified { .. } => Failure::new(Code::Rejected, error.to_string()),
        }
    }
}
