//! The chunks of a compressed scan, which are checked before the crate `laz` reads them: the crate allocates what a chunk
//! announces, up to 4 GiB for a layer.
//!
//! A chunk of layers holds its first point, the number of its points, the byte count of each layer, and the layers. The table
//! of chunks states the byte count of each chunk.
//!
//! **Source.** Isenburg, *`LASzip`* (2013); ASPRS, *LAS Specification 1.4 - R15* (2019), point formats 6 to 10.

use std::io::Cursor;
use std::ops::Range;

use laz::LazVlr;
use laz::laszip::{ChunkTable, CompressorType, LazItem, LazItemType};

use super::head::{Head, long, short, wide};
use crate::read::error::{InputError, Place};
use crate::read::text::Source;

/// The length of the shortest point.
const SHORTEST_POINT: usize = 20;

/// The advice for a damaged scan.
const ADVICE: &str = "fetch the file again, or check it with `lasinfo`";

/// Checks the table of the chunks, and the sizes that the chunks announce.
///
/// # Errors
/// Fails if a chunk or a layer is longer than the bytes that hold it, or if the chunks have too few points.
pub fn check(source: Source<'_>, head: &Head) -> Result<(), InputError> {
    let record = &source.data[head.record.clone()];
    let damaged =
        || source.malformed(head.record.start, "a damaged record of the compression", "a LASzip record");
    let vlr = LazVlr::from_buffer(record).map_err(|_| damaged())?;
    if vlr.items().iter().any(|item| item.size() != size_of(*item)) {
        return Err(damaged());
    }
    let is_layered = vlr.items().iter().any(|item| item.version() > 2);
    let kind = short(record, 0);
    if is_layered
        && kind != CompressorType::LayeredChunked as u16
        && kind != CompressorType::PointWiseChunked as u16
    {
        return Err(damaged());
    }
    let chunks = table(source, head, &vlr)?;
    if !is_layered {
        return Ok(());
    }
    let layers = vlr.items().iter().copied().map(layers_of).sum();
    for (at, chunk) in chunks.into_iter().enumerate() {
        check_layers(source, (at, chunk), head.length, layers)?;
    }
    Ok(())
}

/// Returns the bytes of each chunk.
fn table(source: Source<'_>, head: &Head, vlr: &LazVlr) -> Result<Vec<Range<usize>>, InputError> {
    let data = source.data;
    let place = Place::Byte(head.start as u64);
    let wrong = || source.unsupported(place, "a damaged table of chunks", ADVICE);
    let is_behind = |at: &usize| *at >= head.start + ChunkTable::OFFSET_SIZE;
    // A writer that cannot go back states the position at the end of the file.
    let positions = [head.start, data.len().saturating_sub(8)].map(|at| wide(data, at).unwrap_or(0));
    let stated = positions.into_iter().find(|at| *at as i64 > head.start as i64);
    let end = stated.and_then(|at| usize::try_from(at).ok()).filter(is_behind).ok_or_else(wrong)?;
    let count = data.get(end..).and_then(|table| table.get(4..8)).map(|count| long(count, 0) as usize);
    if count.is_none_or(|count| count > data.len() / SHORTEST_POINT) {
        return Err(wrong());
    }
    let is_variable = vlr.uses_variable_size_chunks();
    let entries = ChunkTable::read(&mut Cursor::new(&data[end..]), is_variable).map_err(|_| wrong())?;
    let mut chunks = Vec::new();
    let (mut at, mut points) = (head.start + ChunkTable::OFFSET_SIZE, 0_u64);
    for entry in &entries {
        let own = if is_variable { entry.point_count } else { u64::from(vlr.chunk_size()) };
        let (number, bytes, room) = (chunks.len() + 1, entry.byte_count, end - at);
        let size = usize::try_from(bytes).ok().filter(|size| *size <= room).ok_or_else(|| {
            let what =
                format!("a damaged table of chunks, whose chunk {number} has {bytes} bytes in {room},");
            source.unsupported(place, what, ADVICE)
        })?;
        if own == 0 && points < head.points {
            return Err(wrong());
        }
        points = points.saturating_add(own);
        chunks.push(at..at + size);
        at += size;
    }
    if points < head.points { Err(wrong()) } else { Ok(chunks) }
}

/// Checks that the layers fill their chunk. The first point of the chunk has `length` bytes.
fn check_layers(
    source: Source<'_>,
    (number, chunk): (usize, Range<usize>),
    length: usize,
    layers: usize,
) -> Result<(), InputError> {
    let sizes = chunk.start + length + 4;
    let start = sizes + 4 * layers;
    let announced = source.data.get(sizes..start.min(chunk.end).max(sizes)).unwrap_or_default();
    let bytes: u64 = announced.chunks_exact(4).map(|size| u64::from(long(size, 0))).sum();
    let room = chunk.end.saturating_sub(start) as u64;
    if start > chunk.end || bytes != room {
        let what = format!(
            "a damaged laser scan, whose chunk {} has layers of {bytes} bytes in {room},",
            number + 1
        );
        return Err(source.unsupported(Place::Byte(sizes as u64), what, ADVICE));
    }
    Ok(())
}

/// Returns the number of bytes of an item.
fn size_of(item: LazItem) -> u16 {
    match item.item_type() {
        LazItemType::Byte(size) | LazItemType::Byte14(size) => size,
        LazItemType::Point10 => 20,
        LazItemType::GpsTime | LazItemType::RGBNIR14 => 8,
        LazItemType::RGB12 | LazItemType::RGB14 => 6,
        LazItemType::WavePacket13 | LazItemType::WavePacket14 => 29,
        LazItemType::Point14 => 30,
    }
}

/// Returns the number of layers of an item.
fn layers_of(item: LazItem) -> usize {
    match item.item_type() {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(size) => usize::from(size),
        LazItemType::RGB14 | LazItemType::WavePacket14 => 1,
        LazItemType::Byte(_)
        | LazItemType::Point10
        | LazItemType::GpsTime
        | LazItemType::RGB12
        | LazItemType::WavePacket13 => 0,
    }
}
