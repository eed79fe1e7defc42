//! The plan of each file: whether it can be cut, and where its rows are.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use septet_protocol::checksum::checksum;
use septet_protocol::wire::{Ended, Processes};

use super::super::array::Layout;
use super::super::columns::{self, Opening};
use super::super::dispatch::{a_domain, check_options, is_domain};
use super::super::error::InputError;
use super::super::formats::{Rows, by_content, npy, of_content, raw, read_by_name, reader};
use super::super::head::Head;
use super::super::load::{self, Packing};
use super::super::points::ReadOptions;
use super::super::signature;
use super::super::text::{Lines, Source, line_feeds};
use super::super::utf16;
use super::chunks::{OpenFile, Unit};
use super::error::{SharedError, agree};
use crate::format::Format;

/// The number of lines with data that determine whether a table is a list of cells or has another format.
const LINES: usize = 9;

/// The number of bytes in which the first row of a table is sought at first.
const HEAD: u64 = 1 << 13;

/// A file whose rows several processes read.
pub(super) struct Cut {
    /// The file.
    pub path: PathBuf,
    /// The bytes of the rows.
    pub rows: Range<u64>,
    /// The number of lines before the rows.
    pub lines: u64,
    /// The number of line feeds before the rows.
    pub feeds: u64,
    /// The number of coordinates of each point.
    pub dimension: usize,
    /// The format of the rows.
    pub form: Form,
    /// Whether the file looks like a domain. Its errors then advise to mesh it.
    pub is_domain: bool,
}

/// The format of the rows of a file.
pub(super) enum Form {
    /// Lines of text.
    Table(Box<Head>),
    /// Rows of an array in C order.
    Array(Layout),
}

/// How a file is read.
pub(super) enum Plan {
    /// Each process reads a part of it.
    Cut(Cut),
    /// Process 0 reads it.
    Whole(PathBuf),
}

/// The plan of a file, and the view that a process has of it: its size, and the checksum of its first bytes.
struct Surveyed {
    plan: Plan,
    seen: [u64; 2],
}

/// Plans how to read the files. All processes must see the same files.
pub(super) fn survey(
    processes: &mut Processes<'_>,
    files: &[PathBuf],
    options: &ReadOptions,
    step: usize,
) -> Result<Vec<Plan>, Ended> {
    let each = |path: &PathBuf| of_file(path, options, step);
    let own: Result<Vec<Surveyed>, SharedError> = files.iter().map(each).collect();
    let own = agree(processes, own)?;
    let (plans, seen): (Vec<Plan>, Vec<[u64; 2]>) = own.into_iter().map(|of| (of.plan, of.seen)).unzip();
    let same = compare(processes, files, &seen)?;
    agree(processes, same)?;
    Ok(plans)
}

/// Compares the views of all processes. Details travel only if the checksums of the views differ.
pub(super) fn compare(
    processes: &mut Processes<'_>,
    files: &[PathBuf],
    seen: &[[u64; 2]],
) -> Result<Result<(), SharedError>, Ended> {
    let bytes: Vec<u8> = seen.as_flattened().iter().flat_map(|word| word.to_le_bytes()).collect();
    let sums = processes.all_gather(&[seen.len() as u64, checksum(&bytes)])?;
    if let Some(process) = sums.iter().position(|sum| sum[0] != sums[0][0]) {
        let (found, expected) = (sums[process][0], sums[0][0]);
        return Ok(Err(SharedError::OtherList { process: process as u32, found, expected }));
    }
    if sums.iter().all(|sum| *sum == sums[0]) {
        return Ok(Ok(()));
    }
    let all = processes.all_gather(&seen.to_vec())?;
    for (at, path) in files.iter().enumerate() {
        let differs = |of: &Vec<[u64; 2]>| of.get(at) != all[0].get(at);
        if let Some(process) = all.iter().position(differs) {
            let [found, expected] = [process, 0].map(|of| all[of].get(at).copied().unwrap_or_default());
            let (path, process) = (path.clone(), process as u32);
            let [found, expected] = described(found, expected);
            return Ok(Err(SharedError::Differs { path, process, found, expected }));
        }
    }
    Ok(Ok(()))
}

/// Describes the difference of two views of a file.
fn described(found: [u64; 2], expected: [u64; 2]) -> [String; 2] {
    if found[0] == expected[0] {
        return [found, expected].map(|of| format!("a header with the checksum {:016x}", of[1]));
    }
    [found, expected].map(|of| format!("{} bytes", of[0]))
}

fn of_file(path: &Path, options: &ReadOptions, step: usize) -> Result<Surveyed, SharedError> {
    check_options(path, options)?;
    let whole = |size| Surveyed { plan: Plan::Whole(path.to_owned()), seen: [size, 0] };
    if path.as_os_str() == "-" {
        return Ok(whole(0));
    }
    let found = fs::metadata(path).map_err(|error| load::unreadable(path, error))?;
    if found.is_dir() {
        return Err(InputError::Directory { path: path.to_owned() }.into());
    }
    let packing = Packing::of_points(path, options);
    // Only one process can read from a pipe. Values of other columns stay on the process that writes them, and the rows of a
    // file of weights drop points.
    if !found.is_file() || packing == Packing::Gzip || options.keep_columns || options.drops_by_weight_file()
    {
        return Ok(whole(if found.is_file() { found.len() } else { 0 }));
    }
    let size = found.len();
    let mut file = OpenFile::of(path, step)?;
    let mut first = Vec::new();
    file.read(0..size.min(signature::HEAD as u64), &mut first)?;
    let is_coded = first.starts_with(&[0x1f, 0x8b]) || utf16::has_mark(&first);
    if is_coded && packing != Packing::Plain {
        return Ok(whole(size));
    }
    let format = options.format.or(read_by_name(path)).or_else(|| of_content(&first));
    let rows = format.and_then(|format| reader(format).rows);
    let name = if options.raw.is_some() { Some("raw") } else { format.map(Format::name) };
    if options.columns.is_some() && (options.raw.is_some() || rows == Some(Rows::Array)) {
        let format = name.unwrap_or_default();
        return Err(InputError::NotATable { path: path.to_owned(), format }.into());
    }
    let cut = match (options.raw, rows) {
        (Some(rows), _) => {
            let source = Source { path, data: &[] };
            Some((of_layout(source, raw::layout(source, rows, size)?, options)?, 0))
        }
        // Its first lines may look like those of a table.
        (None, Some(Rows::Lines)) if options.format.is_none() && signature::begins_binary(&first, size) => {
            None
        }
        (None, Some(Rows::Array)) => array(path, &mut file, (first, size), options)?,
        (None, Some(Rows::Lines)) => table(path, &mut file, size, options, step)?,
        (None, None) => None,
    };
    Ok(cut.map_or_else(|| whole(size), |(cut, sum)| Surveyed { plan: Plan::Cut(cut), seen: [size, sum] }))
}

/// Plans how to read an array. Returns `None` for Fortran order.
fn array(
    path: &Path,
    file: &mut OpenFile<'_>,
    (mut data, size): (Vec<u8>, u64),
    options: &ReadOptions,
) -> Result<Option<(Cut, u64)>, SharedError> {
    complete_header(path, file, (&mut data, size))?;
    let source = Source { path, data: &data };
    let layout = npy::layout(source, size, npy::Content::of_points(options))?;
    let cut = of_layout(source, layout, options)?;
    // One process must see the whole last column.
    let is_whole = layout.fortran || layout.may_be_homogeneous(options);
    Ok((!is_whole).then(|| (cut, checksum(&data))))
}

/// Makes the first bytes of a `.npy` file of `size` bytes its whole header.
pub(super) fn complete_header(
    path: &Path,
    file: &mut OpenFile<'_>,
    (data, size): (&mut Vec<u8>, u64),
) -> Result<(), SharedError> {
    let (_, start) = npy::header_range(Source { path, data }, size)?;
    let known = data.len() as u64;
    if start > known {
        file.read(known..start, data)?;
    }
    data.truncate(start as usize);
    Ok(())
}

/// Returns the plan of an array in C order.
fn of_layout(source: Source<'_>, layout: Layout, options: &ReadOptions) -> Result<Cut, InputError> {
    let dimension = layout.collector(source, options, 0)?.dimension();
    let rows = layout.start..layout.start + layout.rows * layout.row_size();
    let (path, form) = (source.path.to_owned(), Form::Array(layout));
    Ok(Cut { path, rows, lines: 0, feeds: 0, dimension, form, is_domain: false })
}

/// Plans how to read a table. Returns `None` if it has no rows, or if its first lines are those of another format.
fn table(
    path: &Path,
    file: &mut OpenFile<'_>,
    size: u64,
    options: &ReadOptions,
    step: usize,
) -> Result<Option<(Cut, u64)>, SharedError> {
    let (mut data, mut end) = (Vec::new(), 0);
    loop {
        let more = HEAD.min(step as u64).max(end);
        let from = end;
        end = size.min(end + more);
        file.read(from..end, &mut data)?;
        let whole = if end == size { data.len() } else { Unit::Lines.whole(&data) };
        let head = Source { path, data: &data[..whole] };
        let is_enough = || {
            let mut lines = Lines::new(head.data);
            (0..LINES).all(|_| lines.next_data().is_some())
        };
        if end < size && !is_enough() {
            continue;
        }
        if options.format.is_none() && has_other_format(path, head.data) {
            return Ok(None);
        }
        let is_domain = is_domain(path, head.data);
        let refused = |error| if is_domain { a_domain(head, "points") } else { error };
        match columns::opening(head, options, size).map_err(refused)? {
            Opening::NoRow if end < size => {}
            Opening::NoRow | Opening::Whole => return Ok(None),
            Opening::Rows(first, start, lines) => {
                let cut = of_table(head, options, (first, start, lines), is_domain).map_err(refused)?;
                let sum = checksum(&head.data[..start]);
                return Ok(Some((Cut { rows: start as u64..size, ..cut }, sum)));
            }
        }
    }
}

/// Whether a file that is named as a table has, or may have, the first lines of another format.
fn has_other_format(path: &Path, data: &[u8]) -> bool {
    signature::is_ele(data) || signature::may_be_node(data) || by_content(path, data).is_some()
}

/// Returns the plan of a table with this first row, its offset, and the number of lines before it.
fn of_table(
    source: Source<'_>,
    options: &ReadOptions,
    (head, start, lines): (Box<Head>, usize, u64),
    is_domain: bool,
) -> Result<Cut, InputError> {
    let dimension = match head.collector(source, options, (0, 0, 1)) {
        Ok(points) => points.dimension(),
        // The process that reads the row reports it with its number in the list.
        Err(error) if error.row().is_some() => options.dimension.unwrap_or(3),
        Err(error) => return Err(error),
    };
    let feeds = line_feeds(&source.data[..start]);
    let (path, rows) = (source.path.to_owned(), 0..0);
    Ok(Cut { path, rows, lines, feeds, dimension, form: Form::Table(head), is_domain })
}
