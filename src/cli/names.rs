//! Names of formats on the command line.

use septet_core::Door;
use septet_io::read::{RawRows, UnknownRawRows};
use septet_io::{Format, Role};

use super::text::suggestion;

/// Returns a parser of the names of formats that have a use.
pub fn of_role(role: Role) -> impl Fn(&str) -> Result<Format, String> + Clone {
    move |name| {
        Format::named(name, role).map_err(|error| {
            let near = suggestion(&name.to_ascii_lowercase(), error.known.split(' '));
            format!("{near}{error}")
        })
    }
}

/// Parses the form of binary coordinates.
pub fn raw_rows(text: &str) -> Result<RawRows, String> {
    text.parse().map_err(|error: UnknownRawRows| error.to_string())
}

/// Returns the names of the formats of a use, without further names of the same format.
pub fn names(role: Role) -> String {
    role.formats().map(Format::name).collect::<Vec<_>>().join(", ")
}

/// Returns the text of a row of options. `{points}` stands for the names of formats of points, and `{data}` for the
/// extensions of outputs with values at points.
pub fn with_formats(text: &str) -> String {
    let text = text.replace("{points}", &names(Role::Points)).replace("{data}", &with_data());
    Door::Shell.spell(&text)
}

/// Returns the extensions of outputs with values at points, for help texts and messages.
pub fn with_data() -> String {
    Role::Triangulation.extensions(|row| row.has_data)
}
