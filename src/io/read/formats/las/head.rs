//! The header of a laser scan, which is checked before the crate `las` reads the file: announced sizes that the file cannot
//! have would make the crate allocate them or panic.
//!
//! **Source.** ASPRS, *LAS Specification 1.4 - R15* (2019), tables 3 and 6; Isenburg, *`LASzip`* (2013), the record 22204.

use std::ops::Range;

use crate::read::error::{InputError, Place};
use crate::read::text::Source;

/// The length of the shortest header.
const SHORTEST: usize = 227;

/// The length of the header of a record of variable length.
const RECORD: usize = 54;

/// The record that describes the compression.
const LASZIP: u16 = 22204;

/// The bits of a point format that mark compression.
const COMPRESSED: u8 = 0xc0;

/// The length of the shortest point.
const SHORTEST_POINT: u64 = 20;

/// The sizes that the header of a scan states.
pub struct Head {
    /// The number of points.
    pub points: u64,
    /// The length of a point, in bytes.
    pub length: usize,
    /// Whether the points are compressed.
    pub is_compressed: bool,
    /// The record that describes the compression. Empty if the points are not compressed.
    pub record: Range<usize>,
    /// The position of the points, or of the position of the table of chunks before compressed points.
    pub start: usize,
    /// The minor version of the format.
    minor: u8,
}

impl Head {
    /// Reads the header and checks its sizes against the size of the file.
    ///
    /// # Errors
    /// Fails if the file is too short for its points or records.
    pub fn of(source: Source<'_>) -> Result<Self, InputError> {
        let data = source.data;
        if data.len() < SHORTEST {
            return Err(source.truncated(
                Place::Whole,
                "bytes of the header",
                SHORTEST as u64,
                data.len() as u64,
            ));
        }
        let minor = data[25];
        let recent = if minor >= 4 { wide(data, 247).unwrap_or(0) } else { 0 };
        let mut head = Head {
            points: if recent > 0 { recent } else { u64::from(long(data, 107)) },
            length: usize::from(short(data, 105)),
            is_compressed: data[104] & COMPRESSED != 0,
            record: 0..0,
            start: long(data, 96) as usize,
            minor,
        };
        let records = u64::from(long(data, 100)) * RECORD as u64;
        let first = u64::from(short(data, 94));
        if head.start > data.len() || first + records > head.start as u64 {
            return Err(source.malformed(
                96,
                "points before the end of the header",
                "the position of the first point",
            ));
        }
        if (head.length as u64) < SHORTEST_POINT {
            return Err(source.malformed(
                105,
                format!("points of {} bytes", head.length),
                "points of at least 20 bytes",
            ));
        }
        if head.is_compressed {
            head.record = head.compression(source)?;
        } else {
            head.check_points(source)?;
        }
        Ok(head)
    }

    /// Returns the bytes of the file without the records behind the points, which hold no coordinates.
    pub fn without_extended_records(&self, data: &[u8]) -> Vec<u8> {
        let mut data = data.to_vec();
        if self.minor >= 4
            && let Some(records) = data.get_mut(235..247)
        {
            records.fill(0);
        }
        data
    }

    /// Checks that the file has all points that it announces, and no further ones.
    fn check_points(&self, source: Source<'_>) -> Result<(), InputError> {
        let (size, place) = (source.data.len() as u64, Place::Byte(self.start as u64));
        let room = self.end(source.data).saturating_sub(self.start as u64);
        let length = self.length as u64;
        if self.points > size / length || self.points * length > size - self.start as u64 {
            let found = (size - self.start as u64) / length;
            return Err(source.truncated(place, "points", self.points, found));
        }
        let more = room.saturating_sub(self.points * length);
        if more >= length && more.is_multiple_of(length) {
            return Err(source.surplus(place, "points", self.points));
        }
        Ok(())
    }

    /// Returns the end of the points: the first of the parts behind them, or the end of the file.
    fn end(&self, data: &[u8]) -> u64 {
        let waves = if self.minor >= 3 { wide(data, 227).unwrap_or(0) } else { 0 };
        let records = if self.minor >= 4 { wide(data, 235).unwrap_or(0) } else { 0 };
        let behind = [waves, records].into_iter().filter(|at| *at >= self.start as u64);
        behind.fold(data.len() as u64, u64::min)
    }

    /// Returns the record of the compression, whose items must have the length of a point. The crate allocates models for
    /// each byte of a point.
    fn compression(&self, source: Source<'_>) -> Result<Range<usize>, InputError> {
        let data = source.data;
        let wrong =
            |at: usize| source.malformed(at, "a damaged record of the compression", "a LASzip record");
        if self.length > data.len() {
            return Err(source.malformed(
                105,
                format!("points of {} bytes", self.length),
                "points of the file",
            ));
        }
        let at = self.laszip(data).ok_or_else(|| wrong(usize::from(short(data, 94))))?;
        let (record, end) = (at + RECORD, at + RECORD + usize::from(short(data, at + 20)));
        let items = data.get(record + 34..end.min(self.start)).ok_or_else(|| wrong(at))?;
        let count = usize::from(short(data, record + 32));
        let lengths: usize = items.chunks_exact(6).take(count).map(|item| usize::from(short(item, 2))).sum();
        if count == 0 || items.len() < 6 * count || lengths != self.length {
            return Err(wrong(at));
        }
        Ok(record..end.min(self.start))
    }

    /// Returns the position of the record of the compression.
    fn laszip(&self, data: &[u8]) -> Option<usize> {
        let mut at = usize::from(short(data, 94));
        for _ in 0..long(data, 100) {
            if at + RECORD > self.start {
                return None;
            }
            if short(data, at + 18) == LASZIP && data[at + 2..].starts_with(b"laszip encoded") {
                return data[at + 16..].starts_with(&[0; 2]).then_some(at);
            }
            at += RECORD + usize::from(short(data, at + 20));
        }
        None
    }
}

/// Returns the number in two bytes.
pub fn short(data: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([data[at], data[at + 1]])
}

/// Returns the number in four bytes.
pub fn long(data: &[u8], at: usize) -> u32 {
    u32::from(short(data, at)) | u32::from(short(data, at + 2)) << 16
}

/// Returns the number in eight bytes, if the data have them.
pub fn wide(data: &[u8], at: usize) -> Option<u64> {
    let bytes = data.get(at..at.checked_add(8)?)?;
    Some(u64::from(long(bytes, 0)) | u64::from(long(bytes, 4)) << 32)
}
