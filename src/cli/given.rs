//! The options of a run on the command line, made from their rows.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use septet_core::Spec;
use septet_core::spec::{Commands, Row, SpecError, Value, Words, options_of};
use septet_io::Role;

use super::effects::needs;
use super::errors::Failure;
use super::names::{of_role, raw_rows, with_formats};

/// The options of a run that a command has, as given. `COMMAND` are the bits of [`Commands`].
#[derive(Clone, Debug)]
pub struct Given<const COMMAND: u8>(Options);

/// The options that a user gave.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Options with their texts, in the order of the rows.
    words: Vec<(&'static Row, String)>,
}

impl<const COMMAND: u8> Given<COMMAND> {
    /// Returns the options.
    pub fn options(&self) -> &Options {
        &self.0
    }
}

impl<const COMMAND: u8> Args for Given<COMMAND> {
    fn augment_args(command: Command) -> Command {
        let of = Commands::of_bits(COMMAND);
        options_of(of).fold(command, |command, row| command.arg(argument(row, of)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const COMMAND: u8> FromArgMatches for Given<COMMAND> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |row: &&Row| matches.value_source(row.key) == Some(ValueSource::CommandLine);
        let text = |row: &Row| {
            if row.is_flag { Some("true".to_owned()) } else { matches.get_one::<String>(row.key).cloned() }
        };
        let rows = options_of(Commands::of_bits(COMMAND)).filter(given);
        Ok(Given(Options { words: rows.filter_map(|row| Some((row, text(row)?))).collect() }))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Options {
    /// Returns `true` if the user gave this option.
    pub fn has(&self, name: &str) -> bool {
        self.words.iter().any(|(row, _)| row.name == name)
    }

    /// Returns the specification as requested.
    ///
    /// # Errors
    /// Fails if an option has no effect with the others.
    pub fn spec(&self) -> Result<Spec, Failure> {
        let mut spec = Spec::default();
        for (row, text) in &self.words {
            match row.set(&mut spec, text) {
                Err(SpecError::Needs { option, needed, word }) => {
                    needs(&format!("--{option}"), true, &format!("--{needed} {word}"), false)?;
                }
                set => set?,
            }
        }
        Ok(spec)
    }
}

/// Returns the argument of a row for a command.
fn argument(row: &'static Row, command: Commands) -> Arg {
    let doc = with_formats(row.doc);
    let (short, long) = doc.split_once("\n\n").unwrap_or((&doc, ""));
    let mut argument =
        Arg::new(row.key).long(row.name).help(short.to_owned()).help_heading(row.heading.title());
    if !long.is_empty() {
        argument = argument.long_help(doc.clone());
    }
    if let Some(short) = row.short {
        argument = argument.short(short);
    }
    argument = argument.hide_short_help(!row.is_common);
    if row.is_flag {
        return argument.action(ArgAction::SetTrue);
    }
    if let Some(default) = row.default_text() {
        argument = argument.default_value(default);
    }
    if row.words.is_empty() {
        let parser = move |text: &str| checked(row, text).map(|()| text.to_owned());
        return argument.value_name(row.form).allow_negative_numbers(true).value_parser(parser);
    }
    let words = row.words_of(command).map(|&(word, meaning)| PossibleValue::new(word).help(meaning));
    argument.value_parser(PossibleValuesParser::new(words))
}

/// Checks a value by itself. Readers know the names of formats.
fn checked(row: &Row, text: &str) -> Result<(), String> {
    match row.name {
        "input-format" => of_role(Role::Points)(text).map(drop),
        "raw" => raw_rows(text).map(drop),
        _ => row.check(text),
    }
}

/// Returns a parser of the words of an enum, with their meanings in the help.
pub fn words<T: Words + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let words = T::TABLE.iter().map(|&(word, meaning)| PossibleValue::new(word).help(meaning));
    PossibleValuesParser::new(words).try_map(|word| T::read(&word))
}
