//! The errors of the libraries: no message names an option of the command line, and all doors know the options of remedies.

use std::collections::BTreeSet;
use std::io::{Error as IoError, ErrorKind};

use clap::CommandFactory;
use septet_core::generate::{GenerateError, Kind};
use septet_core::mesh::MeshError;
use septet_core::spec::{Neighbours, SpecError, Until};
use septet_core::{Door, Error, Remedy};
use septet_geometry::range::RangeError;
use septet_io::Role;
use septet_io::read::{EntryFault, InputError, ListError, Place, WeightError, WeightFault};
use septet_io::write::OutputError;
use septet_lab::accounts::{AccountError, ReportError};
use septet_lab::claims::ClaimError;
use septet_lab::experiment::fit::FitError;
use septet_lab::experiment::{JournalError, SweepError};
use septet_meshing::domain::Feature;
use septet_meshing::generate::Reason;
use septet_meshing::octree::{CellKey, TooFine};
use septet_meshing::size::SizeError;
use septet_protocol::transport::TransportError;

/// The messages and remedies of errors.
macro_rules! described {
    ($of:ident: $($error:expr),+ $(,)?) => {
        vec![$({
            #[allow(unused_imports, reason = "an error may be a variable")]
            use $of::*;
            let error = $error;
            (error.to_string(), error.remedy())
        }),+]
    };
}

type Described = Vec<(String, Option<Remedy>)>;

fn broken() -> IoError {
    ErrorKind::StorageFull.into()
}

fn of_specs() -> Described {
    let graph = "density";
    described![SpecError:
        NoWorkers,
        TooManyWorkers { workers: 9, most: 8 },
        NoThreads,
        Alpha { alpha: 0.5 },
        K { k: 9, points: 8 },
        LogFactor { factor: -1.0 },
        Unused { graph, parameter: "k" },
        AutomaticAlpha { k: Neighbours::Count(4) },
        OverlapLog { factor: 10.0 },
        FirstBalls { correction: "naive", k: 4 },
        Value { option: "leaf", value: "x".into(), expected: "expected a number".into() },
        Needs { option: "delivery-seed", needed: "transport", word: "sim" },
        SmallerSide { graph },
        Uncorrected { correction: "naive" },
        Samples { samples: 3, least: 5 },
        Tries { tries: 0, most: 9 },
        TriesOfBaseline { partition: "kd" },
        TooFewWorkers { workers: 1, processes: 2 },
        NotDistributed { output: "a picture", option: "view" },
        EmptyLeaf,
        Weighted,
    ]
}

fn of_runs() -> Described {
    let mut all = described![Error:
        Points(RangeError::NotFinite { index: 0, value: f64::NAN }),
        Points(RangeError::Spread { bits: 411, low: 0, high: 1 }),
        Indices { rows: 9, first: 0, last: 7 },
        Memory { forecast: 9, limit: 8, points: 7 },
        Exceeded { used: 9, limit: 8 },
        Piece { points: 9, most: 8, workers: 2 },
        Machine(TransportError::Stopped),
        Start(broken()),
        Interrupted,
    ];
    all.extend(described![MeshError:
        Unsupported("no surface"),
        Size(SizeError::Place),
        Size(SizeError::TooFine(TooFine::Cells { limit: 9 })),
        Size(SizeError::TooFine(TooFine::Levels { at: CellKey::ROOT })),
        Dimension { what: "size field", expected: 3, found: 2 },
        Missing { features: Vec::new(), reason: Reason::Angles },
        Missing { features: Vec::new(), reason: Reason::Rounding },
        Missing { features: Vec::new(), reason: Reason::Rounds },
        Coarse { feature: Feature::Corner(0), size: 1.0, step: 1.0 },
        TooMany { most: 9 },
        Memory { forecast: 9, limit: 8, points: 7 },
        Run(Error::Interrupted),
    ]);
    all.extend(described![GenerateError:
        UnknownKind { name: "cub".into() },
        Dimension(4),
        Lipschitz(2.0),
        LipschitzUnused(Kind::Uniform),
        Ratio(0.5),
        RatioUnused(Kind::Uniform),
        TooManyShells { n: 9, ratio: 2.0, limit: 8 },
        TooMany { kind: Kind::Uniform, n: 9, limit: 8 },
        Spec { spec: "x".into(), reason: "no number".into() },
        Machine(Error::Interrupted),
        Incomplete { reason: "no end".into() },
    ]);
    all
}

fn of_inputs() -> Described {
    let path = || "a.csv".into();
    let place = Place::Line(3);
    let syntax = |columns| InputError::Syntax {
        path: path(),
        line: 3,
        column: None,
        text: "x".into(),
        expected: "a number".into(),
        row: None,
        columns,
    };
    let mut all = described![InputError:
        Missing { path: path() },
        Directory { path: path() },
        Unreadable { path: path(), source: broken() },
        Gzip { path: path(), source: broken() },
        UnknownFormat { path: path(), advice: None, role: Role::Points },
        UnknownFormat { path: path(), advice: Some("write .vtu".into()), role: Role::Domain },
        Unsupported { path: path(), place, what: "a grid".into(), advice: "save a mesh".into() },
        syntax(None),
        syntax(Some("1,2,4".into())),
        Malformed { path: path(), offset: 7, found: "x".into(), expected: "y" },
        Columns { path: path(), place, problem: "no x".into(), names: Vec::new(), example: "{raw},b".into() },
        NoHeights { path: path(), place },
        TerrainInSpace { path: path() },
        NoRows { path: path(), place },
        NotRaw { path: path(), format: "csv" },
        PartOfRow { path: path(), size: 9, row: 8 },
        NotATable { path: path(), format: "npy" },
        NotFinite { path: path(), place, index: 1, value: f64::NAN },
        Truncated { path: path(), place, expected: 9, found: 8, what: "points" },
        Count { path: path(), place, expected: 9, what: "points" },
        MixedDimension { path: path(), place, expected: 3, found: 2, row: None },
        UnsupportedDimension { path: path(), place, found: 4 },
        OutOfRangeIndex { path: path(), place, cell: 1, value: -1, first: 0, limit: Some(9) },
        OutOfMemory { path: path(), bytes: 9 },
    ];
    all.extend(of_weights().into_iter().map(|error| (error.to_string(), Some(error.remedy()))));
    all
}

fn of_weights() -> Vec<WeightError> {
    use WeightError::*;
    let (path, place) = (|| "w.csv".into(), Place::Line(3));
    let value = |value, fault| Value { path: path(), place, index: 2, value, are_radii: true, fault };
    vec![
        value(f64::NAN, WeightFault::NotFinite),
        value(-1.0, WeightFault::Negative),
        value(1e200, WeightFault::Overflow),
        Count { path: path(), found: 1, expected: 2, are_radii: false },
        Column { path: path(), place, problem: "there is no column w".into(), names: vec!["x".into()] },
        NoColumns { path: path(), format: "ply" },
        Terrain { path: path() },
    ]
}

fn of_lists() -> Described {
    let (path, first) = (|| "b.csv".into(), || "a.csv".into());
    let names = || vec!["mass".to_owned()];
    let mut all =
        described![EntryFault: Missing { path: path() }, Folder, Itself, List, StandardInput, NotUtf8];
    all.extend(described![ListError:
        Pattern { pattern: path(), problem: "no end" },
        Folder { pattern: path(), folder: path(), source: broken() },
        NoMatch { pattern: path() },
        List { error: Box::new(InputError::Missing { path: path() }) },
        Entry { list: path(), line: 1, name: "a".into(), fault: EntryFault::Folder },
        NoEntry { list: path() },
        File { error: Box::new(InputError::Missing { path: path() }), before: 3 },
        MixedDimension { path: path(), found: 2, first: first(), expected: 3 },
        MixedColumns { path: path(), found: names(), first: first(), expected: names() },
    ]);
    all
}

fn of_outputs() -> Described {
    let path = || "a.vtu".into();
    described![OutputError:
        UnknownFormat { path: path(), advice: "write .vtu".into(), role: Role::Mesh },
        NotOneFile,
        Compressed { path: path() },
        NotText { path: path() },
        NoPieces { path: path() },
        Obstructed { path: path(), obstacle: "a file is there".into() },
        NotPlane { path: path(), format: "polymesh" },
        OnlyLinear { path: path(), format: "su2" },
        TooLarge { path: path(), entries: 9 },
        MissingDirectory { path: path(), directory: path() },
        IsDirectory { path: path() },
        NotWritable { path: path(), source: broken() },
        Io { path: path(), source: broken() },
        Stream { source: broken() },
        InvalidMesh { reason: "no point 7".into() },
        FirstId { first_id: 2 },
    ]
}

fn of_accounts() -> Described {
    let syntax = || serde_json::from_str::<u8>("x").unwrap_err();
    let mut all = described![AccountError:
        Unreadable { line: 1, source: broken() },
        Empty,
        Syntax { line: 1, source: syntax() },
        Schema { found: "x".into() },
        Missing { expected: 1, found: 2 },
        Incomplete { expected: 2, found: 1 },
        Order { row: 1, after: 2 },
        Loose { row: 1 },
        Unused { row: 1 },
        Primitive { row: 1, primitive: "scam".into() },
        Phase { row: 1, phase: "lunch".into() },
        Node { row: 1 },
        Overflow { row: 1 },
        Longest { row: 1 },
        Nesting { row: 1 },
    ];
    all.extend(described![ReportError:
        Syntax(syntax()),
        Schema { found: "x".into() },
        NoCounts,
        Seed { reported: 1, traced: 2 },
        Points { reported: 1, traced: 2 },
    ]);
    all
}

fn of_experiments() -> Described {
    let (series, path) = (|| "uniform".to_owned(), || "runs.jsonl".into());
    let key = "depth";
    let mut all = described![FitError:
        NoRuns,
        UnknownKey { name: "x".into(), known: "depth, work".into() },
        UnknownAbscissa { name: "x".into() },
        Mixes { key, phases: "hulls".into() },
        UnknownPhase { phase: "x".into(), phases: "hulls".into() },
        NoPhase { key },
        OnePhase,
        Margin { margin: 2.0 },
        TooFewSizes { series: series(), sizes: 1, least: 2 },
        TooFewLevels { series: series(), levels: 1, runs: 1 },
        TooFewSeeds { series: series(), size: 9.0, seeds: 1, least: 3 },
        Nothing { key },
        NotTimed,
        NoSerial { set: "uniform".into() },
    ];
    all.extend(described![SweepError:
        Empty { what: "sizes" },
        WeakLeaves,
        AutoWorkers,
        TooMany { n: 9, workers: 9 },
        TimedUntil,
        TimedCorrection,
        Unreached { option: "supergraph", until: Until::Partition },
        AlphaOfLeaf,
        LipschitzUnused,
        Spec(SpecError::NoWorkers),
    ]);
    all.extend(described![JournalError:
        Io { path: path(), source: broken() },
        Line { path: path(), line: 1, what: "a sweep", reason: "no size".into() },
        OtherSweep { path: path(), what: "a sweep", there: "a".into(), asked: "b".into() },
        NoSweep { path: path(), what: "a sweep" },
        OtherVersion { path: path(), there: "0.0.1".into() },
    ]);
    all.extend(
        described![ClaimError: Mesh { reason: "x".into() }, Trace(broken()), Unknown { name: "x".into() }],
    );
    all
}

/// The long options of all commands.
fn options() -> BTreeSet<String> {
    let program = super::Cli::command();
    let arguments = program.get_subcommands().flat_map(clap::Command::get_arguments);
    arguments.filter_map(|argument| argument.get_long()).map(str::to_owned).collect()
}

/// The words of a text that begin with two hyphens and a letter.
fn options_in(text: &str) -> Vec<String> {
    let starts = text.match_indices("--").map(|(at, _)| &text[at + 2..]);
    let names =
        starts.map(|rest| rest.split(|c: char| !c.is_ascii_lowercase() && c != '-').next().unwrap_or(""));
    names.filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase())).map(str::to_owned).collect()
}

#[test]
fn every_door_spells_the_remedies() {
    let known = options();
    let all = [of_specs(), of_runs(), of_inputs(), of_lists(), of_outputs(), of_accounts(), of_experiments()];
    let mut named = 0;
    for (message, remedy) in all.into_iter().flatten() {
        assert!(options_in(&message).is_empty(), "{message}");
        assert!(!message.contains("; ") && !message.ends_with('.'), "a message is one clause: {message}");
        let Some(remedy) = remedy else { continue };
        let [shell, rust] = [Door::Shell, Door::Rust].map(|door| remedy.spelled(door));
        assert!(options_in(&rust).is_empty() && rust == remedy.to_string(), "{rust}");
        for name in options_in(&shell) {
            assert!(known.contains(&name), "no command has --{name}: {shell}");
            assert!(rust.contains(&name.replace('-', "_")), "{rust}");
            named += 1;
        }
        assert!(!message.contains(&shell), "the message has the remedy: {message}");
    }
    assert!(named > 40, "{named} options are named");
}

#[test]
fn data_of_errors_are_not_options() {
    let columns = of_inputs().into_iter().find(|(message, _)| message.contains("no x")).unwrap().1.unwrap();
    assert!(columns.spelled(Door::Shell).ends_with("--columns {raw},b"), "{columns}");
}
