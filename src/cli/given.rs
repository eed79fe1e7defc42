//! The options of a run on the command line, made from their rows.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use septet_core::Spec;
use septet_core::mesh::{MESH_OPTIONS, MeshSpec};
use septet_core::spec::{Commands, OPTIONS, Row, SpecError, Value, Words, options_of};
use septet_io::Role;

use super::effects::needs;
use super::errors::Failure;
use super::names::{of_role, raw_rows, with_formats};

/// The options of a run that a command has, as given. `COMMAND` are the bits of [`Commands`].
#[derive(Clone, Debug)]
pub struct Given<const COMMAND: u16>(Options<Spec>);

impl<const COMMAND: u16> Given<COMMAND> {
    /// Returns the options.
    pub fn options(&self) -> &Options<Spec> {
        &self.0
    }
}

impl<const COMMAND: u16> Args for Given<COMMAND> {
    fn augment_args(command: Command) -> Command {
        let of = Commands::of_bits(COMMAND);
        arguments(command, OPTIONS, of)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const COMMAND: u16> FromArgMatches for Given<COMMAND> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Given(Options::of(matches, options_of(Commands::of_bits(COMMAND)))))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The options of a mesh, as given.
#[derive(Clone, Debug)]
pub struct GivenMesh(Options<MeshSpec>);

impl GivenMesh {
    /// Returns the options.
    pub fn options(&self) -> &Options<MeshSpec> {
        &self.0
    }
}

impl Args for GivenMesh {
    fn augment_args(command: Command) -> Command {
        arguments(command, MESH_OPTIONS, Commands::MESH)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for GivenMesh {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(GivenMesh(Options::of(matches, MESH_OPTIONS)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The options of a specification that a user gave.
#[derive(Clone, Debug)]
pub struct Options<S: 'static> {
    /// Options with their texts, in the order of the rows.
    words: Vec<(&'static Row<S>, String)>,
}

impl<S: Default> Options<S> {
    fn of(matches: &ArgMatches, rows: impl IntoIterator<Item = &'static Row<S>>) -> Self {
        let given = |row: &&Row<S>| matches.value_source(row.key) == Some(ValueSource::CommandLine);
        let text = |row: &Row<S>| {
            if row.is_flag {
                return Some("true".to_owned());
            }
            let values: Vec<&str> = matches.get_many::<String>(row.key)?.map(String::as_str).collect();
            Some(values.join(","))
        };
        let rows = rows.into_iter().filter(given);
        Options { words: rows.filter_map(|row| Some((row, text(row)?))).collect() }
    }

    /// Returns `true` if the user gave this option.
    pub fn has(&self, name: &str) -> bool {
        self.words.iter().any(|(row, _)| row.name == name)
    }

    /// Returns the options that have no effect unless another option has a value: their names, with that option and value.
    pub fn needs(&self) -> impl Iterator<Item = (&'static str, (&'static str, &'static str))> {
        self.words.iter().filter_map(|(row, _)| Some((row.name, row.needs?)))
    }

    /// Returns the specification as requested.
    ///
    /// # Errors
    /// Fails if an option has no effect with the others.
    pub fn spec(&self) -> Result<S, Failure> {
        let mut spec = S::default();
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

/// Adds the arguments of rows to a command.
fn arguments<S: Default + 'static>(
    command: Command,
    rows: impl IntoIterator<Item = &'static Row<S>>,
    of: Commands,
) -> Command {
    let rows = rows.into_iter().filter(|row| row.commands.meets(of));
    rows.fold(command, |command, row| command.arg(argument(row, of)))
}

/// Returns the argument of a row for a command.
fn argument<S: Default + 'static>(row: &'static Row<S>, command: Commands) -> Arg {
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
    if row.types.contains(&"array") {
        argument = argument.action(ArgAction::Append);
    }
    if row.is_flag {
        return argument.action(ArgAction::SetTrue);
    }
    if let Some(default) = row.default_text() {
        argument = argument.default_value(default);
    }
    if row.words.is_empty() {
        let parser = move |text: &str| checked(row, text).map(|()| text.to_owned());
        // A list of numbers may begin with a negative one.
        let takes_lists = row.check("-1,0").is_ok() && row.check("a,b").is_err();
        argument = argument.allow_negative_numbers(true).allow_hyphen_values(takes_lists);
        return argument.value_name(row.form).value_parser(parser);
    }
    let words = row.words_of(command).map(|&(word, meaning)| PossibleValue::new(word).help(meaning));
    argument.value_name(row.key.to_uppercase()).value_parser(PossibleValuesParser::new(words))
}

/// Checks a value by itself. Readers know the names of formats.
fn checked<S: Default>(row: &Row<S>, text: &str) -> Result<(), String> {
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
