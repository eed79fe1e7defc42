//! The run of a periodic triangulation, in one process or in several.

use std::time::Instant;

use septet_geometry::coordinates::{Coordinates, PointSlice};
use septet_geometry::point::Position;
use septet_geometry::range::RangeError;
use septet_geometry::site::Weighted;
use septet_protocol::wire::{Alone, Processes};
use septet_workers::config::cores::map;

use super::edges::Clashes;
use super::images::{Images, Sites};
use super::lattice::Lattice;
use super::quotient::{Covered, Quotient};
use super::team::Team;
use crate::error::{Error, PeriodicError, incomplete};
use crate::input::Whole;
use crate::result::outcome::{Accounting, LeftOut, Outcome};
use crate::result::periodic::PeriodicCells;
use crate::run::processes::{HeldRows, placement, run_rows};
use crate::run::{Hosts, run_once, started};
use crate::spec::{Periodic, Spec, Task};

/// The largest number of rows: images are counted in 32 bits.
const MOST_ROWS: u64 = (u32::MAX / 27) as u64;

/// Triangulates points in a periodic box in this process. A failed certificate is not an error.
///
/// # Errors
/// See [`Error`].
pub(crate) fn run_periodic(
    points: PointSlice<'_>,
    periodic: &Periodic,
    order: (&Spec, Task),
) -> Result<Outcome, Error> {
    let (alone, rows) = (&mut Alone, points.len() as u64);
    let team = &mut Team { processes: &mut Processes::over(alone), placement: None };
    let run = run_points(HeldRows { points, first: 0, rows, base: 0 }, periodic, order, team)?;
    run.ok_or_else(|| incomplete("the process has no ranks".to_string()))
}

/// Triangulates the points of all processes in a periodic box. The first process has the cells. Returns `None` on a process
/// without ranks. A failed certificate is not an error.
///
/// # Errors
/// See [`Error`]. All processes with ranks return an error.
pub(crate) fn run_shared(
    processes: &mut Processes<'_>,
    held: HeldRows<'_>,
    periodic: &Periodic,
    order: (&Spec, Task),
) -> Result<Option<Outcome>, Error> {
    let placement = placement(order.0, processes.processes())?;
    run_points(held, periodic, order, &mut Team { processes, placement: Some(placement) })
}

fn run_points(
    held: HeldRows<'_>,
    periodic: &Periodic,
    order: (&Spec, Task),
    team: &mut Team<'_, '_>,
) -> Result<Option<Outcome>, Error> {
    let first = (held.first, held.base);
    match held.points {
        PointSlice::Plane(points) => run_sites((with_weights(points), first), (periodic, false), order, team),
        PointSlice::Space(points) => run_sites((with_weights(points), first), (periodic, false), order, team),
        PointSlice::WeightedPlane(sites) => run_sites((sites.to_vec(), first), (periodic, true), order, team),
        PointSlice::WeightedSpace(sites) => run_sites((sites.to_vec(), first), (periodic, true), order, team),
        PointSlice::Higher(points) => Err(PeriodicError::Higher { dimension: points.dimension() }.into()),
    }
}

/// Checks a periodic box, and that all points lie in it or stand for their images in it.
///
/// # Errors
/// Returns the error of a run in this box.
pub fn check_box(points: PointSlice<'_>, periodic: &Periodic) -> Result<(), Error> {
    match points {
        PointSlice::Plane(points) => check_sites(with_weights(points), periodic),
        PointSlice::Space(points) => check_sites(with_weights(points), periodic),
        PointSlice::WeightedPlane(sites) => check_sites(sites.to_vec(), periodic),
        PointSlice::WeightedSpace(sites) => check_sites(sites.to_vec(), periodic),
        PointSlice::Higher(points) => Err(PeriodicError::Higher { dimension: points.dimension() }.into()),
    }
}

fn check_sites<P: Position>(rows: Vec<Weighted<P>>, periodic: &Periodic) -> Result<(), Error> {
    let alone = &mut Alone;
    let team = &mut Team { processes: &mut Processes::over(alone), placement: None };
    Sites::of(Lattice::of(periodic, P::DIM)?, (rows, 0), team).map(drop)
}

fn with_weights<P: Position>(points: &[P]) -> Vec<Weighted<P>> {
    map(points, |&point| Weighted::new(point, 0.0))
}

/// Runs the machine until the cover suffices. `first` is the number of the first row of this process, and that of the first
/// row of all.
fn run_sites<P: Position>(
    (rows, (first, base)): (Vec<Weighted<P>>, (u64, u64)),
    (periodic, has_weights): (&Periodic, bool),
    (spec, task): (&Spec, Task),
    team: &mut Team<'_, '_>,
) -> Result<Option<Outcome>, Error> {
    let start = Instant::now();
    check(spec, task)?;
    // Neighbours show the hull.
    let spec = &spec.clone().with(|spec| spec.keep.neighbours = true);
    let sites = Sites::of(Lattice::of(periodic, P::DIM)?, (rows, first), team)?;
    if sites.count() > MOST_ROWS {
        return Err(PeriodicError::Many { points: sites.count() as usize, most: MOST_ROWS as usize }.into());
    }
    let mut width = sites.first_width();
    loop {
        let images = sites.images(width, team)?;
        let run = run_images(&images, (spec, task), team).map_err(|error| of_rows(error, &images));
        let failed = team.all(vec![u64::from(run.is_err())])?.concat().contains(&1);
        let mut run = run?;
        if failed {
            return Ok(None);
        }
        let shares = run.as_mut().map(|run| std::mem::take(&mut run.shares)).unwrap_or_default();
        let covered = Covered { sites: &sites, images: &images, shares: &shares, width };
        let quotient = covered.quotient(team)?;
        // The images of a flat run may lie too far away.
        let is_enough = |run: &Outcome| run.refutation.is_some() || sites.has_all(width) || !run.is_flat();
        let is_open = quotient.is_none() || !run.as_ref().is_none_or(is_enough);
        if !team.all(vec![u64::from(is_open)])?.concat().contains(&1) {
            let result = (run, quotient.unwrap_or_default());
            let mut run = finished(covered, result, (has_weights, base), team)?;
            if let Some(run) = &mut run {
                run.times.total = start.elapsed().as_secs_f64();
            }
            return Ok(run);
        }
        width *= 2.0;
    }
}

/// Runs the machine over the sites and their images. Returns `None` on a process without ranks.
fn run_images<P: Position>(
    images: &Images<P>,
    order: (&Spec, Task),
    team: &mut Team<'_, '_>,
) -> Result<Option<Outcome>, Error> {
    let sites = &images.sites;
    let Some(placement) = team.placement else {
        return run_once(
            order,
            Whole::points(sites).held(),
            &mut Hosts::Own(&mut started(order, sites.len())),
        )
        .map(Some);
    };
    let process = team.processes.process();
    if process >= placement.processes() {
        return Ok(None);
    }
    let (points, rows) = (Coordinates::points(sites), images.rows());
    let held = HeldRows { points, first: images.first(process), rows, base: 0 };
    run_rows(team.processes, (sites, held), placement, order).map(Some)
}

/// Refuses what a periodic run does not have.
fn check(spec: &Spec, task: Task) -> Result<(), PeriodicError> {
    match task {
        Task::Triangulate | Task::Simulate => {}
        Task::Count(_) | Task::Independent { .. } => return Err(PeriodicError::Task),
    }
    let outputs = [
        (spec.keep.owner, "the owner of a cell"),
        (spec.keep.view.is_some_and(|points| points > 0), "a picture"),
        (spec.keep.costs, "a cost trace"),
    ];
    match outputs.iter().find(|(is_wanted, _)| *is_wanted) {
        Some(&(_, output)) => Err(PeriodicError::Output { output }),
        None => Ok(()),
    }
}

/// Returns an error that names rows in the place of images.
fn of_rows<P: Position>(error: Error, images: &Images<P>) -> Error {
    let row = |index: usize| images.of(index as u64).row as usize;
    match error {
        Error::Points(RangeError::NotFinite { index, value }) => {
            RangeError::NotFinite { index: row(index), value }.into()
        }
        Error::Points(RangeError::Spread { bits, low, high }) => {
            RangeError::Spread { bits, low: row(low), high: row(high) }.into()
        }
        other => other,
    }
}

/// Replaces the triangulation of the images by that of the box. `base` is the number of the first row of all processes.
fn finished<P: Position>(
    covered: Covered<'_, P>,
    (mut run, Quotient { packed, volume }): (Option<Outcome>, Quotient),
    (has_weights, base): (bool, u64),
    team: &mut Team<'_, '_>,
) -> Result<Option<Outcome>, Error> {
    let Covered { sites, images, .. } = covered;
    let left_out = run.as_mut().map(|run| std::mem::take(&mut run.left_out)).unwrap_or_default();
    let left_out = of_base_sites(left_out, images, base);
    let LeftOut { duplicates, refused, hidden } = &left_out;
    let own = [duplicates.len(), refused.len(), hidden.len(), packed.len() / (P::DIM + 1)];
    let is_refuted = run.as_ref().is_some_and(|run| run.refutation.is_some());
    let own = own.map(|count| count as u64).into_iter().chain([volume.to_bits(), u64::from(is_refuted)]);
    let all = team.all(own.collect())?;
    let [duplicate, refused, hidden, cells] = [0, 1, 2, 3].map(|at| all.iter().map(|own| own[at]).sum());
    let volume = all.iter().map(|own| f64::from_bits(own[4])).sum();
    let input = sites.count();
    let used = input.saturating_sub(duplicate + refused + hidden);
    let is_certified = all.iter().all(|own| own[5] == 0);
    let packed = team.on_first(packed)?;
    let steps = sites.all_steps(team)?;
    if is_certified && sites.lattice.is_closed(P::DIM) && used > 0 {
        check_cover(&sites.lattice, (P::DIM, cells), (used, volume))?;
    }
    let Some(mut run) = run else { return Ok(None) };
    let clashes = Clashes::of(&packed, P::DIM + 1);
    let mut part = PeriodicCells::new(packed, steps, P::DIM);
    (part.is_simplicial, part.images) = (clashes.is_empty(), images.count());
    part.sheets = clashes.sheets(&sites.lattice, P::DIM);
    run.facts.points = Accounting { input, used, duplicate, refused, hidden: has_weights.then_some(hidden) };
    (run.facts.cells, run.facts.hull_facets) = (cells, 0);
    (run.left_out, run.kept.periodic) = (left_out, Some(part));
    Ok(Some(run))
}

/// Returns the rows of base sites that are not vertices.
fn of_base_sites<P: Position>(left_out: LeftOut, images: &Images<P>, base: u64) -> LeftOut {
    let own = |rows: Vec<u64>| rows.into_iter().filter(|row| images.is_base(*row)).map(|row| row + base);
    let LeftOut { duplicates, refused, hidden } = left_out;
    let duplicates = duplicates.into_iter().filter(|(row, _)| images.is_base(*row));
    LeftOut {
        duplicates: duplicates.map(|(row, first)| (row + base, first + base)).collect(),
        refused: own(refused).collect(),
        hidden: own(hidden).collect(),
    }
}

/// The largest error of the sum of the volumes, in boxes. The rounding of one volume is far smaller.
const MOST_ERROR: f64 = 1e-6;

/// Checks that the cells of a closed box cover it once, and in the plane that there are twice as many as points.
///
/// # Errors
/// Fails if they do not.
fn check_cover(
    lattice: &Lattice,
    (dimension, cells): (usize, u64),
    (points, volume): (u64, f64),
) -> Result<(), Error> {
    let of_box: f64 = lattice.lengths[..dimension].iter().product();
    let boxes = volume / of_box;
    let is_torus = dimension == 3 || cells == 2 * points;
    if (boxes - 1.0).abs() < MOST_ERROR && is_torus {
        return Ok(());
    }
    Err(incomplete(format!("{cells} cells of {points} points cover the periodic box {boxes} times")))
}
