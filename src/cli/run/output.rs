//! The files of a run.

use std::path::{Path, PathBuf};

use septet_core::model::MeshView;
use septet_core::result::periodic::PeriodicCells;
use septet_core::result::unfolded::Unfolded;
use septet_core::run::memory::check_peak;
use septet_core::spec::Periodic;
use septet_core::{Outcome, Spec};
use septet_io::read::Column;
use septet_io::write::{
    SharedMesh, WriteOptions, image_columns, numbers_on_first, to_first, write_offsets, write_shared,
};
use septet_lab::report::{CostHeader, write_cost_trace};

use super::goal::Goal;
use super::plan::Plan;
use super::rows::Rows;
use super::team::Team;
use crate::errors::{Code, Failure};
use crate::files::{self, Fresh};
use crate::formats::write_mesh;
use crate::progress::Talk;

/// Writes the triangulation with its break lines to all outputs. Returns the files written.
pub(super) fn write_mesh_files(
    (plan, spec): (&Plan<'_>, &Spec),
    run: &Outcome,
    rows: &Rows,
    team: &mut Team<'_>,
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    let held = &rows.held;
    if team.is_alone() {
        let (coordinates, source) = (held.points.coordinates(), held.source_index.as_deref());
        let cells = rows.breaks.as_ref().map(|breaks| breaks.cells(run, talk)).transpose()?;
        return write_all((plan, spec), (run, cells.as_deref()), (rows, coordinates, source), talk);
    }
    if spec.input.periodic.is_some() {
        return write_gathered((plan, spec), run, (rows, team), talk);
    }
    let mesh = SharedMesh {
        run,
        coordinates: held.points.coordinates(),
        heights: held.heights.as_deref(),
        first: plan.first_row() + held.first,
        source_index: held.source_index.as_deref(),
        dropped: held.skipped,
    };
    let stops = || talk.is_cancelled() || check_peak(spec).is_err();
    let (outputs, options) = (&plan.goal.args().output, options((plan, spec.keep.owner), rows));
    let written = write_shared(&mut team.processes, outputs, &mesh, &options, &stops).map_err(Failure::from);
    if written.as_ref().is_err_and(|failure| failure.code == Code::Interrupted) {
        // All processes have stopped. The limit of one of them may be the reason.
        team.agree(check_peak(spec).map_err(Failure::from))?;
    }
    written
}

/// Returns the options of the writers.
fn options<'a>((plan, with_owner): (&Plan<'_>, bool), rows: &'a Rows) -> WriteOptions<'a> {
    let (args, held) = (plan.goal.args(), &rows.held);
    WriteOptions { with_owner, first_id: held.first_id, point_data: &held.columns, ..args.writing.options() }
}

/// Writes a periodic triangulation, whose cells the first process has, on that process. Returns the files written.
fn write_gathered(
    order: (&Plan<'_>, &Spec),
    run: &Outcome,
    (rows, team): (&Rows, &mut Team<'_>),
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    let held = &rows.held;
    let coordinates = numbers_on_first(&mut team.processes, held.points.coordinates())?;
    let own = held.source_index.iter().flatten().copied();
    let source = if held.skipped > 0 { Some(to_first(&mut team.processes, own)?) } else { None };
    let all = (rows, &coordinates[..], source.as_deref());
    Ok(team.first_only(|| write_all(order, (run, None), all, talk))?.unwrap_or_default())
}

/// Writes a triangulation that this process has to all outputs, or to none of its files. `coordinates` are those of all points, and
/// `source` is the row of the input of each of them, if rows were dropped.
fn write_all(
    (plan, spec): (&Plan<'_>, &Spec),
    (run, other_cells): (&Outcome, Option<&[u64]>),
    (rows, coordinates, source): (&Rows, &[f64], Option<&[u64]>),
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    let held = &rows.held;
    // In a file that has only cells, or only some of the points, indices count all rows of the input.
    let options = WriteOptions { source, ..options((plan, spec.keep.owner), rows) };
    let mut files = Fresh::default();
    for output in &plan.goal.args().output {
        talk.check();
        let stage = format!("writing {}", output.display());
        let mut progress = |done: u64, total: u64| {
            talk.stage(&stage, done, Some(total));
            if done >= total {
                // The file is complete, but has no name yet.
                check_peak(spec).unwrap_or_else(|error| Failure::from(error).unwind());
            }
        };
        let view = run.view(coordinates);
        let view = MeshView { heights: held.heights.as_deref(), ..view };
        let view = match other_cells {
            Some(cells) => MeshView { cells, owner: None, owning_leaf: None, run: None, ..view },
            None => view,
        };
        let has_points = !options.format_of(output)?.row().has_input_rows;
        let written = match spec.input.periodic.as_ref().filter(|_| has_points) {
            Some(periodic) => write_unfolded((output, periodic), run, &view, &options, &mut progress)?,
            None => write_mesh(output, &view, &options, &mut progress)?,
        };
        files.extend(written);
    }
    Ok(files.keep())
}

/// Writes a periodic triangulation with the images of points that are vertices. Each point has the values of its row, the row
/// and the offset.
fn write_unfolded(
    (output, periodic): (&Path, &Periodic),
    run: &Outcome,
    view: &MeshView<'_>,
    options: &WriteOptions<'_>,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<PathBuf>, Failure> {
    let Some(part) = &run.kept.periodic else { return Ok(write_mesh(output, view, options, progress)?) };
    let unfolded = Unfolded::of((run.cells(), part), view.coordinates, periodic);
    let of_row = |own: &Column| {
        let values = unfolded.rows.iter().map(|&row| own.values[row as usize]);
        Column { name: own.name.clone(), values: values.collect() }
    };
    let mut columns: Vec<Column> = options.point_data.iter().map(of_row).collect();
    columns.extend(image_columns(&unfolded, view.dimension, options.source));
    let view = MeshView { coordinates: &unfolded.coordinates, cells: &unfolded.cells, run: None, ..*view };
    let options = WriteOptions { source: None, point_data: &columns, ..*options };
    Ok(write_mesh(output, &view, &options, progress)?)
}

/// Writes the lists of rows for which the run is asked, and adds their files to those written before. If one of them cannot be
/// written, none of the files is left. The first process writes for all.
pub(super) fn write_lists(
    plan: &Plan<'_>,
    run: &Outcome,
    (rows, team): (&Rows, &mut Team<'_>),
    files: &mut Vec<PathBuf>,
) -> Result<(), Failure> {
    for write in [write_duplicates, write_hidden, write_offsets_of] {
        let written = write(plan, run, rows, team).inspect_err(|_| files::remove(files))?;
        files.extend(written);
    }
    Ok(())
}

/// Writes the rows of duplicates, if the run is asked for them. Returns the file.
fn write_duplicates(
    plan: &Plan<'_>,
    run: &Outcome,
    rows: &Rows,
    team: &mut Team<'_>,
) -> Result<Option<PathBuf>, Failure> {
    let Some(path) = &plan.goal.args().duplicates else { return Ok(None) };
    let row = |point: u64| rows.held.source_index.as_ref().map_or(point, |rows| rows[point as usize]);
    let own: Vec<(u64, u64)> =
        run.left_out.duplicates.iter().map(|&(own, first)| (row(own), row(first))).collect();
    let mut all: Vec<(u64, u64)> =
        if team.is_alone() { own } else { team.all_gather(&own)?.into_iter().flatten().collect() };
    all.sort_unstable();
    let lines = all.iter().map(|(row, first)| format!("{row},{first}\n"));
    let text: String = std::iter::once("row,first\n".to_owned()).chain(lines).collect();
    team.first_only(|| Ok(files::write_text(path, &text)?))?;
    Ok((path.as_os_str() != "-").then(|| path.to_owned()))
}

/// Writes the rows of hidden points, if the run is asked for them. Returns the file.
fn write_hidden(
    plan: &Plan<'_>,
    run: &Outcome,
    rows: &Rows,
    team: &mut Team<'_>,
) -> Result<Option<PathBuf>, Failure> {
    let Some(path) = plan.goal.hidden() else { return Ok(None) };
    let mut hidden = gathered(&run.left_out.hidden, team)?;
    if rows.held.skipped > 0 {
        // A process knows the numbers of its own rows only.
        let first = plan.first_row() + rows.held.first;
        let source = rows.held.source_index.as_deref().unwrap_or_default();
        let of_input = |row: &u64| source.get(usize::try_from(row.checked_sub(first)?).ok()?).copied();
        let own: Vec<u64> = hidden.iter().filter_map(of_input).collect();
        hidden = gathered(&own, team)?;
    }
    hidden.sort_unstable();
    team.first_only(|| Ok(files::write_rows(path, &hidden)?))?;
    Ok((path.as_os_str() != "-").then(|| path.to_owned()))
}

/// Writes the offsets of vertices, if the run is asked for them. Returns the file.
fn write_offsets_of(
    plan: &Plan<'_>,
    run: &Outcome,
    _: &Rows,
    team: &mut Team<'_>,
) -> Result<Option<PathBuf>, Failure> {
    let Some(path) = plan.goal.offsets() else { return Ok(None) };
    let offsets = || run.kept.periodic.as_ref().map(PeriodicCells::offsets).unwrap_or_default();
    team.first_only(|| Ok(write_offsets(path, &offsets(), run.space)?))?;
    Ok(Some(path.to_owned()))
}

/// Returns the rows of all processes.
fn gathered(own: &Vec<u64>, team: &mut Team<'_>) -> Result<Vec<u64>, Failure> {
    if team.is_alone() { Ok(own.clone()) } else { Ok(team.processes.all_gather(own)?.concat()) }
}

/// Writes the cost trace, if the run keeps it. Returns its file.
pub(super) fn write_costs(goal: Goal<'_>, spec: &Spec, run: &Outcome) -> Result<Option<PathBuf>, Failure> {
    let (Some(path), Some(trace)) = (goal.cost_trace(), &run.kept.costs) else { return Ok(None) };
    let header = CostHeader::of(spec, &run.settled, run.points.used, run.space);
    let mut text = Vec::new();
    let written = write_cost_trace(&mut text, header, trace).map_err(|e| e.to_string());
    let text = written.and_then(|()| String::from_utf8(text).map_err(|e| e.to_string()));
    let text =
        text.map_err(|e| Failure::new(Code::Failed, format!("the cost trace cannot be written: {e}")))?;
    files::write_text(path, &text)?;
    Ok((path.as_os_str() != "-").then(|| path.to_owned()))
}
