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
    let path = path.display().to_string();
    match number {
        Some(number) => {
            let text = io::Error::from_raw_os_error(number).to_string();
            let text = text.split(" (os error").next().unwrap_or(&text).to_owned();
            PyOSError::new_err((number, text, path))
        }
        None => PyOSError::new_err(format!("{path}: {kind}")),
    }
}

/// Returns the exception for a file that cannot be read.
pub fn of_input(py: Python<'_>, error: &InputError) -> PyErr {
    match error {
        InputError::Missing { path } => of_system(io::ErrorKind::NotFound, None, path),
        InputError::Directory { path } => of_system(io::ErrorKind::IsADirectory, None, path),
        InputError::Unreadable { path, source } => of_system(source.kind(), source.raw_os_error(), path),
        _ => {
            let message = with_remedy(&error.to_string(), error.remedy());
            let raised =
                exception(py, "InputError", &message, [("path", error.path().display().to_string())]);
            // Setting an attribute of an exception of the package cannot fail.
            let _ = raised.value(py).setattr("line", error.line());
            raised
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
        _ => plain(py, "OptionError", &with_remedy(&error.to_string(), error.remedy())),
    }
}
