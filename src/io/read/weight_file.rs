//! Files of weights: one number a row, in a text table or a `.npy` array.

use std::path::Path;

use glam::{DVec2, DVec3};
use septet_core::model::Points;

use super::error::{InputError, Place, WeightError};
use super::formats::{described, of_content, reader};
use super::load::{self, Packing};
use super::points::{PointFile, ReadOptions, ReadProgress};
use super::text::Source;
use super::weight_rows::WeightRows;
use super::weights::WeightOption;
use crate::format::{Format, Role};

/// Returns the points of all rows of an input with the weights of the file of weights, if the options state one. Drops the points
/// of rows without a weight if the options say so.
pub(super) fn joined(
    mut file: PointFile,
    options: &ReadOptions,
    progress: &mut ReadProgress<'_>,
) -> Result<PointFile, InputError> {
    let Some((option, path)) = options.weights.as_ref().and_then(|option| Some((option, option.file()?)))
    else {
        return Ok(file);
    };
    let data = load::load(path, Packing::of(path), progress)?;
    let rows = of_data(Source { path, data: &data }, option, options.skip_invalid)?;
    let points = (file.points.len() + file.skipped) as u64;
    check_count(path, option, (rows.len() as u64, points))?;
    attach(&mut file, &rows);
    Ok(file)
}

/// Checks that a file of weights has a row for each row of points, given by the numbers of both.
pub(super) fn check_count(
    path: &Path,
    option: &WeightOption,
    (found, expected): (u64, u64),
) -> Result<(), InputError> {
    if found == expected {
        return Ok(());
    }
    let (path, are_radii) = (path.to_owned(), option.are_radii);
    Err(WeightError::Count { path, found, expected, are_radii }.into())
}

/// Returns the weights of all rows of a file. With `drops`, a row without a weight is NaN and no error.
pub(super) fn of_data(
    source: Source<'_>,
    option: &WeightOption,
    drops: bool,
) -> Result<Vec<f64>, InputError> {
    let content = of_content(source.data).filter(|format| format.has(Role::Weights));
    let format = content.or_else(|| Format::of_path(source.path)).unwrap_or(Format::Xyz);
    let Some(read) = reader(format).weights else {
        let what = format!("{} of weights", described(format));
        let advice = format.instead(Role::Weights).map(str::to_owned);
        let advice =
            advice.unwrap_or_else(|| format!("give one number a row as one of {}", Role::Weights.known()));
        return Err(source.unsupported(Place::Whole, what, advice));
    };
    let mut rows = WeightRows::new(source.path, option, drops);
    read(source, &mut rows)?;
    Ok(rows.values)
}

/// Gives the points their weights. `rows` has the weights of all rows of the file, including dropped ones; a NaN drops its point.
pub(super) fn attach(file: &mut PointFile, rows: &[f64]) {
    let row = |i: usize| file.source_index.as_ref().map_or(i, |index| index[i] as usize);
    let weights: Vec<f64> = (0..file.points.len()).map(|i| rows[row(i)]).collect();
    if weights.iter().any(|weight| weight.is_nan()) {
        keep(file, &weights.iter().map(|weight| !weight.is_nan()).collect::<Vec<bool>>());
    }
    file.weights = Some(weights.into_iter().filter(|weight| !weight.is_nan()).collect());
}

/// Drops the points for which `is_kept` is not set.
fn keep(file: &mut PointFile, is_kept: &[bool]) {
    let before = file.points.len();
    match &mut file.points {
        Points::Plane(points) => retain::<DVec2>(points, is_kept),
        Points::Space(points) => retain::<DVec3>(points, is_kept),
        // Points of a higher dimension have no weights.
        Points::Higher(_) => return,
    }
    let index = file.source_index.get_or_insert_with(|| (0..before as u64).collect());
    retain(index, is_kept);
    file.columns.iter_mut().for_each(|column| retain(&mut column.values, is_kept));
    file.skipped += before - file.points.len();
}

fn retain<T>(values: &mut Vec<T>, is_kept: &[bool]) {
    let mut kept = is_kept.iter();
    values.retain(|_| kept.next().copied().unwrap_or(false));
}
