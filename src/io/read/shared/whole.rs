//! Files that process 0 reads and sends to the others.

use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

use septet_core::model::Points;
use septet_protocol::codec::{Bulk, decode, encode};
use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::super::apart::apart;
use super::super::dispatch;
use super::super::error::InputError;
use super::super::list::empty;
use super::super::load::{self, Packing};
use super::super::points::{PointFile, ReadOptions};
use super::super::text::Source;
use super::super::weight_file::{attach, check_count, of_data};
use super::super::weights::WeightOption;
use super::block::Rows;
use super::error::SharedError;
use super::rows::{Part, WholeFile};
use super::survey::Plan;

/// Reads the files that cannot be cut. `parts` are the parts of the other files. Ends when `stop` returns `true`.
pub(super) fn read(
    plans: &[Plan],
    options: &ReadOptions,
    parts: &[Vec<Part>],
    (limit, stop): (u64, &dyn Fn() -> bool),
) -> Result<Vec<PointFile>, SharedError> {
    let (mut all, mut before) = (Vec::new(), 0);
    let mut counted = vec![0; plans.len()];
    for part in parts.iter().flatten() {
        if let Some(rows) = counted.get_mut(part[0] as usize) {
            *rows += part[3];
        }
    }
    for (at, plan) in plans.iter().enumerate() {
        let Plan::Whole(path) = plan else {
            before += counted[at];
            continue;
        };
        let (owned, chosen) = (path.clone(), options.clone());
        let read = apart(move || points(&owned, &chosen, limit), &mut || stop());
        let read = read.map_err(|error| load::unreadable(path, error))?;
        let file = match read.unwrap_or(Err(SharedError::Interrupted))? {
            // A part of a table may have no rows.
            Err(InputError::NoRows { .. }) if plans.len() > 1 => empty(options),
            file => file.map_err(|error| SharedError::of(error, plans.len(), before))?,
        };
        before += row_count(&file);
        all.push(file);
    }
    if options.drops_by_weight_file()
        && let Some((option, path)) = options.weights.as_ref().and_then(|of| Some((of, of.file()?)))
    {
        let rows = apart_weights((path, option), true, (limit, stop), plans.len())?;
        let expected = all.iter().map(row_count).sum();
        let checked = check_count(path, option, (rows.len() as u64, expected));
        checked.map_err(|error| SharedError::of_weights(error, plans.len()))?;
        let mut rest = &rows[..];
        for file in &mut all {
            let (own, after) = rest.split_at(row_count(file) as usize);
            attach(file, own);
            rest = after;
        }
    }
    Ok(all)
}

/// Returns the number of rows of a file, including dropped ones.
fn row_count(file: &PointFile) -> u64 {
    (file.points.len() + file.skipped) as u64
}

/// Returns the weights of all rows of a file of at most `limit` bytes, for points of `files` files. With `drops`, a row without a
/// weight is NaN and no error. Ends when `stop` returns `true`.
pub(super) fn apart_weights(
    (path, option): (&Path, &WeightOption),
    drops: bool,
    (limit, stop): (u64, &dyn Fn() -> bool),
    files: usize,
) -> Result<Vec<f64>, SharedError> {
    let (owned, chosen) = (path.to_owned(), option.clone());
    let read = move || -> Result<Result<Vec<f64>, InputError>, SharedError> {
        let data = bytes(&owned, Packing::of(&owned), limit)?;
        Ok(data.and_then(|data| of_data(Source { path: &owned, data: &data }, &chosen, drops)))
    };
    let done = apart(read, &mut || stop()).map_err(|error| load::unreadable(path, error))?;
    done.unwrap_or(Err(SharedError::Interrupted))?.map_err(|error| SharedError::of_weights(error, files))
}

/// Returns the points of a file of at most `limit` bytes.
fn points(
    path: &Path,
    options: &ReadOptions,
    limit: u64,
) -> Result<Result<PointFile, InputError>, SharedError> {
    let read = bytes(path, Packing::of_points(path, options), limit)?;
    Ok(read.and_then(|data| dispatch::points(path, &data, options)))
}

/// Returns the bytes of a file of at most `limit` bytes.
fn bytes(path: &Path, packing: Packing, limit: u64) -> Result<Result<Vec<u8>, InputError>, SharedError> {
    let (input, total): (Box<dyn Read>, _) = if path.as_os_str() == "-" {
        (Box::new(io::stdin().lock()), None)
    } else {
        let (file, total) = load::open(path)?;
        (Box::new(file), total)
    };
    let mut limited = input.take(limit.saturating_add(1));
    let is_large = total.is_some_and(|total| total > limit);
    let data = if is_large {
        Ok(Vec::new())
    } else {
        load::load_from(&mut limited, path, total, packing, &mut |_, _| {})
    };
    if is_large || limited.limit() == 0 {
        return Err(SharedError::TooLarge { path: path.to_owned(), limit });
    }
    Ok(data)
}

/// Returns the facts of a file that the other processes need.
pub(super) fn known(file: &PointFile) -> WholeFile {
    WholeFile {
        rows: row_count(file),
        kept: file.points.len() as u64,
        dimension: file.points.dimension(),
        first_id: file.first_id,
        kind: file.coordinate_type,
        notes: file.notes.clone(),
        reading: file.reading.clone(),
    }
}

/// How process 0 sends rows.
#[derive(Clone, Copy)]
pub(super) struct Dealing {
    /// The number of rows that are sent at a time.
    pub round: u64,
    /// Whether the rows have their numbers in the file.
    pub has_index: bool,
    /// Whether the points have weights.
    pub has_weights: bool,
}

/// Sends the rows of a file to the processes in rounds. Process 0 has the `content`. `wanted` are the rows of each process
/// among the rows that were not dropped. Returns the rows of this process.
pub(super) fn deal(
    processes: &mut Processes<'_>,
    content: Option<&PointFile>,
    known: &WholeFile,
    wanted: &[Range<u64>],
    how: Dealing,
) -> Result<Rows, Ended> {
    let mut own = Rows::new(known.dimension);
    let mut start = 0;
    while start < known.kept {
        let end = known.kept.min(start + how.round.max(1));
        let mut sent = Vec::new();
        for (process, wanted) in wanted.iter().enumerate() {
            let (from, to) = (wanted.start.max(start), wanted.end.min(end));
            if let Some(file) = content.filter(|_| from < to) {
                sent.push(parcel(process as u32, file, from as usize..to as usize, how)?);
            }
        }
        for arrived in processes.scatter(sent)? {
            let (numbers, index) = decode::<(Bulk<f64>, Bulk<u64>)>(&arrived.bytes).map_err(|error| {
                WireError::Corrupt { process: arrived.process, reason: error.to_string() }
            })?;
            // The weights follow the coordinates.
            let width = known.dimension + usize::from(how.has_weights);
            let (coordinates, weights) = numbers.split_at(numbers.len() / width * known.dimension);
            let points = Points::of(known.dimension, coordinates);
            own.add(Rows { points, weights: weights.to_vec(), index: index.0 });
        }
        start = end;
    }
    Ok(own)
}

/// Returns the parcel with rows of a file.
fn parcel(process: u32, file: &PointFile, rows: Range<usize>, how: Dealing) -> Result<Parcel, WireError> {
    let width = file.points.dimension();
    let mut numbers = file.points.coordinates()[rows.start * width..rows.end * width].to_vec();
    if let Some(weights) = file.weights.as_ref().filter(|_| how.has_weights) {
        numbers.extend_from_slice(&weights[rows.clone()]);
    }
    let index = match &file.source_index {
        _ if !how.has_index => Vec::new(),
        Some(index) => index[rows].to_vec(),
        None => (rows.start as u64..rows.end as u64).collect(),
    };
    let bytes = encode(&(Bulk(numbers), Bulk(index)))
        .map_err(|error| WireError::Corrupt { process, reason: error.to_string() })?;
    Ok(Parcel { process, bytes })
}
