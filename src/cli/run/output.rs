//! The files of a run.

use std::path::PathBuf;

use septet_core::{Outcome, Spec};
use septet_io::write::{SharedMesh, WriteOptions, write_shared};
use septet_lab::report::{CostHeader, write_cost_trace};

use super::goal::Goal;
use super::plan::Plan;
use super::rows::Rows;
use super::team::Team;
use crate::errors::{Code, Failure};
use crate::files;
use crate::formats::write_mesh;
use crate::progress::Talk;
use crate::rows::InputRows;

/// Writes the triangulation to all outputs. Returns the files written.
pub(super) fn write_mesh_files(
    (plan, with_owner): (&Plan<'_>, bool),
    run: &Outcome,
    rows: &Rows,
    team: &mut Team<'_>,
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    if team.is_alone() {
        return write_all((plan, with_owner), run, rows, talk);
    }
    let args = plan.goal.args();
    let mesh = SharedMesh { run, rows: &rows.held.points, first: plan.first_row() + rows.held.first };
    let is_cancelled = || talk.is_cancelled();
    Ok(write_shared(&mut team.processes, &args.output, &mesh, &args.writing.options(), &is_cancelled)?)
}

/// Writes the triangulation of one process.
fn write_all(
    (plan, with_owner): (&Plan<'_>, bool),
    run: &Outcome,
    rows: &Rows,
    talk: &Talk,
) -> Result<Vec<PathBuf>, Failure> {
    let (args, held) = (plan.goal.args(), &rows.held);
    let options = WriteOptions {
        with_owner,
        first_id: held.first_id,
        point_data: &rows.columns,
        ..args.writing.options()
    };
    let mut files = Vec::new();
    for output in &args.output {
        talk.check();
        let stage = format!("writing {}", output.display());
        let mut progress = |done: u64, total: u64| talk.stage(&stage, done, Some(total));
        let view = run.view(held.points.coordinates());
        let written = match (&held.source_index, options.format_of(output)?) {
            // In a file that has only cells, or only some of the points, indices count all rows of the input, including
            // dropped ones.
            (Some(source), format) if format.row().has_input_rows => {
                let all = InputRows::of(&view, &rows.columns, source, held.skipped);
                let options = WriteOptions { point_data: &all.columns, ..options };
                write_mesh(output, &all.view(&view), &options, &mut progress)
            }
            _ => write_mesh(output, &view, &options, &mut progress),
        };
        files.extend(written?);
    }
    Ok(files)
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
