//! The run of a periodic triangulation, in one process.

use std::time::Instant;

use septet_geometry::coordinates::PointSlice;
use septet_geometry::point::Position;
use septet_geometry::range::RangeError;
use septet_geometry::site::Weighted;
use septet_workers::config::cores::map;

use super::edges::Clashes;
use super::images::{Images, Sites};
use super::lattice::Lattice;
use super::quotient::{Covered, Quotient};
use crate::error::{Error, PeriodicError, incomplete};
use crate::input::Whole;
use crate::result::outcome::{Accounting, LeftOut, Outcome};
use crate::result::periodic::PeriodicCells;
use crate::run::{Hosts, run_once, started};
use crate::spec::{Periodic, Spec, Task};

/// The largest number of rows: images are counted in 32 bits.
const MOST_ROWS: usize = (u32::MAX / 27) as usize;

/// Triangulates points in a periodic box. A failed certificate is not an error.
///
/// # Errors
/// See [`Error`].
pub(crate) fn run_periodic(
    points: PointSlice<'_>,
    periodic: &Periodic,
    order: (&Spec, Task),
) -> Result<Outcome, Error> {
    match points {
        PointSlice::Plane(points) => run_sites(with_weights(points), (periodic, false), order),
        PointSlice::Space(points) => run_sites(with_weights(points), (periodic, false), order),
        PointSlice::WeightedPlane(sites) => run_sites(sites.to_vec(), (periodic, true), order),
        PointSlice::WeightedSpace(sites) => run_sites(sites.to_vec(), (periodic, true), order),
        PointSlice::Higher(points) => Err(PeriodicError::Higher { dimension: points.dimension() }.into()),
    }
}

fn with_weights<P: Position>(points: &[P]) -> Vec<Weighted<P>> {
    map(points, |&point| Weighted::new(point, 0.0))
}

fn run_sites<P: Position>(
    rows: Vec<Weighted<P>>,
    (periodic, has_weights): (&Periodic, bool),
    (spec, task): (&Spec, Task),
) -> Result<Outcome, Error> {
    let start = Instant::now();
    check(spec, task)?;
    if rows.len() > MOST_ROWS {
        return Err(PeriodicError::Many { points: rows.len(), most: MOST_ROWS }.into());
    }
    let sites = Sites::of(Lattice::of(periodic, P::DIM)?, rows)?;
    let mut width = sites.first_width();
    loop {
        let images = sites.images(width);
        let whole = Whole::points(&images.sites);
        let run = run_once((spec, task), whole.held(), &mut Hosts::Own(&mut started(spec)));
        let mut run = run.map_err(|error| of_rows(error, &images))?;
        let shares = std::mem::take(&mut run.shares);
        let covered = Covered { sites: &sites, images: &images, shares: &shares, width };
        // The images of a flat run may lie too far away.
        let is_decided = run.refutation.is_some() || sites.has_all(width) || !run.is_flat();
        if let Some(quotient) = covered.quotient().filter(|_| is_decided) {
            let mut run = finished(covered, (run, quotient), has_weights)?;
            run.times.total = start.elapsed().as_secs_f64();
            return Ok(run);
        }
        width *= 2.0;
    }
}

/// Refuses what a periodic run does not have.
fn check(spec: &Spec, task: Task) -> Result<(), PeriodicError> {
    if task != Task::Triangulate {
        return Err(PeriodicError::Task);
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
    let row = |index: usize| images.of(index as u64).0 as usize;
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

/// Replaces the triangulation of the images by that of the box.
fn finished<P: Position>(
    covered: Covered<'_, P>,
    (mut run, Quotient { packed, volume }): (Outcome, Quotient),
    has_weights: bool,
) -> Result<Outcome, Error> {
    let Covered { sites, images, .. } = covered;
    let is_certified = run.refutation.is_none();
    let clashes = Clashes::of(&packed, P::DIM + 1);
    let mut cells = PeriodicCells::new(packed, sites.all_steps(), P::DIM);
    (cells.is_simplicial, cells.images) = (clashes.is_empty(), images.count());
    cells.sheets = clashes.sheets(&sites.lattice, P::DIM);
    let is_base = |row: &u64| images.is_base(*row);
    let LeftOut { mut duplicates, mut refused, mut hidden } = std::mem::take(&mut run.left_out);
    duplicates.retain(|(row, _)| is_base(row));
    refused.retain(is_base);
    hidden.retain(is_base);
    let input = sites.count();
    let left_out = [duplicates.len(), refused.len(), hidden.len()].map(|count| count as u64);
    run.facts.points = Accounting {
        input,
        used: input.saturating_sub(left_out.iter().sum()),
        duplicate: left_out[0],
        refused: left_out[1],
        hidden: has_weights.then_some(left_out[2]),
    };
    run.left_out = LeftOut { duplicates, refused, hidden };
    if is_certified && sites.lattice.is_closed(P::DIM) && run.facts.points.used > 0 {
        check_cover(&sites.lattice, (P::DIM, cells.count() as u64), (run.facts.points.used, volume))?;
    }
    run.facts.cells = cells.count() as u64;
    run.facts.hull_facets = 0;
    run.kept.periodic = Some(cells);
    Ok(run)
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
