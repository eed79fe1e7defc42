//! The rows of this process: all of them, or a block of those of several processes.

use std::cell::Cell;
use std::ops::Range;
use std::path::PathBuf;

use septet_core::generate::{Request, SeparateRows};
use septet_core::model::WeightedPoints;
use septet_core::result::view::MOST_POINTS;
use septet_core::run::memory::admit;
use septet_core::run::processes::rows_of;
use septet_core::spec::Task;
use septet_core::{Error, Outcome, Spec};
use septet_geometry::coordinates::{HigherSlice, PointSlice};
use septet_io::read::{Extent, SharedPoints, read_shared, share_points};
use septet_io::write::check_gathered;

use super::breaklines::Breaklines;
use super::plan::Plan;
use super::team::Team;
use crate::errors::{Code, Failure};
use crate::far::Far;
use crate::input::{Input, Loaded, make, placed};
use crate::progress::Talk;

/// The rows of this process.
pub(super) struct Rows {
    /// The points.
    pub held: SharedPoints,
    /// The points with their weights, if they have some.
    weighted: Option<WeightedPoints>,
    /// The Lipschitz constant of an f-spaced set.
    pub spacing: Option<f64>,
    /// Measured seconds, if this process reads alone.
    pub seconds: Option<f64>,
    /// The break lines, if there are some.
    pub breaks: Option<Breaklines>,
}

impl Rows {
    /// Reads or generates the rows of this process.
    ///
    /// # Errors
    /// Fails with the first failure of any process.
    pub(super) fn read(plan: &Plan<'_>, team: &mut Team<'_>, talk: &Talk) -> Result<Self, Failure> {
        let Some(placement) = plan.placement else {
            let mut rows = Rows::of_all(plan.input.load(&plan.reading, talk)?)?;
            rows.breaks = Breaklines::join(plan.goal.breaklines(), &mut rows.held, talk)?;
            return Ok(rows);
        };
        let process = team.processes.process();
        let stop = &|| talk.is_cancelled();
        let block = |rows: u64| rows_of(placement, process, rows);
        let (held, spacing) = match &plan.input {
            Input::Sample(request) => sample(request, team, &block, talk)?,
            Input::File(name) => {
                (read_shared(&mut team.processes, &[PathBuf::from(name)], &plan.reading, &block, stop)?, None)
            }
            Input::List(list) => {
                (read_shared(&mut team.processes, list.files(), &plan.reading, &block, stop)?, None)
            }
        };
        let far = if plan.input.is_sample() { None } else { Far::of_blocks(&held, &mut team.processes)? };
        if team.is_first() {
            for note in &held.notes {
                talk.note(format!("note: {note}"));
            }
            if let Some(far) = far {
                talk.note(far.describe(&held.files));
            }
        }
        // A process that was interrupted while reading ends the command on all of them.
        team.agree(if talk.is_cancelled() { Err(Failure::interrupted()) } else { Ok(()) })?;
        let rows = Rows::of(held, spacing, None);
        team.agree(rows)
    }

    /// Takes the points that one process loaded.
    fn of_all(loaded: Loaded) -> Result<Self, Failure> {
        let Loaded {
            points,
            heights,
            weights,
            spacing,
            skipped,
            source_index,
            first_id,
            columns,
            files,
            reading,
            seconds,
        } = loaded;
        let extent = reading.as_ref().and_then(|_| Extent::of(&points));
        let extent = extent.map(|extent| match &heights {
            Some(heights) => extent.with_axis(heights),
            None => extent,
        });
        let rows = points.len() as u64;
        let held = SharedPoints {
            heights,
            weights,
            skipped,
            source_index,
            first_id,
            files,
            columns,
            reading,
            extent,
            ..SharedPoints::of_block(points, 0, rows)
        };
        Rows::of(held, spacing, Some(seconds))
    }

    /// Joins the points and their weights.
    fn of(mut held: SharedPoints, spacing: Option<f64>, seconds: Option<f64>) -> Result<Self, Failure> {
        let join = |weights: Vec<f64>| {
            let lacks = || {
                Failure::new(
                    Code::Failed,
                    format!("{} weights for {} points", weights.len(), held.points.len()),
                )
            };
            WeightedPoints::join(&held.points, &weights).ok_or_else(lacks)
        };
        let weighted = held.weights.take().map(join).transpose()?;
        Ok(Rows { held, weighted, spacing, seconds, breaks: None })
    }

    /// Returns the points, with their weights if they have some.
    pub(super) fn sites(&self) -> PointSlice<'_> {
        self.weighted.as_ref().map_or_else(|| self.held.points.slice(), WeightedPoints::slice)
    }

    /// Completes the specification once the rows are known: the spacing, the picture, progress and cancellation. Each of
    /// several processes checks the forecast of its memory against its limit.
    ///
    /// # Errors
    /// Fails if the points of a process need more memory.
    pub(super) fn complete(
        &self,
        spec: &mut Spec,
        plan: &Plan<'_>,
        team: &mut Team<'_>,
        talk: &Talk,
    ) -> Result<(), Failure> {
        let (args, points) = (plan.goal.args(), &self.held.points);
        let counted = plan.goal.task() == Task::Simulate;
        spec.recursion.spacing = self.spacing;
        let has_picture = spec.input.periodic.is_none() && points.dimension() <= 3;
        if team.is_alone() && args.json.is_some() && has_picture {
            spec.keep.view = spec.keep.view.or((counted || plan.goal.has_stats()).then_some(MOST_POINTS));
        }
        spec.control.cancel = Some(talk.cancel.clone());
        if team.is_first() {
            spec.control.progress = Some(talk.phases());
        }
        if !team.is_alone() {
            let order = (&*spec, plan.goal.task());
            let admitted = match self.sites() {
                PointSlice::Plane(points) => admit(order, points),
                PointSlice::Space(points) => admit(order, points),
                PointSlice::WeightedPlane(points) => admit(order, points),
                PointSlice::WeightedSpace(points) => admit(order, points),
                PointSlice::Higher(HigherSlice::Four(points)) => admit(order, points),
                PointSlice::Higher(HigherSlice::Five(points)) => admit(order, points),
                PointSlice::Higher(HigherSlice::Six(points)) => admit(order, points),
            };
            team.agree(admitted.map_err(Failure::from))?;
        }
        if plan.placement.is_some() {
            let outputs = (&args.output[..], &args.writing.options());
            check_gathered(&mut team.processes, outputs, (self.held.rows, points.dimension()))?;
        }
        Ok(())
    }

    /// Returns the largest difference of the heights of coincident points of all processes, if the points are a terrain and some
    /// coincide.
    ///
    /// # Errors
    /// Fails if the processes lose each other.
    pub(super) fn height_difference(
        &self,
        run: &Outcome,
        plan: &Plan<'_>,
        team: &mut Team<'_>,
    ) -> Result<Option<f64>, Failure> {
        let Some(heights) = &self.held.heights else { return Ok(None) };
        let own = run.left_out.height_difference(heights, plan.first_row());
        Ok(team.processes.all_gather(&own)?.into_iter().flatten().reduce(f64::max))
    }

    /// Returns the failure for an error of a run over these rows. An error about points gives the file and the positions of the
    /// points in it.
    pub(super) fn failure(&self, error: Error, plan: &Plan<'_>) -> Failure {
        self.told(error, plan).1
    }

    /// Returns the failure of a run, and whether only this process knows the number of a row that it names.
    pub(super) fn told(&self, error: Error, plan: &Plan<'_>) -> (bool, Failure) {
        let base = plan.first_row() as usize + self.held.first as usize;
        let knows = Cell::new(false);
        let of_input = |row: usize| {
            // If rows were dropped, a process knows the numbers of its own rows only.
            let own = self.held.source_index.as_ref().and_then(|source| source.get(row.checked_sub(base)?));
            knows.set(knows.get() || own.is_some());
            own.map_or(row.saturating_sub(plan.first_row() as usize), |row| *row as usize)
        };
        let failure = placed(error, &self.held.files, &plan.goal.args().input, of_input);
        (knows.get(), failure)
    }
}

/// Generates the rows of this process, or receives them from the first process, which then generates the set. Also returns the
/// Lipschitz constant of an f-spaced set. `block` returns the rows of this process, of the given number of rows.
fn sample(
    request: &Request,
    team: &mut Team<'_>,
    block: &dyn Fn(u64) -> Range<u64>,
    talk: &Talk,
) -> Result<(SharedPoints, Option<f64>), Failure> {
    let separate = SeparateRows::of(request).map_err(Failure::from);
    if let Some(set) = team.agree(separate)? {
        let own = block(set.count());
        let points = set.points(own.clone());
        let held = SharedPoints::of_block(points, own.start, set.count());
        return Ok((SharedPoints { notes: set.notes(request), ..held }, None));
    }
    let made = team.first_only(|| make(request, talk))?;
    let spacing = made.as_ref().and_then(|made| made.spacing);
    let spacing = team.processes.all_gather(&spacing)?.swap_remove(0);
    Ok((share_points(&mut team.processes, made.map(|made| made.points), block)?, spacing))
}
