//! The options of a run: one row for each. Command lines, help, reports, sweeps and the guide read these rows.

use septet_workers::config::Neighbours;

use super::periodic::Periodic;
use super::row::{Commands, Heading, Matters, Row, Series, option};
use super::value::{Auto, Between, Bytes, Reals, Seed, Whole};
use super::{
    Alpha, Correction, GraphKind, MOST_POINTS, Nodes, Partition, Purpose, Registers, Repair, SeparatorSets,
    Spec, TransportName, Until, Workers,
};

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

/// The options of a run, in the order in which they are set and listed.
pub static OPTIONS: &[Row] = &[
    option!(
        Spec, "skip-invalid", "skip_invalid",
        "Drop points with coordinates that are not finite numbers, instead of refusing the file",
        bool,
        |s| s.input.skip_invalid,
        |s, is_set| { s.input.skip_invalid = is_set; Ok(()) },
        { is_flag: true, commands: Commands::POINTS, heading: Heading::Input, is_common: true, matters: Matters::Cells }
    ),
    option!(
        Spec, "dimension", "dimension",
        "Dimension of the input, from 2 to 6; 2 keeps the first two coordinates",
        Between<2, 6>,
        |s| Between(s.input.dimension.map(|dimension| dimension as u32)),
        |s, Between(dimension)| { s.input.dimension = dimension.map(|d| d as usize); Ok(()) },
        { short: Some('d'), form: "2..6", commands: Commands::POINTS.and(Commands::QUERIES), heading: Heading::Input, is_common: true, matters: Matters::Cells }
    ),
    option!(
        Spec, "columns", "columns",
        "Columns of the coordinates in a text table\n\nNames from the header row, or 1-based numbers. By default, \
         columns named x, y and z are used. A table without a header row may have two or three columns; one with more \
         columns needs this option or the dimension.",
        Option<Vec<String>>,
        |s| s.input.columns.clone(),
        |s, columns| { s.input.columns = columns; Ok(()) },
        { form: "X,Y[,Z]", commands: Commands::FILES, heading: Heading::Input, is_common: true, matters: Matters::Cells }
    ),
    option!(
        Spec, "input-format", "input_format",
        "Format of the points, for standard input and unknown extensions\n\n{points}.",
        Option<String>,
        |s| s.input.format.clone(),
        |s, format| { s.input.format = format; Ok(()) },
        { form: "NAME", commands: Commands::FILES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        Spec, "raw", "raw",
        "Read coordinates in binary without a header, such as f64,3\n\nThe type of the coordinates (f32 or f64, or f32be \
         or f64be for big-endian numbers) and the number of coordinates of a point (2 or 3). The names of the files may \
         be any but those of other formats.",
        Option<String>,
        |s| s.input.raw.clone(),
        |s, raw| { s.input.raw = raw; Ok(()) },
        { form: "TYPE,D", commands: Commands::FILES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        Spec, "keep-columns", "keep_columns",
        "Keep the other numeric columns of a text table as point data ({data})",
        bool,
        |s| s.input.keep_columns,
        |s, is_set| { s.input.keep_columns = is_set; Ok(()) },
        { is_flag: true, commands: Commands::RUNS, heading: Heading::Input, matters: Matters::Report }
    ),
    option!(
        Spec, "terrain", "terrain",
        "Triangulate by x and y, and keep z as a height in the outputs\n\nThe file has three coordinates, or is a grid of \
         heights (ESRI ASCII raster), whose cells without data are left out. Of points with equal x and y, the first one \
         keeps its z, and a note gives the largest difference.",
        bool,
        |s| s.input.terrain,
        |s, is_set| { s.input.terrain = is_set; Ok(()) },
        { is_flag: true, commands: Commands::TRIANGULATE.and(Commands::VERIFY), heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        Spec, "periodic", "periodic",
        "Lengths of a periodic box, such as 1,1,1\n\nThe points lie in the box from {origin} on, and are repeated \
         along its axes. The result has each class of repeated cells once. `none` is the length of an axis that is not \
         periodic.",
        Reals,
        |s| Reals(s.input.periodic.as_ref().map(|periodic| periodic.lengths.clone())),
        |s, Reals(lengths)| { s.input.periodic = lengths.map(Periodic::of); Ok(()) },
        { form: "LX,LY[,LZ]", commands: Commands::BOXES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        Spec, "origin", "origin",
        "Lower corner of the periodic box [default: 0]",
        Reals,
        |s| Reals(s.input.periodic.as_ref().and_then(Periodic::corner)),
        |s, Reals(corner)| s.input.set_origin(corner),
        { form: "OX,OY[,OZ]", commands: Commands::BOXES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        Spec, "wrap", "wrap",
        "Admit points outside of the periodic box, as images of points in it",
        bool,
        |s| s.input.periodic.as_ref().is_some_and(|periodic| periodic.wrap),
        |s, is_set| s.input.set_wrap(is_set),
        { is_flag: true, commands: Commands::BOXES, heading: Heading::Input, matters: Matters::Cells }
    ),
    option!(
        Spec, "with-owner", "with_owner",
        "Write the owning worker and the owning leaf of every cell ({data})",
        bool,
        |s| s.keep.owner,
        |s, is_set| { s.keep.owner = is_set; Ok(()) },
        { is_flag: true, commands: Commands::RUNS, heading: Heading::Output, matters: Matters::Report }
    ),
    option!(
        Spec, "view", "view",
        "Number of points in the picture of the JSON report\n\nAt most 20000, 0 for none. [default: 20000 for simulate \
         in one process, otherwise 0]",
        Between<0, MOST_POINTS>,
        |s| Between(s.keep.view),
        |s, Between(points)| { s.keep.view = points; Ok(()) },
        { form: "N", commands: Commands::RUNS, heading: Heading::Reports, matters: Matters::Report }
    ),
    option!(
        Spec, "nodes", "nodes",
        "Nodes of the partition tree that the JSON report lists\n\nLevels, phases and totals always cover all nodes.",
        Nodes,
        |s| s.keep.nodes,
        |s, nodes| { s.keep.nodes = nodes; Ok(()) },
        { commands: Commands::SIMULATE, heading: Heading::Reports, matters: Matters::Report }
    ),
    option!(
        Spec, "workers", "workers",
        "Number of workers, or `leaves` for one per leaf of the partition tree\n\n`auto` is the number of cores. \
         `triangulate` takes fewer for few points, and for points on curved surfaces, where more workers are not \
         faster. With several processes, `auto` is one worker for each process.",
        Workers,
        |s| s.machine.workers,
        |s, workers| { s.machine.workers = workers; Ok(()) },
        { form: "P|auto|leaves", commands: Commands::RUNS.and(Commands::MESH), is_common: true }
    ),
    option!(
        Spec, "seed", "seed",
        "Seed of the random draws",
        Seed,
        |s| Seed(Some(s.machine.seed)),
        |s, Seed(seed)| { s.machine.seed = seed.unwrap_or(s.machine.seed); Ok(()) },
        { form: "S", commands: Commands::RUNS.and(Commands::PREDICT).and(Commands::MESH) }
    ),
    option!(
        Spec, "threads", "threads",
        "Number of threads that read, run the workers and write [default: cores]",
        Whole,
        |s| Whole(s.machine.threads.map(|threads| threads as u64)),
        |s, Whole(threads)| { s.machine.threads = threads.map(|threads| threads as usize); Ok(()) },
        { form: "T", commands: Commands::MACHINES.and(Commands::QUERIES), is_common: true, matters: Matters::Time }
    ),
    option!(
        Spec, "registers", "registers",
        "SIMD width of the inner loops; it does not change results",
        Registers,
        |s| s.machine.registers,
        |s, registers| { s.machine.registers = registers; Ok(()) },
        { commands: Commands::TREES, matters: Matters::Time }
    ),
    option!(
        Spec, "supergraph", "supergraph",
        "Graph that is expected to contain all edges of the Delaunay triangulation",
        GraphKind,
        |s| s.recursion.graph.kind(),
        |s, kind| { s.recursion.graph = kind.graph(); Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, is_common: true, series: Series::Always(""), first_use: Until::Graph }
    ),
    option!(
        Spec, "alpha", "alpha",
        "Parameter alpha of a density or overlap graph, at least 1",
        Alpha,
        |s| s.recursion.graph.alpha(),
        |s, alpha| { s.recursion.graph = s.recursion.graph.with_alpha(alpha)?; Ok(()) },
        { form: "A|auto", commands: Commands::COUNTS, heading: Heading::Graph, is_common: true, series: Series::Changed("alpha ") }
    ),
    option!(
        Spec, "k", "k",
        "Parameter k of a nearest-neighbour or overlap graph; `10ln` stands for ceil(10 ln n)\n\nThe balls of an overlap \
         graph extend to the k-th neighbour, by default to the first. Its k is a number, and needs a number as alpha.",
        Neighbours,
        |s| s.recursion.graph.k(),
        |s, k| { s.recursion.graph = s.recursion.graph.with_k(k)?; Ok(()) },
        { form: "K|auto|Cln", commands: Commands::COUNTS, heading: Heading::Graph, is_common: true, series: Series::Changed("k ") }
    ),
    option!(
        Spec, "separator-sets", "separator_sets",
        "Sharing of separator points",
        SeparatorSets,
        |s| s.recursion.sets,
        |s, sets| { s.recursion.sets = sets; Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, series: Series::Always("sets "), first_use: Until::Graph }
    ),
    option!(
        Spec, "partition", "partition",
        "Separators of the partition",
        Partition,
        |s| s.tree.partition,
        |s, partition| { s.tree.partition = partition; Ok(()) },
        { commands: Commands::TREES, series: Series::Changed("partition ") }
    ),
    option!(
        Spec, "neighbours", "neighbours",
        "Correction of nearest-neighbour balls across separators",
        Correction,
        |s| s.recursion.neighbours,
        |s, correction| { s.recursion.neighbours = correction; Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, series: Series::Changed("neighbours "), first_use: Until::Neighbours }
    ),
    option!(
        Spec, "repair", "repair",
        "Repair of stars that disagree",
        Repair,
        |s| s.recursion.repair,
        |s, repair| { s.recursion.repair = repair; Ok(()) },
        { commands: Commands::COUNTS, heading: Heading::Graph, series: Series::Changed("repair "), first_use: Until::Graph }
    ),
    option!(
        Spec, "constants", "constants",
        "Constants of the partition: for little work and depth, or for little time\n\n{samples}, {tries} and {leaf} \
         replace single constants.",
        Purpose,
        |s| s.tree.constants.purpose,
        |s, purpose| { s.tree.constants.purpose = purpose; Ok(()) },
        { commands: Commands::COUNTS, series: Series::Changed("constants for ") }
    ),
    option!(
        Spec, "samples", "samples",
        "Largest number of samples from which a separator is drawn; small subproblems have fewer",
        Auto,
        |s| Auto(s.tree.constants.samples),
        |s, Auto(samples)| { s.tree.constants.samples = samples; Ok(()) },
        { form: "M|auto", commands: Commands::COUNTS, series: Series::Changed("samples ") }
    ),
    option!(
        Spec, "tries", "tries",
        "Number of great circles of which the best becomes the separator",
        Auto,
        |s| Auto(s.tree.constants.tries.map(u64::from)),
        |s, Auto(tries)| {
            let number = tries.map(u32::try_from).transpose();
            let refused = |_| super::SpecError::Value {
                option: "tries",
                value: tries.unwrap_or_default().to_string(),
                expected: "expected a smaller number".to_owned(),
            };
            s.tree.constants.tries = number.map_err(refused)?;
            Ok(())
        },
        { form: "T|auto", commands: Commands::COUNTS, series: Series::Changed("tries ") }
    ),
    option!(
        Spec, "leaf", "leaf",
        "Largest number of points in a leaf of the partition tree\n\n`auto` depends on the dimension and the supergraph. For \
         meshes it is 4000 in space and 2000 in the plane.",
        Auto,
        |s| Auto(s.tree.leaf),
        |s, Auto(leaf)| { s.tree.leaf = leaf; Ok(()) },
        { form: "M|auto", series: Series::Changed("leaf ") }
    ),
    option!(
        Spec, "transport", "transport",
        "Transport of the messages",
        TransportName,
        |s| s.machine.transport.kind(),
        |s, transport| { s.machine.transport = transport.transport(); Ok(()) },
        { limited: &[("processes", Commands::RUNS)] }
    ),
    option!(
        Spec, "delivery-seed", "delivery_seed",
        "Seed of the delivery order, with {transport=sim} [default: 0]",
        Seed,
        |s| Seed(s.machine.transport.delivery_seed()),
        |s, Seed(seed)| s.machine.transport.set_delivery_seed(seed),
        { form: "S", needs: Some(("transport", "sim")) }
    ),
    option!(
        Spec, "processes", "processes",
        "Number of processes, with {transport=processes} [default: one for each worker, at most the cores]",
        Between<1, 256>,
        |s| Between(s.machine.transport.processes()),
        |s, Between(processes)| s.machine.transport.set_processes(processes),
        { form: "N", commands: Commands::RUNS, needs: Some(("transport", "processes")) }
    ),
    option!(
        Spec, "max-memory", "max_memory",
        "Stop with exit code 5 if the run needs more memory\n\nA forecast refuses most of these runs before they start. Cells \
         are counted while they grow, and the run stops at the limit without output. Of several processes, each has this \
         limit. `septet mesh` only forecasts. K, M, G and T stand for powers of 1024, as in 2G. \
         Without a limit, `septet mesh` stops when it finds that the computer has too little memory.",
        Bytes,
        |s| Bytes(s.machine.max_memory),
        |s, Bytes(limit)| { s.machine.max_memory = limit; Ok(()) },
        { form: "BYTES", matters: Matters::Time }
    ),
];

#[cfg(test)]
mod tests;
