//! The options of a run: one row for each. Command lines, help, reports, sweeps and the guide read these rows.

use septet_workers::config::Neighbours;

use super::value::{Auto, Between, Bytes, Seed, Setting, Value, Whole, Word, Words, words};
use super::{
    Alpha, Correction, GraphKind, Nodes, Partition, Purpose, Registers, SeparatorSets, Spec, SpecError,
    TransportName, Workers,
};
use crate::result::view::MOST_POINTS;

/// The commands that have options of a run, as a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Commands(u8);

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

    const RUNS: Commands = Commands::TRIANGULATE.and(Commands::SIMULATE);
    const COUNTS: Commands = Commands::SIMULATE.and(Commands::SCALE).and(Commands::PREDICT);
    const POINTS: Commands = Commands::RUNS.and(Commands::PREDICT).and(Commands::RIVAL);
    const FILES: Commands = Commands::POINTS.and(Commands::VERIFY);
    const TREES: Commands = Commands::RUNS.and(Commands::SCALE).and(Commands::PREDICT);
    const MACHINES: Commands = Commands::TREES.and(Commands::MESH);

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
    pub const fn of_bits(bits: u8) -> Commands {
        Commands(bits)
    }

    /// Returns the set as bits, for a parameter of a type.
    #[must_use]
    pub const fn bits(self) -> u8 {
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
    /// The cells, because other points are read.
    Cells,
}

words!(Matters {
    Report "report" "Only the contents of reports and files besides the cells",
    Time "time" "Only times and memory",
    Counts "counts" "The counts of the machine, but no cell",
    Cells "cells" "The cells, because other points are read",
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

/// One option of a run.
#[derive(Debug)]
pub struct Row {
    /// The name on the command line.
    pub name: &'static str,
    /// The name in reports and in other languages.
    pub key: &'static str,
    /// The short name on the command line.
    pub short: Option<char>,
    /// The first paragraph is the short help. The other one is the rest of the long help. `{points}` and `{data}` stand for
    /// the formats of points and of outputs with values at points, which readers and writers know.
    pub doc: &'static str,
    /// The form of the value, such as `P|auto|leaves`. Empty for words and flags.
    pub form: &'static str,
    /// The words of the option, if its values are words.
    pub words: &'static [Word],
    /// The JSON types of the value in a report ([`Value::TYPES`]).
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
    /// Checks a value.
    check: fn(&str) -> Result<(), String>,
    get: fn(&Spec) -> Setting,
    set: fn(&mut Spec, &str) -> Result<(), SpecError>,
}

impl Row {
    /// Checks a value by itself.
    ///
    /// # Errors
    /// Returns what was expected.
    pub fn check(&self, text: &str) -> Result<(), String> {
        (self.check)(text)
    }

    /// Returns the value in a specification.
    pub fn get(&self, spec: &Spec) -> Setting {
        (self.get)(spec)
    }

    /// Sets the value. Options that are set together must be set in the order of [`OPTIONS`].
    ///
    /// # Errors
    /// Fails if the value is not one of this option, or has no effect with options that were set before.
    pub fn set(&self, spec: &mut Spec, text: &str) -> Result<(), SpecError> {
        (self.set)(spec, text)
    }

    /// Returns the default as text, if there is one.
    pub fn default_text(&self) -> Option<String> {
        self.get(&Spec::default()).text()
    }

    /// Returns `true` if the value is not the default.
    pub fn is_changed(&self, spec: &Spec) -> bool {
        self.get(spec) != self.get(&Spec::default())
    }

    /// Returns the words that a command has, with their meanings.
    pub fn words_of(&self, command: Commands) -> impl Iterator<Item = &'static Word> + use<'_> {
        let has = move |word: &str| {
            self.limited.iter().all(|&(limited, commands)| limited != word || commands.meets(command))
        };
        self.words.iter().filter(move |(word, _)| has(word))
    }
}

/// Returns the row of an option.
///
/// # Panics
/// Panics if there is no such option.
pub fn row(name: &str) -> &'static Row {
    OPTIONS.iter().find(|row| row.name == name).unwrap_or_else(|| panic!("no option {name}"))
}

/// Returns the options of a command, in order.
pub fn options_of(command: Commands) -> impl Iterator<Item = &'static Row> {
    OPTIONS.iter().filter(move |row| row.commands.meets(command))
}

/// Returns the options whose values differ from the defaults and can change the counts of a command, as words of its
/// command line. All of them have a value there, including defaults.
pub fn words_of_counts(spec: &Spec, command: Commands) -> String {
    let rows = options_of(command).filter(|row| row.matters >= Matters::Counts);
    let word = |row: &Row| Some(format!(" --{} {}", row.name, row.get(spec).text()?));
    rows.filter_map(word).collect()
}

/// Returns the table of all options for the guide, in Markdown.
pub fn guide_table() -> String {
    let bar = |text: &str| text.replace('|', "\\|");
    let mut table =
        "| option | meaning | values | default | can change |\n|---|---|---|---|---|\n".to_owned();
    for row in OPTIONS {
        let (meaning, more) = row.doc.split_once("\n\n").unwrap_or((row.doc, ""));
        let ends = if more.is_empty() { "" } else { ". " };
        let words: Vec<String> = row.words.iter().map(|(word, _)| format!("`{word}`")).collect();
        let values = if row.words.is_empty() { format!("`{}`", bar(row.form)) } else { words.join(", ") };
        let values = if row.is_flag { "-".to_owned() } else { values };
        let default = row.default_text().map_or_else(|| "-".to_owned(), |text| format!("`{text}`"));
        let change = row.matters.name();
        let line =
            format!("| `--{}` | {meaning}{ends}{more} | {values} | {default} | {change} |\n", row.name);
        table.push_str(&line);
    }
    table
}

/// Returns the options of the algorithm for the name of a series, from their values as text. If `with_defaults` is not set,
/// no default is part of the name.
pub fn series_name(with_defaults: bool, text: impl Fn(&Row) -> Option<String>) -> Vec<String> {
    let named = |row: &Row| {
        let (before, is_shown) = match row.series {
            Series::Omitted => return None,
            Series::Changed(before) => (before, false),
            Series::Always(before) => (before, with_defaults),
        };
        let value = text(row).filter(|value| !value.is_empty() && value != "auto")?;
        (is_shown || Some(&value) != row.default_text().as_ref()).then(|| format!("{before}{value}"))
    };
    OPTIONS.iter().filter_map(named).collect()
}

/// A row whose other columns are replaced.
macro_rules! option {
    ($name:literal, $key:literal, $doc:literal, $type:ty, $get:expr, $set:expr, { $($column:ident: $value:expr),* $(,)? }) => {
        Row {
            $($column: $value,)*
            name: $name,
            key: $key,
            doc: $doc,
            words: <$type as Value>::WORDS,
            types: <$type as Value>::TYPES,
            check: |text| <$type as Value>::read(text).map(drop),
            get: |spec| {
                let get: fn(&Spec) -> $type = $get;
                Value::setting(&get(spec))
            },
            set: |spec, text| {
                let value = <$type as Value>::read(text).map_err(|expected| SpecError::Value {
                    option: $name,
                    value: text.to_owned(),
                    expected,
                })?;
                let set: fn(&mut Spec, $type) -> Result<(), SpecError> = $set;
                set(spec, value)
            },
            ..PLAIN
        }
    };
}

const PLAIN: Row = Row {
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
    check: |_| Ok(()),
    get: |_| Setting::None,
    set: |_, _| Ok(()),
};

/// The options of a run, in the order in which they are set and listed.
pub static OPTIONS: &[Row] = &[
    option!(
        "skip-invalid", "skip_invalid",
        "Drop points with coordinates that are not finite numbers, instead of refusing the file",
        bool,
        |s| s.input.skip_invalid,
        |s, is_set| { s.input.skip_invalid = is_set; Ok(()) },
        { is_flag: true, commands: Commands::POINTS, heading: Heading::Input, is_common: true, matters: Matters::Cells }
    ),
    option!(
        "dimension", "dimension",
        "Dimension of the input; 2 keeps the first two coordinates",
        Between<2, 3>,
        |s| Between(s.input.dimension.map(|dimension| dimension as u32)),
        |s, Between(dimension)| { s.input.dimension = dimension.map(|d| d as usize); Ok(()) },
        { short: Some('d'), form: "2|3", commands: Commands::POINTS, heading: Heading::Input, is_common: true, matters: Matters::Cells }
    ),
    option!(
        "columns", "columns",
        "Columns of the coordinates in a text table\n\nNames from the header row, or 1-based numbers. By default, \
         columns named x, y and z are used. A table without a header row may have two or three columns; one with more \
         columns needs this option or the dimension.",
        Option<Vec<String>>,
        |s| s.input.columns.clone(),
        |s, columns| { s.input.columns = columns; Ok(()) },
        { form: "X,Y[,Z]", commands: Commands::FILES, heading: Heading::Input, is_common: true, matters: Matters::Cells }
    ),
    option!(
        "input-format", "input_format",
        "Format of the points, for standard input and unknown extensions\n\n{points}.",
        Option<String>,
        |s| s.input.format.clone(),
        |s, format| { s.input.format = format; Ok(()) },
        { form: "NAME", commands: Commands::FILES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        "raw", "raw",
        "Read coordinates in binary without a header, such as f64,3\n\nThe type of the coordinates (f32 or f64, or f32be \
         or f64be for big-endian numbers) and the number of coordinates of a point (2 or 3). The names of the files may \
         be any but those of other formats.",
        Option<String>,
        |s| s.input.raw.clone(),
        |s, raw| { s.input.raw = raw; Ok(()) },
        { form: "TYPE,D", commands: Commands::FILES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        "keep-columns", "keep_columns",
        "Keep the other numeric columns of a text table as point data ({data})",
        bool,
        |s| s.input.keep_columns,
        |s, is_set| { s.input.keep_columns = is_set; Ok(()) },
        { is_flag: true, commands: Commands::RUNS, heading: Heading::Input, matters: Matters::Report }
    ),
    option!(
        "with-owner", "with_owner",
        "Write the owning worker and the owning leaf of every cell ({data})",
        bool,
        |s| s.keep.owner,
        |s, is_set| { s.keep.owner = is_set; Ok(()) },
        { is_flag: true, commands: Commands::RUNS, heading: Heading::Output, matters: Matters::Report }
    ),
    option!(
        "view", "view",
        "Number of points in the picture of the JSON report\n\nAt most 20000, 0 for none. [default: 20000 for simulate \
         in one process, otherwise 0]",
        Between<0, MOST_POINTS>,
        |s| Between(s.keep.view),
        |s, Between(points)| { s.keep.view = points; Ok(()) },
        { form: "N", commands: Commands::RUNS, heading: Heading::Reports, matters: Matters::Report }
    ),
    option!(
        "nodes", "nodes",
        "Nodes of the partition tree that the JSON report lists\n\nLevels, phases and totals always cover all nodes.",
        Nodes,
        |s| s.keep.nodes,
        |s, nodes| { s.keep.nodes = nodes; Ok(()) },
        { commands: Commands::SIMULATE, heading: Heading::Reports, matters: Matters::Report }
    ),
    option!(
        "workers", "workers",
        "Number of workers, or `leaves` for one per leaf of the partition tree\n\n`auto` is the number of cores. \
         `triangulate` takes fewer for few points, and for points on curved surfaces, where more workers are not \
         faster. With several processes, `auto` is one worker for each process.",
        Workers,
        |s| s.machine.workers,
        |s, workers| { s.machine.workers = workers; Ok(()) },
        { form: "P|auto|leaves", commands: Commands::RUNS.and(Commands::MESH), is_common: true }
    ),
    option!(
        "seed", "seed",
        "Seed of the random draws",
        Seed,
        |s| Seed(Some(s.machine.seed)),
        |s, Seed(seed)| { s.machine.seed = seed.unwrap_or(s.machine.seed); Ok(()) },
        { form: "S", commands: Commands::RUNS.and(Commands::PREDICT).and(Commands::MESH) }
    ),
    option!(
        "threads", "threads",
        "Number of threads that read, run the workers and write [default: cores]",
        Whole,
        |s| Whole(s.machine.threads.map(|threads| threads as u64)),
        |s, Whole(threads)| { s.machine.threads = threads.map(|threads| threads as usize); Ok(()) },
        { form: "T", is_common: true, matters: Matters::Time }
    ),
    option!(
        "registers", "registers",
        "SIMD width of the inner loops; it does not change results",
        Registers,
        |s| s.machine.registers,
        |s, registers| { s.machine.registers = registers; Ok(()) },
        { commands: Commands::TREES, matters: Matters::Time }
    ),
    option!(
        "supergraph", "supergraph",
        "Graph that is expected to contain all edges of the Delaunay triangulation",
        GraphKind,
        |s| s.recursion.graph.kind(),
        |s, kind| { s.recursion.graph = kind.graph(); Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, is_common: true, series: Series::Always("") }
    ),
    option!(
        "alpha", "alpha",
        "Parameter alpha of a density or overlap graph, at least 1",
        Alpha,
        |s| s.recursion.graph.alpha(),
        |s, alpha| { s.recursion.graph = s.recursion.graph.with_alpha(alpha)?; Ok(()) },
        { form: "A|auto", commands: Commands::COUNTS, heading: Heading::Graph, is_common: true, series: Series::Changed("alpha ") }
    ),
    option!(
        "k", "k",
        "Parameter k of a nearest-neighbour graph; `10ln` stands for ceil(10 ln n)",
        Neighbours,
        |s| s.recursion.graph.k(),
        |s, k| { s.recursion.graph = s.recursion.graph.with_k(k)?; Ok(()) },
        { form: "K|auto|Cln", commands: Commands::COUNTS, heading: Heading::Graph, is_common: true, series: Series::Changed("k ") }
    ),
    option!(
        "separator-sets", "separator_sets",
        "Sharing of separator points",
        SeparatorSets,
        |s| s.recursion.sets,
        |s, sets| { s.recursion.sets = sets; Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, series: Series::Always("sets ") }
    ),
    option!(
        "partition", "partition",
        "Separators of the partition",
        Partition,
        |s| s.tree.partition,
        |s, partition| { s.tree.partition = partition; Ok(()) },
        { commands: Commands::TREES, series: Series::Changed("partition ") }
    ),
    option!(
        "neighbours", "neighbours",
        "Correction of nearest-neighbour balls across separators",
        Correction,
        |s| s.recursion.neighbours,
        |s, correction| { s.recursion.neighbours = correction; Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, series: Series::Changed("neighbours ") }
    ),
    option!(
        "constants", "constants",
        "Constants of the partition: for little work and depth, or for little time\n\n--samples, --tries and --leaf \
         replace single constants.",
        Purpose,
        |s| s.tree.constants.purpose,
        |s, purpose| { s.tree.constants.purpose = purpose; Ok(()) },
        { commands: Commands::COUNTS, series: Series::Changed("constants for ") }
    ),
    option!(
        "samples", "samples",
        "Largest number of samples from which a separator is drawn; small subproblems have fewer",
        Auto,
        |s| Auto(s.tree.constants.samples),
        |s, Auto(samples)| { s.tree.constants.samples = samples; Ok(()) },
        { form: "M|auto", commands: Commands::COUNTS, series: Series::Changed("samples ") }
    ),
    option!(
        "tries", "tries",
        "Number of great circles of which the best becomes the separator",
        Auto,
        |s| Auto(s.tree.constants.tries.map(u64::from)),
        |s, Auto(tries)| {
            s.tree.constants.tries = tries.map(|tries| u32::try_from(tries).unwrap_or(u32::MAX));
            Ok(())
        },
        { form: "T|auto", commands: Commands::COUNTS, series: Series::Changed("tries ") }
    ),
    option!(
        "leaf", "leaf",
        "Largest number of points in a leaf of the partition tree",
        Auto,
        |s| Auto(s.tree.leaf),
        |s, Auto(leaf)| { s.tree.leaf = leaf; Ok(()) },
        { form: "M|auto", series: Series::Changed("leaf ") }
    ),
    option!(
        "transport", "transport",
        "Transport of the messages",
        TransportName,
        |s| s.machine.transport.kind(),
        |s, transport| { s.machine.transport = transport.transport(); Ok(()) },
        { limited: &[("processes", Commands::RUNS)] }
    ),
    option!(
        "delivery-seed", "delivery_seed",
        "Seed of the delivery order, with --transport sim [default: 0]",
        Seed,
        |s| Seed(s.machine.transport.delivery_seed()),
        |s, Seed(seed)| s.machine.transport.set_delivery_seed(seed),
        { form: "S", needs: Some(("transport", "sim")) }
    ),
    option!(
        "processes", "processes",
        "Number of processes, with --transport processes [default: one for each worker, at most the cores]",
        Between<1, 256>,
        |s| Between(s.machine.transport.processes()),
        |s, Between(processes)| s.machine.transport.set_processes(processes),
        { form: "N", commands: Commands::RUNS, needs: Some(("transport", "processes")) }
    ),
    option!(
        "max-memory", "max_memory",
        "Refuse to start if the run is expected to need more memory\n\nK, M, G and T stand for powers of 1024, as in 2G.",
        Bytes,
        |s| Bytes(s.machine.max_memory),
        |s, Bytes(limit)| { s.machine.max_memory = limit; Ok(()) },
        { form: "BYTES", matters: Matters::Time }
    ),
];

#[cfg(test)]
mod tests;
