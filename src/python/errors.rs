//! Failures as exceptions of the package.

use std::io;
use std::path::Path;

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use septet_core::{Code, Door, Remedy};
use septet_doors::Failure;
use septet_io::read::InputError;
use septet_io::write::OutputError;

/// Creates an exception of the package with its attributes.
pub fn exception<'py, V: IntoPyObject<'py>>(
    py: Python<'py>,
    class: &str,
    message: &str,
    attributes: impl IntoIterator<Item = (&'static str, V)>,
) -> PyErr {
    let made = || {
        let value = py.import("septet._errors")?.getattr(class)?.call1((message,))?;
        for (name, attribute) in attributes {
            value.setattr(name, attribute)?;
        }
        Ok(value)
    };
    made().map_or_else(|error: PyErr| error, PyErr::from_value)
}

/// Creates an exception of the package without attributes.
pub fn plain(py: Python<'_>, class: &str, message: &str) -> PyErr {
    exception(py, class, message, [("", 0); 0])
}

/// Returns the exception of a failure.
pub fn raise(py: Python<'_>, failure: &Failure) -> PyErr {
    let message = &failure.message;
    if let Some(forecast) = failure.forecast {
        let sizes = [("forecast", forecast.bytes), ("limit", forecast.limit)];
        return exception(py, "MemoryLimitError", message, sizes);
    }
    match (failure.code, failure.index) {
        (_, Some(index)) => exception(py, "PointError", message, [("index", index)]),
        (Code::Input, None) => plain(py, "PointError", message),
        (Code::Usage, None) => plain(py, "OptionError", message),
        (Code::Limit, None) => plain(py, "MemoryLimitError", message),
        _ => plain(py, "RunError", message),
    }
}

/// Returns a text with its remedy.
pub fn with_remedy(message: &str, remedy: Option<Remedy>) -> String {
    remedy.map_or_else(|| message.to_owned(), |remedy| format!("{message}; {}", remedy.spelled(Door::Python)))
}

/// Returns a text with the parts of its remedy that name only options of a function: its other parts are for the program. `options`
/// are spelled as in the program.
pub fn with_known(message: &str, remedy: Option<Remedy>, options: &[&str]) -> String {
    let template = Remedy::sent(remedy);
    let is_known = |part: &&str| {
        let names = part.split('{').skip(1).filter_map(|rest| rest.split_once('}'));
        names
            .map(|(option, _)| option.split('=').next().unwrap_or_default())
            .all(|name| options.contains(&name))
    };
    let clause = |clause: &str| clause.split(", or ").filter(is_known).collect::<Vec<_>>().join(", or ");
    let known: Vec<String> = template.split("; ").map(clause).filter(|clause| !clause.is_empty()).collect();
    match known.join("; ") {
        known if known.is_empty() => message.to_owned(),
        known => format!("{message}; {}", Door::Python.spell(&known)),
    }
}

/// The options of `septet.read`.
pub const OF_READ: &[&str] = &["columns", "dimension"];

/// The options of `septet.mesh`.
pub const OF_MESH: &[&str] = &[
    "size",
    "min-size",
    "boundary",
    "max-distance",
    "feature-angle",
    "improve",
    "threads",
    "seed",
    "max-memory",
];

/// Returns the exception of an error of the operating system: of the class that fits its number.
fn of_system(kind: io::ErrorKind, number: Option<i32>, path: &Path) -> PyErr {
    // The numbers of Linux, macOS and Windows are the same for these kinds.
    let number = number.or(match kind {
        io::ErrorKind::NotFound => Some(2),
        io::ErrorKind::PermissionDenied => Some(13),
        io::ErrorKind::NotADirectory => Some(20),
        io::ErrorKind::IsADirectory => Some(21),
        _ => None,
    });
    match number {
        Some(number) => {
            let text = io::Error::from_raw_os_error(number).to_string();
            let text = text.split(" (os error").next().unwrap_or(&text).to_owned();
            PyOSError::new_err((number, text, path.as_os_str().to_owned()))
        }
        None => PyOSError::new_err(format!("{}: {kind}", path.display())),
    }
}

/// Returns the exception for a file that is not what it should be, with the line of a text file.
pub fn of_file(py: Python<'_>, message: &str, path: &Path, line: Option<u64>) -> PyErr {
    let raised = exception(py, "InputError", message, [("path", path.as_os_str().to_owned())]);
    // Setting an attribute of an exception of the package cannot fail.
    let _ = raised.value(py).setattr("line", line);
    raised
}

/// Returns the exception for a file that a function with these options cannot read.
pub fn of_input(py: Python<'_>, error: &InputError, options: &[&str]) -> PyErr {
    match error {
        InputError::Missing { path } => of_system(io::ErrorKind::NotFound, None, path),
        InputError::Directory { path } => of_system(io::ErrorKind::IsADirectory, None, path),
        InputError::Unreadable { path, source } => of_system(source.kind(), source.raw_os_error(), path),
        _ => {
            let message = with_known(&error.to_string(), error.remedy(), options);
            of_file(py, &message, error.path(), error.line())
        }
    }
}

/// Returns the exception for a file that cannot be written.
pub fn of_output(py: Python<'_>, error: &OutputError) -> PyErr {
    match error {
        OutputError::MissingDirectory { path, .. } => of_system(io::ErrorKind::NotFound, None, path),
        OutputError::IsDirectory { path } => of_system(io::ErrorKind::IsADirectory, None, path),
        OutputError::NotWritable { path, source } | OutputError::Io { path, source } => {
            of_system(source.kind(), source.raw_os_error(), path)
        }
        _ => plain(py, "OptionError", &with_known(&error.to_string(), error.remedy(), &[])),
    }
}
