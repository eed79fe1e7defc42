//! The weights of a file of their own, for several processes.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use septet_protocol::checksum::checksum;
use septet_protocol::codec::{Bulk, decode, encode};
use septet_protocol::wire::{Ended, Parcel, Processes, WireError};

use super::super::array::Layout;
use super::super::error::InputError;
use super::super::formats::{npy, of_content};
use super::super::load::{self, Packing};
use super::super::signature;
use super::super::text::Source;
use super::super::weight_file::check_count;
use super::super::weight_rows::WeightRows;
use super::super::weights::WeightOption;
use super::Limits;
use super::chunks::{OpenFile, Unit};
use super::error::{SharedError, agree};
use super::{survey, whole};
use crate::format::Format;

/// A file of weights of all rows of an input.
pub(super) struct WeightFile<'a> {
    /// The file, and whether its numbers are radii.
    pub option: &'a WeightOption,
    /// The sizes of steps.
    pub limits: Limits,
    /// Returns whether to end on all processes.
    pub stop: &'a dyn Fn() -> bool,
    /// The number of files of points.
    pub files: usize,
}

impl WeightFile<'_> {
    /// Reads the weights of the block of this process. No row of the input is dropped. `blocks` are those of all processes, and
    /// `rows` is the number of rows of the input.
    pub fn read(
        &self,
        processes: &mut Processes<'_>,
        blocks: &[Range<u64>],
        rows: u64,
    ) -> Result<Vec<f64>, Ended> {
        let path = self.option.file().unwrap_or(Path::new(""));
        let surveyed = of_file(path, self.limits.step);
        let (layout, seen) = agree(processes, surveyed.map_err(|error| self.of_list(error)))?;
        let same = survey::compare(processes, &[PathBuf::from(path)], &[seen])?;
        agree(processes, same)?;
        if let Some(layout) = layout {
            let own = &blocks[processes.process() as usize];
            let read = self.part(path, &layout, (own, rows));
            return agree(processes, read.map_err(|error| self.of_list(error)));
        }
        let all = match processes.process() {
            0 => self.whole(path, rows),
            _ => Ok(Vec::new()),
        };
        let all = agree(processes, all)?;
        self.deal(processes, &all, (blocks, rows))
    }

    /// Returns the error of a file as that of the weights of a list, if there are several files of points.
    fn of_list(&self, error: SharedError) -> SharedError {
        match error {
            SharedError::File(error) => SharedError::of_weights(*error, self.files),
            other => other,
        }
    }

    /// Reads rows of an array.
    fn part(
        &self,
        path: &Path,
        layout: &Layout,
        (own, rows): (&Range<u64>, u64),
    ) -> Result<Vec<f64>, SharedError> {
        check_count(path, self.option, (layout.rows, rows))?;
        let mut weights = WeightRows::new(path, self.option, false).after(own.start);
        let size = layout.row_size();
        let [start, end] = [own.start, own.end].map(|row| layout.start + row * size);
        OpenFile::of(path, self.limits.step)?.chunks(
            start..end,
            Unit::Bytes(size),
            &mut |offset, bytes| Ok(layout.numbers_at(offset, bytes, &mut weights)?),
        )?;
        Ok(weights.values)
    }

    /// Reads all rows.
    fn whole(&self, path: &Path, rows: u64) -> Result<Vec<f64>, SharedError> {
        let how = (self.limits.whole, self.stop);
        let all = whole::apart_weights((path, self.option), false, how, self.files)?;
        let checked = check_count(path, self.option, (all.len() as u64, rows));
        checked.map_err(|error| SharedError::of_weights(error, self.files))?;
        Ok(all)
    }

    /// Sends each process the weights of its block, in rounds. Process 0 has `all` of them.
    fn deal(
        &self,
        processes: &mut Processes<'_>,
        all: &[f64],
        (blocks, rows): (&[Range<u64>], u64),
    ) -> Result<Vec<f64>, Ended> {
        let (mut own, mut start) = (Vec::new(), 0);
        while start < rows {
            let end = rows.min(start + self.limits.round.max(1));
            let mut sent = Vec::new();
            for (process, block) in (0..).zip(blocks) {
                let (from, to) = (block.start.max(start), block.end.min(end));
                if from < to && !all.is_empty() {
                    let part = Bulk(all[from as usize..to as usize].to_vec());
                    let bytes = encode(&part).map_err(|error| corrupt(process, &error))?;
                    sent.push(Parcel { process, bytes });
                }
            }
            for Parcel { process, bytes } in processes.scatter(sent)? {
                let part: Bulk<f64> = decode(&bytes).map_err(|error| corrupt(process, &error))?;
                own.extend_from_slice(&part);
            }
            start = end;
        }
        Ok(own)
    }
}

fn corrupt(process: u32, error: &impl ToString) -> WireError {
    WireError::Corrupt { process, reason: error.to_string() }
}

/// Returns the layout of an array of which each process can read its part, and the view of the file that this process has: its size,
/// and the checksum of the header of an array. Other files have no layout.
fn of_file(path: &Path, step: usize) -> Result<(Option<Layout>, [u64; 2]), SharedError> {
    let found = fs::metadata(path).map_err(|error| load::unreadable(path, error))?;
    if found.is_dir() {
        return Err(InputError::Directory { path: path.to_owned() }.into());
    }
    let size = if found.is_file() { found.len() } else { 0 };
    if !found.is_file() || Packing::of(path) == Packing::Gzip {
        return Ok((None, [size, 0]));
    }
    let (mut file, mut data) = (OpenFile::of(path, step)?, Vec::new());
    file.read(0..size.min(signature::HEAD as u64), &mut data)?;
    if of_content(&data) != Some(Format::Npy) {
        return Ok((None, [size, 0]));
    }
    survey::complete_header(path, &mut file, (&mut data, size))?;
    let layout = npy::layout_of_weights(Source { path, data: &data }, size)?;
    Ok((Some(layout), [size, checksum(&data)]))
}
