//! `.npz` files: archives (ZIP) of `.npy` arrays, stored or deflated.
//!
//! Only the directory at the end of the file is read, which names all members. An archive of this kind has no encryption, no
//! parts and no other methods, so that a general reader of archives would add code without use.

use std::borrow::Cow;
use std::io::Read;

use flate2::Crc;
use flate2::read::DeflateDecoder;

use super::npy;
use crate::read::error::{InputError, Place};
use crate::read::load::reserve;
use crate::read::points::{PointFile, ReadOptions};
use crate::read::text::{Source, excerpt};

/// The name of the array that is read if there are several.
const POINTS: &str = "points";

/// A member of an archive.
struct Member<'a> {
    /// The name without `.npy`.
    name: String,
    /// The method of compression: 0 for none, 8 for deflate.
    method: u16,
    /// The size after decompression.
    size: u64,
    /// The CRC-32 after decompression.
    crc: u32,
    /// The offset of the data in the file.
    start: usize,
    data: &'a [u8],
}

/// Reads the points of the only array, or of the array `points`.
pub fn read(source: Source<'_>, options: &ReadOptions) -> Result<PointFile, InputError> {
    let members = members(source)?;
    let named = members.iter().find(|member| member.name == POINTS);
    let member = match (&members[..], named) {
        ([member], _) | (_, Some(member)) => member,
        (members, None) => {
            let names: Vec<&str> = members.iter().take(20).map(|member| member.name.as_str()).collect();
            let what = format!("an archive of {} arrays ({})", members.len(), names.join(", "));
            let advice = "name the array of the points `points`, or save it alone with numpy.save";
            return Err(source.unsupported(Place::Whole, what, advice));
        }
    };
    let data = unpacked(source, member)?;
    let mut file = npy::read(Source { path: source.path, data: &data }, options)?;
    if members.len() > 1 {
        file.notes.push(format!("the array {POINTS} is read, {} others are ignored", members.len() - 1));
    }
    Ok(file)
}

/// Returns the bytes of a member, which have the size and the CRC-32 that the directory states.
fn unpacked<'a>(source: Source<'_>, member: &Member<'a>) -> Result<Cow<'a, [u8]>, InputError> {
    let Member { name, size, crc, data, .. } = member;
    let damaged = |found: String| source.malformed(member.start, found, "the bytes that the archive states");
    let data = if member.method == 0 { Cow::Borrowed(*data) } else { Cow::Owned(inflated(source, member)?) };
    if data.len() as u64 != *size {
        return Err(damaged(format!("an array {name} of another size than {size} bytes")));
    }
    let mut found = Crc::new();
    found.update(&data);
    if found.sum() != *crc {
        return Err(damaged(format!("an array {name} with the CRC-32 {:08x}, not {crc:08x}", found.sum())));
    }
    Ok(data)
}

/// Decompresses a member, and reads at most one byte more than the directory states.
fn inflated(source: Source<'_>, member: &Member<'_>) -> Result<Vec<u8>, InputError> {
    let mut data = Vec::new();
    // A deflated byte holds at most 1032 bytes, so that the announced size bounds no more memory than the file may fill.
    let most = member.size.min(1032 * member.data.len() as u64) + 1;
    reserve(&mut data, most, source.path)?;
    let read = DeflateDecoder::new(member.data).take(most).read_to_end(&mut data);
    read.map_err(|error| {
        let found = format!("damaged data of the array {} ({error})", member.name);
        source.malformed(member.start, found, "data that deflate has packed")
    })?;
    Ok(data)
}

/// The mark of the end of an archive, and the least number of bytes from it to the end of the file.
const END: (&[u8], usize) = (b"PK\x05\x06", 22);

/// Reads the directory of an archive.
fn members(source: Source<'_>) -> Result<Vec<Member<'_>>, InputError> {
    let data = source.data;
    let cut = || source.truncated(Place::Byte(data.len() as u64), "directories of an archive", 1, 0);
    let (count, mut at) = directory(data).ok_or_else(cut)?;
    let mut members = Vec::new();
    for found in 0..count {
        let member = Member::at(data, at);
        let place = Place::Byte(at as u64);
        let (member, next) =
            member.ok_or_else(|| source.truncated(place, "members of an archive", count, found))?;
        if member.method != 0 && member.method != 8 {
            let what = format!("compression {} of the array {}", member.method, member.name);
            return Err(source.unsupported(
                place,
                what,
                "save it with numpy.savez or numpy.savez_compressed",
            ));
        }
        members.push(member);
        at = next;
    }
    if members.is_empty() {
        return Err(source.unsupported(
            Place::Whole,
            "an archive without arrays",
            "save arrays with numpy.savez",
        ));
    }
    Ok(members)
}

/// Returns the number of members, and the offset of the directory.
fn directory(data: &[u8]) -> Option<(u64, usize)> {
    let from = data.len().saturating_sub(END.1 + usize::from(u16::MAX));
    let at = (from..=data.len().checked_sub(END.1)?).rev().find(|at| data[*at..].starts_with(END.0))?;
    // A large archive has a second record of the end, which a locator before the first one names.
    let locator = at.checked_sub(20).filter(|at| data[*at..].starts_with(b"PK\x06\x07"));
    let (count, offset) = match locator {
        None => (number(data, at + 10, 2)?, number(data, at + 16, 4)?),
        Some(locator) => {
            let wide = usize::try_from(number(data, locator + 8, 8)?).ok()?;
            (number(data, wide.checked_add(32)?, 8)?, number(data, wide.checked_add(48)?, 8)?)
        }
    };
    // Each member has at least 46 bytes in the directory.
    Some((count.min(1 + data.len() as u64 / 46), usize::try_from(offset).ok()?))
}

impl<'a> Member<'a> {
    /// Reads the entry of the directory at an offset. Also returns the offset of the next one.
    fn at(data: &'a [u8], at: usize) -> Option<(Self, usize)> {
        const WIDE: u64 = 0xffff_ffff;
        if !data.get(at..)?.starts_with(b"PK\x01\x02") {
            return None;
        }
        let short = |offset: usize| number(data, at.checked_add(offset)?, 2);
        let method = short(10)? as u16;
        let crc = number(data, at + 16, 4)? as u32;
        let [mut packed, mut size] = [20, 24].map(|offset| number(data, at + offset, 4).unwrap_or(0));
        let [name, extra, comment] = [28, 30, 32].map(|offset| short(offset).unwrap_or(0) as usize);
        let mut local = number(data, at + 42, 4)?;
        let text = data.get(at + 46..at + 46 + name)?;
        let mut fields = data.get(at + 46 + name..at + 46 + name + extra)?;
        // The field 1 has the numbers that need 64 bits, in this order.
        while let (Some(kind), Some(length)) = (number(fields, 0, 2), number(fields, 2, 2)) {
            let content = fields.get(4..4 + length as usize)?;
            if kind == 1 {
                let wide = [&mut size, &mut packed, &mut local].into_iter().filter(|value| **value == WIDE);
                for (value, i) in wide.zip(0..) {
                    *value = number(content, 8 * i, 8)?;
                }
            }
            fields = &fields[4 + length as usize..];
        }
        // The local header has its own lengths of the name and of the extra fields.
        let local = usize::try_from(local).ok()?;
        let lengths = number(data, local.checked_add(26)?, 2)? + number(data, local.checked_add(28)?, 2)?;
        let start = local + 30 + lengths as usize;
        let data = data.get(start..start.checked_add(usize::try_from(packed).ok()?)?)?;
        let name = String::from_utf8_lossy(text).trim_end_matches(".npy").to_owned();
        Some((
            Member { name: excerpt(name.as_bytes()), method, size, crc, start, data },
            at + 46 + text.len() + extra + comment,
        ))
    }
}

/// Returns a little-endian number of at most 8 bytes.
fn number(data: &[u8], at: usize, size: usize) -> Option<u64> {
    let bytes = data.get(at..at.checked_add(size)?)?;
    let mut all = [0; 8];
    all[..size].copy_from_slice(bytes);
    Some(u64::from_le_bytes(all))
}
