//! The settled arguments of a run, and their checks before the points are read.

use std::path::{Path, PathBuf};

use septet_core::Spec;
use septet_core::run::admit_team;
use septet_core::run::memory::admit_rows;
use septet_core::run::processes::placement;
use septet_io::Role;
use septet_io::read::{InputError, ReadOptions};
use septet_io::write::{check_dimension, check_offsets_output, check_rows_output, check_shared};
use septet_protocol::transport::Placement;

use super::goal::Goal;
use super::team::Team;
use super::trace;
use crate::effects::needs;
use crate::errors::{Code, Failure};
use crate::files;
use crate::formats::{check_reading, read_options};
use crate::given::Options;
use crate::input::Input;
use crate::instruments::{Tables, check_trace};
use crate::names::with_data;
use crate::options::RunArgs;
use crate::progress::Talk;
use crate::weights::GivenWeights;

/// The tables of a run, as they appear in file names.
const TABLES: [&str; 3] = ["phases", "rounds", "levels"];

/// The settled arguments of a run.
pub(super) struct Plan<'a> {
    /// The subcommand with its options.
    pub goal: Goal<'a>,
    /// The input.
    pub input: Input<'a>,
    /// The tables.
    pub tables: Tables,
    /// The options of the reader.
    pub reading: ReadOptions,
    /// The process of each worker. `None` if one process runs the command alone.
    pub placement: Option<Placement>,
}

impl<'a> Plan<'a> {
    /// Settles the arguments, and refuses those that the processes cannot obey. The first process checks the names of all
    /// files that the processes write.
    ///
    /// # Errors
    /// Fails if the arguments do not fit together, or if a file cannot be written.
    pub(super) fn of(goal: Goal<'a>, spec: &Spec, (team, talk): (&Team<'_>, &Talk)) -> Result<Self, Failure> {
        let args = goal.args();
        if !team.is_alone() {
            refuse(goal, spec)?;
        }
        let input = Input::of(&args.input, spec.input.dimension, talk)?;
        check_trace(&args.tracing)?;
        let tables = Tables::of(args.profile.as_deref(), &TABLES)?;
        check_reading(goal.given(), input.is_sample())?;
        if let Some(weights) = goal.weights() {
            weights.check(goal.given(), input.is_sample())?;
        }
        let processes = team.processes.processes();
        let placement = if team.is_alone() { None } else { Some(placement(spec, processes)?) };
        if team.is_first() {
            let traces = trace::paths(&args.tracing, team);
            let texts = args
                .json
                .iter()
                .chain(&args.duplicates)
                .chain(&traces)
                .map(PathBuf::as_path)
                .chain(tables.paths());
            let lists = [goal.hidden(), goal.offsets()].into_iter().flatten();
            let texts: Vec<&Path> = texts.chain(goal.cost_trace()).chain(lists).collect();
            goal.hidden().map_or(Ok(()), check_rows_output)?;
            goal.offsets().map_or(Ok(()), check_offsets_output)?;
            let weights = goal.weights().and_then(GivenWeights::file);
            let inputs = input.files().into_iter().chain(weights).chain(goal.breaklines());
            let inputs: Vec<&Path> = inputs.collect();
            files::check_as(&inputs, &args.output, &args.writing.options(), &texts)?;
        }
        check_effects(args, goal.given())?;
        if spec.input.periodic.is_some() {
            check_images(args)?;
        }
        if let (Input::Sample(request), None) = (&input, placement) {
            // A sample that is too large is refused before it is generated.
            admit_rows(spec, request.n, request.dimension)?;
        }
        if let Some(path) = goal.weights().and_then(GivenWeights::file).filter(|path| !path.exists()) {
            // The points are read first, which may take long.
            return Err(InputError::Missing { path: path.to_owned() }.into());
        }
        let weights = goal.weights().map(GivenWeights::reading);
        let reading = ReadOptions { weights, ..read_options(&spec.input)? };
        Ok(Plan { goal, input, tables, reading, placement })
    }

    /// Checks that the processes of a team can write the outputs together.
    ///
    /// # Errors
    /// See [`check_shared`].
    pub(super) fn check_outputs(&self, team: &mut Team<'_>) -> Result<(), Failure> {
        let args = self.goal.args();
        if self.placement.is_some() {
            check_shared(&mut team.processes, &args.output, &args.writing.options())?;
        }
        Ok(())
    }

    /// Checks that triangulations of this dimension can be written to all outputs.
    ///
    /// # Errors
    /// See [`check_dimension`].
    pub(super) fn check_dimension(&self, dimension: usize, team: &mut Team<'_>) -> Result<(), Failure> {
        let args = self.goal.args();
        if dimension > 3 && self.goal.has_stats() {
            let message =
                format!("--stats: the numbers exist in dimensions 2 and 3, not in dimension {dimension}");
            return team.agree(Err(Failure::new(Code::Usage, message).help("omit --stats")));
        }
        if dimension > 3 && self.goal.given().has("view") {
            let message = format!("--view: pictures show dimensions 2 and 3, not dimension {dimension}");
            return team.agree(Err(Failure::new(Code::Usage, message).help("omit --view")));
        }
        let options = args.writing.options();
        let mut outputs = args.output.iter();
        team.agree(outputs.try_for_each(|output| Ok(check_dimension(output, &options, dimension)?)))
    }

    /// Returns the number of the first row of all processes.
    pub(super) fn first_row(&self) -> u64 {
        self.goal.args().hidden.first_row.unwrap_or(0)
    }
}

/// Refuses what needs all cells or all ranks in one process.
fn refuse(goal: Goal<'_>, spec: &Spec) -> Result<(), Failure> {
    let args = goal.args();
    if goal.breaklines().is_some() {
        let message = "several processes cannot insert --breaklines";
        return Err(Failure::new(Code::Usage, message).help("run one process"));
    }
    if args.input == "@-" || args.input.trim_start_matches('@').starts_with("/dev/") {
        let message = format!("{}: several processes cannot read it", args.input);
        return Err(
            Failure::new(Code::Usage, message).help("give the name of a file, or - for standard input")
        );
    }
    if args.duplicates.is_some() && spec.input.skip_invalid {
        let message = "several processes cannot write --duplicates with --skip-invalid";
        return Err(Failure::new(Code::Usage, message).help("run one process, or omit one of the options"));
    }
    Ok(admit_team(spec)?)
}

/// Refuses outputs without a place for images of points.
fn check_images(args: &RunArgs) -> Result<(), Failure> {
    let options = args.writing.options();
    for output in &args.output {
        if !options.format_of(output)?.row().has_images {
            let message = format!("{}: the format has no place for images of points", output.display());
            let known = Role::Triangulation.extensions(|row| row.has_images);
            return Err(Failure::new(Code::Usage, message).help(format!("write one of {known}")));
        }
    }
    Ok(())
}

/// Returns a failure if an option is set that no output or report uses.
fn check_effects(args: &RunArgs, given: &Options<Spec>) -> Result<(), Failure> {
    args.writing.check(&args.output)?;
    let has_data = args.writing.any(&args.output, |format| format.row().has_data);
    let outputs = with_data().split(' ').map(|extension| format!("-o OUT{extension}")).collect::<Vec<_>>();
    let outputs = outputs.join(" or ");
    needs("--keep-columns", given.has("keep-columns"), &outputs, has_data)?;
    needs("--with-owner", given.has("with-owner"), &outputs, has_data)?;
    needs("--view", given.has("view"), "--json", args.json.is_some())
}
