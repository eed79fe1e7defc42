//! Remedies of errors. Each door to the library spells the options in a remedy in its own words.

use std::borrow::Cow;
use std::fmt::{self, Display, Write};

/// What the caller can do about an error.
///
/// A remedy is a template. `{max-memory}` stands for an option, `{workers=1}` for an option with a value, and `{{` for a
/// brace. Only options of the library are parsed: [`Remedy::and`] takes the data of an error as they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remedy(Cow<'static, str>);

/// A way to call septet. It decides the spelling of options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Door {
    /// The command line: `--max-memory`, `--workers 1`.
    Shell,
    /// The library: `max_memory`, `workers = 1`, in backticks.
    Rust,
    /// The Python package: `max_memory=...`, `workers=1`, `supergraph="knn"`. An option that has another name there, such as
    /// `period=...`, is spelled so.
    Python,
    /// The library for C, whose options are fields: `max_memory`, `workers = 1`.
    C,
}

impl Remedy {
    /// The remedy for errors that no caller can cause.
    pub const REPORT: Remedy = Remedy::of("this is a defect of septet: please report it with the input");

    /// Creates a remedy from a template.
    pub const fn of(template: &'static str) -> Self {
        Remedy(Cow::Borrowed(template))
    }

    /// Creates a remedy without options from a text.
    pub fn plain(text: impl Display) -> Self {
        Remedy::of("").and(text)
    }

    /// Returns the remedy that another process sent ([`Remedy::sent`]).
    pub fn received(template: String) -> Option<Self> {
        (!template.is_empty()).then_some(Remedy(Cow::Owned(template)))
    }

    /// Returns the text with which a remedy travels to other processes.
    pub fn sent(remedy: Option<Remedy>) -> String {
        remedy.map_or_else(String::new, |remedy| remedy.0.into_owned())
    }

    /// Adds a text without options.
    #[must_use]
    pub fn and(self, text: impl Display) -> Self {
        self.pushed(&text.to_string().replace('{', "{{"))
    }

    /// Adds a template.
    #[must_use]
    pub fn then(self, template: &'static str) -> Self {
        self.pushed(template)
    }

    /// Adds an option.
    #[must_use]
    pub fn option(self, name: &'static str) -> Self {
        self.pushed(&format!("{{{name}}}"))
    }

    /// Adds an option with a value: a number, or a word of the library.
    #[must_use]
    pub fn set(self, name: &'static str, value: impl Display) -> Self {
        self.pushed(&format!("{{{name}={value}}}"))
    }

    fn pushed(self, template: &str) -> Self {
        Remedy(Cow::Owned(self.0.into_owned() + template))
    }

    /// Returns the remedy in the words of a door.
    pub fn spelled(&self, door: Door) -> String {
        door.spell(&self.0)
    }
}

impl Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.spelled(Door::Rust))
    }
}

impl Door {
    /// Returns the text of a template ([`Remedy`]) in the words of this door.
    pub fn spell(self, template: &str) -> String {
        let mut text = String::with_capacity(template.len());
        let mut rest = template;
        while let Some((before, after)) = rest.split_once('{') {
            text.push_str(before);
            rest = match (after.strip_prefix('{'), after.split_once('}')) {
                (None, Some((option, after))) => {
                    self.add_option(option, &mut text);
                    after
                }
                (brace, _) => {
                    text.push('{');
                    brace.unwrap_or(after)
                }
            };
        }
        text + rest
    }

    /// Adds an option with its value, if it has one.
    fn add_option(self, option: &str, text: &mut String) {
        let (name, value) =
            option.split_once('=').map_or((option, None), |(name, value)| (name, Some(value)));
        let key = || name.replace('-', "_");
        // Writing to a string cannot fail.
        let _ = match (self, value) {
            (Door::Shell, None) => write!(text, "--{name}"),
            (Door::Shell, Some(value)) => write!(text, "--{name} {value}"),
            (Door::Rust, None) => write!(text, "`{}`", key()),
            (Door::Rust, Some(value)) => write!(text, "`{} = {value}`", key()),
            (Door::Python, None) if name == "skip-invalid" => write!(text, "on_invalid=\"skip\""),
            (Door::Python, None) if name == "periodic" => write!(text, "period=..."),
            (Door::Python, None) if name == "wrap" => write!(text, "wrap=True"),
            (Door::Python, None) if name == "dimension" => write!(text, "ndim=..."),
            (Door::Python, Some(value)) if name == "dimension" => write!(text, "ndim={value}"),
            (Door::C, None) if name == "periodic" => write!(text, "period"),
            (Door::Python, None) => write!(text, "{}=...", key()),
            (Door::Python, Some(value)) if value.parse::<f64>().is_err() => {
                write!(text, "{}=\"{value}\"", key())
            }
            (Door::Python, Some(value)) => write!(text, "{}={value}", key()),
            (Door::C, None) => write!(text, "{}", key()),
            (Door::C, Some(value)) => write!(text, "{} = {value}", key()),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doors_spell_options() {
        let remedy = Remedy::of("raise {max-memory}, or use {workers=1} or ").set("leaf", 7).then(".");
        assert_eq!(remedy.spelled(Door::Shell), "raise --max-memory, or use --workers 1 or --leaf 7.");
        assert_eq!(remedy.to_string(), "raise `max_memory`, or use `workers = 1` or `leaf = 7`.");
        assert_eq!(remedy.spelled(Door::Python), "raise max_memory=..., or use workers=1 or leaf=7.");
        assert_eq!(remedy.spelled(Door::C), "raise max_memory, or use workers = 1 or leaf = 7.");
        let words = Remedy::of("use {separator-sets=both} or {skip-invalid}");
        assert_eq!(words.spelled(Door::Python), "use separator_sets=\"both\" or on_invalid=\"skip\"");
        assert_eq!(words.spelled(Door::C), "use separator_sets = both or skip_invalid");
        let others = Remedy::of("give {origin}, {wrap}, {periodic} or {dimension=2}");
        assert_eq!(others.spelled(Door::Python), "give origin=..., wrap=True, period=... or ndim=2");
        assert_eq!(others.spelled(Door::C), "give origin, wrap, period or dimension = 2");
    }

    #[test]
    fn data_are_not_parsed() {
        for data in ["{leaf}", "{", "{{", "}", "a {b=1} c", "{{{", ""] {
            let remedy = Remedy::of("rename ").and(data).then(" or omit ").option("raw");
            assert_eq!(remedy.spelled(Door::Shell), format!("rename {data} or omit --raw"));
            assert_eq!(Remedy::received(Remedy::sent(Some(remedy.clone()))), Some(remedy));
        }
        assert_eq!(Remedy::received(Remedy::sent(None)), None);
        assert_eq!(Door::Shell.spell("an open {brace"), "an open {brace");
    }
}
