//! Names of formats on the command line.

use septet_io::read::{Format, RawRows, UnknownFormatName, UnknownRawRows};

use super::text::suggestion;

/// The message for an unknown name, with a suggestion.
pub(super) fn unknown(name: &str, error: UnknownFormatName) -> String {
    format!("{}{error}", suggestion(&name.to_ascii_lowercase(), error.known.split(' ')))
}

/// Parses the form of binary coordinates.
pub fn raw_rows(text: &str) -> Result<RawRows, String> {
    text.parse().map_err(|error: UnknownRawRows| error.to_string())
}

/// Parses the name of a format of points.
pub fn input_format(name: &str) -> Result<Format, String> {
    let parsed = name.parse().map_err(|error| unknown(name, error))?;
    if parsed == Format::Ele { Err("ele is a format of cells, not of points".to_owned()) } else { Ok(parsed) }
}
