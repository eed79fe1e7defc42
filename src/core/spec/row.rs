//! The form of an option of a run: its texts, its values, and what it can change.

use super::error::SpecError;
use super::groups::Spec;
use super::task::Until;
use super::value::{Setting, Word};

/// The commands that have options of a run, as a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Commands(u16);

impl Commands {
    /// `septet triangulate`.
    pub const TRIANGULATE: Commands = Commands(1);
    /// `septet simulate`.
    pub const SIMULATE: Commands = Commands(2);
    /// `septet scale`.
    pub const SCALE: Commands = Commands(4);
    /// `septet predict`.
    pub const PREDICT: Commands = Commands(8);
    /// `septet mesh`.
    pub const MESH: Commands = Commands(16);
    /// `septet rival`.
    pub const RIVAL: Commands = Commands(32);
    /// `septet verify`, which only reads points.
    pub const VERIFY: Commands = Commands(64);
    /// `septet locate`, `septet interpolate`, `septet voronoi` and `septet alpha`.
    pub const QUERIES: Commands = Commands(128);
    /// `septet voronoi`, which also takes weights and periodic boxes.
    pub const VORONOI: Commands = Commands(256);

    pub(super) const RUNS: Commands = Commands::TRIANGULATE.and(Commands::SIMULATE);
    pub(super) const BOXES: Commands = Commands::RUNS.and(Commands::VERIFY).and(Commands::VORONOI);
    pub(super) const COUNTS: Commands = Commands::SIMULATE.and(Commands::SCALE).and(Commands::PREDICT);
    pub(super) const POINTS: Commands = Commands::RUNS.and(Commands::PREDICT).and(Commands::RIVAL);
    pub(super) const FILES: Commands = Commands::POINTS.and(Commands::VERIFY).and(Commands::QUERIES);
    pub(super) const TREES: Commands = Commands::RUNS.and(Commands::SCALE).and(Commands::PREDICT);
    pub(super) const MACHINES: Commands = Commands::TREES.and(Commands::MESH);

    /// Returns the commands of both sets.
    #[must_use]
    pub const fn and(self, other: Commands) -> Commands {
        Commands(self.0 | other.0)
    }

    /// Returns `true` if the sets have a command in common.
    #[must_use]
    pub const fn meets(self, other: Commands) -> bool {
        self.0 & other.0 != 0
    }

    /// Returns the set of these bits ([`Commands::bits`]).
    #[must_use]
    pub const fn of_bits(bits: u16) -> Commands {
        Commands(bits)
    }

    /// Returns the set as bits, for a parameter of a type.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }
}

/// The heading of an option in the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// The points.
    Input,
    /// The files of the result.
    Output,
    /// The machine and its partition tree.
    Machine,
    /// The supergraph.
    Graph,
    /// The sizes and the quality of a mesh.
    Sizes,
    /// The boundary of a mesh.
    Boundary,
    /// Reports and tables.
    Reports,
}

impl Heading {
    /// Returns the text of the heading.
    pub const fn title(self) -> &'static str {
        match self {
            Heading::Input => "Input",
            Heading::Output => "Output",
            Heading::Machine => "Machine",
            Heading::Graph => "Supergraph",
            Heading::Sizes => "Sizes and quality",
            Heading::Boundary => "Boundary",
            Heading::Reports => "Reports",
        }
    }
}

/// What another value of an option can change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Matters {
    /// Only the contents of reports and files besides the cells.
    Report,
    /// Only times and memory.
    Time,
    /// The counts of the machine, but no cell.
    Counts,
    /// The cells.
    Cells,
}

words!(Matters {
    Report "report" "Only the contents of reports and files besides the cells",
    Time "time" "Only times and memory",
    Counts "counts" "The counts of the machine, but no cell",
    Cells "cells" "The cells",
});

/// The form of an option in the name of a series of runs: the words before its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// The name does not contain the option.
    Omitted,
    /// The name contains the value unless it is the default.
    Changed(&'static str),
    /// The name contains the value.
    Always(&'static str),
}

/// One option of a specification: of a run, or of a mesh ([`crate::mesh::MESH_OPTIONS`]).
#[derive(Debug)]
pub struct Row<S: 'static = Spec> {
    /// The name on the command line.
    pub name: &'static str,
    /// The name in reports and in other languages.
    pub key: &'static str,
    /// The short name on the command line.
    pub short: Option<char>,
    /// The first paragraph is the short help. The other one is the rest of the long help. `{points}` and `{data}` stand for
    /// the formats of points and of outputs with values at points, which readers and writers know. Other options are
    /// those of a template ([`crate::Remedy`]).
    pub doc: &'static str,
    /// The form of the value, such as `P|auto|leaves`. Empty for words and flags.
    pub form: &'static str,
    /// The words of the option, if its values are words.
    pub words: &'static [Word],
    /// The JSON types of the value in a report ([`super::Value::TYPES`]).
    pub types: &'static [&'static str],
    /// Whether the option is a flag.
    pub is_flag: bool,
    /// The commands that have the option.
    pub commands: Commands,
    /// Words that only some of these commands have.
    pub limited: &'static [(&'static str, Commands)],
    /// The heading in the help.
    pub heading: Heading,
    /// Whether the short help lists the option.
    pub is_common: bool,
    /// What another value can change.
    pub matters: Matters,
    /// The option and the word without which this option has no effect.
    pub needs: Option<(&'static str, &'static str)>,
    /// The form of the option in the name of a series of runs.
    pub series: Series,
    /// The first phase that uses the option, of those after which a run may stop.
    pub first_use: Until,
    /// Checks a value.
    pub(crate) check: fn(&str) -> Result<(), String>,
    pub(crate) get: fn(&S) -> Setting,
    pub(crate) set: fn(&mut S, &str) -> Result<(), SpecError>,
}

impl<S> Row<S> {
    /// A row of which every column is the usual one, or empty.
    pub(crate) const PLAIN: Row<S> = Row {
        name: "",
        key: "",
        short: None,
        doc: "",
        form: "",
        words: &[],
        types: &[],
        is_flag: false,
        commands: Commands::MACHINES,
        limited: &[],
        heading: Heading::Machine,
        is_common: false,
        matters: Matters::Counts,
        needs: None,
        series: Series::Omitted,
        first_use: Until::Partition,
        check: |_| Ok(()),
        get: |_| Setting::None,
        set: |_, _| Ok(()),
    };
}

impl<S: Default> Row<S> {
    /// Checks a value by itself.
    ///
    /// # Errors
    /// Returns what was expected.
    pub fn check(&self, text: &str) -> Result<(), String> {
        (self.check)(text)
    }

    /// Returns the value in a specification.
    pub fn get(&self, spec: &S) -> Setting {
        (self.get)(spec)
    }

    /// Sets the value. Options that are set together must be set in the order of [`super::OPTIONS`].
    ///
    /// # Errors
    /// Fails if the value is not one of this option, or has no effect with options that were set before.
    pub fn set(&self, spec: &mut S, text: &str) -> Result<(), SpecError> {
        (self.set)(spec, text)
    }

    /// Returns the default as text, if there is one.
    pub fn default_text(&self) -> Option<String> {
        self.get(&S::default()).text()
    }

    /// Returns `true` if the value is not the default.
    pub fn is_changed(&self, spec: &S) -> bool {
        self.get(spec) != self.get(&S::default())
    }

    /// Returns the words that a command has, with their meanings.
    pub fn words_of(&self, command: Commands) -> impl Iterator<Item = &'static Word> {
        let has = move |word: &str| {
            self.limited.iter().all(|&(limited, commands)| limited != word || commands.meets(command))
        };
        self.words.iter().filter(move |(word, _)| has(word))
    }
}

/// A row of an option: the specification that has it, its name and key, its document, the type of its value, how it is read
/// and set, and the columns that differ from [`Row::PLAIN`].
macro_rules! option {
    ($spec:ty, $name:literal, $key:literal, $doc:literal, $type:ty, $get:expr, $set:expr, { $($column:ident: $value:expr),* $(,)? }) => {
        $crate::spec::Row {
            $($column: $value,)*
            name: $name,
            key: $key,
            doc: $doc,
            words: <$type as $crate::spec::Value>::WORDS,
            types: <$type as $crate::spec::Value>::TYPES,
            check: |text| <$type as $crate::spec::Value>::read(text).map(drop),
            get: |spec| {
                let get: fn(&$spec) -> $type = $get;
                $crate::spec::Value::setting(&get(spec))
            },
            set: |spec, text| {
                let value = <$type as $crate::spec::Value>::read(text).map_err(|expected| $crate::spec::SpecError::Value {
                    option: $name,
                    value: text.to_owned(),
                    expected,
                })?;
                let set: fn(&mut $spec, $type) -> Result<(), $crate::spec::SpecError> = $set;
                set(spec, value)
            },
            ..$crate::spec::Row::PLAIN
        }
    };
}
pub(crate) use option;
